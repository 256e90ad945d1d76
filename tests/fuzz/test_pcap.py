"""Any PCAP command with any arguments, in any order: an error of Python's or the manual's, never a panic or a hang."""

from __future__ import annotations

import contextlib
import inspect
import math
import os
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from motion_kernel import CommandRefused, Machine, Mcu, ModeReg, PcapError
from motion_kernel.commands import COMMANDS
from tests.conformance.conftest import MILL, ROTARY

# servo axes; switches, index pulses, a probe; steppers, one of them with an encoder, one rotary
MACHINES = [
    Machine.load(MILL),
    Machine.load(MILL.parents[1] / "pcap" / "cell.toml"),
    Machine.parse(
        ROTARY.replace("[[axis]]", '[[axis]]\ndrive = "stepper"').replace(
            "[[axis]]", "[[axis]]\nencoder = { counts_per_unit = 300, feedback = true }", 1
        )
    ),
]
# what a caller may do wrong; a panic of the kernel is none of these
ERRORS = (ValueError, KeyError, IndexError, OverflowError, CommandRefused, PcapError)

AXIS = st.sampled_from(["X", "Y", "C", 0, 1, 2, "X", 0, 1, "Q", 3, -1])
NUMBER = st.one_of(
    st.floats(-100, 100), st.sampled_from([0.0, -0.0, 1e-300, 1e300, -1e300, 5e-324, math.inf, -math.inf, math.nan])
)
WHOLE = st.one_of(st.integers(-3, 40), st.sampled_from([99, 100, 999, 1000, 1001, 2**31 - 1, -(2**31), 2**32, 2**64]))
TARGETS = st.dictionaries(AXIS, NUMBER, max_size=4)
ARGUMENTS: dict[str, st.SearchStrategy[Any]] = {
    "AxisId": AXIS,
    "Axes": st.one_of(AXIS, st.lists(AXIS, max_size=4)),
    "float": NUMBER,
    "int": WHOLE,
    "int | str": st.one_of(WHOLE, st.sampled_from(["mm", "deg", "counts", "min", "light-year"])),
    "str": st.sampled_from(["", "SerialNumber", "nowhere.toml", "a\0b"]),
    "str | os.PathLike[str]": st.sampled_from(["", "nowhere.toml", "a\0b", str(MILL)]),
    "Mapping[AxisId, float]": TARGETS,
    "Sequence[float]": st.lists(NUMBER, max_size=5),
    "Sequence[Sequence[float]]": st.sampled_from([[[1.0] * 15] * 15, [[1.0]], []]),
    "bytes": st.binary(max_size=1100),
    "InterruptRoutine": st.just(lambda lines: None),
}
# these leave the card without a system, so that nothing else would be tried any more
APART = {"bootfile", "initmcusystem", "initmcusystem2", "initmcusystem3"}


def parameters(name: str) -> list[inspect.Parameter]:
    """Those of a command, without the controller itself."""
    return list(inspect.signature(getattr(Mcu, name)).parameters.values())[1:]


@st.composite
def calls(draw: st.DrawFn) -> tuple[str, list[Any], dict[str, Any]]:
    """A command with arguments of the types that it asks for."""
    name = draw(st.sampled_from(sorted(COMMANDS.keys() - APART)))
    drawn = [(p, draw(ARGUMENTS[str(p.annotation)])) for p in parameters(name)]
    plain = [value for p, value in drawn if p.kind is not inspect.Parameter.KEYWORD_ONLY]
    named = {p.name: value for p, value in drawn if p.kind is inspect.Parameter.KEYWORD_ONLY}
    return name, plain, named


def test_every_type_of_argument_is_drawn() -> None:
    assert {str(p.annotation) for name in COMMANDS for p in parameters(name)} == ARGUMENTS.keys()


@settings(max_examples=int(os.environ.get("FUZZ_EXAMPLES", "150")), suppress_health_check=list(HealthCheck))
@given(
    st.sampled_from(MACHINES),
    st.sampled_from([0, ModeReg.of("LookAhead", "SProfile", "JSatSAF"), ModeReg.of("SimulationMode", "ChkMaxVel")]),
    st.lists(calls(), min_size=1, max_size=25),
)
def test_no_command_breaks_the_controller(
    machine: Machine, modereg: int, sequence: list[tuple[str, list[Any], dict[str, Any]]]
) -> None:
    mcu = Mcu(machine)
    mcu.cl(mcu.machine.axis_names)
    mcu.wrmodereg(modereg)
    for name, plain, named in sequence:
        with contextlib.suppress(*ERRORS):
            getattr(mcu, name)(*plain, **named)
        mcu.advance(3)
    mcu.advance(200)
    mcu.rs()
    assert not any(mcu.rdaxst(axis).cl for axis in mcu.machine.axis_names)
