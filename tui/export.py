"""Writes the HTML report of a run that ended, and says what became of it."""

from __future__ import annotations

import getpass
import os
import socket
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from cnc_front import outputs
from cnc_front.errors import UsageError
from cnc_front.german import refusal
from tui.words import Words

if TYPE_CHECKING:
    from cnc_front.outcome import Outcome


def default_folder(outcome: Outcome) -> str:
    """Where a report goes if nothing else is asked for: beside nothing of the user's, named as the job."""
    return f"{Path(outcome.path).stem}-report"


def export(outcome: Outcome, folder: str, words: Words) -> tuple[str, Path | None]:
    """The message, and the page that was written. Takes a second or more: call it from a worker."""
    from cnc_front.report import write_report

    folder = folder or default_folder(outcome)
    try:
        write_report(outcome.report, outputs.check_report(folder, [outcome.path]), words.language)
    except UsageError as error:
        return refusal(error, words.language).replace("--report", "W301", 1), None
    except OSError as error:
        return f"W301 {error.filename or folder}: {error.strerror or error}", None
    return words("exported", folder=folder), Path(folder).absolute() / outputs.REPORT_FILE


def how_to_open(page: Path, words: Words) -> str:
    """Where the report is and how to see it: here, or from the machine that one sits at."""
    if os.environ.get("SSH_CONNECTION"):
        host = f"{getpass.getuser()}@{socket.gethostname()}"
        return words("exported_far", folder=page.parent, host=host)
    return words("exported_here", page=page, opener="open" if sys.platform == "darwin" else "xdg-open")
