"""DIN 66025 part programs: `compile` turns text into autocode for the CNC tasks of motion_kernel."""

from __future__ import annotations

from gcode.compiler import CompileError, Program, compile
from motion_kernel import Diagnostic

__all__ = ["CompileError", "Diagnostic", "Program", "compile"]
