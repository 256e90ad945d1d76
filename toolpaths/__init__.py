"""The second opinion on a run: programmed geometry of its own, and how far a run stays from it.

`Path` is the path as programmed, before merging, from the columns of `gcode.Program.sequence()`; `Tracker`
measures the samples of a run against it (design D7, D20, D21). Lengths in mm.
"""

from __future__ import annotations

from cnc_front._native.toolpaths import Path, Tracker

__all__ = ["Path", "Tracker"]
