"""The engine that the terminal drives: a job on the emulated controller, in a thread of its own.

It steps the same `Execution` as `cnc-front run`; pacing only chooses how many samples pass per slice, so a paced
run is the same run, throttled from outside. Wishes of the operator are put into a queue and obeyed between
slices; what the controller then reports is published as an immutable Snapshot. Between runs the machine stands on
a `Bench`: each run begins where the one before, or the operator by hand, left it.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cnc_front.engine import Job, Snapshot, State, Switches, wait_for
from cnc_front.errors import CompileError, UsageError
from cnc_front.jobs import CompileOptions
from cnc_front.messages import text
from cnc_front.search import Start
from cnc_front.service import Service, service_of
from cnc_front.sim_job import LoadedJob, run_time_s
from cnc_front.sim_load import Asked, Loaded, Loader
from cnc_front.sim_machine import SimMachine
from cnc_front.sim_run import SimRun
from cnc_front.sim_view import Operator

if TYPE_CHECKING:
    from cnc_front.outcome import Outcome

#: Samples per slice: some 5 ms of work, so that a feed hold is obeyed well within 100 ms.
SLICE = 8192
#: Samples per slice while the rapid override is the lower one: it must know when a rapid block begins and ends.
RAPID_SLICE = 32
#: Wall seconds between slices of a paced run.
TICK_S = 0.008
#: A paced run that falls behind by more than this starts its clock anew instead of catching up.
LAG_S = 0.25
#: Wall seconds between copies of the deviation per vertex.
DEVIATION_S = 0.05
#: Wall seconds between two readings of all registers, while somebody looks.
SERVICE_S = 0.15
#: A program that is checked again before its start starts by itself only within this time of the key, s.
PROMPT_S = 1.0

_NOTHING: tuple[int, NDArray[np.float32]] = (0, np.zeros(0, np.float32))


class SimEngine:
    """The Engine protocol of cnc_front.engine on the emulator. Calls for a worker say so; others return at once."""

    def __init__(
        self,
        machine: str | None = None,
        options: CompileOptions | None = None,
        *,
        language: str = "en",
        speed: float = 1.0,
        recordings: Path | None = None,
    ) -> None:
        """`machine`: path of a machine file (None: as design 3.1). `speed`: see `set_speed`. `recordings`: folder for
        a recording of each program that runs. Raises CompileError."""
        self._loader = Loader(machine, options or CompileOptions())
        self._language = language
        switches = Switches(self._loader.options.optional_stop, tuple(self._loader.options.block_delete))
        self._operator = Operator(speed=max(0.0, speed), switches=switches)
        self._machine = SimMachine(self._loader.first_bench(), self._operator, language, recordings)
        self._wishes: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._snapshot = self._machine.snapshot()
        self._deviation = _NOTHING
        self._deviation_at = 0.0
        self._outcome: Outcome | None = None
        self._judged: SimRun | None = None
        self._service: Service | None = None
        self._service_asked = self._service_at = 0.0
        self._clock = (0.0, 0)
        self._holds = 0
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._work, name="sim-engine", daemon=True)
        self._thread.start()

    # ---- what takes time: call it from a worker

    def load(self, path: str, wanted: Callable[[], bool] = lambda: True) -> Job:
        """Compiles a job. Raises CompileError, or UsageError while another job runs or if it is no longer `wanted`."""
        return self._load(path, None, wanted)

    def _load(self, path: str, start: str | None, wanted: Callable[[], bool] = lambda: True) -> Job:
        import_module("cnc_front.outcome")  # what a run needs comes with the job: the first screen is there sooner

        self._refuse_while_busy()
        loaded = self._loader.load(path, start, self._operator.switches, self._machine.bench)
        if not wanted():
            raise UsageError(text("load_let_go", self._language))
        self._wish(lambda: self._take(loaded))
        return loaded.job.view

    def _refuse_while_busy(self) -> None:
        if not self._machine.is_free:
            raise UsageError(text("hand_refused", self._language))

    def search(self, block: str) -> Start:
        """The state before a block of the loaded job. Raises CompileError, UsageError without a job."""
        return self._loader.search(self._has_job(), block)

    def start_at(self, block: str) -> Job:
        """Loads the job again, to begin at a block; empty: at its top. Raises CompileError, UsageError."""
        return self._load(self._has_job().asked.path, block or None)

    def _has_job(self) -> Loaded:
        if self._machine.loaded is None:
            raise UsageError(text("no_job", self._language))
        return self._machine.loaded

    def check_mdi(self, block: str) -> None:
        """Checks one block; `start_mdi` executes it. Raises CompileError, or UsageError while something moves."""
        self._refuse_while_busy()
        bench, mdi = self._machine.bench, self._machine.mdi
        options = self._loader.compile_options(Switches(), bench.file)
        checked = mdi.check(block, bench.file, bench.place, options)
        self._wish(lambda: self._machine.take_block(checked))

    # ---- what the operator wants

    def current_job(self) -> Job | None:
        """The loaded job."""
        loaded = self._machine.loaded
        return loaded.job.view if loaded is not None else None

    def start(self) -> None:
        """Starts the loaded job, or goes on where it stands. Where the machine or the switches have changed since the
        job was checked, it is checked again first; if that takes long, it has to be started again."""
        holds = self._holds
        self._wish(lambda: self._start(holds))

    def hold(self) -> None:
        """Feed hold: brakes on the path; `resume` goes on (design D5)."""
        self._holds += 1  # a start that waits for its check is off
        self._wish(self._machine.hold)

    def resume(self) -> None:
        """Goes on after a hold, a block end or a programmed stop."""
        self._wish(lambda: self._paced(self._machine.resume))

    def step(self) -> None:
        """Executes one block; sets single block if it is off."""
        holds = self._holds
        self._wish(lambda: self._start(holds, step=True))

    def reset(self) -> None:
        """Brakes on the path and drops the spooler; the job must be started again. Clears an ended job."""
        self._holds += 1
        self._wish(lambda: self._paced(self._machine.reset))

    def set_override(self, factor: float) -> None:
        """Feed override from the next sample on, ramped with TROVRST; factors of 0 and less are refused."""
        self._wish(lambda: self._machine.set_override(factor))

    def seek(self, place: str) -> None:
        """Raises UsageError: no machine can be wound back."""
        raise UsageError(text("replay_none", self._language))

    def set_rapid(self, factor: float) -> None:
        """Rapid override, up to 1: the lower one of both counts while a rapid block is current (design D30)."""
        self._wish(lambda: self._machine.set_rapid(factor))

    def set_single_block(self, on: bool) -> None:
        """Stops at the end of each block, from the present one on (the next, if it leaves no room to brake)."""
        self._wish(lambda: self._machine.set_single_block(on))

    def set_switches(self, switches: Switches) -> None:
        """Refused while a job is under way; the loaded job is checked again with them before it starts."""
        self._wish(lambda: self._machine.set_switches(switches))

    def set_speed(self, factor: float) -> None:
        """Simulated seconds per wall second; 0 runs as fast as possible."""
        self._wish(lambda: self._set_speed(factor))

    def jog(self, axis: str, distance: float) -> None:
        """One step of an axis; dropped while a step is under way."""
        self._wish(lambda: self._paced(lambda: self._machine.jog(axis, distance)))

    def home(self, axes: Sequence[str]) -> None:
        """Searches the reference of axes, one after the other."""
        self._wish(lambda: self._paced(lambda: self._machine.home(axes)))

    def set_zero(self, axis: str) -> None:
        """Work offset G54 of an axis is here."""
        self._wish(lambda: self._machine.set_zero(axis))

    def force_input(self, number: int, on: bool) -> None:
        """Makes a simulated input active or inactive."""
        self._wish(lambda: self._machine.force_input(number, on))

    def release_inputs(self) -> None:
        """No input is forced any more."""
        self._wish(self._machine.release_inputs)

    def start_mdi(self) -> None:
        """Executes the block that was checked."""
        self._wish(lambda: self._paced(self._machine.start_mdi))

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

    def outcome(self) -> Outcome | None:
        """The run that ended last; there as soon as a snapshot says that it is over."""
        return self._outcome

    def service(self) -> Service | None:
        """Registers, tasks and variables; read again and again for a second after each call."""
        self._service_asked = time.monotonic()
        if not self._machine.moves_on:
            self._wish(lambda: None)  # at rest the thread waits for wishes
        return self._service

    def wait(self, seconds: float, until: Callable[[Snapshot], bool]) -> bool:
        """Waits until a snapshot fulfils `until`, at most `seconds`; for tests and line mode."""
        return wait_for(lambda: until(self._snapshot), seconds)

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
            if self._machine.moves_on:
                self._pass_time()
            self._publish()

    def _obey(self) -> None:
        """Carries out what is in the queue; waits for it while nothing moves or a paced run is ahead."""
        pause = (0.0 if self._operator.speed == 0 else TICK_S) if self._machine.moves_on else 0.5
        try:
            wish = self._wishes.get(timeout=pause) if pause else self._wishes.get_nowait()
            while True:
                wish()
                wish = self._wishes.get_nowait()
        except queue.Empty:
            return

    def _pass_time(self) -> None:
        machine, samples = self._machine, SLICE
        if self._operator.speed > 0:
            began, first = self._clock
            rate = self._operator.speed / (machine.bench.file.machine.sample_time_us * 1e-6)
            due = int((time.monotonic() - began) * rate) - (machine.samples - first)
            if due > rate * LAG_S and due > SLICE:
                self._restart_clock()
            samples = min(due, SLICE)
        until = time.monotonic() + TICK_S
        while samples > 0 and machine.moves_on:
            part = min(samples, RAPID_SLICE) if machine.is_sliced else samples
            machine.advance(part)
            samples -= part
            if time.monotonic() > until:
                break

    def _restart_clock(self) -> None:
        self._clock = (time.monotonic(), self._machine.samples)

    def _paced(self, wish: Callable[[], None]) -> None:
        """A wish after which something may move: its time counts from now on."""
        wish()
        self._restart_clock()

    def _publish(self) -> None:
        run, now = self._machine.run, time.monotonic()
        if run is None or run.loaded is not self._shown_job():
            self._deviation = _NOTHING
        elif now - self._deviation_at > DEVIATION_S or not run.moves_on:
            self._deviation, self._deviation_at = run.driven(), now
        if run is not None and run.is_over and run is not self._judged and run.loaded is self._shown_job():
            self._judged = run
            self._outcome = run.outcome(self._outcome.number + 1 if self._outcome else 1)
        if now - self._service_asked < 1.0 and now - self._service_at > SERVICE_S:
            mcu = self._machine.bench.mcu if run is None else run.execution.mcu
            self._service, self._service_at = service_of(mcu, self._machine.bench.file, self._language), now
        self._snapshot = self._machine.snapshot()

    def _shown_job(self) -> LoadedJob | None:
        return self._machine.loaded.job if self._machine.loaded is not None else None

    # ---- wishes, obeyed in the engine's thread

    def _take(self, loaded: Loaded) -> None:
        self._machine.take(loaded)
        threading.Thread(target=self._estimate, args=(loaded.job,), name="sim-estimate", daemon=True).start()

    def _estimate(self, job: LoadedJob) -> None:
        """The machine time of the whole job, from a run of its own in the background."""

        def superseded() -> bool:
            return self._closing.is_set() or self._shown_job() is not job

        job.time_total_s = run_time_s(job.job, superseded)

    def _start(self, holds: int, *, step: bool = False) -> None:
        machine = self._machine
        asked = machine.stale() if machine.is_free else None
        if asked is None:
            self._paced(machine.step if step else machine.start)
        else:
            check = threading.Thread(target=self._check_again, args=(asked, holds, step), name="sim-check", daemon=True)
            check.start()

    def _check_again(self, asked: Asked, holds: int, step: bool) -> None:
        began = time.monotonic()
        try:
            loaded = self._loader.load(asked.path, asked.start, asked.switches, self._machine.bench)
        except CompileError as error:
            reason = str(error.diagnostics[0]).partition("\n")[0]
            self._wish(lambda: self._tell("not_checked", finding=reason))
            return
        self._wish(lambda: self._begin(loaded, step, holds == self._holds and time.monotonic() - began <= PROMPT_S))

    def _begin(self, loaded: Loaded, step: bool, prompt: bool) -> None:
        machine = self._machine
        if not machine.is_free:
            return
        self._take(loaded)
        if not prompt or machine.stale() is not None:
            self._tell("checked_again")
        else:
            self._paced(machine.step if step else machine.start)

    def _tell(self, id: str, **values: object) -> None:
        self._operator.message = text(id, self._language, **values)

    def _set_speed(self, factor: float) -> None:
        self._operator.speed = max(0.0, factor)
        self._restart_clock()
