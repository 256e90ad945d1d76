"""Single block while the job runs: the axes stop at block ends in the middle of what is spooled already."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from cnc_front.engine import Snapshot, State
from cnc_front.sim import SimEngine

PROGRAM = "G21 G90 G1 F3000\n" + "".join(f"X{10 * n}\n" for n in range(1, 21)) + "M30\n"
SECONDS = 20.0


@pytest.fixture
def engine(tmp_path: Path) -> Iterator[SimEngine]:
    job = tmp_path / "steps.nc"
    job.write_text(PROGRAM)
    engine = SimEngine()
    engine.load(str(job))
    engine.set_speed(5.0)
    yield engine
    engine.close()


def _x(snapshot: Snapshot) -> float:
    return snapshot.axes[0].command


def test_switched_on_while_running_it_stops_at_the_end_of_the_block(engine: SimEngine) -> None:
    engine.start()
    assert engine.wait(SECONDS, lambda s: s.state is State.RUNNING and _x(s) > 12.0)
    engine.set_single_block(True)
    assert engine.wait(SECONDS, lambda s: s.state is State.STEP)
    first = _x(engine.snapshot())
    assert first == pytest.approx(round(first, -1), abs=1e-9)
    assert first < 200.0
    # the cursor stands before the block that comes next: block X10 is line 2
    assert engine.snapshot().line == 2 + round(first / 10.0)
    for _ in range(3):
        first += 10.0
        engine.step()
        assert engine.wait(SECONDS, lambda s, x=first: s.state is State.STEP and _x(s) == pytest.approx(x, abs=1e-9))
    engine.set_single_block(False)
    engine.resume()
    assert engine.wait(SECONDS, lambda s: s.state is State.DONE)
    assert _x(engine.snapshot()) == pytest.approx(200.0, abs=1e-9)


def test_hold_stops_at_once_on_the_way_to_the_block_end(engine: SimEngine) -> None:
    engine.set_speed(1.0)
    engine.start()
    assert engine.wait(SECONDS, lambda s: s.state is State.RUNNING and _x(s) > 1.0)
    engine.set_single_block(True)
    engine.hold()
    assert engine.wait(SECONDS, lambda s: s.state is State.HOLD)
    engine.step()
    assert engine.wait(SECONDS, lambda s: s.state is State.STEP)
    assert _x(engine.snapshot()) % 10.0 == pytest.approx(0.0, abs=1e-9)
    engine.set_speed(5.0)
    for _ in range(2):
        engine.step()
        assert engine.wait(SECONDS, lambda s: s.state is not State.STEP)
        assert engine.wait(SECONDS, lambda s: s.state is State.STEP)
    engine.reset()
    assert engine.wait(SECONDS, lambda s: s.state is State.ABORTED)
