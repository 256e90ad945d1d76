"""rw_SymPas programs as tests: what a program leaves behind is written beside its lines.

A file holds programs, each below a line `{ shows: row, row }`. Comments that the runner reads:

    // CD0 = 50.0          common variable at the end; also >, <, >=, <=, and `= 50.0 +- 0.1`
    // error 256           the runtime error of that line ends the task
    // refused 91          the compiler refuses that line (or `// refused`)
    // warned              the compiler warns of that line
    // at 0.5 s: 5 on      input 5 becomes active half a second after the start; also `5 off`
    // at 0.5 s: CI9 = 1   written from outside
    // stimulus: at 1 s: A1 encoder cut       a rule of docs/stimulus.md
    // within 2 s          the task need not end: it is looked at after that time (else 60 s)
    // output: text        the text that the task writes
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import sympas
from motion_kernel import Machine, Mcu

#: A job to step through.
LOOPS = """program Loops;
var i, sum : integer;
    mean : double;
function Half(n : integer) : double;
begin
  Half := n / 2.0;
end;
begin
  for i := 1 to 3 do
    sum := sum + i;
  mean := Half(sum);
  writeln('mean ', mean);
  wt(15625);
  CI0 := 1;
end.
"""

HERE = Path(__file__).parent
CELL = Machine.load(HERE / "cell.toml")
HEAD = re.compile(r"^\{ shows: ([^}]*)\}\n", re.MULTILINE)
VALUE = re.compile(r"(C[ID])(\d+)\s*(=|>=|<=|>|<)\s*(-?[\w.+-]+)(?:\s*\+-\s*([\d.e-]+))?")
NUMBER = r"(\d+(?:\.\d+)?)"


@dataclass(frozen=True)
class Program:
    """One program and what it must do."""

    rows: tuple[str, ...]
    file: str
    line: int
    text: str


def programs() -> list[Program]:
    """All programs of the files beside this one."""
    found: list[Program] = []
    for path in sorted(HERE.glob("*.src")):
        text = path.read_text("utf-8")
        heads = list(HEAD.finditer(text))
        assert heads and heads[0].start() == 0, f"{path.name} begins with no program"
        for n, head in enumerate(heads):
            end = heads[n + 1].start() if n + 1 < len(heads) else len(text)
            rows = tuple(head[1].replace(",", " ").split())
            line = text.count("\n", 0, head.end()) + 1
            found.append(Program(rows, path.name, line, text[head.end() : end]))
    return found


def findings(text: str) -> tuple[sympas.Diagnostic, ...]:
    """Everything the compiler says of a program."""
    try:
        return sympas.compile(text, CELL).warnings
    except sympas.CompileError as error:
        return error.diagnostics


@dataclass
class Job:
    """A controller that executes a program in a task."""

    text: str
    machine: Machine = CELL
    task: int = 0
    mcu: Mcu = field(init=False)

    def __post_init__(self) -> None:
        self.mcu = Mcu(self.machine)
        self.load(self.text, self.task)
        self.mcu.startcnct(self.task)

    def load(self, text: str, task: int) -> None:
        """Compiles a further program into a task, without starting it."""
        self.mcu.load(task, sympas.compile(text, self.machine))

    def run(self, seconds: float = 60.0) -> Job:
        """Lets the task run to its end, or for that time."""
        for _ in range(max(1, round(seconds / 0.00128))):
            self.mcu.advance(1)
            if not self.mcu.rdcncts(self.task).running & 1:
                break
        return self

    def ci(self, number: int) -> int:
        return self.mcu.rdci(number)

    def cd(self, number: int) -> float:
        return self.mcu.rdcd(number)


def remarks(text: str) -> list[tuple[int, str]]:
    """Line number and remark for the runner of each line that has one."""
    lines = (line.partition("//") for line in text.splitlines())
    return [(n, remark.strip()) for n, (_, mark, remark) in enumerate(lines, 1) if mark]
