"""The PCAP command set is whole, and docs/pcap.md says what the code says."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from motion_kernel import Mcu
from motion_kernel.commands import COMMANDS, command
from tests.conformance.pcap_page import HEAD, PAGE, ROOT, page, rows, shown_by

CATALOGUE = Path(__file__).parent / "conformance-kernel.csv"
OWN_WORDS = {"mcug3_setboardintroutine": "setboardintroutine", "mcug3_resetboardintroutine": "resetboardintroutine"}


def commands_of_the_manual() -> dict[str, str]:
    """Chapter of each command that has a row of its own in the catalogue."""
    with CATALOGUE.open(encoding="utf-8", newline="") as lines:
        found = {row["id"].removeprefix("pcap."): row["chapter"] for row in csv.DictReader(lines) if is_command(row)}
    assert len(found) > 180
    return found


def is_command(row: dict[str, str]) -> bool:
    return row["id"].startswith("pcap.") and row["id"].count(".") == 1 and row["chapter"].startswith("4.4.")


def test_every_command_of_the_manual_is_a_method_with_its_chapter() -> None:
    ours = {OWN_WORDS.get(name, name): c.chapter for name, c in COMMANDS.items() if c.chapter.startswith("4.4.")}
    assert ours == commands_of_the_manual()
    chapters = {int(chapter.split(".")[2]) for chapter in ours.values()}
    assert chapters == set(range(3, 178)), "4.4.3 to 4.4.177, none left out"


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_is_lower_case_and_explained(name: str) -> None:
    method = getattr(Mcu, name)
    assert name == name.lower() == COMMANDS[name].manual.lower()
    text, _, table = (method.__doc__ or "").rpartition("\n\n")
    assert text.endswith(".") and table.endswith(f"chapter {COMMANDS[name].chapter}."), "help says what, and where"
    assert "return" in method.__annotations__


def test_a_command_that_stands_twice_is_noticed() -> None:
    def rdrp() -> None: ...

    with pytest.raises(TypeError, match="twice"):
        command("4.4.95")(rdrp)


def test_the_page_is_current() -> None:
    """Else: python -m tests.conformance.pcap_page > docs/pcap.md"""
    text = PAGE.read_text("utf-8")
    assert text.startswith(HEAD)
    lines = [line.strip("| ").replace("\\|", "\0").split(" | ") for line in text[len(HEAD) :].splitlines()]
    tests = shown_by()
    for (manual, method, unit, chapter, row), cells in zip(rows(), lines, strict=True):
        assert cells[:2] == [manual, f"`{method}`".replace("\\|", "\0")]
        assert (cells[2].strip("| "), cells[-2]) == (unit, chapter) if unit else cells[-2] == chapter
        assert cells[-1] in tests.get(row, []), f"{manual}: no such test shows {row}; write the page anew (see above)"


def test_the_page_can_be_written() -> None:
    assert page().count("\n") == HEAD.count("\n") + len(COMMANDS)
    assert (ROOT / "docs").is_dir()
