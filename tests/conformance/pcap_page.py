"""Writes docs/pcap.md from the table of PCAP commands: `python -m tests.conformance.pcap_page > docs/pcap.md`."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from pathlib import Path

from motion_kernel import Mcu
from motion_kernel.commands import COMMANDS, Command
from tests.conformance.__main__ import RUST_FOLDERS
from tests.conformance.claims import claims_under

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "pcap.md"
HEAD = """# PCAP commands

<!-- Written by `python -m tests.conformance.pcap_page > docs/pcap.md`; a test checks that it is current. -->

Every command of chapter 4.4 as a method of `motion_kernel.Mcu`, in the order of the manual. Axes are given by name or
index (`AxisId`), several as a list (`Axes`). A command that reads returns the value and raises `PcapError` where the
manual has an error code; one that writes returns the code of the manual where there is one and else raises `ValueError`
for a value that is not allowed; motion in open loop raises `CommandRefused`. Axis units are mm or degrees, and s;
PU and TU those of `ctru`. `help(Mcu.NAME)` says more.

| command | Python | unit | chapter | shown by |
|---|---|---|---|---|
"""


def rows() -> Iterator[tuple[str, str, str, str, str]]:
    """Name in the manual, Python signature, unit, chapter, conformance row of each command, by chapter."""
    for entry in sorted(COMMANDS.values(), key=lambda c: ([int(n) for n in c.chapter.split(".")], c.name)):
        yield entry.manual, signature(entry), entry.unit, entry.chapter, entry.row


def signature(entry: Command) -> str:
    """The method without `self`, as one types it."""
    method = inspect.signature(getattr(Mcu, entry.name))
    parameters = list(method.parameters.values())[1:]
    text = str(method.replace(parameters=parameters)).replace("'", "").replace("os.PathLike[str]", "PathLike")
    return f"{entry.name}{text}".replace("|", "\\|")


def shown_by() -> dict[str, list[str]]:
    """The tests that claim a conformance row, as file::test, the Python ones first."""
    tests: dict[str, list[str]] = {}
    for file in sorted((ROOT / "tests").rglob("test_*.py")):
        for function, ids in python_claims(ast.parse(file.read_text("utf-8"))):
            for row in ids:
                tests.setdefault(row, []).append(f"{file.relative_to(ROOT).as_posix()}::{function}")
    for claim in claims_under(ROOT, RUST_FOLDERS):
        for row in claim.ids:
            tests.setdefault(row, []).append(f"{claim.file.relative_to(ROOT).as_posix()}::{claim.function}")
    return tests


def python_claims(tree: ast.Module) -> Iterator[tuple[str, list[str]]]:
    """Tests with the row ids of their `shows` marks."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            marks = [
                m for m in node.decorator_list if isinstance(m, ast.Call) and ast.unparse(m.func).endswith(".shows")
            ]
            ids = [str(a.value) for mark in marks for a in mark.args if isinstance(a, ast.Constant)]
            if ids:
                yield node.name, ids


def page() -> str:
    tests = shown_by()
    lines = [
        f"| {manual} | `{method}` | {unit} | {chapter} | {', '.join(tests.get(row, ['-'])[:1])} |"
        for manual, method, unit, chapter, row in rows()
    ]
    return HEAD + "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(page(), end="")
