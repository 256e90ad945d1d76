"""Writes the HTML report of a run that ended, and says what became of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from cnc_front import outputs
from cnc_front.errors import UsageError
from tui.words import Words

if TYPE_CHECKING:
    from cnc_front.outcome import Outcome


def default_folder(outcome: Outcome) -> str:
    """Where a report goes if nothing else is asked for: beside nothing of the user's, named as the job."""
    return f"{Path(outcome.path).stem}-report"


def export(outcome: Outcome, folder: str, words: Words) -> str:
    """The message. Takes a second or more: call it from a worker."""
    from cnc_front.report import write_report

    folder = folder or default_folder(outcome)
    try:
        write_report(outcome.report, outputs.check_report(folder, [outcome.path]), words.language)
    except UsageError as error:
        return str(error).replace("--report", "W301", 1)
    except OSError as error:
        return f"W301 {error.filename or folder}: {error.strerror or error}"
    return words("exported", folder=folder)
