"""MDI: one block of the operator at a time, G-code or a rw_SymPas statement.

A G-code block is compiled as the last line of a program of all blocks before it, by block search: modal state,
offsets and variables are those behind them, and nothing but the block itself moves.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from cnc_front._native import sympas as native_sympas
from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import CompileError
from cnc_front.jobs import CompileOptions, JobSource, MachineFile, compile_autocode, diagnose
from cnc_front.sim_bench import Place
from cnc_front.sim_job import LoadedJob, load_source

NAME = "MDI"
#: Blocks that are remembered before modes begin anew.
MOST = 2000
#: What stands behind the block to find the state there; it is never executed.
_PROBE = "M05"
#: Positions of the search and of the machine agree within this, mm.
_SAME = 1e-6
_SEARCHED = ("GC617", "GC618")


@dataclass(frozen=True, slots=True)
class Block:
    """A block that was checked: what would be executed, and the state behind it."""

    text: str
    #: lines of the program that stand before it
    before: tuple[str, ...]
    #: where the machine stood
    place: Place
    job: LoadedJob | None = None
    statement: native_sympas.Program | None = None
    after: dict[str, Any] = field(default_factory=dict)
    #: the search calls the tool in the spindle again, which is in
    tool_is_in: bool = False


@dataclass(slots=True)
class Mdi:
    """The blocks so far and the state behind them."""

    lines: tuple[str, ...] = ()
    state: dict[str, Any] = field(default_factory=dict)

    @property
    def modal(self) -> str:
        """Active G codes behind the last block; empty before the first."""
        return str(self.state.get("modal", ""))

    def check(self, text: str, file: MachineFile, place: Place, options: CompileOptions) -> Block:
        """Compiles one block where the machine stands. Raises CompileError with lines and columns of the block."""
        text = text.strip()
        if text.endswith(";"):
            return self._statement(text, file, place, options)
        before = self._before(file, place) if self.lines else ()
        return self._block(text, before, file, place, options)

    def took(self, block: Block) -> None:
        """A block was executed to its end."""
        if block.job is not None:
            self.lines, self.state = (*block.before, block.text), block.after

    def _before(self, file: MachineFile, place: Place) -> tuple[str, ...]:
        """The lines before the next block; where the machine was moved in between, one that says where it stands. What
        cannot be said in a line ends the modal state: modes begin anew."""
        if len(self.lines) >= MOST:
            return ()
        at = self.state.get("machine", {})
        machine = file.machine
        names, letters = machine.axis_names, machine.letters
        moved = [
            a for a, name in enumerate(names) if letters[a] and abs(at.get(name, place.at[a]) - place.at[a]) > _SAME
        ]
        if not moved:
            return self.lines
        motion, *modes = self.modal.split()
        if motion not in ("G0", "G1", "G00", "G01") or "G21" not in modes:
            return ()
        words = " ".join(f"{letters[a]}{place.at[a]:.9f}" for a in moved)
        again = [motion] if motion in ("G1", "G01") else []
        again += ["G91"] if "G91" in modes else []
        return (*self.lines, f"G90 G53 G0 {words}", *([" ".join(again)] if again else []))

    def _block(
        self, text: str, before: tuple[str, ...], machine: MachineFile, place: Place, options: CompileOptions
    ) -> Block:
        first = len(before) + 1
        source = JobSource(NAME, "\n".join((*before, text, "")).encode(), "din66025")
        file = place.machine(machine)
        options = replace(options, stop=None, mdi=True)
        part = replace(options, start=str(first) if before else None)
        try:
            job = load_source(source, file, part, None)
            after = self._after(source, file, options, first + 1)
        except CompileError as error:
            if before and any(finding.line < first for finding in error.diagnostics):
                return self._block(
                    text, (), machine, place, options
                )  # what was executed no longer compiles: modes begin anew
            raise CompileError(
                [_moved(finding, first) for finding in error.diagnostics if not finding.is_warning]
            ) from None
        return Block(text, before, place, job, None, after, bool(before and self.state.get("in_spindle")))

    @staticmethod
    def _after(source: JobSource, file: MachineFile, options: CompileOptions, line: int) -> dict[str, Any]:
        """The state behind the block. CompileError where no block could follow it."""
        probed = replace(source, data=source.data + f"{_PROBE}\n".encode())
        _, findings, facts = diagnose(probed, file, replace(options, start=str(line)), check_only=True)
        if any(finding.id in _SEARCHED for finding in findings) or facts["start"] is None:
            message = "no block can follow this one: it ends the program, jumps, or leaves radius correction on"
            raise CompileError([Diagnostic(NAME, line - 1, 1, 2, "CF210", message, "put it into a part program")])
        return dict(facts["start"])

    def _statement(self, text: str, file: MachineFile, place: Place, options: CompileOptions) -> Block:
        source = JobSource(NAME, f"begin\n{text}\nend.\n".encode(), "sympas")
        program, findings = compile_autocode(source, file, options)
        if program is None:
            raise CompileError([_moved(finding, 2) for finding in findings])
        return Block(text, self.lines, place, statement=program)


def _moved(finding: Diagnostic, first: int) -> Diagnostic:
    """A finding as if the block stood alone. Behind it nothing is the operator's."""
    return replace(finding, line=max(1, finding.line - first + 1))
