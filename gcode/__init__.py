"""DIN 66025 part programs: `compile` turns text into autocode for the CNC tasks of motion_kernel."""

from __future__ import annotations

from gcode.compiler import CompileError, Diagnostic, Program, compile

__all__ = ["CompileError", "Diagnostic", "Program", "compile"]
