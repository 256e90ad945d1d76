"""What the terminal sees of a run: the snapshot of cnc_front.engine, built from what the controller reports."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.alarms import alarm_fact, alarm_text, without_bounces
from cnc_front.engine import Alarm, AxisValues, Mode, Snapshot, State, Stop, Switches
from cnc_front.execution import AlarmEvent, End
from cnc_front.sim_bench import Bench
from cnc_front.sim_job import LoadedJob
from cnc_front.sim_load import dry_feed
from cnc_front.sim_run import SimRun

#: Bits of Chunk.flags.
MOVING, RAPID, WAITING = 1, 2, 4
#: Outputs of part programs (din66025.md section 15) and the common double that takes S.
CLOCKWISE, COUNTER_CLOCKWISE, FLOOD, MIST = 1, 2, 4, 8
SPEED_CD = 200


@dataclass(slots=True)
class Operator:
    """What the operator last asked for, as far as it was accepted."""

    override: float = 1.0
    rapid: float = 1.0
    single_block: bool = False
    speed: float = 1.0
    switches: Switches = field(default_factory=Switches)
    message: str = ""


@dataclass(frozen=True, slots=True)
class Common:
    """What every snapshot is made of, beside the run."""

    operator: Operator
    loaded: LoadedJob | None
    bench: Bench
    mode: Mode
    stop: Stop
    revision: int
    start_line: int
    mdi: str
    mdi_modal: str
    language: str


def bench_snapshot(common: Common) -> Snapshot:
    """No program has begun, or the last one was put away: the machine stands, or moves by the operator's hand."""
    bench, loaded, operator = common.bench, common.loaded, common.operator
    status = bench.mcu.status()
    state, why = _bench_state(common)
    return Snapshot(
        state=state,
        why=why,
        machine_time_s=0.0,
        line=0,
        feed_programmed=0.0,
        feed_actual=status["path_v"] * 60.0,
        override_effective=operator.override,
        path_done_mm=0.0,
        path_total_mm=loaded.path.length_mm if loaded else 0.0,
        time_total_s=loaded.time_total_s if loaded else None,
        deviation_now_mm=0.0,
        deviation_max_mm=0.0,
        deviation_max_line=0,
        spool_empty_s=0.0,
        modal=(loaded.fact("modal", 1) or "") if loaded else "",
        tool=0,
        spindle=spindle_text(_outputs(status), bench.mcu.rdcd(SPEED_CD)),
        coolant=coolant_text(_outputs(status)),
        message=operator.message,
        alarms=tuple(_alarm(event, True, common) for event in bench.alarms),
        stop=common.stop,
        inputs=_inputs(bench.mcu),
        outputs=_outputs(status),
        **_shared(common, status),
    )


def _bench_state(common: Common) -> tuple[State, str]:
    bench = common.bench
    if bench.is_busy:
        if bench.held:
            return (State.HOLDING if bench.moves_on else State.HOLD), "jog" if bench.ended else "hold"
        return State.RUNNING, bench.doing
    return (State.READY if common.loaded else State.NO_JOB), ""


def _shared(common: Common, status: dict[str, Any]) -> dict[str, Any]:
    """What both kinds of snapshot say alike."""
    operator, file = common.operator, common.bench.file
    axes = tuple(_axis(common.bench, a, values) for a, values in enumerate(status["axes"]))
    return {
        "axes": axes,
        "override_set": operator.override,
        "speed_factor": operator.speed,
        "single_block": operator.single_block,
        "mode": common.mode,
        "rapid_set": operator.rapid,
        "switches": operator.switches,
        "forced": common.bench.forced,
        "dry_feed": dry_feed(operator.switches, file) * 60.0,
        "feed_limit": file.machine.feed_limit * 60.0,
        "revision": common.revision,
        "start_line": common.start_line,
        "mdi": common.mdi,
        "mdi_modal": common.mdi_modal,
        "output": tuple(common.bench.output),
    }


def run_snapshot(common: Common, run: SimRun) -> Snapshot:
    """What the run of a job or of an MDI block reports."""
    loaded, mcu = run.loaded, run.execution.mcu
    status = mcu.status()
    run.entry = status["entry"] or run.entry
    run.line = status["line"] or run.line
    state, why, inputs = _state(run, status)
    # at a block end the program stands before the block that comes next
    line = mcu.rdcncts(0)[3] if run.execution.stepped else run.line
    is_mdi = common.mode is Mode.MDI  # its lines are none of the job
    factor = status["factor"]
    feed = loaded.fact("feeds", line) or 0.0
    # axes that a program test does not move; behind the end of a program they have settled on the bench
    settled = run.is_test or run.execution.end is End.FINISHED
    shown = common.bench.mcu.status() if settled else status
    return Snapshot(
        state=state,
        why=why,
        machine_time_s=run.execution.machine_time_s,
        line=0 if is_mdi else line,
        feed_programmed=status["programmed_v"] * 60.0 if status["entry"] else feed,
        feed_actual=status["path_v"] * 60.0,
        override_effective=factor,
        path_done_mm=_done_mm(loaded, run, status),
        path_total_mm=loaded.path.length_mm,
        time_total_s=loaded.time_total_s,
        deviation_now_mm=run.deviation_now_mm,
        deviation_max_mm=run.deviation_max_mm,
        deviation_max_line=0 if is_mdi else run.deviation_max_line,
        spool_empty_s=_spool_empty_s(loaded, run, status),
        modal=loaded.fact("modal", line) or "",
        tool=_tool(run),
        spindle=spindle_text(_outputs(status), mcu.rdcd(SPEED_CD)),
        coolant=coolant_text(_outputs(status)),
        message=common.operator.message or _last_message(run),
        alarms=_alarms(run, common),
        stop=run.stop,
        waits_for=inputs,
        inputs=_inputs(mcu),
        outputs=_outputs(status),
        **_shared(common, shown),
    )


