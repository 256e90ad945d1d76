"""Everything that reads foreign bytes: no crash, no hang, and either a result or positioned findings.

A small budget in every run, always with the same cases; more with FUZZ_EXAMPLES=100000.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cnc_front._native import gcode, motion_kernel

ROOT = Path(__file__).parents[2]
JOBS = [(ROOT / "examples" / "jobs" / name).read_bytes() for name in ("bracket.nc", "cam.nc")]
MACHINE = (ROOT / "examples" / "machines" / "mill4a.toml").read_bytes()
STIMULI = [path.read_bytes() for path in sorted((ROOT / "examples" / "faults").glob("*.stim"))]
PLAYED = b"stimulus = '''\nwhile X > 1: input 3 on bouncing 4 ms\nat 1 s: X blocked\n'''\n"
SWITCHES = PLAYED + (ROOT / "examples" / "faults" / "machine.toml").read_bytes()
RULES = (
    "at when whenever while and after input output line ci on off bouncing blocked free encoder cut mended drive "
    "pushed bus error supply low lost X Y Q : , > < = 1 3 17 -5 2.5 1e9 1e99 nan s ms mm # \n \r\n"
)
VOCABULARY = (
    "G0 G1 G2 G3 G4 G17 G18 G19 G20 G28 G53 G54 G83 G90 G91 G92 X Y Z I J K R F S T M0 M6 M30 M98 P Q L N10 O1 % / ( ) "
    "; #1= [ ] + * / SQRT IF THEN EQ 0 1 -1 1.5 .5 1e9 99999999999 \n \r\n"
)
WORDS = st.sampled_from(VOCABULARY.split(" "))
BUDGET = settings(
    max_examples=int(os.environ.get("FUZZ_EXAMPLES", "150")),
    deadline=None,
    derandomize="FUZZ_EXAMPLES" not in os.environ,
    suppress_health_check=list(HealthCheck),
)
Row = tuple[str, int, int, int, str, str, str]


@st.composite
def damaged(draw: st.DrawFn, texts: list[bytes]) -> bytes:
    """A good text with a few bytes replaced, removed or doubled."""
    text = bytearray(draw(st.sampled_from(texts)))
    for _ in range(draw(st.integers(1, 8))):
        at = draw(st.integers(0, len(text) - 1))
        length = draw(st.integers(0, 6))
        text[at : at + length] = draw(st.binary(max_size=6))
    return bytes(text)


def check_findings(rows: list[Row], lines: int) -> None:
    """Each finding has a place inside the text, an id and a message."""
    for file, line, column, end_column, id, message, _hint in rows:
        assert file == "job.nc" and 1 <= line <= lines and 1 <= column <= end_column + 1
        assert id[:2] in {"GC", "GW"} and message


def compile_and_check(source: bytes) -> None:
    program, rows, _facts = gcode.compile(source, "job.nc", motion_kernel.Machine.builtin(), check_only=False)
    check_findings(rows, source.count(b"\n") + source.count(b"\r") + 1)
    has_errors = any(row[4].startswith("GC") for row in rows)
    assert (program is None) == has_errors


@BUDGET
@given(st.one_of(st.binary(max_size=400), st.lists(WORDS, max_size=60).map(lambda words: " ".join(words).encode())))
def test_any_text_as_part_program(source: bytes) -> None:
    compile_and_check(source)


@BUDGET
@given(damaged(JOBS))
def test_damaged_part_program(source: bytes) -> None:
    compile_and_check(source)


@BUDGET
@given(
    st.one_of(
        damaged(STIMULI), st.lists(st.sampled_from(RULES.split(" ")), max_size=40).map(lambda w: " ".join(w).encode())
    )
)
def test_any_text_as_stimulus(text: bytes) -> None:
    machine = motion_kernel.Machine.builtin()
    try:
        stimulus = motion_kernel.Stimulus.parse(text, "x.stim", machine)
    except motion_kernel.MachineError as error:
        assert error.args[0]
        for file, line, column, end_column, id, message, hint in error.args[0]:
            assert file == "x.stim" and 1 <= line <= text.count(b"\n") + 1 and 1 <= column <= end_column
            assert id.startswith("ST") and message and hint
    else:
        mcu = motion_kernel.Mcu(machine)
        mcu.add_stimulus(stimulus)
        mcu.advance(50)


@BUDGET
@given(damaged([MACHINE, SWITCHES]))
def test_damaged_machine_file(text: bytes) -> None:
    try:
        machine = motion_kernel.Machine.parse(text, "m.toml")
    except motion_kernel.MachineError as error:
        for file, line, column, _end, id, message, _hint in error.args[0]:
            assert file == "m.toml" and line >= 1 and column >= 1 and id.startswith(("MC", "ST")) and message
    else:
        motion_kernel.Machine.parse(machine.show().encode(), "shown.toml")


def test_the_checks_can_fail() -> None:
    with pytest.raises(AssertionError):
        check_findings([("job.nc", 3, 1, 1, "GC104", "text", "")], 2)
    with pytest.raises(AssertionError):
        check_findings([("job.nc", 1, 1, 1, "", "text", "")], 2)
