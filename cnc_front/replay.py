"""Plays a recording in the terminal: an Engine that reads columns instead of moving a machine. Read-only."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnc_front.engine import AxisValues, Job, Snapshot, State, Switches, wait_for
from cnc_front.errors import CompileError, UsageError
from cnc_front.messages import text
from cnc_front.outcome import Outcome
from cnc_front.reel import HELD, MOVING, WAITING, Film, Reel
from cnc_front.replay_events import Happenings, clock
from cnc_front.search import Start
from cnc_front.service import Service
from cnc_front.sim_view import coolant_text, spindle_text

#: Wall seconds between steps, and the largest step that a slow machine catches up.
TICK_S, LAG_S = 0.01, 0.25
#: A film that stands is reported anew so often, s.
BEAT_S = 0.25
#: Samples per step without pacing, and on the way to another place.
SLICE, SEEKING = 8192, 65536
#: States in which the film stands.
STANDS = (State.READY, State.HOLD, State.STEP, State.DONE, State.ABORTED, State.ALARM)


class ReplayEngine:
    """The Engine protocol of cnc_front.engine on a recording. Whatever would move a machine is refused."""

    def __init__(self, path: str, *, language: str = "en", speed: float = 1.0, revision: int = 1) -> None:
        """Opens the recording and reads it once; raises CompileError. `revision`: that of its job."""
        self._path, self._language, self._speed, self._revision = path, language, max(0.0, speed), revision
        self._lock = threading.Lock()
        self._reel = Reel(path)
        self._film, self._happened = Film(self._reel), self._from_the_start()
        self._state, self._message = State.READY, ""
        self._single = False
        self._until: int | None = None  # the sample at which a step ends
        self._wanted: int | None = None  # the sample that is sought
        self._snapshot = self._look()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._work, name="replay", daemon=True)
        self._thread.start()

    def _from_the_start(self) -> Happenings:
        reel = self._reel
        return Happenings(
            reel.index.events,
            reel.machine,
            reel.sample_s,
            language=self._language,
            schedule=reel.schedule,
            ready=not reel.is_sap,
            stopped=(reel.index.result or {}).get("error"),
            places=reel.places,
        )

    # ---- what may be done

    def load(self, path: str, wanted: Callable[[], bool] = lambda: True) -> Job:
        """The recording from its beginning; raises UsageError for anything else."""
        if path != self._path:
            raise UsageError(text("replay_only", self._language))
        self.reset()
        return self._reel.job

    @property
    def job(self) -> Job:
        """The recorded program."""
        return self._reel.job

    def current_job(self) -> Job | None:
        """As `job`."""
        return self._reel.job

    def start(self) -> None:
        """Plays; from the beginning when it is over."""
        with self._lock:
            self._play_until(self._reel.index.next_change(self._film.position) if self._single else None)

    def step(self) -> None:
        """Plays to where the source line changes."""
        with self._lock:
            if self._state in STANDS:
                self._play_until(self._reel.index.next_change(self._film.position))

    def _play_until(self, sample: int | None) -> None:
        if not self._film.is_over or self._rewind():
            self._until = sample
            self._set(State.RUNNING)

    def hold(self) -> None:
        """Pauses."""
        with self._lock:
            self._wanted = None
            if self._state in (State.RUNNING, State.WAITING):
                self._set(State.HOLD)

    def resume(self) -> None:
        """Plays on."""
        self.start()

    def reset(self) -> None:
        """Back to the beginning."""
        with self._lock:
            self._wanted = None
            if self._rewind():
                self._set(State.READY)

    def seek(self, place: str) -> None:
        """To a time ("1:23.5", "83.5", "+5", "-5" s) or a block ("N620", "L12"); raises UsageError."""
        with self._lock:
            now = self._film.position if self._wanted is None else self._wanted
            self._wanted = self._reel.sample_at(place, now, self._language)
            if self._state not in (State.RUNNING, State.WAITING):
                self._state = State.HOLD
            self._until = None

    def set_speed(self, factor: float) -> None:
        """Recorded seconds per wall second; 0 plays as fast as possible."""
        with self._lock:
            self._speed = max(0.0, factor)
            self._snapshot = self._look()

    def set_single_block(self, on: bool) -> None:
        """Pauses where the source line changes."""
        with self._lock:
            self._single = on
            self._until = self._reel.index.next_change(self._film.position) if on else None
            self._snapshot = self._look()

    # ---- what is refused

    def _refuse(self, *_: object) -> None:
        with self._lock:
            self._message = text("replay_only", self._language)
            self._snapshot = self._look()

    def set_override(self, factor: float) -> None:
        """Refused."""
        self._refuse()

    def set_rapid(self, factor: float) -> None:
        """Refused."""
        self._refuse()

    def set_switches(self, switches: Switches) -> None:
        """Refused."""
        self._refuse()

    def jog(self, axis: str, distance: float) -> None:
        """Refused."""
        self._refuse()

    def home(self, axes: Sequence[str]) -> None:
        """Refused."""
        self._refuse()

    def set_zero(self, axis: str) -> None:
        """Refused."""
        self._refuse()

    def force_input(self, number: int, on: bool) -> None:
        """Refused."""
        self._refuse()

    def release_inputs(self) -> None:
        """Refused."""
        self._refuse()

    def start_mdi(self) -> None:
        """Refused."""
        self._refuse()

    def check_mdi(self, block: str) -> None:
        """Raises UsageError."""
        raise UsageError(text("replay_only", self._language))

    def search(self, block: str) -> Start:
        """Raises UsageError."""
        raise UsageError(text("replay_only", self._language))

    def start_at(self, block: str) -> Job:
        """Raises UsageError."""
        raise UsageError(text("replay_only", self._language))

    # ---- what is shown

    def snapshot(self) -> Snapshot:
        """The sample shown last."""
        return self._snapshot

    def new_deviation(self, since: int) -> tuple[int, NDArray[np.float32]]:
        """As Engine says."""
        with self._lock:
            reached, values = self._film.driven()
        return reached, values[since if since <= reached else 0 : reached]

    def outcome(self) -> Outcome | None:
        """None: nothing is run or judged."""
        return None

    def service(self) -> Service | None:
        """None: there is no controller."""
        return None

    def wait(self, seconds: float, until: Callable[[Snapshot], bool]) -> bool:
        """Waits until a snapshot fulfils `until`, at most `seconds`."""
        return wait_for(lambda: until(self._snapshot), seconds)

    def close(self) -> None:
        """Ends the thread."""
        self._closing.set()
        self._thread.join(timeout=5.0)

    # ---- the thread

    def _work(self) -> None:
        before, owed = time.monotonic(), 0.0
        told = before
        while not self._closing.wait(0.0 if self._wanted is not None else TICK_S):
            now = time.monotonic()
            passed, before = min(now - before, LAG_S), now
            with self._lock:
                if self._wanted is not None:
                    self._go_to(self._wanted)
                elif self._state in (State.RUNNING, State.WAITING):
                    owed += passed * self._speed / self._reel.sample_s
                    samples = int(owed) if self._speed else SLICE
                    owed = owed - samples if self._speed else 0.0
                    self._play(samples)
                else:
                    owed = 0.0
                    if now - told > BEAT_S:  # what stands is no older for that
                        told, self._snapshot = now, self._look()

    def _go_to(self, sample: int) -> None:
        """A stretch of the way to a sample; hold and close need not wait for all of it."""
        if sample < self._film.position and not self._rewind():
            self._wanted = None
            return
        if self._advance(min(sample - self._film.position, SEEKING)):
            is_there = self._film.position >= sample or self._film.is_over
            self._set(self._state, "" if is_there else text("replay_seeks", self._language))
            self._wanted = None if is_there else sample

    def _play(self, samples: int) -> None:
        film = self._film
        if self._until is not None:
            samples = min(samples, self._until - film.position)
        if not self._advance(samples):
            return
        if film.is_over or film.position >= self._reel.index.samples:
            self._advance(1)  # the end of the file
            self._end()
        elif self._until is not None and film.position >= self._until:
            self._until = None
            self._set(State.STEP)
        else:
            flags = int(film.value("flags") or 0)
            stands = flags & (WAITING | HELD) and not flags & MOVING
            self._set(State.WAITING if stands else State.RUNNING)

    def _advance(self, samples: int) -> bool:
        """False, and said, where the recording cannot be read on."""
        try:
            self._film.advance(samples)
        except CompileError as error:
            self._wanted = None
            self._set(State.ABORTED, error.diagnostics[0].message)
            return False
        self._happened.go_on(self._film.position if not self._film.is_over else 1 << 62)
        return True

    def _end(self) -> None:
        """State and message at the end: how the recorded run came out."""
        index = self._reel.index
        result = index.result or {"status": "failed"}
        error = result.get("error") or {}
        if self._film.is_complete:
            verdict = (result.get("verdict") or {}).get("word", "")
            self._set(State.DONE, text("replay_end", self._language, verdict=verdict, time=clock(self._now_s)))
        else:
            reason = index.damage or self._reason(result)
            state = State.ALARM if error.get("id") == "CF302" else State.ABORTED
            self._set(state, text("replay_cut", self._language, reason=reason).rstrip(": "))

    def _reason(self, result: dict[str, Any]) -> str:
        """Why the recorded run ended, in the operator's language."""
        first = next(iter((result.get("verdict") or {}).get("reasons") or ()), None)
        if first is None:
            return ""
        return text(first["id"], self._language, **{key: value for key, value in first.items() if key != "id"})

    def _rewind(self) -> bool:
        """To the first sample; False (and said) where the file is there no more."""
        self._until = None
        if not self._film.position and not self._film.is_over:
            return True
        try:
            self._film, self._happened = Film(self._reel), self._from_the_start()
        except (CompileError, OSError) as error:
            reason = error.diagnostics[0].message if isinstance(error, CompileError) else str(error)
            self._set(State.ABORTED, reason)
            return False
        return True

    def _set(self, state: State, message: str = "") -> None:
        self._state, self._message = state, message
        self._snapshot = self._look()

    @property
    def _now_s(self) -> float:
        return self._film.position * self._reel.sample_s

    # ---- the snapshot

    def _look(self) -> Snapshot:
        film, reel, happened = self._film, self._reel, self._happened
        factor = film.value("factor")
        effective = 1.0 if factor is None else float(factor)
        fills, empty_s = self._spoolers()
        return Snapshot(
            state=self._state,
            why=self._why(),
            machine_time_s=self._now_s,
            line=film.line,
            axes=self._axes(fills),
            feed_programmed=self._programmed(),
            feed_actual=float(film.value("v_plan") or 0.0) * effective * 60,  # v_plan is nominal
            override_set=happened.override_at(self._now_s),
            override_effective=effective,
            path_done_mm=self._done_mm(),
            path_total_mm=reel.length_mm,
            time_total_s=reel.index.samples * reel.sample_s,
            deviation_now_mm=float(film.value("deviation_mm") or 0.0),
            deviation_max_mm=film.max_mm,
            deviation_max_line=film.max_line,
            spool_empty_s=empty_s,
            modal=reel.modal_at(film.line),
            tool=happened.tool,
            spindle="" if reel.is_sap else spindle_text(happened.outputs, film.speed),
            coolant="" if reel.is_sap else coolant_text(happened.outputs),
            speed_factor=self._speed,
            single_block=self._single,
            message=self._message or happened.note(self._now_s),
            alarms=happened.alarms,
            inputs=happened.inputs,
            outputs=happened.outputs,
            revision=self._revision,
            replay=True,
        )

    def _why(self) -> str:
        if self._state is State.WAITING:
            return "held" if int(self._film.value("flags") or 0) & HELD else "dwell"
        if self._state is State.ALARM and self._happened.alarms:
            return str(((self._reel.index.result or {}).get("error") or {}).get("name", ""))
        return "hold" if self._state is State.HOLD else ""

    def _programmed(self) -> float:
        """Feed of the present block, mm/min."""
        reel = self._reel
        entry = int(self._film.value("entry") or 0)
        place = int(np.searchsorted(reel.entries, entry))
        return float(reel.blocks["vl"][place]) * 60 if entry and place < len(reel.entries) else 0.0

    def _spoolers(self) -> tuple[list[float], float]:
        """Fill of each spooler, and the nominal time of what waits in them; NaN where it is not recorded."""
        film, reel = self._film, self._reel
        known = film.spoolers() if film.position else None
        if known is None:
            return [0.0 if not film.position else np.nan] * len(
                reel.machine.axis_names
            ), 0.0 if not film.position else np.nan
        fills, waiting = known
        entry = int(film.value("entry") or 0)
        first, last = np.searchsorted(reel.entries, [entry, entry + waiting], side="right")
        ends = np.append(reel.ends_s, 0.0)  # at index -1: before the first
        left = float(ends[last - 1] - ends[first - 1]) if len(reel.entries) else 0.0
        return fills, left / max(float(film.value("factor") or 1.0), 1e-6)

    def _done_mm(self) -> float:
        film, reel = self._film, self._reel
        if self._state is State.DONE:
            return reel.length_mm
        place, s_mm = film.value("dp"), reel.line["s_mm"]
        next_vertex, _ = film.driven()
        if place is None or not len(s_mm):
            return 0.0
        if next_vertex >= len(s_mm):
            return reel.length_mm
        left = float(np.linalg.norm(reel.line["points"][next_vertex] - place)) if film.trackers else 0.0
        return max(0.0, float(s_mm[next_vertex]) - left)

    def _axes(self, fills: Sequence[float]) -> tuple[AxisValues, ...]:
        film, reel, machine = self._film, self._reel, self._reel.machine
        actual, command = film.value("rp"), film.value("dp")
        points = reel.line["points"]
        if actual is None or command is None:
            actual = command = points[0] if len(points) else np.zeros(len(machine.axis_names))
        target = command
        if len(points) and film.trackers:
            vertex = min(film.driven()[0], len(points) - 1)
            target = points[reel.ends[np.searchsorted(reel.ends, vertex)]]
        rows: Any = zip(
            machine.axis_names, machine.units, actual, command, target, machine.mpe, fills, machine.limits, strict=True
        )
        bits = self._happened.bits
        return tuple(
            AxisValues(
                name=name,
                unit=unit,
                actual=float(a),
                command=float(c),
                to_go=float(t - c),
                following=float(c - a),
                mpe=mpe,
                referenced="referenced" in bits[name],
                spool_fill=fill,
                bits=tuple(sorted(bits[name])),
                limits=limits,
            )
            for name, unit, a, c, t, mpe, fill, limits in rows
        )