def _state(run: SimRun, status: dict[str, Any]) -> tuple[State, str, tuple[int, ...]]:
    """The state of ui-guide section 4, why the machine stands, and the inputs that it waits for."""
    execution = run.execution
    if execution.end is not None:
        if execution.end is End.FINISHED:
            return (State.ABORTED if run.aborted else State.DONE), "", ()
        return State.ALARM, execution.fault.alarm.name if execution.fault is not None else execution.end.value, ()
    if run.holding and not run.between_blocks:
        return (State.HOLD if execution.held else State.HOLDING), "hold", ()
    if execution.waits:
        return State.STOPPED, execution.host_events[-1].kind if execution.host_events else "M00", ()
    if execution.stepped or (run.between_blocks and execution.held):
        return State.STEP, "single block", ()
    if run.flags & WAITING and not run.flags & MOVING:
        kind, value = status["wait"] or ("dwell", 0)
        inputs = tuple(n + 1 for n in range(32) if value >> n & 1) if kind == "inputs" else ()
        return State.WAITING, kind, inputs
    return State.RUNNING, "", ()


def _axis(bench: Bench, a: int, values: dict[str, Any]) -> AxisValues:
    machine, order = bench.file.machine, bench.home_order
    return AxisValues(
        name=machine.axis_names[a],
        unit=machine.units[a],
        actual=values["rp"],
        command=values["dp"],
        to_go=values["target"] - values["dp"],
        following=values["dp"] - values["rp"],
        mpe=machine.mpe[a],
        referenced="referenced" in values["axst"],
        spool_fill=1.0 - values["lsm"] / values["memory"] if values["memory"] else 0.0,
        bits=tuple(values["axst"]),
        limits=machine.limits[a],
        zero=bench.place.zero[a],
        gains=bench.gains(a),
        jog_feed=bench.jog_feed(a),
        homing=bench.homing(a),
        home_side=bench.home_side(a),
        home_place=order.index(a) + 1 if a in order else 0,
    )


def _done_mm(loaded: LoadedJob, run: SimRun, status: dict[str, Any]) -> float:
    if run.execution.end is End.FINISHED and not run.aborted:
        return loaded.path.length_mm
    if run.reached_mm is not None:
        return run.reached_mm
    if run.entry == 0:
        return 0.0
    # between two commands the one before is done
    return loaded.done_mm(run.entry, status["done"]) if status["entry"] else loaded.done_mm(run.entry + 1, 0.0)


def _spool_empty_s(loaded: LoadedJob, run: SimRun, status: dict[str, Any]) -> float:
    waiting: int = max((axis["mcis"] for axis in status["axes"]), default=0)
    factor: float = status["factor"]
    return loaded.spooled_s(run.entry, waiting) / max(factor, 1e-6)


def _tool(run: SimRun) -> int:
    changes = [event.text for event in run.execution.host_events if event.kind == "M06"]
    return int(changes[-1]) if changes else 0


def spindle_text(outputs: int, speed: float) -> str:
    """M3, M4 or M5 with S, from the outputs of part programs."""
    word = "M3" if outputs & CLOCKWISE else "M4" if outputs & COUNTER_CLOCKWISE else "M5"
    return word if word == "M5" else f"{word} S{speed:g}"


def coolant_text(outputs: int) -> str:
    """M7, M8 or M9."""
    return " ".join(word for bit, word in ((MIST, "M7"), (FLOOD, "M8")) if outputs & bit) or "M9"


def _outputs(status: dict[str, Any]) -> int:
    outputs = 0
    for axis in status["axes"]:
        outputs |= axis["digo"]
    return outputs


def _inputs(mcu: native_kernel.Mcu) -> int:
    """Inputs of the base board that are active."""
    return mcu.rddigi(0) & 0xFFFF


def _last_message(run: SimRun) -> str:
    texts = [event.text for event in run.execution.host_events if event.kind == "MSG"]
    return texts[-1] if texts else ""


def _alarms(run: SimRun, common: Common) -> tuple[Alarm, ...]:
    """What the run has met so far; a runtime error of the task last."""
    execution = run.execution
    events = without_bounces(execution.alarms)
    if execution.end is End.TASK_ERROR:
        _, line = execution.task_error or (0, 0)
        events.append(AlarmEvent(execution.machine_time_s, "", 1, "task_error", line))
    fault = execution.fault.alarm if execution.fault is not None else None
    return tuple(_alarm(event, event is fault or event.name == "task_error", common) for event in events)


def _alarm(event: AlarmEvent, stopped: bool, common: Common) -> Alarm:
    alarm = alarm_of(event, common.bench.file.machine, common.language, stopped=stopped)
    return replace(alarm, line=0) if common.mode is Mode.MDI else alarm


def alarm_of(event: AlarmEvent, machine: native_kernel.Machine, language: str, *, stopped: bool) -> Alarm:
    """A bit that came up, in words; `stopped`: it ended the run."""
    fact = alarm_fact(event, machine, language)
    code, text = alarm_text(event.name, event.bit, event.axis, language, fact)
    return Alarm(event.t_s, code, event.axis, event.line, text, stopped, event.name)
