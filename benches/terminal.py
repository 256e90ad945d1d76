"""`python -m benches.terminal [LINES]`: what the terminal costs, in a real pseudo-terminal of 120x40.

Prints: translation of a program of a million lines, its first frame behind that, the slowest frame while scrolling;
then the share of one core at 10 Hz while a path of 100,000 points is driven at x1, terminal and emulator together.
"""

from __future__ import annotations

import fcntl
import os
import pty
import select
import struct
import sys
import tempfile
import termios
import time
from math import cos, sin
from pathlib import Path

LINES = 1_000_000
POINTS = 100_000
#: Seconds for which the share of a core is measured.
WATCHED_S = 8.0


def spiral(lines: int) -> str:
    """A spiral in blocks of some 0.1 mm."""
    blocks = ["G90 G21 G94 G64 P0"]
    for n in range(lines - 2):
        angle = 0.02 * n**0.5 * 6
        radius = 0.05 + 60.0 * (n / lines)
        feed = " F3000" if n == 0 else ""
        blocks.append(f"G1 X{radius * cos(angle):.3f} Y{radius * sin(angle):.3f}{feed}")
    return "\n".join([*blocks, "M30", ""])


def child(path: str, watched_s: float) -> None:
    """Runs the terminal in this process's terminal; figures go to file descriptor 3."""
    from cnc_front.engine import Job, State
    from cnc_front.sim import SimEngine
    from tui.app import Terminal
    from tui.look import make_look
    from tui.words import Words

    engine = SimEngine(speed=1.0)
    figures: dict[str, float] = {}

    class Measured(Terminal):
        def on_mount(self) -> None:
            super().on_mount()
            self.run_worker(self._open, thread=True)

        def _open(self) -> None:
            began = time.monotonic()
            job = engine.load(path)
            figures["translation_s"] = time.monotonic() - began
            self.call_from_thread(self._first, job)
            if watched_s:
                self._watch()
            self.call_from_thread(self.exit)

        def _first(self, job: Job) -> None:
            began = time.monotonic()
            while self.job is not job:
                engine.wait(5, lambda s: s.revision > 0)
                self.tick()
            figures["first_frame_s"] = time.monotonic() - began
            slowest = 0.0
            for _ in range(200):
                before = time.monotonic()
                self.page.scroll(20)
                self.program.choose(self.program.chosen * 2 % len(job.lines) + 1)
                self.tick()
                slowest = max(slowest, time.monotonic() - before)
            figures["slowest_scroll_s"] = slowest

        def _watch(self) -> None:
            engine.wait(120, lambda s: s.time_total_s is not None)
            engine.start()
            engine.wait(10, lambda s: s.state is State.RUNNING)
            time.sleep(1.0)
            cpu, wall = time.process_time(), time.monotonic()
            time.sleep(watched_s)
            figures["core_share"] = (time.process_time() - cpu) / (time.monotonic() - wall)
            figures["vertices"] = float(len(self.picture._points))

    Measured(engine, make_look("dark", "quadrant"), Words()).run()
    engine.close()
    os.write(3, "\n".join(f"{name} {value:.3f}" for name, value in figures.items()).encode())


def measured(path: Path, watched_s: float) -> dict[str, float]:
    """Runs `child` in a pseudo-terminal whose other side is read at once."""
    reader, writer = os.pipe()
    pid, master = pty.fork()
    if pid == 0:
        os.dup2(writer, 3)
        os.environ["TERM"] = "xterm-256color"
        os.execv(sys.executable, [sys.executable, "-m", "benches.terminal", "--child", str(path), str(watched_s)])
    os.close(writer)
    fcntl.ioctl(master, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 120, 0, 0))
    while True:
        ready, _, _ = select.select([master, reader], [], [], 600)
        if not ready or reader in ready:
            break
        try:
            os.read(master, 1 << 16)
        except OSError:
            break
    rows = os.read(reader, 1 << 16).decode().splitlines()
    os.waitpid(pid, 0)
    if not rows:
        raise SystemExit("the terminal ended without figures")
    return {name: float(value) for name, value in (row.split() for row in rows)}


def main() -> None:
    """Both programs, one row each."""
    lines = int(sys.argv[1]) if len(sys.argv) > 1 else LINES
    with tempfile.TemporaryDirectory() as folder:
        for count, watched_s in ((lines, 0.0), (POINTS, WATCHED_S)):
            path = Path(folder) / f"spiral{count}.nc"
            path.write_text(spiral(count))
            figures = measured(path, watched_s)
            print(f"{count:>9} lines: " + "  ".join(f"{name} {value:g}" for name, value in figures.items()))


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        child(sys.argv[2], float(sys.argv[3]))
    else:
        main()
