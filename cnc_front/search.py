"""Block search: what holds where a program is to begin in the middle, for the command line and the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypedDict

from cnc_front.errors import CompileError
from cnc_front.jobs import CompileOptions, JobSource, MachineFile, diagnose
from cnc_front.messages import text


class Start(TypedDict):
    """State before the first block of a part. Positions by axis name, mm or degrees."""

    line: int
    modal: str  # "G1 G17 G90 G21 G94 G40 G49 G64 G54"
    machine: dict[str, float]
    program: dict[str, float]
    shift: dict[str, float]  # from program to machine coordinates: zero offset, G52, G92, tool length
    in_spindle: int
    tool: int  # preselected
    tool_length: float
    spindle: int  # 3, 4 or 5
    speed: float | None  # S
    flood: bool
    mist: bool
    feed: float | None  # mm/min


def search(source: JobSource, machine: MachineFile, options: CompileOptions, block: str) -> Start:
    """The state before `block` ("N120", or "57" for a line), without running anything.

    Raises CompileError where the program has an error, the block is not executed (GC617), or the program cannot
    start there (GC618).
    """
    _, diagnostics, facts = diagnose(source, machine, replace(options, start=block), check_only=True)
    if any(not d.is_warning for d in diagnostics):
        raise CompileError(diagnostics)
    start: Start = facts["start"]
    return start


def start_text(start: Mapping[str, Any], units: Mapping[str, str], language: str) -> str:
    """The state as operators read it."""

    def places(values: Mapping[str, float]) -> str:
        return "  ".join(f"{axis} {value:.3f} {units[axis]}" for axis, value in values.items())

    shown = {
        "line": start["line"],
        "modal": start["modal"],
        "position": places(start["program"]),
        "machine": places(start["machine"]),
        "offset": places(start["shift"]),
        "tool": f"T{start['in_spindle']} (T{start['tool']})",
        "length": f"{start['tool_length']:.3f}",
        "spindle": f"M{start['spindle']} S{start['speed'] or 0:g}",
        "coolant": " ".join([*(["M8"] if start["flood"] else []), *(["M7"] if start["mist"] else [])]) or "M9",
        "feed": "-" if start["feed"] is None else f"F{start['feed']:g}",
    }
    return text("start", language, **shown)
