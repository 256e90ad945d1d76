"""A function fits on a screen, a file holds one idea. EXCEPTIONS is a ratchet: an entry may shrink, never grow."""

from __future__ import annotations

import ast
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
FUNCTION_LINES = 60
FILE_LINES = 500
TRACKED_BYTES = 200_000

# "file" or "file::function": (lines allowed, why it is not split)
EXCEPTIONS: dict[str, tuple[int, str]] = {
    "motion_kernel/src/sap/compute.rs::compute": (97, "one match over the frequent instructions"),
}

RUST_FN = re.compile(r"^(\s*)(?:pub(?:\([a-z]+\))? )?(?:const |unsafe |async |extern \"C\" )*fn (\w+)")


def tracked(*patterns: str) -> list[Path]:
    """Files that git keeps, or would keep after the next `git add`, by git's patterns (all without one)."""
    names = subprocess.run(
        ["git", "ls-files", "-z", "-co", "--exclude-standard", *patterns],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return [ROOT / name for name in names.stdout.split("\0") if name and (ROOT / name).is_file()]


def python_functions(source: str) -> Iterator[tuple[str, int]]:
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.end_lineno:
            yield node.name, node.end_lineno - node.lineno + 1


def rust_functions(source: str) -> Iterator[tuple[str, int]]:
    """Name and length of each function, by the closing brace at its indentation (rustfmt guarantees it)."""
    start, indent, name = 0, "", ""
    for number, line in enumerate(source.splitlines(), 1):
        if match := RUST_FN.match(line):
            start, indent, name = number, match.group(1), match.group(2)
        if start and line.rstrip() == f"{indent}}}":
            yield name, number - start + 1
            start = 0


def too_long() -> dict[str, int]:
    """Every file and function above the measure, with its lines."""
    found: dict[str, int] = {}
    for file in tracked("*.py", "*.rs"):
        name, text = file.relative_to(ROOT).as_posix(), file.read_text("utf-8")
        functions = python_functions(text) if file.suffix == ".py" else rust_functions(text)
        lines = text.count("\n")
        if lines > FILE_LINES and "tests" not in file.parts:  # a file of tests is a list of cases
            found[name] = lines
        for function, length in functions:
            if length > FUNCTION_LINES:
                found[f"{name}::{function}"] = max(length, found.get(f"{name}::{function}", 0))
    return found


def test_sizes() -> None:
    found = too_long()
    grown = {name: lines for name, lines in found.items() if lines > EXCEPTIONS.get(name, (0, ""))[0]}
    assert not grown, "split it where it reads better, or say in EXCEPTIONS why not"


def test_exceptions_are_still_needed() -> None:
    assert EXCEPTIONS.keys() <= too_long().keys(), "an exception is no longer needed: remove it"
    assert all(reason for _, reason in EXCEPTIONS.values())


def test_lengths_are_measured() -> None:
    rust = "impl A {\n    pub fn f(&self) {\n        if x {\n        }\n    }\n}\nfn g() {\n}\n"
    assert list(rust_functions(rust)) == [("f", 4), ("g", 2)]
    assert list(python_functions("class A:\n    def f(self):\n        x = 1\n        return x\n")) == [("f", 3)]


def test_no_large_file_is_tracked() -> None:
    large = {str(file): file.stat().st_size for file in tracked() if file.stat().st_size > TRACKED_BYTES}
    assert not large
