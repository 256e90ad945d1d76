"""Where results may be written: never over the job, the machine file or a file that is not ours (design 3.1)."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from cnc_front.errors import UsageError

#: First bytes of a recording (MCAP) and of an autocode file, and the mark in every report of ours.
RECORDING_MAGIC = b"\x89MCAP0\r\n"
AUTOCODE_MAGIC = b"\x89CNC\r\n\x1a\n"
REPORT_MARK = "<!-- cnc-front report -->"
REPORT_FILE = "report.html"


def check_recording(path: str, inputs: Iterable[str]) -> Path:
    """The path for a recording, or UsageError."""
    return _checked_file(path, inputs, "--record", RECORDING_MAGIC, "recording of ours")


def is_recording(path: Path) -> bool:
    """Whether a file begins as a recording does."""
    return _starts_with(path, RECORDING_MAGIC)


def check_autocode(path: str, inputs: Iterable[str]) -> Path:
    """The path for an autocode file, or UsageError."""
    return _checked_file(path, inputs, "--output", AUTOCODE_MAGIC, "autocode file")


def _checked_file(path: str, inputs: Iterable[str], option: str, magic: bytes, kind: str) -> Path:
    """The path for a file that begins with `magic`: what else stands there is not overwritten."""
    target = Path(path)
    _refuse_inputs(target, inputs, option)
    _refuse_odd(target, option)
    if target.exists() and not _starts_with(target, magic):
        raise UsageError(f"{option}: {path} exists and is no {kind}; choose another name")
    if not target.parent.is_dir():
        raise UsageError(f"{option}: there is no folder {target.parent}")
    _refuse_readonly(target if target.exists() else target.parent, option)
    return target


def check_report(path: str, inputs: Iterable[str], option: str = "--report") -> Path:
    """The folder for a report, or UsageError: new, empty, or holding an earlier report."""
    target = Path(path)
    _refuse_inputs(target, inputs, option)
    if target.exists() and not target.is_dir():
        raise UsageError(f"{option}: {path} is a file; give a folder")
    if target.is_dir() and any(target.iterdir()) and not _is_report(target / REPORT_FILE):
        raise UsageError(f"{option}: {path} holds files that are no report of ours; choose another folder")
    above = next((folder for folder in (target, *target.absolute().parents) if folder.exists()), target)
    if not above.is_dir():
        raise UsageError(f"{option}: {above} is a file; a folder cannot be made below it")
    _refuse_readonly(above, option)
    return target


def _refuse_inputs(target: Path, inputs: Iterable[str], option: str) -> None:
    for name in inputs:
        if name and target.exists() and Path(name).exists() and target.samefile(name):
            raise UsageError(f"{option}: {target} is an input of this run; choose another name")


def _refuse_odd(target: Path, option: str) -> None:
    if target.exists() and not target.is_file():
        raise UsageError(f"{option}: {target} is not a regular file")


def _refuse_readonly(place: Path, option: str) -> None:
    if not os.access(place, os.W_OK):
        raise UsageError(f"{option}: no permission to write {place}")


def _starts_with(path: Path, magic: bytes) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(len(magic)) == magic
    except OSError:
        return False


def _is_report(path: Path) -> bool:
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            return REPORT_MARK in file.read(200)
    except OSError:
        return False
