"""One run of a loaded job as the operator drives it: hold, single block, abort, and what was measured so far."""

from __future__ import annotations

import copy
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import toolpaths as native_paths
from cnc_front.engine import Stop
from cnc_front.execution import End, Execution
from cnc_front.sim_job import LoadedJob

if TYPE_CHECKING:
    from cnc_front.outcome import Outcome
    from cnc_front.sim_record import RunRecording

#: Machine time that still passes after the axes have come to rest, so that the actual positions arrive, s.
SETTLE_S = 0.2
#: Bit of Chunk.flags: a rapid block is current.
RAPID = 2


class SimRun:
    """From start to end of a job. Not safe across threads: only the engine's thread calls it."""

    def __init__(
        self,
        loaded: LoadedJob,
        override: float,
        mcu: native_kernel.Mcu | None = None,
        *,
        is_test: bool = False,
        recording: RunRecording | None = None,
    ) -> None:
        """`mcu`: a controller that is ready and stands where the job begins. `is_test`: nobody is waited for.
        `recording`: takes the samples, and what the operator does."""
        from cnc_front.deliver import Plotting

        machine = loaded.job.machine.machine
        self.loaded, self.is_test = loaded, is_test
        self.execution = Execution(
            loaded.job, ((0.0, override),), acknowledges=is_test, stimulus=loaded.stimulus, on=mcu
        )
        #: block search calls the tool that is in the spindle: nobody is asked
        self.tool_is_in = False
        self._factor = override
        self.tracker = native_paths.Tracker(
            loaded.path,
            sample_time_s=self.execution.sample_time_s,
            schedule=[(0.0, override)],
            trovrst_s=machine.trovrst_s,
        )
        self.tracker.watch(loaded.vertex_s_mm)
        self._plotting = Plotting(machine.tolerance_mm)
        self._plotting.attach(loaded.path, self.tracker, loaded.polyline)
        self._recording = recording
        #: why there is no recording, or no more of it
        self.unrecorded = ""
        self._began, self._override = time.monotonic(), override
        self.aborted = False
        self.holding = False
        self.between_blocks = False  # the hold is one of single block
        self.deviation_now_mm = 0.0
        self.deviation_max_mm = 0.0
        self.deviation_max_line = 0
        self.flags = 0
        self.entry = 0
        self.line = 0  # the last one told: between jobs and entries there is none
        #: path that was done when the job ended; None before
        self.reached_mm: float | None = None
        self._settle = 0

    @property
    def samples(self) -> int:
        """Samples since the start of the job."""
        return self.execution.mcu.samples()

    @property
    def is_over(self) -> bool:
        """Finished, aborted or stopped by a fault."""
        return self.execution.end is not None

    @property
    def at_rest(self) -> bool:
        """The job goes on only when the operator says so."""
        return self.execution.stepped or self.execution.waits != 0 or (self.holding and self.execution.held)

    @property
    def moves_on(self) -> bool:
        """Emulated time passes: the job runs, brakes, or the axes still settle."""
        return not self.is_over and (not self.at_rest or self._settle > 0)

    @property
    def is_underway(self) -> bool:
        """The job is neither over nor merely loaded."""
        return not self.is_over

    def advance(self, samples: int) -> None:
        """Lets emulated time pass and measures it."""
        rested = self.at_rest
        if rested:
            samples = min(samples, self._settle)
        chunk = self.execution.advance(samples)
        happened = self.execution.happened()
        if chunk is None:
            return
        deviation = self._measure(chunk) if len(chunk) else np.zeros(0, np.float32)
        self._record(lambda recording: recording.write(chunk, deviation, happened))
        if self.execution.waits and self.tool_is_in:
            self.tool_is_in = False
            self.execution.acknowledge()
        if self.at_rest:
            settle = round(SETTLE_S / self.execution.sample_time_s)
            self._settle = max(0, self._settle - max(1, len(chunk))) if rested else settle

    def _record(self, write: Callable[[RunRecording], None]) -> None:
        """A full disk ends the recording, not the run."""
        if self._recording is not None:
            try:
                write(self._recording)
            except OSError as error:
                self._recording, self.unrecorded = None, error.strerror or str(error)

    def did(self, name: str, value: int = 0) -> None:
        """The operator did something: for the recording."""
        t_s = self.execution.machine_time_s
        self._record(lambda recording: recording.did(t_s, name, value))

    def _measure(self, chunk: native_kernel.Chunk) -> NDArray[np.float32]:
        deviation = self.tracker.feed(chunk)
        self._plotting.add(deviation)
        worst = int(np.argmax(deviation))
        if float(deviation[worst]) > self.deviation_max_mm:
            self.deviation_max_mm = float(deviation[worst])
            self.deviation_max_line = int(chunk.line[worst])
        self.deviation_now_mm = float(deviation[-1])
        self.flags = int(chunk.flags[-1])
        return deviation

    def balance(self, feed: float, rapid: float) -> None:
        """Sends the override that counts now: the lower one while a rapid block is current (design D30)."""
        factor = min(feed, rapid) if self.flags & RAPID else feed
        if factor != self._factor:
            self._factor = factor
            self.execution.set_override(factor)

    @property
    def stop(self) -> Stop:
        """Which of the four stops the machine is in."""
        if self.execution.fault is not None:
            return Stop.FAST_STOP
        if self.aborted:
            return Stop.ABORT
        if self.holding and not self.between_blocks:
            return Stop.HOLD
        return Stop.BLOCK_END if self.at_rest else Stop.NONE

    def driven(self) -> tuple[int, NDArray[np.float32]]:
        """How many vertices of the plot are done, and the largest deviation up to each, mm."""
        values, approaching = self.tracker.watched()
        finished = self.execution.end is End.FINISHED and not self.aborted
        return (len(values) if finished else approaching), values

    def outcome(self, number: int) -> Outcome:
        """The result of a run that is over; call it once. An aborted run counts as interrupted."""
        from cnc_front.outcome import outcome_of
        from cnc_front.run import RunOptions, RunResult

        execution = self.execution
        if self.aborted and execution.end is End.FINISHED:
            execution = copy.copy(execution)
            execution.end = End.INTERRUPTED
        options = RunOptions(schedule=((0.0, self._override),), stimulus=self.loaded.stimulus_file)
        wall = time.monotonic() - self._began
        summary = self.tracker.finish()
        self.reached_mm = self.loaded.path.length_mm - summary["missing_mm"]
        self.line = self.line or int(summary["reached_line"])
        result = RunResult(self.loaded.job, options, execution, summary, self.loaded.path, self.tracker, wall)
        name = self._recording.name if self._recording is not None else None
        outcome = outcome_of(result, self._plotting, number, recording=name)
        self._record(lambda recording: recording.finish(outcome.run))
        self._recording = None
        return outcome

    # ---- the operator

    def hold(self) -> None:
        """Brakes along the path; at a block end or a programmed stop the axes stand already, and only `go_on` moves."""
        if not self.at_rest and (not self.holding or self.between_blocks):
            self.did("hold")
            self.holding, self.between_blocks, self.execution.held = True, False, False
            self.execution.mcu.hold()

    def hold_at_block_end(self) -> None:
        """Stops at the end of the block being executed, also in the middle of what is spooled."""
        if not self.at_rest and not self.holding:
            self.holding, self.between_blocks, self.execution.held = True, True, False
            self.execution.mcu.hold_at_block_end()

    def go_on(self, single_block: bool) -> None:
        """Ends a hold, block end or programmed stop; to the next block end if `single_block`."""
        self._settle = 0
        self.did("step" if single_block else "resume")
        if self.holding:
            self.execution.held = False
            self.between_blocks = single_block and self.execution.mcu.step_block()
            if self.between_blocks:
                return  # a block that is spooled already
            self.holding = False
            self.execution.mcu.resume()
        if self.execution.waits:
            self.execution.acknowledge()
        if self.execution.stepped or single_block:
            self.set_stepping(single_block)

    def step_block(self) -> None:
        """The next block alone."""
        self.set_stepping(True)

    def set_stepping(self, on: bool) -> None:
        """Single block for what is not yet spooled."""
        self.execution.stepped = False
        if on:
            self.execution.mcu.stepcnct(0)
        else:
            self.execution.mcu.contcnct(0)

    def abort(self) -> None:
        """Brakes along the path, drops what is spooled, ends the task."""
        self.did("reset")
        self.aborted = True
        self.holding = self.between_blocks = self.execution.held = self.execution.stepped = False
        self.execution.waits = 0
        self.execution.mcu.abort()
