"""Writes the table of devices in docs/resources.md: `python -m tests.conformance.resources_page`."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from pathlib import Path

from motion_kernel.devices import DEVICES, Device

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "resources.md"
ROWS = Path(__file__).with_name("conformance-resources.csv")
BEGIN, END = "<!-- devices -->\n", "<!-- end of devices -->\n"
COLUMNS = ("number", "name in Python", "type", "access", "Index", "SubIndex", "option", "meaning")
HEAD = f"| {' | '.join(COLUMNS)} |\n{'|---' * len(COLUMNS)}|\n"
#: What the rows say before they say what a device does.
OPENING = re.compile(
    r"^(\[note\] )?(Writing 1 to |Reading |Writing )?([Dd]evices? \d+( to \d+)?|Index \d) \([^)]*\) (is )?"
)


def meanings() -> dict[tuple[int, int | None], str]:
    """What the rows of the conformance table say, by device number and function of SyncMode."""
    found: dict[tuple[int, int | None], str] = {}
    with ROWS.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            number = re.match(r"res\.(?:dev-0*(\d+)(?:-0214)?\.|endat\.(\d+)|rts\.(\d+)|sync\.index-(\d+))", row["id"])
            if number is None:
                continue
            device, endat, rts, function = (int(n) if n else None for n in number.groups())
            key = (7000, function) if function else (next(n for n in (device, endat, rts, 0) if n is not None), None)
            text = OPENING.sub("", row["must"])
            found.setdefault(key, text)
    return found


def rows() -> Iterator[str]:
    """One line for each device, by number."""
    told = meanings()
    for device in sorted(DEVICES.values(), key=lambda d: (d.first, d.function or 0)):
        numbers = f"{device.first}" + (f" to {device.last}" if device.last > device.first else "")
        access = "r" * device.readable + "w" * device.writable
        option = ", ".join(name for name in device.needs if name != "RESOURCE") or "-"
        meaning = told.get((device.first, device.function), "-")
        yield (
            f"| {numbers} | `{device.name}` | {device.type.name.lower()} | {access} | {device.index} "
            f"| {device.sub_index} | {option} | {describe(device, meaning)} |\n"
        )


def describe(device: Device, meaning: str) -> str:
    """The meaning as a cell: no bar, begun with a capital."""
    text = meaning.replace("|", "\\|")
    return text[:1].upper() + text[1:]


def page(text: str) -> str:
    """The page with its table made new."""
    before, rest = text.split(BEGIN)
    return before + BEGIN + "\n" + HEAD + "".join(rows()) + "\n" + END + rest.split(END)[1]


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text("utf-8")), "utf-8")
