"""What the operator may do with the emulated machine, obeyed in one thread: programs, MDI, jogs, and what each stop
leaves behind. It knows no clock; `cnc_front.sim` decides how much time passes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from cnc_front.engine import Mode, Snapshot, Stop, Switches
from cnc_front.execution import End
from cnc_front.messages import text
from cnc_front.sim_bench import Bench, copy_commons, positions
from cnc_front.sim_job import LoadedJob
from cnc_front.sim_load import Asked, Loaded
from cnc_front.sim_mdi import Block, Mdi
from cnc_front.sim_run import SimRun
from cnc_front.sim_view import Common, Operator, bench_snapshot, run_snapshot

if TYPE_CHECKING:
    from cnc_front.sim_record import RunRecording


@dataclass(slots=True)
class SimMachine:
    """The machine, its loaded job and its present run. Not safe across threads."""

    bench: Bench
    operator: Operator
    language: str = "en"
    #: folder for recordings of programs; None: none are made
    recordings: Path | None = None
    loaded: Loaded | None = None
    run: SimRun | None = None
    mdi: Mdi = field(default_factory=Mdi)
    #: the MDI block that was checked; the one that runs
    block: Block | None = None
    running: Block | None = None
    mode: Mode = Mode.AUTO
    revision: int = 0
    _stop: Stop = Stop.NONE

    # ---- state

    @property
    def is_underway(self) -> bool:
        """A program or block has begun and is not over."""
        return self.run is not None and not self.run.is_over

    @property
    def is_free(self) -> bool:
        """Nothing moves and nothing is under way."""
        return not self.is_underway and not self.bench.is_busy

    @property
    def moves_on(self) -> bool:
        """Emulated time passes."""
        return self.bench.moves_on or (self.run is not None and self.run.moves_on)

    @property
    def samples(self) -> int:
        """Samples of what moves."""
        if self.run is not None and not self.bench.is_busy:
            return self.run.samples
        return self.bench.mcu.samples()

    @property
    def is_sliced(self) -> bool:
        """The rapid override needs to know every change between feed and rapid."""
        return self.is_underway and self.operator.rapid < self.operator.override

    def advance(self, samples: int) -> None:
        """Lets emulated time pass."""
        if self.bench.is_busy:
            self.bench.advance(samples)
            if not self.bench.is_busy:
                self._bench_done()
        elif self.run is not None:
            self.run.advance(samples)
            self.run.balance(self.operator.override, self.operator.rapid)
            if self.run.unrecorded:
                self._unrecorded(self.run.unrecorded)
                self.run.unrecorded = ""
            if self.run.is_over:
                self._put_down(self.run)

    def _bench_done(self) -> None:
        if self.bench.error is not None:
            if self.bench.error[0] == "bench_fault":
                self._stop = Stop.FAST_STOP
            id, values = self.bench.error
            self.operator.message = text(id, self.language, **values)
        self.running = None

    def _put_down(self, run: SimRun) -> None:
        """The machine stands where a run has left it, with its outputs; a program test has moved nothing."""
        mcu = run.execution.mcu
        if not run.is_test:
            at = positions(mcu, run.loaded.job.machine.machine)
            self.bench.move_to(at, mcu)
        if self.running is not None and run.execution.end is End.FINISHED and not run.aborted:
            self.mdi.took(self.running)
        self.running = None

    # ---- programs

    def take(self, loaded: Loaded) -> None:
        """Another job, or the same one checked again."""
        if self.is_underway:
            return
        if loaded.machine.sha256 != self.bench.file.sha256:
            self.bench, self.mdi = Bench(loaded.machine, loaded.asked.place), Mdi()
        self.loaded, self.run, self.mode, self._stop = loaded, None, Mode.AUTO, Stop.NONE
        self.operator.message = ""
        self.revision += 1

    def stale(self) -> Asked | None:
        """How the loaded job must be loaded again, if the machine or the switches are no longer those of its check."""
        if self.loaded is None:
            return None
        now = replace(self.loaded.asked, switches=self.operator.switches, place=self.bench.place)
        alike = replace(now.switches, program_test=self.loaded.asked.switches.program_test)
        return now if replace(now, switches=alike) != self.loaded.asked else None

    def start(self) -> None:
        """From the top (or the block that was asked for), or on from where it stands."""
        if self.is_underway or self.bench.is_busy:
            self.resume()
        elif self.loaded is not None and not self._in_alarm():
            test = self.operator.switches.program_test
            self._begin(self.loaded.job, Mode.AUTO, tool_is_in=False, is_test=test)

    def _begin(self, job: LoadedJob, mode: Mode, *, tool_is_in: bool, is_test: bool = False) -> None:
        mcu = self.bench.fitted if self.bench.is_changed or mode is Mode.MDI else None
        if mcu is not None and mode is Mode.MDI:
            copy_commons(self.bench.mcu, mcu)  # a program begins with none, an MDI block with those of the block before
        self.mode, self._stop, self.operator.message = mode, Stop.NONE, ""
        recording = self._recording(job) if mode is Mode.AUTO and not is_test else None
        self.run = SimRun(job, self.operator.override, mcu, is_test=is_test, recording=recording)
        self.run.tool_is_in = tool_is_in
        self.run.did("start")
        if self.operator.single_block:
            self.run.step_block()

    def _recording(self, job: LoadedJob) -> RunRecording | None:
        if self.recordings is None:
            return None
        from cnc_front.sim_record import RunRecording

        try:
            return RunRecording(self.recordings, job, self.operator.override)
        except OSError as error:
            self._unrecorded(error.strerror or str(error))
            return None

    def _unrecorded(self, reason: str) -> None:
        self.operator.message = text("unrecorded", self.language, reason=reason)

    def _in_alarm(self) -> bool:
        return self.run is not None and self.run.execution.end not in (None, End.FINISHED)

    def hold(self) -> None:
        """Feed hold, whatever moves."""
        if self.bench.is_busy:
            self._stop = Stop.HOLD if self.bench.hold() else Stop.FAST_STOP
            if self._stop is Stop.FAST_STOP:
                self.operator.message = text("hand_stopped", self.language)
            elif self.bench.ended:
                self.operator.message = text("jogs_ended", self.language, axes=", ".join(self.bench.ended))
        elif self.run is not None and not self.run.is_over:
            self.run.hold()

    def resume(self) -> None:
        """Goes on after a hold, a block end or a programmed stop."""
        if self.bench.is_busy:
            self.bench.resume()
            self._stop, self.operator.message = Stop.NONE, ""
        elif self.run is not None and not self.run.is_over:
            self.run.go_on(self.operator.single_block)

    def step(self) -> None:
        """One block; sets single block if it is off."""
        self.operator.single_block = True
        if self.run is None or self.run.is_over:
            self.start()
        elif self.run.at_rest:
            self.run.go_on(single_block=True)

    def reset(self) -> None:
        """Brakes on the path and drops the spooler; clears what is over."""
        self.block = None
        self.release_inputs()
        if self.bench.is_busy:
            self._stop = Stop.ABORT
            self.bench.abort()
        elif self.run is not None and self.run.is_over:
            self.run, self._stop, self.mode = None, Stop.NONE, Mode.AUTO
            self.operator.message = ""
        elif self.run is not None:
            self.run.abort()

    # ---- overrides and switches

    def set_override(self, factor: float) -> None:
        """Feed override; above 0."""
        if not 0 < factor <= 10:
            self.operator.message = text("override_refused", self.language, factor=factor)
            return
        self.operator.override = factor
        self._did("override", round(factor * 100))
        self._balance()

    def set_rapid(self, factor: float) -> None:
        """Rapid override (design D30); above 0."""
        if 0 < factor <= 1:
            self.operator.rapid = factor
            self._did("rapid", round(factor * 100))
            self._balance()

    def _did(self, name: str, value: int) -> None:
        if self.run is not None and not self.run.is_over:
            self.run.did(name, value)

    def _balance(self) -> None:
        if self.run is not None and not self.run.is_over:
            self.run.balance(self.operator.override, self.operator.rapid)

    def set_single_block(self, on: bool) -> None:
        """Stops at block ends from the present one on."""
        self.operator.single_block = on
        self._did("single_block", int(on))
        run = self.run
        if run is None or run.is_over or run.at_rest:
            return
        if on:
            run.hold_at_block_end()
        elif run.between_blocks:
            run.go_on(single_block=False)
        elif not run.holding:
            run.set_stepping(False)

    def set_switches(self, switches: Switches) -> None:
        """Only at standstill between programs: what is spooled was compiled with the old ones."""
        if self.is_free:
            self.operator.switches = switches
        else:
            self.operator.message = text("switches_refused", self.language)

    # ---- by hand

    def _take_over(self) -> bool:
        """The operator's hand needs a machine that nothing else moves; a run that is over is put away."""
        if not self.is_free:
            self.operator.message = text("hand_refused", self.language)
            return False
        if self._in_alarm():
            self.operator.message = text("hand_alarm", self.language)
            return False
        self.run, self.mode, self._stop, self.operator.message = None, Mode.MANUAL, Stop.NONE, ""
        return True

    def _axis(self, name: str) -> int | None:
        return self.bench.names.index(name) if name in self.bench.names else None

    def jog(self, name: str, distance: float) -> None:
        """One step; dropped while something moves."""
        axis = self._axis(name)
        if axis is None or self.bench.is_busy or not self._take_over():
            return
        refused = self.bench.jog(axis, distance)
        if refused:
            self.operator.message = text(f"jog_{refused}", self.language, axis=name)

    def home(self, names: Sequence[str]) -> None:
        """Axes one after the other, those away from the work first."""
        axes = [axis for name in names if (axis := self._axis(name)) is not None]
        if not axes or not self._take_over():
            return
        missing = [self.bench.names[a] for a in axes if not self.bench.homing(a)]
        if missing:
            self.operator.message = text("home_missing", self.language, axes=", ".join(missing))
            return
        self.bench.home(axes)

    def set_zero(self, name: str) -> None:
        """G54 of an axis is where it stands."""
        axis = self._axis(name)
        if axis is not None and self._take_over():
            self.bench.set_zero(axis)

    def force_input(self, number: int, on: bool) -> None:
        """In what runs now, and on the bench."""
        if not 1 <= number <= 16:
            return
        also = [self.run.execution.mcu] if self.run is not None and not self.run.is_over else []
        self.bench.force(number, on, *also)

    def release_inputs(self) -> None:
        """No input is forced any more."""
        also = [self.run.execution.mcu] if self.run is not None and not self.run.is_over else []
        self.bench.release(*also)

    # ---- MDI

    def take_block(self, block: Block) -> None:
        """A block that was checked; `start_mdi` executes it."""
        self.block = block

    def start_mdi(self) -> None:
        """Executes the checked block, once."""
        block = self.block
        if block is None or not self._take_over():
            return
        if block.place != self.bench.place:
            self.operator.message = text("mdi_again", self.language)
            return
        self.block, self.running, self.mode = None, block, Mode.MDI
        if block.statement is not None:
            self.bench.statement(block.statement)
        elif block.job is not None:
            self._begin(block.job, Mode.MDI, tool_is_in=block.tool_is_in)

    # ---- what is shown

    def snapshot(self) -> Snapshot:
        """What the controller reports."""
        common = Common(
            self.operator,
            self.loaded.job if self.loaded is not None else None,
            self.bench,
            self.mode,
            self._stop,
            self.revision,
            self.loaded.start["line"] if self.loaded is not None and self.loaded.start is not None else 0,
            self.block.text if self.block is not None else "",
            self.mdi.modal,
            self.language,
        )
        return bench_snapshot(common) if self.run is None else run_snapshot(common, self.run)
