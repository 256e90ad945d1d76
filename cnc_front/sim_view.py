"""What the terminal sees of a run: the snapshot of cnc_front.engine, built from what the controller reports."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from cnc_front.alarms import alarm_text
from cnc_front.engine import Alarm, AxisValues, Snapshot, State
from cnc_front.execution import AlarmEvent, End
from cnc_front.sim_job import LoadedJob
from cnc_front.sim_run import SimRun

#: Bits of Chunk.flags.
MOVING, RAPID, WAITING = 1, 2, 4
#: Outputs of part programs (din66025.md section 15) and the common double that takes S.
CLOCKWISE, COUNTER_CLOCKWISE, FLOOD, MIST = 1, 2, 4, 8
SPEED_CD = 200


@dataclass(slots=True)
class Operator:
    """What the operator last asked for; it acts when the controller takes it over."""

    override: float = 1.0
    single_block: bool = False
    speed: float = 1.0
    message: str = ""


def empty_snapshot(operator: Operator) -> Snapshot:
    """Nothing is loaded."""
    return Snapshot(
        state=State.NO_JOB,
        why="",
        machine_time_s=0.0,
        line=0,
        axes=(),
        feed_programmed=0.0,
        feed_actual=0.0,
        override_set=operator.override,
        override_effective=operator.override,
        path_done_mm=0.0,
        path_total_mm=0.0,
        time_total_s=None,
        deviation_now_mm=0.0,
        deviation_max_mm=0.0,
        deviation_max_line=0,
        spool_empty_s=0.0,
        modal="",
        tool=0,
        spindle="",
        coolant="",
        speed_factor=operator.speed,
        single_block=operator.single_block,
        message=operator.message,
    )


def snapshot(loaded: LoadedJob, run: SimRun | None, operator: Operator, language: str) -> Snapshot:
    """The loaded job and, once it was started, what its run reports."""
    if run is None:
        return _before_start(loaded, operator)
    status = run.execution.mcu.status()
    run.entry = status["entry"] or run.entry
    run.line = status["line"] or run.line
    state, why = _state(run)
    # at a block end the program stands before the block that comes next
    line = run.execution.mcu.rdcncts(0)[3] if run.execution.stepped else run.line
    factor = status["factor"]
    feed = loaded.fact("feeds", line) or 0.0
    return Snapshot(
        state=state,
        why=why,
        machine_time_s=run.execution.machine_time_s,
        line=line,
        axes=tuple(_axis(loaded, a, values) for a, values in enumerate(status["axes"])),
        feed_programmed=status["programmed_v"] * 60.0 if status["entry"] else feed,
        feed_actual=status["path_v"] * 60.0,
        override_set=status["trovr"],
        override_effective=factor,
        path_done_mm=_done_mm(loaded, run, status),
        path_total_mm=loaded.path.length_mm,
        time_total_s=loaded.time_total_s,
        deviation_now_mm=run.deviation_now_mm,
        deviation_max_mm=run.deviation_max_mm,
        deviation_max_line=run.deviation_max_line,
        spool_empty_s=_spool_empty_s(loaded, run, status),
        modal=loaded.fact("modal", line) or "",
        tool=_tool(run),
        spindle=_spindle(run, status),
        coolant=_coolant(status),
        speed_factor=operator.speed,
        single_block=operator.single_block,
        message=operator.message or _last_message(run),
        alarms=tuple(_alarm(event, run, language) for event in run.execution.alarms),
    )


def _before_start(loaded: LoadedJob, operator: Operator) -> Snapshot:
    machine = loaded.job.machine.machine
    empty = empty_snapshot(operator)
    rows = zip(machine.axis_names, machine.units, machine.start, machine.mpe, strict=True)
    axes = tuple(AxisValues(n, u, at, at, 0.0, 0.0, mpe, True, 0.0, ("pe", "cl")) for n, u, at, mpe in rows)
    values = {name: getattr(empty, name) for name in Snapshot.__slots__}
    values |= {"state": State.READY, "axes": axes, "path_total_mm": loaded.path.length_mm}
    return Snapshot(**(values | {"time_total_s": loaded.time_total_s, "modal": loaded.fact("modal", 1) or ""}))


def _state(run: SimRun) -> tuple[State, str]:
    """The state of ui-guide section 4, and why the machine stands."""
    execution = run.execution
    if execution.end is not None:
        if execution.end is End.FINISHED:
            return (State.ABORTED, "") if run.aborted else (State.DONE, "")
        return State.ALARM, execution.alarms[-1].name if execution.alarms else execution.end.value
    if run.holding and not run.between_blocks:
        return (State.HOLD, "hold") if execution.held else (State.HOLDING, "hold")
    if execution.waits:
        return State.STOPPED, execution.host_events[-1].kind if execution.host_events else "M00"
    if execution.stepped or (run.between_blocks and execution.held):
        return State.STEP, "single block"
    if run.flags & WAITING and not run.flags & MOVING:
        return State.WAITING, "dwell"
    return State.RUNNING, ""


def _axis(loaded: LoadedJob, a: int, values: dict[str, Any]) -> AxisValues:
    machine = loaded.job.machine.machine
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
    )


def _done_mm(loaded: LoadedJob, run: SimRun, status: dict[str, Any]) -> float:
    if run.execution.end is End.FINISHED and not run.aborted:
        return loaded.path.length_mm
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


def _spindle(run: SimRun, status: dict[str, Any]) -> str:
    outputs = _outputs(status)
    word = "M3" if outputs & CLOCKWISE else "M4" if outputs & COUNTER_CLOCKWISE else "M5"
    return word if word == "M5" else f"{word} S{run.execution.mcu.rdcd(SPEED_CD):g}"


def _coolant(status: dict[str, Any]) -> str:
    outputs = _outputs(status)
    return " ".join(word for bit, word in ((MIST, "M7"), (FLOOD, "M8")) if outputs & bit) or "M9"


def _outputs(status: dict[str, Any]) -> int:
    outputs = 0
    for axis in status["axes"]:
        outputs |= axis["digo"]
    return outputs


def _last_message(run: SimRun) -> str:
    texts = [event.text for event in run.execution.host_events if event.kind == "MSG"]
    return texts[-1] if texts else ""


def _alarm(event: AlarmEvent, run: SimRun, language: str) -> Alarm:
    code, text = alarm_text(event.name, event.bit, event.axis, language)
    fault = run.execution.fault
    stopped = fault is not None and event is fault.alarm
    return Alarm(event.t_s, code, event.axis, event.line, text, stopped)
