"""Speed of rw_SymPas: `python -m benches.sympas`.

10,000 lines compiled, against Free Pascal (`fpc`, Debian's fp-compiler) on the same text in the same run. Issue 6 asks
that our compiler takes less time. Both start a process, so that what a user waits for is compared, and the compiler
alone is shown beside it.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from benches.__main__ import best
from motion_kernel import Machine

LINES = 10_000


def source(lines: int) -> str:
    """A text that both languages understand: routines, loops, conditions, expressions."""
    body = [
        "procedure P{n}(a, b : integer);",
        "var i, sum : integer; x : double;",
        "begin",
        "  sum := a * 3 + b mod 7 - (a xor b);",
        "  for i := 1 to a do sum := sum + i * (b - i);",
        "  while sum > 100 do begin",
        "    sum := sum - 17;",
        "    if (sum and 1) = 0 then g := g + 1 else h := h + 0.5;",
        "  end;",
        "  x := sum * 0.25 + sqr(h) - sin(h) * 1.5;",
        "  repeat",
        "    i := i + 1;",
        "    x := x - 1.0;",
        "  until (x < 0.0) or (i > 50);",
        "  h := x;",
        "  g := g + sum shl 1;",
        "end;",
        "",
    ]
    text = ["program Bench;", "var g : integer; h : double;"]
    count = (lines - 4) // (len(body) + 1)
    for n in range(count):
        text += [line.replace("{n}", str(n)) for line in body]
    text += ["begin", *(f"  P{n}({n}, 3);" for n in range(count)), "end."]
    return "\n".join(text) + "\n"


def main() -> None:
    """Prints the table."""
    import sympas

    text = source(LINES)
    machine = Machine.builtin()
    print(f"{text.count(chr(10))} lines, {len(text)} bytes")
    ours = best(lambda: sympas.compile(text, machine))
    print(f"compiler alone            {ours:8.3f} s  {LINES / ours:12,.0f} lines/s")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "bench.src"
        file.write_text(text)
        command = [sys.executable, "-m", "cnc_front", "check", "-q", str(file)]
        whole = best(lambda: subprocess.run(command, check=True, capture_output=True))
        print(f"cnc-front check           {whole:8.3f} s")
        fpc = shutil.which("fpc") or shutil.which("ppcx64")
        if fpc is None:
            print("skipped: fpc is not installed")
            return
        pascal = file.with_suffix(".pas")
        pascal.write_text(text)
        theirs = best(lambda: subprocess.run([fpc, "-s", str(pascal)], check=True, capture_output=True, cwd=folder))
        print(f"fpc, without link         {theirs:8.3f} s  ratio ours/fpc {whole / theirs:.2f}")


if __name__ == "__main__":
    main()
