"""The states that operators see: word, symbol, colour and what leaves them (ui-guide section 4), one row each."""

from __future__ import annotations

from dataclasses import dataclass

from cnc_front.engine import State


@dataclass(frozen=True, slots=True)
class Face:
    """How a state looks; `style` names a field of Look."""

    symbol: str
    english: str
    german: str
    style: str
    leaves_by: tuple[str, str]


FACES: dict[State, Face] = {
    State.NO_JOB: Face("-", "NO JOB", "KEIN AUFTRAG", "dim", ("F2 opens a job", "F2 öffnet einen Auftrag")),
    State.READY: Face("#", "READY", "BEREIT", "strong", ("r starts", "r startet")),
    State.RUNNING: Face(">", "RUNNING", "LÄUFT", "inverse", ("hold, end, alarm", "Halt, Ende, Störung")),
    State.HOLDING: Face("=", "HOLDING", "BREMST", "hold", ("stands soon", "steht gleich")),
    State.HOLD: Face("=", "HOLD", "HALT", "hold", ("r goes on", "r fährt weiter")),
    State.STEP: Face("=", "STEP", "SATZENDE", "hold", ("r or t goes on", "r oder t fährt weiter")),
    State.STOPPED: Face("=", "STOPPED", "PROG.HALT", "hold", ("r goes on", "r fährt weiter")),
    State.WAITING: Face("~", "WAITING", "WARTET", "strong", ("dwell or input ends", "Verweilzeit oder Eingang")),
    State.DONE: Face("v", "DONE", "FERTIG", "strong", ("r starts again, F2 next", "r beginnt neu, F2 nächster")),
    State.ABORTED: Face("x", "ABORTED", "ABGEBROCHEN", "bad", ("r starts from the top", "r beginnt von vorn")),
    State.ALARM: Face("!!", "ALARM", "STÖRUNG", "alarm", ("cure, then ^X Enter", "beheben, dann ^X Enter")),
}

#: The job has begun and is not over.
UNDERWAY = {State.RUNNING, State.HOLDING, State.HOLD, State.STEP, State.STOPPED, State.WAITING}
#: `r` resumes.
RESUMABLE = {State.HOLD, State.STEP, State.STOPPED}
#: `r` starts from the top.
STARTABLE = {State.READY, State.DONE, State.ABORTED}
#: There is something to hold.
MOVING = {State.RUNNING, State.WAITING}
