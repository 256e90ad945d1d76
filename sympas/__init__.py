"""rw_SymPas jobs: `compile` turns text into autocode for the CNC tasks of motion_kernel."""

from __future__ import annotations

from motion_kernel import Diagnostic
from sympas.compiler import CompileError, Program, compile, load

__all__ = ["CompileError", "Diagnostic", "Program", "compile", "load"]
