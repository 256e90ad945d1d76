"""`python -m tui.picture [JOB [FILE.svg]]`: the picture of the terminal in the README, from a real run."""

from __future__ import annotations

import asyncio
import sys
import time
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from cnc_front.engine import State
from cnc_front.sim import SimEngine
from tui.app import Terminal
from tui.look import make_look
from tui.words import Words

#: The run is held here, so that the picture shows what is done and what is to do.
SHARE = 0.55
SPEED = 10.0


async def take_picture(job: str) -> str:
    """Runs a job to about half, at 120x40, and returns the screen as SVG."""
    engine = SimEngine(speed=SPEED)
    app = Terminal(
        engine,
        make_look("dark", "braille"),
        Words(),
        job=job,
        clock=lambda: datetime(2026, 1, 2, 12, 31, 7),
        paced=False,
    )
    try:
        async with app.run_test(size=(120, 40)) as pilot:

            async def until(true: Callable[[], bool]) -> None:
                deadline = time.monotonic() + 120
                while not true() and time.monotonic() < deadline:
                    if engine.snapshot().state is State.STOPPED:
                        engine.resume()
                    await asyncio.sleep(0.02)
                    app.tick()

            await until(lambda: app.job is not None and engine.snapshot().time_total_s is not None)
            engine.start()
            await until(lambda: engine.snapshot().path_done_mm > SHARE * engine.snapshot().path_total_mm)
            app.tick()
            await pilot.pause()
            return app.export_screenshot(title="cnc-front tui")
    finally:
        engine.close()


def main() -> None:
    """Writes the picture."""
    job = sys.argv[1] if len(sys.argv) > 1 else "examples/jobs/cam.nc"
    target = Path(sys.argv[2] if len(sys.argv) > 2 else "docs/terminal.svg")
    target.write_text(_without_addresses(asyncio.run(take_picture(job))), "utf-8")
    print(target, target.stat().st_size, "bytes")


def _without_addresses(svg: str) -> str:
    """Rich's template names web fonts; a picture in a repository asks nobody for anything."""
    lines = svg.split("\n")
    begins = [i for i, line in enumerate(lines) if "@font-face" in line]
    for begin in reversed(begins):
        end = next(i for i in range(begin, len(lines)) if lines[i].strip() == "}")
        del lines[begin : end + 1]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
