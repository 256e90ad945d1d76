"""pytest plugin: `--results=FILE` writes each test's outcome with the row ids of its `shows` marks.

With the equals sign: pytest takes a separate FILE that exists for a folder of tests before it knows the option.

The ids travel as user properties of the report, which pytest-xdist carries from its workers to the controller.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

RESULTS = pytest.StashKey[dict[str, dict[str, object]]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--results", metavar="FILE", help="write outcomes and conformance rows as JSON")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[RESULTS] = {}
    if config.getoption("--results") and not hasattr(config, "workerinput"):
        config.pluginmanager.register(Collector(config), "conformance-results")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        for mark in item.iter_markers("shows"):
            item.user_properties += [("shows", row) for row in mark.args]


class Collector:
    """Keeps, per test, the worst outcome of its phases."""

    def __init__(self, config: pytest.Config) -> None:
        self.config = config

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        results = self.config.stash[RESULTS]
        shows = sorted({str(value) for key, value in report.user_properties if key == "shows"})
        entry = results.setdefault(report.nodeid, {"outcome": "passed", "shows": shows})
        if report.outcome != "passed" and entry["outcome"] != "failed":
            entry["outcome"] = report.outcome

    def pytest_sessionfinish(self) -> None:
        out = Path(self.config.getoption("--results"))
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(json.dumps(self.config.stash[RESULTS], indent=0, sort_keys=True), "utf-8")
