"""Every test tree of ours reports which conformance rows it shows (`@pytest.mark.shows`)."""

import os

from hypothesis import settings

# no test writes into the history of the user who runs it; tests of the history name a file of their own
os.environ["CNC_FRONT_HISTORY"] = "off"

pytest_plugins = ("tests.conformance.plugin",)

# the same cases every time, so that a red run is the change's fault; HYPOTHESIS_PROFILE=explore draws new ones
settings.register_profile("steady", derandomize=True, deadline=None)
settings.register_profile("explore", deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "steady"))
