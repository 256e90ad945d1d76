"""The emulated machine while no part program runs: it stands where the last one left it, jogs, homes, gets work
offsets and forced inputs, and executes rw_SymPas statements of the operator."""

from __future__ import annotations

import tomllib
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import sympas as native_sympas
from cnc_front.execution import HARMLESS, AlarmEvent
from cnc_front.jobs import MachineFile

#: A second, slow approach makes the place independent of the speed: way off the switch (axis units), speed ratio.
OFF_SWITCH, SLOW = 10.0, 0.05
STEPS_OFF = 20
#: Axes that are homed first, by letter: away from the work before the others move.
HOMED_FIRST = ("Z", "W")
#: A position that no index pulse has.
NOWHERE = 1e12
#: Bits of axst: limit switches and software limits.
LIMITS = frozenset({"lslh", "lsrh", "lsls", "lsrs"})
#: Bits of CNCTS.running (4.3.2.10).
EXECUTES, HALTED_AT_WRITELN = 1, 4
#: Common integers between translator and application: they are no variables of the operator.
RESERVED = (99, 198)
COMMONS = 1000
#: Lines that statements wrote and that are kept.
LINES = 200
#: Samples behind the end of motion until the axes have settled.
SETTLE = 160


@dataclass(frozen=True, slots=True)
class Place:
    """Where the machine stands: coordinates and work offset G54 per axis, and how far coordinates were shifted
    against the scale of the plant by homing."""

    at: tuple[float, ...]
    zero: tuple[float, ...]
    shift: tuple[float, ...]

    @staticmethod
    def first(machine: native_kernel.Machine) -> Place:
        """As the machine file says."""
        return Place(tuple(machine.start), tuple(machine.g54), (0.0,) * len(machine.start))

    def moved(self, at: Sequence[float]) -> Place:
        """The same elsewhere."""
        return replace(self, at=tuple(at))

    def machine(self, file: MachineFile) -> MachineFile:
        """The machine as a program is compiled for it."""
        return replace(file, machine=file.machine.placed(list(self.at), list(self.zero)))

    def boot(self, file: MachineFile) -> native_kernel.Mcu:
        """A controller ready for part programs, its axes here."""
        plant = [at - by for at, by in zip(self.at, self.shift, strict=True)]
        mcu = native_kernel.Mcu(file.machine.placed(plant, list(self.zero)))
        mcu.prepare_gcode()
        for axis, by in enumerate(self.shift):
            if by != 0.0:
                mcu.shp(axis, self.at[axis])
        return mcu


