"""What the README tells people to type exists, and so does every file it points to."""

from __future__ import annotations

import re
import shlex

import pytest

from cnc_front.cli import build_parser
from tests.house.test_sizes import ROOT

README = (ROOT / "README.md").read_text("utf-8")
# indented or quoted commands; those with a PLACEHOLDER are explained, not typed
TYPED = re.findall(r"(?:^    (?:\$ )?|`)((?:cnc-front|make) [^`#\n]*)", README, re.MULTILINE)
COMMANDS = [c.strip() for c in TYPED if not re.search(r"\b[A-Z]{2,}\b|F\.mcap|^cnc-front \w+$", c)]


@pytest.mark.parametrize("line", COMMANDS)
def test_command_exists(line: str) -> None:
    program, *arguments = shlex.split(line)
    if program == "make":
        goals = re.search(r"^GOALS := (.*)$", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE)
        assert goals and set(arguments) <= set(goals.group(1).split())
        return
    build_parser().parse_args(arguments)  # raises UsageError on what is unknown
    for argument in arguments:
        if "/" in argument and not argument.startswith("out/"):
            assert (ROOT / argument).is_file(), argument


def test_the_two_commands_come_first() -> None:
    assert COMMANDS[:2] == ["make demo", "make test"]
    assert "cnc-front tui examples/jobs/cam.nc" in COMMANDS


@pytest.mark.parametrize("page", ["README.md", "ARCHITECTURE.md"])
def test_links_lead_somewhere(page: str) -> None:
    text = (ROOT / page).read_text("utf-8")
    links = [link for link in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in link]
    assert not [link for link in links if not (ROOT / link).exists()]


def test_its_python_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(ROOT)
    for block in re.findall(r"```python\n(.*?)```", README, re.DOTALL):
        exec(compile(block, "README.md", "exec"), {})
    assert capsys.readouterr().out.split()[0] == "True", "the move is finished (pe)"
