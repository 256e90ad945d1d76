"""The operator's terminal interface (Textual). It drives the engine of cnc_front through one narrow protocol."""

from __future__ import annotations

import argparse
import os

THEMES = ("dark", "light", "mono")


def start(options: argparse.Namespace, language: str) -> int:
    """Runs the terminal until the operator quits; the exit code."""
    from cnc_front.jobs import CompileOptions
    from cnc_front.sim import SimEngine
    from tui.app import Terminal

    plain = bool(os.environ.get("NO_COLOR")) or os.environ.get("TERM") == "dumb"
    theme = options.theme or ("mono" if plain else "dark")
    glyphs = options.glyphs or ("ascii" if os.environ.get("TERM") in ("linux", "dumb") else "quadrant")
    compile_options = CompileOptions(options.profile, options.optional_stop, tuple(options.skip), options.language)
    engine = SimEngine(options.machine, compile_options, language=language)
    try:
        return Terminal(engine, language=language, theme=theme, glyphs=glyphs, job=options.job).run() or 0
    finally:
        engine.close()