@dataclass(slots=True)
class Bench:
    """One machine. Not safe across threads: only the engine's thread calls it."""

    file: MachineFile
    place: Place
    mcu: native_kernel.Mcu = field(init=False)
    #: all axes that can be homed, those first that lead away from the work
    home_order: list[int] = field(init=False)
    #: "", "jog", "home" or "mdi": what is under way
    doing: str = field(init=False, default="")
    line: int = field(init=False, default=0)
    held: bool = field(init=False, default=False)
    #: axes whose jog the hold has ended: `resume` does not bring it back
    ended: tuple[str, ...] = field(init=False, default=())
    #: what went wrong: an id of cnc_front.messages and its values
    error: tuple[str, dict[str, Any]] | None = field(init=False, default=None)
    #: what stopped the axes, until they move again
    alarms: tuple[AlarmEvent, ...] = field(init=False, default=())
    output: deque[str] = field(init=False, default_factory=lambda: deque(maxlen=LINES))
    #: what else is needed for a home search: each step starts a motion
    _steps: Iterator[None] | None = field(init=False, default=None)
    _settle: int = field(init=False, default=0)
    #: inputs that the operator has forced: to what, and what they were before
    _forced: dict[int, tuple[bool, bool]] = field(init=False, default_factory=dict)
    _tree: dict[str, Any] = field(init=False)

    def __post_init__(self) -> None:
        self._tree = tomllib.loads(self.file.machine.show())
        self.mcu = self.place.boot(self.file)
        letters = self.file.machine.letters
        able = [axis for axis in range(len(self.names)) if self.homing(axis)]
        self.home_order = sorted(able, key=lambda axis: letters[axis] not in HOMED_FIRST)

    @property
    def names(self) -> list[str]:
        """The axes."""
        return self.file.machine.axis_names

    @property
    def is_busy(self) -> bool:
        """Something is under way."""
        return bool(self.doing)

    @property
    def moves_on(self) -> bool:
        """Emulated time passes."""
        return self.is_busy and not (self.held and self._settle <= 0)

    def move_to(self, at: Sequence[float], ran: native_kernel.Mcu) -> None:
        """The machine stands elsewhere: a program has moved it, on a controller of its own. Its outputs and common
        variables stay."""
        self.place = self.place.moved(at)
        self.mcu, self.doing, self.held = self.place.boot(self.file), "", False
        self.place = self.place.moved(self.positions())  # a program begins on whole counts, as the set points do
        for axis in range(len(at)):
            self.mcu.wrdigo(axis, ran.rddigo())
        copy_commons(ran, self.mcu)
        for number, (on, _) in self._forced.items():
            self._level(self.mcu, number, on)

    def positions(self) -> tuple[float, ...]:
        """Set points of axes in their loops (no rounding adds up), actual positions of the others."""
        return positions(self.mcu, self.file.machine)

    def gains(self, axis: int) -> tuple[tuple[str, float], ...]:
        """The PIDF gains of an axis."""
        return tuple((name, float(value)) for name, value in self._tree["axis"][axis]["pidf"].items())

    def jog_feed(self, axis: int) -> float:
        """Jog velocity jvl, units a minute."""
        return self.mcu.read_axis_register(axis, "jvl") * 60.0

    # ---- what the operator wants

    def jog(self, axis: int, distance: float) -> str:
        """One step; why not, if it is refused."""
        low, high = self.file.machine.limits[axis] or (float("-inf"), float("inf"))
        if not low <= self.place.at[axis] + distance <= high:
            return "limit"
        return self._begin("jog", self.mcu.jog([axis], [distance], True))

    def _begin(self, doing: str, outcome: str) -> str:
        if outcome != "entered":
            return "loop" if outcome == "refused" else outcome
        self.doing, self.held, self.error, self._settle = doing, False, None, SETTLE
        self.alarms, self.ended = (), ()
        return ""

    def set_zero(self, axis: int) -> None:
        """G54 of an axis is here."""
        zero = list(self.place.zero)
        zero[axis] = self.place.at[axis]
        self.place = replace(self.place, zero=tuple(zero))

    def force(self, number: int, on: bool, *also: native_kernel.Mcu) -> None:
        """An input becomes active or inactive, whatever its inversion, and stays so in later controllers too."""
        before = bool(self.mcu.rddigi(0) >> (number - 1) & 1)
        self._forced[number] = (on, self._forced[number][1] if number in self._forced else before)
        for mcu in (self.mcu, *also):
            self._level(mcu, number, on)
        self.mcu.pass_on(1)

    @property
    def forced(self) -> tuple[int, ...]:
        """The inputs that are forced."""
        return tuple(sorted(self._forced))

    def release(self, *also: native_kernel.Mcu) -> None:
        """No input is forced any more; each is again what it was before."""
        for number, (_, before) in self._forced.items():
            for mcu in (self.mcu, *also):
                self._level(mcu, number, before)
        if self._forced:
            self.mcu.pass_on(1)
        self._forced.clear()

    def _level(self, mcu: native_kernel.Mcu, number: int, on: bool) -> None:
        inverted = sum(1 << (i["number"] - 1) for i in self._tree.get("input", ()) if i.get("inverted"))
        levels = (mcu.rddigi(0) & 0xFFFF) ^ inverted
        bit = 1 << (number - 1)
        mcu.set_inputs(levels | bit if on != bool(inverted & bit) else levels & ~bit)

    @property
    def fitted(self) -> native_kernel.Mcu:
        """A controller for a program that begins here, with the inputs that were forced."""
        mcu = self.place.boot(self.file)
        for number, (on, _) in self._forced.items():
            self._level(mcu, number, on)
        return mcu

    @property
    def is_changed(self) -> bool:
        """A controller as `run` boots it would not do."""
        return bool(self._forced) or any(self.place.shift)

    def statement(self, program: native_sympas.Program) -> None:
        """Executes a rw_SymPas statement as CNC task 0."""
        self.mcu.load(0, program)
        self.mcu.startcnct(0)
        self._begin("mdi", "entered")

    def hold(self) -> bool:
        """Interpolations of a statement brake on their path, and its task stops; both can go on: True. Jogs and
        searches end, each axis on its own ramp; where nothing else is left, nothing can go on: False."""
        status = self.mcu.status()["axes"]
        direct = [axis["spooler"] == "Direct" for axis in status]
        jogs = [n for n, axis, d in zip(self.names, status, direct, strict=True) if d and "pe" not in axis["axst"]]
        goes_on = not all(direct) or self.mcu.rdcncts(0)[2] & EXECUTES
        if self.doing == "mdi" and (goes_on or not jogs):
            self.mcu.hold()
            self.held, self._settle = True, SETTLE
            self.ended = tuple(jogs)
            return True
        self._steps = None
        self.mcu.js(list(range(len(self.names))))
        return False

    def resume(self) -> None:
        """Goes on."""
        if self.held:
            self.held = False
            self.mcu.resume()

    def abort(self) -> None:
        """Brakes on the path, ends the statement."""
        self._steps, self.held = None, False
        self.mcu.abort()

    # ---- time

    def advance(self, samples: int) -> None:
        """Lets emulated time pass."""
        chunk = self.mcu.advance(samples)
        if self.held:
            self._settle -= max(1, len(chunk))
        if self.doing == "mdi":
            self._listen()
        if chunk.stop == "fault":
            self._fast_stop(chunk.stop_value)
        if self.doing == "home" and self.error is None:
            self._watch_limits()
        stands = bool(self.mcu.status()["stands"])
        if chunk.stop == "finished" and stands and not self.held:
            self._go_on()

    def _watch_limits(self) -> None:
        """A search that runs against a limit finds nothing."""
        for axis, values in enumerate(self.mcu.status()["axes"]):
            if LIMITS.intersection(values["axst"]):
                self._steps = None
                self.mcu.js(list(range(len(self.names))))
                self.error = ("home_failed", {"axis": self.names[axis]})

    def _fast_stop(self, axis: int) -> None:
        """What an application does at a fault: everything stops, each axis on its own ramp."""
        values = self.mcu.status()["axes"][axis]
        bits = [name for name in values["axst"] if name not in HARMLESS]
        numbers = {name: number for number, name, _ in native_kernel.register_bits("axst")}
        t_s, off = self.mcu.samples() * self.file.machine.sample_time_us * 1e-6, values["dp"] - values["rp"]
        self.alarms = tuple(
            AlarmEvent(t_s, self.names[axis], numbers[name], name, 0, off, values["dp"]) for name in bits
        )
        self._steps, self.held = None, False
        self.mcu.stop_job()
        self.error = ("bench_fault", {"axis": self.names[axis], "name": " ".join(bits)})

    def _go_on(self) -> None:
        """The motion is over; a home search has more of them."""
        if self._steps is not None:
            try:
                next(self._steps)
            except StopIteration:
                self._steps = None
            else:
                return
        self.mcu.pass_on(SETTLE)
        self.doing, self.line = "", 0
        self.place = self.place.moved(self.positions())

    def _listen(self) -> None:
        errnum, _, running, line, *_ = self.mcu.rdcncts(0)
        self.line = line
        text = self.mcu.take_output(0)
        self.output.extend(text.splitlines())
        if errnum and not self.error:
            self.error = ("sap_failed", {"errnum": errnum})
        if running & HALTED_AT_WRITELN:
            self.mcu.contcnct(0)

    # ---- homing

    def homing(self, axis: int) -> str:
        """How the reference of an axis is found: "switch", "index", both, or empty where it cannot be."""
        name = self.names[axis]
        switch = any(i.get("function") == "REF" and i.get("axis") == name for i in self._tree.get("input", ()))
        index = self._tree["axis"][axis].get("index", {})
        found = ["switch"] if switch else []
        if index and (index.get("period", 0.0) > 0 or switch):
            found.append("index")
        return "+".join(found)

    def home_side(self, axis: int) -> str:
        """Where the switch is looked for: "left" or "right"."""
        return str(self._tree["axis"][axis]["home_direction"])

    def home(self, axes: Sequence[int]) -> None:
        """Homes axes that can be homed, one after the other, in that order."""
        axes = [axis for axis in self.home_order if axis in axes]
        self._begin("home", "entered")
        self._steps = self._search(axes)
        next(self._steps)

    def _search(self, axes: Sequence[int]) -> Iterator[None]:
        """Onto the switch, off it, slowly onto it; then the next index pulse the other way. Each `yield` waits for
        standstill."""
        for axis in axes:
            tree, how = self._tree["axis"][axis], self.homing(axis)
            back = 1.0 if self.home_side(axis) == "left" else -1.0
            speed = self.mcu.read_axis_register(axis, "hvl")
            place: float | None = None  # of the reference, as the axis counts now
            if "switch" in how:
                yield from self._onto_switch(axis, speed)
                yield from self._off_switch(axis, back)
                if self.error:
                    return
                yield from self._onto_switch(axis, speed * SLOW)
                # an endless search ends at the switch or at a limit; the edge itself may be behind the axis again
                found = not self.error and "cl" in self.mcu.status()["axes"][axis]["axst"]
                place = self.mcu.read_axis(axis)["rp"] if found else None
            if "index" in how and (place is not None or how == "index"):
                index: Mapping[str, float] = tree["index"]
                self.mcu.write_axis_register(axis, "hvl", speed * SLOW)
                self.mcu.write_axis_register(axis, "lpndx", NOWHERE)
                self.mcu.rdigi(axis)
                way = 1.5 * index["period"] if index.get("period", 0.0) > 0 else OFF_SWITCH
                self.mcu.search("index", [axis], [back * way])
                yield
                place = self.mcu.read_axis_register(axis, "lpndx")
            self.mcu.write_axis_register(axis, "hvl", speed)
            if place is None or place == NOWHERE:
                self.error = ("home_failed", {"axis": self.names[axis]})
                return
            self._found(axis, tree["reference"] - place)

    def _on_switch(self, axis: int) -> bool:
        return "refh" in self.mcu.status()["axes"][axis]["axst"]

    def _onto_switch(self, axis: int, velocity: float) -> Iterator[None]:
        self.mcu.write_axis_register(axis, "hvl", velocity)
        self.mcu.search(self.home_side(axis), [axis], [0.0])
        yield

    def _off_switch(self, axis: int, back: float) -> Iterator[None]:
        for _ in range(STEPS_OFF):
            self.mcu.jog([axis], [back * OFF_SWITCH], True)
            yield
            if not self._on_switch(axis):
                return
        self.error = ("home_stuck", {"axis": self.names[axis]})

    def _found(self, axis: int, by: float) -> None:
        """The coordinates of an axis are shifted: its reference has the coordinate of the machine file."""
        self.mcu.shp(axis, self.mcu.read_axis(axis)["rp"] + by)
        shift = list(self.place.shift)
        shift[axis] += by
        self.place = replace(self.place, shift=tuple(shift)).moved(self.positions())


def copy_commons(source: native_kernel.Mcu, target: native_kernel.Mcu) -> None:
    """The common variables of one controller, on another."""
    for number in range(COMMONS):
        if number not in RESERVED:
            target.wrci(number, source.rdci(number))
        target.wrcd(number, source.rdcd(number))


def positions(mcu: native_kernel.Mcu, machine: native_kernel.Machine) -> tuple[float, ...]:
    """Where the axes of a controller at rest are: set points in their loops, actual positions without."""
    found = []
    for axis in mcu.status()["axes"]:
        is_controlled = "cl" in axis["axst"] and abs(axis["dp"] - axis["rp"]) < 0.1
        found.append(float(axis["dp"] if is_controlled else axis["rp"]))
    return tuple(found)
