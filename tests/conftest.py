"""Every test tree of ours reports which conformance rows it shows (`@pytest.mark.shows`)."""

pytest_plugins = ("tests.conformance.plugin",)
