"""What the events of a recording say of one moment: bits, inputs, outputs, tool, alarms, what the operator did."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from cnc_front._native import motion_kernel as native_kernel
from cnc_front.alarms import without_bounces
from cnc_front.engine import Alarm
from cnc_front.execution import HARMLESS, AlarmEvent
from cnc_front.messages import TEXTS, text
from cnc_front.sap_places import Places
from cnc_front.schedule import Schedule
from cnc_front.sim_view import alarm_of

#: Bits that are set before the first sample of a part program: it starts referenced, in closed loop.
READY = ("pe", "cl", "ip", "referenced")
#: Machine time for which an event is told, s.
TOLD_S = 4.0


class Happenings:
    """Goes with the film: `go_on` takes what happened up to a sample."""

    def __init__(
        self,
        events: Sequence[dict[str, Any]],
        machine: native_kernel.Machine,
        sample_s: float,
        *,
        language: str,
        schedule: Schedule,
        ready: bool,
        stopped: dict[str, Any] | None,
        places: Places | None = None,
    ) -> None:
        """`schedule`: overrides by time; `ready`: a part program; `stopped`: the error of the run, as `run --json`
        tells it; `places`: what the lines of a rw_SymPas job mean."""
        self._places = places
        self._events, self._machine, self._sample_s, self._language = events, machine, sample_s, language
        self._stopped = stopped or {}
        self._next = 0
        names = list(machine.axis_names)
        self.bits: dict[str, set[str]] = {name: set(READY) if ready else set() for name in names}
        self.outputs, self.inputs, self.tool = 0, 0, 0
        self.alarms: tuple[Alarm, ...] = ()
        self._came: list[AlarmEvent] = []
        self._schedule, self._operator = schedule, 0.0
        self._note = (0.0, "")

    def go_on(self, sample: int) -> None:
        """Everything up to a sample."""
        while self._next < len(self._events):
            event = self._events[self._next]
            if round(float(event["t_s"]) / self._sample_s) > sample:
                return
            self._next += 1
            self._take(event)

    def _take(self, event: dict[str, Any]) -> None:
        kind, axis, name, on, value = (event[key] for key in ("kind", "axis", "name", "on", "value"))
        if kind == "axst" and axis in self.bits:
            (self.bits[axis].add if on else self.bits[axis].discard)(name)
        elif kind == "outputs":
            self.outputs = int(value)
        elif kind == "stimulus" and value:
            bit = 1 << (int(value) - 1)
            self.inputs = self.inputs | bit if on else self.inputs & ~bit
        elif kind == "operator" and name == "override":
            self._operator = value / 100
        elif kind == "host" and name == "M06":
            self.tool = int(event["text"]) if event["text"].isdecimal() else self.tool
        measured = event.get("following"), event.get("set_point")
        if on and (kind == "errorreg" or (kind == "axst" and name not in HARMLESS)):
            self._alarm(AlarmEvent(event["t_s"], axis, value, name, event["line"], *measured))
        elif kind == "task":
            self._alarm(AlarmEvent(event["t_s"], "", 1, "task_error", event["line"]))
        told = self._told(event)
        if told:
            self._note = (float(event["t_s"]), told)

    def _alarm(self, alarm: AlarmEvent) -> None:
        self._came = without_bounces([*self._came, alarm])
        told = ((alarm, self._has_stopped(alarm)) for alarm in self._came)
        self.alarms = tuple(alarm_of(a, self._machine, self._language, stopped=stopped) for a, stopped in told)

    def _has_stopped(self, alarm: AlarmEvent) -> bool:
        where = (self._stopped.get("name"), self._stopped.get("axis"))
        return alarm.name == "task_error" or where == (alarm.name, alarm.axis)

    def _told(self, event: dict[str, Any]) -> str:
        """What an operator would have seen or done; empty for the rest."""
        kind, name = event["kind"], event["name"]
        if kind == "operator":
            return text(f"did_{name}", self._language, value=event["value"]) if f"did_{name}" in TEXTS else name
        if kind == "host":
            return str(event["text"]) if name == "MSG" else f"{name} {event['text']}".strip() if name != "T" else ""
        if kind == "task":
            where = self._places.at(event["line"]) if self._places else {"task": 0, "line": event["line"]}
            return text("sap_error", self._language, errnum=event["value"], **where)
        return ""

    def override_at(self, t_s: float) -> float:
        """What was asked for: of the schedule, or by the operator."""
        if self._operator:
            return self._operator
        return next((factor for at, factor in reversed(self._schedule) if at <= t_s + 1e-9), 1.0)

    def note(self, t_s: float) -> str:
        """What happened a moment ago, with its time; empty where nothing did."""
        at, told = self._note
        return f"{clock(at)} {told}" if told and t_s - at <= TOLD_S else ""


def clock(seconds: float) -> str:
    """Machine time as m:ss.t"""
    tenths = int(seconds * 10 + 1e-6)
    return f"{tenths // 600}:{tenths // 10 % 60:02d}.{tenths % 10}"
