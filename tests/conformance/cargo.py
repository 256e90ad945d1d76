"""Runs `cargo test --workspace`, passes its output on, and writes each test's outcome as JSON.

usage: python -m tests.conformance.cargo RESULTS.json
One entry per test: {"package": directory, "root": root source file of the test binary, "name", "outcome"}.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
CARGO_TEST = ["cargo", "test", "--workspace", "--locked"]
RUNNING = re.compile(r"^\s+Running .*\((.+)\)$")
DOC_TESTS = re.compile(r"^\s+Doc-tests (\S+)$")
OUTCOME = re.compile(r"^test (\S+)(?: - should panic)? \.\.\. (ok|FAILED|ignored)")
NAMES = {"ok": "passed", "FAILED": "failed", "ignored": "skipped"}


@dataclass(frozen=True, slots=True)
class Binary:
    package: str
    root: str


def binaries(messages: Iterable[str]) -> dict[str, Binary]:
    """Test binaries by file name, from the JSON messages of `cargo test --no-run`."""
    found = {}
    for text in messages:
        message = json.loads(text) if text.startswith("{") else {}
        if message.get("reason") == "compiler-artifact" and message.get("executable"):
            package = str(Path(message["manifest_path"]).parent)
            found[Path(message["executable"]).name] = Binary(package, message["target"]["src_path"])
    return found


def outcomes(lines: Iterable[str], known: dict[str, Binary]) -> Iterator[dict[str, str]]:
    """What the output of `cargo test` says about each test."""
    binary: Binary | None = None
    for line in lines:
        if match := RUNNING.match(line):
            binary = known[Path(match.group(1)).name]
        elif DOC_TESTS.match(line):
            binary = None
        elif binary and (match := OUTCOME.match(line)):
            yield asdict(binary) | {"name": match.group(1), "outcome": NAMES[match.group(2)]}


def echoed(lines: Iterable[str]) -> Iterator[str]:
    for line in lines:
        sys.stdout.write(line)
        sys.stdout.flush()
        yield line


def main(results: str) -> int:
    build = [*CARGO_TEST, "--no-run", "--message-format=json-render-diagnostics"]
    built = subprocess.run(build, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=False)
    if built.returncode:
        return built.returncode
    command = [*CARGO_TEST, "--no-fail-fast"]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as run:
        assert run.stdout
        tests = list(outcomes(echoed(run.stdout), binaries(built.stdout.splitlines())))
    Path(results).write_text(json.dumps(tests, indent=0), "utf-8")
    return run.returncode


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
