"""The operator's terminal. It shows what the engine reports and passes on what the operator wants; it moves nothing."""

from __future__ import annotations

import argparse


def start(options: argparse.Namespace, language: str) -> int:
    """Runs the terminal until the operator quits; the exit code. Textual is loaded here, not by `import tui`."""
    from tui.launch import run_terminal

    return run_terminal(options, language)
