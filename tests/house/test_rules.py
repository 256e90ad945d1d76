"""Rules of the house that a reader cannot see being broken: determinism, licences, locks, reasons for dependencies."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tests.house.test_sizes import ROOT, tracked

# in motion_kernel/src the only time is the sample counter (design 4.1)
OUTSIDE_WORLD = re.compile(
    r"std::(time|env|fs|net|process|thread)\b|\bInstant\b|\bSystemTime\b|\brand::|\bgetrandom\b|\bHashMap\b|\bHashSet\b|RandomState"
)
UNFINISHED = re.compile(r"\b(todo|unimplemented)!|\bNotImplementedError\b")
# written in two parts, so that this file does not find itself
COPYLEFT = re.compile("GNU General " + "Public|GPL" + "-[23]|Lesser General " + "Public")
# a path that exists on one machine only
LOCAL_PATH = re.compile(r"(?<![\w.])/(?:work|home|root)/\w")
COMMENTED = re.compile(r"\S.*#\s*\S+")


def broken(pattern: re.Pattern[str], files: list[Path]) -> list[str]:
    """file:line of every match."""
    return [
        f"{file.relative_to(ROOT)}:{number}: {line.strip()}"
        for file in files
        for number, line in enumerate(file.read_text("utf-8").splitlines(), 1)
        if pattern.search(line)
    ]


def sources() -> list[Path]:
    return [file for file in tracked("*.rs", "*.py", "*.pyi") if file != Path(__file__)]


def test_the_kernel_reads_no_clock_and_no_chance() -> None:
    assert not broken(OUTSIDE_WORLD, tracked("motion_kernel/src/*.rs", "motion_kernel/src/**/*.rs"))


def test_the_patterns_find_what_they_forbid() -> None:
    for line in ("let t = std::time::Instant::now();", "use std::env;", "HashMap::new()"):
        assert OUTSIDE_WORLD.search(line), line
    assert UNFINISHED.search("    todo!()") and COPYLEFT.search("// GPL" + "-2.0") and LOCAL_PATH.search('"/work/x"')


def test_nothing_is_left_unfinished() -> None:
    assert not broken(UNFINISHED, sources())


def test_no_copyleft_text() -> None:
    assert not broken(COPYLEFT, [*sources(), *tracked("*.toml", "*.nc", "*.j2", "*.html")])


def test_no_path_of_one_machine() -> None:
    assert not broken(LOCAL_PATH, [*sources(), *tracked("*.toml", "Makefile", ".ci/*", "*.md")])


def test_no_lock_file_with_addresses() -> None:
    assert not [file for file in tracked() if file.name in {"uv.lock", "poetry.lock", "Pipfile.lock"}]
    assert not broken(re.compile(r"://|@ "), [ROOT / "constraints.txt"])


def test_constraints_pin_every_requirement() -> None:
    lines = (ROOT / "constraints.txt").read_text("utf-8").splitlines()
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", line) for line in lines)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    wanted = [
        *project["build-system"]["requires"],
        *project["project"]["dependencies"],
        *project["project"]["optional-dependencies"]["dev"],
    ]
    pinned = {line.split("==")[0].lower() for line in lines}
    assert {re.split(r"[<>=\[;~! ]", name)[0].lower() for name in wanted} <= pinned


def unexplained(text: str, section: re.Pattern[str]) -> list[str]:
    """Entries of a dependency table without a comment beside or above; one above covers all to the next blank line."""
    found, inside, covered = [], False, False
    for line in text.splitlines():
        if line.startswith("["):
            inside, covered = bool(section.match(line)), False
        elif not line.strip():
            covered = False
        elif line.lstrip().startswith("#"):
            covered = True
        elif inside and "path =" not in line and not covered and not COMMENTED.search(line):
            found.append(line)
    return found


def test_every_rust_dependency_says_why() -> None:
    text = (ROOT / "Cargo.toml").read_text("utf-8")
    assert not unexplained(text, re.compile(r"\[workspace\.dependencies\]"))
    for manifest in tracked("*/Cargo.toml"):
        table = tomllib.loads(manifest.read_text("utf-8"))
        for kind in ("dependencies", "dev-dependencies", "build-dependencies"):
            for name, value in table.get(kind, {}).items():
                assert isinstance(value, dict) and value.get("workspace"), (
                    f"{manifest}: {name} belongs into the workspace table"
                )


def test_every_python_dependency_says_why() -> None:
    text = (ROOT / "pyproject.toml").read_text("utf-8")
    entries = re.findall(r'^    "[^"]+",?.*$', text, re.MULTILINE)
    assert entries
    assert not [entry for entry in entries if not COMMENTED.search(entry)]


def test_an_unexplained_dependency_is_noticed() -> None:
    table = re.compile(r"\[workspace\.dependencies\]")
    assert unexplained('[workspace.dependencies]\n# why\na = "1"\n\nb = "2"\nc = "3" # because\n', table) == ['b = "2"']


@pytest.mark.parametrize(
    "name", ["Cargo.lock", "constraints.txt", "README.md", "ARCHITECTURE.md", "CHANGELOG.md", ".ci/run"]
)
def test_the_house_is_complete(name: str) -> None:
    assert (ROOT / name).is_file()


def test_the_engraving_is_what_its_script_writes() -> None:
    script = ROOT / "examples/jobs/make_engraving.py"
    run = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=True)
    written, committed = run.stdout.split(), script.with_name("engraving.nc").read_text("utf-8").split()
    assert len(written) == len(committed)
    assert sum(a != b for a, b in zip(written, committed, strict=True)) < 10, "more than last digits differ"
