"""The engine that the terminal drives: a job on the emulated controller, in a thread of its own.

It steps the same `Execution` as `cnc-front run`; pacing only chooses how many samples pass per slice, so a paced
run is the same run, throttled from outside. Wishes of the operator are put into a queue and obeyed between
slices; what the controller then reports is published as an immutable Snapshot.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cnc_front.engine import Job, Snapshot, State
from cnc_front.errors import UsageError
from cnc_front.jobs import CompileOptions
from cnc_front.sim_job import LoadedJob, load_job, run_time_s
from cnc_front.sim_run import SimRun
from cnc_front.sim_view import Operator, empty_snapshot, snapshot

#: Samples per slice: some 5 ms of work, so that a feed hold is obeyed well within 100 ms.
SLICE = 8192
#: Wall seconds between slices of a paced run.
TICK_S = 0.008
#: A paced run that falls behind by more than this starts its clock anew instead of catching up.
LAG_S = 0.25
#: Wall seconds between copies of the deviation per vertex.
DEVIATION_S = 0.05

_NOTHING: tuple[int, NDArray[np.float32]] = (0, np.zeros(0, np.float32))


class SimEngine:
    """The Engine protocol of cnc_front.engine on the emulator. Every call but `load` returns at once."""

    def __init__(
        self,
        machine: str | None = None,
        options: CompileOptions | None = None,
        *,
        language: str = "en",
        speed: float = 1.0,
    ) -> None:
        """`machine`: path of a machine file (None: as design 3.1). `speed`: see `set_speed`."""
        self._machine = machine
        self._options = options or CompileOptions()
        self._language = language
        self._operator = Operator(speed=max(0.0, speed))
        self._wishes: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._loaded: LoadedJob | None = None
        self._run: SimRun | None = None
        self._snapshot = empty_snapshot(self._operator)
        self._deviation = _NOTHING
        self._deviation_at = 0.0
        self._clock = (0.0, 0)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._work, name="sim-engine", daemon=True)
        self._thread.start()

    # ---- what the operator wants

    def load(self, path: str) -> Job:
        """Compiles a job; call it from a worker. Raises CompileError, or UsageError while another job runs."""
        if self._run is not None and self._run.is_underway:
            raise UsageError("a job is running; reset it first")
        loaded = load_job(path, self._machine, self._options)
        self._wish(lambda: self._take_job(loaded))
        threading.Thread(target=self._estimate, args=(loaded,), name="sim-estimate", daemon=True).start()
        return loaded.view

    def start(self) -> None:
        """Starts the loaded job from its beginning, or goes on where it stands."""
        self._wish(self._start)

    def hold(self) -> None:
        """Feed hold: brakes on the path; `resume` goes on (design D5)."""
        self._wish(self._hold)

    def resume(self) -> None:
        """Goes on after a hold, a block end or a programmed stop."""
        self._wish(self._resume)

    def step(self) -> None:
        """Executes one block; sets single block if it is off."""
        self._wish(self._step)

    def reset(self) -> None:
        """Brakes on the path and drops the spooler; the job must be started again. Clears an ended job."""
        self._wish(self._reset)

    def set_override(self, factor: float) -> None:
        """Feed override from the next sample on, ramped with TROVRST; factors of 0 and less are refused."""
        self._wish(lambda: self._set_override(factor))

    def set_single_block(self, on: bool) -> None:
        """Stops at the end of each block, from the present one on (the next, if it leaves no room to brake)."""
        self._wish(lambda: self._set_single_block(on))

    def set_speed(self, factor: float) -> None:
        """Simulated seconds per wall second; 0 runs as fast as possible."""
        self._wish(lambda: self._set_speed(factor))

    # ---- what the controller reports

    def snapshot(self) -> Snapshot:
        """The newest state; never older than a slice while a job runs."""
        return self._snapshot

    def new_deviation(self, since: int) -> tuple[int, NDArray[np.float32]]:
        """Largest deviation per path-plot vertex driven since index `since` (mm), and the new index.

        An index below `since` means that the job was started again: the values then begin at vertex 0.
        """
        reached, values = self._deviation
        return reached, values[since if since <= reached else 0 : reached]

    def wait(self, seconds: float, until: Callable[[Snapshot], bool]) -> bool:
        """Waits until a snapshot fulfils `until`, at most `seconds`; for tests and line mode."""
        deadline = time.monotonic() + seconds
        while not until(self._snapshot):
            if time.monotonic() > deadline:
                return False
            time.sleep(0.002)
        return True

    def close(self) -> None:
        """Ends the thread; the emulated machine ends with it."""
        self._closing.set()
        self._wish(lambda: None)
        self._thread.join(timeout=5.0)

    # ---- the engine's thread

    def _wish(self, wish: Callable[[], None]) -> None:
        self._wishes.put(wish)

    def _work(self) -> None:
        try:
            self._obey_and_run()
        except BaseException as error:  # a panic of the compiled module is no Exception; the screen must not freeze
            message = f"internal error ({type(error).__name__}: {error}); please report it"
            self._snapshot = replace(self._snapshot, state=State.ALARM, why="internal error", message=message)

    def _obey_and_run(self) -> None:
        while not self._closing.is_set():
            self._obey()
            if self._run is not None and self._run.moves_on:
                self._pass_time(self._run)
            self._publish()

    def _obey(self) -> None:
        """Carries out what is in the queue; waits for it while nothing moves or a paced run is ahead."""
        running = self._run is not None and self._run.moves_on
        pause = (0.0 if self._operator.speed == 0 else TICK_S) if running else 0.5
        try:
            wish = self._wishes.get(timeout=pause) if pause else self._wishes.get_nowait()
            while True:
                wish()
                wish = self._wishes.get_nowait()
        except queue.Empty:
            return

    def _pass_time(self, run: SimRun) -> None:
        samples = SLICE
        if self._operator.speed > 0:
            began, first = self._clock
            rate = self._operator.speed / run.execution.sample_time_s
            due = int((time.monotonic() - began) * rate) - (run.samples - first)
            if due > rate * LAG_S and due > SLICE:
                self._restart_clock()
            samples = min(due, SLICE)
        if samples > 0:
            run.advance(samples)

    def _restart_clock(self) -> None:
        self._clock = (time.monotonic(), self._run.samples if self._run is not None else 0)

    def _publish(self) -> None:
        if self._loaded is None:
            self._snapshot = empty_snapshot(self._operator)
            return
        run = self._run
        now = time.monotonic()
        if run is not None and (now - self._deviation_at > DEVIATION_S or not run.moves_on):
            self._deviation, self._deviation_at = run.driven(), now
        self._snapshot = snapshot(self._loaded, run, self._operator, self._language)

    def _take_job(self, loaded: LoadedJob) -> None:
        self._loaded, self._run, self._deviation = loaded, None, _NOTHING
        self._operator.message = ""

    def _estimate(self, loaded: LoadedJob) -> None:
        """The machine time of the whole job, from a run of its own in the background."""

        def superseded() -> bool:
            return self._closing.is_set() or self._loaded not in (None, loaded)

        loaded.time_total_s = run_time_s(loaded.job, superseded)

    # ---- wishes, obeyed in the engine's thread

    def _start(self) -> None:
        if self._loaded is None:
            return
        if self._run is not None and not self._run.is_over:
            self._resume()
            return
        self._run = SimRun(self._loaded, self._operator.override)
        self._deviation = _NOTHING
        self._operator.message = ""
        if self._operator.single_block:
            self._run.step_block()
        self._restart_clock()

    def _hold(self) -> None:
        if self._run is not None and not self._run.is_over:
            self._run.hold()

    def _resume(self) -> None:
        if self._run is not None and not self._run.is_over:
            self._run.go_on(self._operator.single_block)
            self._restart_clock()

    def _step(self) -> None:
        self._operator.single_block = True
        if self._run is None or self._run.is_over:
            self._start()
        elif self._run.at_rest:
            self._run.go_on(single_block=True)
            self._restart_clock()

    def _reset(self) -> None:
        if self._run is None:
            return
        if self._run.is_over:
            self._run, self._deviation = None, _NOTHING
        else:
            self._run.abort()
            self._restart_clock()

    def _set_override(self, factor: float) -> None:
        if not 0 < factor <= 10:
            self._operator.message = f"override {factor:g} refused: above 0 up to 10"
            return
        self._operator.override = factor
        if self._run is not None and not self._run.is_over:
            self._run.execution.set_override(factor)

    def _set_single_block(self, on: bool) -> None:
        self._operator.single_block = on
        run = self._run
        if run is None or run.is_over or run.at_rest:
            return
        if on:
            run.hold_at_block_end()
        elif run.between_blocks:
            run.go_on(single_block=False)
        elif not run.holding:
            run.set_stepping(False)

    def _set_speed(self, factor: float) -> None:
        self._operator.speed = max(0.0, factor)
        self._restart_clock()
