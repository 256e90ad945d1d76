"""`cnc-front` and `python -m cnc_front`."""

from __future__ import annotations

import signal
import sys


def main() -> None:
    """Runs the command line and exits with its code."""
    from cnc_front.cli import run_command_line

    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # `cnc-front ... | head` ends quietly
    sys.exit(run_command_line(sys.argv[1:]))


if __name__ == "__main__":
    main()
