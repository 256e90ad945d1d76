"""Running the real command in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Ran:
    """What a command left."""

    code: int
    out: str
    err: str

    @property
    def object(self) -> dict[str, Any]:
        """stdout as the one JSON object that it must be."""
        value = json.loads(self.out)
        assert isinstance(value, dict)
        return value

    def no_traceback(self) -> Ran:
        """Neither Python nor Rust lost its head."""
        for word in ("Traceback", "panicked", "internal error"):
            assert word not in self.err, self.err
        return self


Cli = Callable[..., Ran]


@pytest.fixture(scope="session")
def cli() -> Cli:
    """`cli("run", path, ...)` as a user would call it."""

    def run(*args: object, env: dict[str, str] | None = None, cwd: Path = ROOT, timeout: float = 120.0) -> Ran:
        plain = {name: value for name, value in os.environ.items() if name not in ("LANG", "LC_ALL", "LC_MESSAGES")}
        done = subprocess.run(
            [sys.executable, "-m", "cnc_front", *map(str, args)],
            capture_output=True,
            text=True,
            encoding="utf-8",
            cwd=cwd,
            env=plain | (env or {}),
            timeout=timeout,
            stdin=subprocess.DEVNULL,
        )
        return Ran(done.returncode, done.stdout, done.stderr).no_traceback()

    return run


@pytest.fixture
def job(tmp_path: Path) -> Callable[..., Path]:
    """Writes a part program and returns its path."""

    def write(text: str | bytes, name: str = "part.nc") -> Path:
        path = tmp_path / name
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return path

    return write
