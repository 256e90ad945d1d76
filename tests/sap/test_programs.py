"""Every program of this room does what stands beside its lines."""

from __future__ import annotations

import operator
import re

import pytest

from tests.sap.jobs import NUMBER, VALUE, Job, Program, findings, programs, remarks

RELATIONS = {"=": operator.eq, ">=": operator.ge, "<=": operator.le, ">": operator.gt, "<": operator.lt}
PROGRAMS = [pytest.param(p, marks=pytest.mark.shows(*p.rows), id=f"{p.file}:{p.line}") for p in programs()]


@pytest.mark.parametrize("program", PROGRAMS)
def test_program(program: Program) -> None:
    notes = remarks(program.text)
    wrong = sorted(line for line, note in notes if note.startswith("refused"))
    warned = {line for line, note in notes if note == "warned"}
    diagnostics = findings(program.text)
    assert sorted(d.line for d in diagnostics if not d.is_warning) == wrong, [str(d) for d in diagnostics]
    ends = {line for line, note in notes if note.startswith("error")}  # the compiler may foresee it
    assert {d.line for d in diagnostics if d.is_warning} - ends == warned, [str(d) for d in diagnostics]
    for line, note in notes:
        if note.startswith("refused "):
            assert any(d.line == line and d.id == note.split()[1] for d in diagnostics), note
    if not wrong:
        execute(program, notes)


def execute(program: Program, notes: list[tuple[int, str]]) -> None:
    job = Job(program.text)
    limit = next((float(m[1]) for _, note in notes if (m := re.fullmatch(rf"within {NUMBER} s", note))), None)
    for _, note in notes:
        if note.startswith("stimulus: "):
            job.mcu.add_stimulus(note.removeprefix("stimulus: "))
    for seconds, action in sorted(timed(notes)):
        job.run(seconds - job.mcu.samples * 0.00128)
        act(job, action)
    job.run(limit - job.mcu.samples * 0.00128 if limit else 60.0)
    status = job.mcu.rdcncts(0)
    errors = [(line, int(note.split()[1])) for line, note in notes if note.startswith("error ")]
    assert [(status.errline, status.errnum)] == (errors or [(0, 0)])
    assert limit is not None or not status.running & 1, f"line {status.csrcline} goes on"
    for line, note in notes:
        check(job, program, line, note)


def timed(notes: list[tuple[int, str]]) -> list[tuple[float, str]]:
    matches = (re.fullmatch(rf"at {NUMBER} s: (.+)", note) for _, note in notes)
    return [(float(m[1]), m[2]) for m in matches if m]


def act(job: Job, action: str) -> None:
    if m := re.fullmatch(r"CI(\d+) = (-?\d+)", action):
        job.mcu.wrci(int(m[1]), int(m[2]))
        return
    m = re.fullmatch(r"(\d+) (on|off)", action)
    assert m, action
    job.mcu.set_inputs(switched(job, 1 << int(m[1]) - 1, m[2] == "on"))


def switched(job: Job, bit: int, on: bool) -> int:
    """The levels of the inputs with one of them changed; input 6 is inverted (drive ready)."""
    levels: int = job.__dict__.setdefault("levels", 0)
    job.__dict__["levels"] = levels | bit if on else levels & ~bit
    return job.__dict__["levels"]


def check(job: Job, program: Program, line: int, note: str) -> None:
    where = f"{program.file}:{program.line + line - 1}: {note}"
    if note.startswith("output: "):
        assert job.mcu._mcu.take_output(0) == note.removeprefix("output: ").replace("\\n", "\n"), where
    for kind, number, relation, text, tolerance in VALUE.findall(note):
        if note.startswith("at "):
            continue
        value = job.ci(int(number)) if kind == "CI" else job.cd(int(number))
        if relation == "=" and kind == "CD":
            assert value == pytest.approx(float(text), rel=1e-9, abs=float(tolerance or 1e-9), nan_ok=True), where
        else:
            assert RELATIONS[relation](value, float(text)), f"{where}, but it is {value}"
