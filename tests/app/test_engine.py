"""The engine behind the terminal: the operator's wishes, and that a paced run is the run."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from cnc_front.engine import Engine, Snapshot, State
from cnc_front.errors import CompileError, UsageError
from cnc_front.sim import SimEngine
from tests.app.conftest import ROOT, Cli

PROGRAM = "G90 G21 G17\nG0 X10\nG1 X40 F3000\nG3 X50 Y10 I0 J10\nG1 Y40\nM00\nX0\nY0\nM30\n"
RESTS = (State.DONE, State.ABORTED, State.ALARM)


@pytest.fixture
def engine() -> Iterator[SimEngine]:
    engine = SimEngine(speed=0)
    yield engine
    engine.close()


def is_in(*states: State) -> Callable[[Snapshot], bool]:
    return lambda snapshot: snapshot.state in states


def loaded(engine: SimEngine, path: Path) -> None:
    engine.load(str(path))
    assert engine.wait(5, is_in(State.READY))


def test_it_is_an_engine() -> None:
    engine: Engine = SimEngine()
    assert engine.snapshot().state is State.NO_JOB
    engine.start()
    engine.hold()
    engine.reset()
    engine.close()


def test_load_describes_the_job(engine: SimEngine, job: Callable[..., Path]) -> None:
    view = engine.load(str(job(PROGRAM)))
    assert view.lines[2] == "G1 X40 F3000"
    assert view.extents["X"] == pytest.approx((0.0, 50.0), abs=1e-9)
    assert view.plot.axes == ("X", "Y", "Z")
    assert view.plot.points.shape == (len(view.plot.lines), 3)
    assert list(view.plot.points[-1]) == [0.0, 0.0, 0.0]
    assert engine.wait(10, lambda s: s.time_total_s is not None)
    assert engine.snapshot().path_total_mm == pytest.approx(40 + 5 * np.pi + 30 + 50 + 40)


def test_a_job_that_does_not_compile_starts_nothing(engine: SimEngine, job: Callable[..., Path]) -> None:
    with pytest.raises(CompileError):
        engine.load(str(job("G1 X10\n")))
    engine.start()
    assert not engine.wait(0.1, is_in(State.RUNNING))


def test_stops_for_the_operator_then_ends(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job(PROGRAM))
    engine.start()
    assert engine.wait(10, is_in(State.STOPPED))
    stopped = engine.snapshot()
    assert stopped.why == "M00"
    assert stopped.axes[1].command == 40.0
    assert stopped.axes[1].actual == pytest.approx(40.0, abs=2e-3), "the axes have settled"
    with pytest.raises(UsageError):
        engine.load(str(job(PROGRAM)))
    engine.resume()
    assert engine.wait(10, is_in(*RESTS))
    done = engine.snapshot()
    assert done.state is State.DONE
    assert done.path_done_mm == done.path_total_mm
    assert 0 < done.deviation_max_mm < 0.05
    reached, deviation = engine.new_deviation(0)
    assert reached == len(deviation) > 5
    assert np.nanmax(deviation) == pytest.approx(done.deviation_max_mm, rel=1e-5)


def test_hold_brakes_on_the_path_and_resume_goes_on(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job("G90 G21 G17\nG1 X500 F600\nM30\n"))
    engine.set_speed(1)
    engine.start()
    assert engine.wait(5, lambda s: s.feed_actual > 590)
    engine.hold()
    assert engine.wait(0.5, is_in(State.HOLD))
    held = engine.snapshot()
    assert 0 < held.axes[0].command < 500
    engine.resume()
    assert engine.wait(2, is_in(State.RUNNING))
    engine.set_speed(0)
    assert engine.wait(10, is_in(State.DONE))
    assert engine.snapshot().deviation_max_mm < 0.05


def test_reset_drops_the_job_and_start_begins_anew(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job("G90 G21\nG1 X500 F600\nM30\n"))
    engine.set_speed(5)
    engine.start()
    assert engine.wait(5, lambda s: s.axes[0].command > 1)
    engine.reset()
    assert engine.wait(5, is_in(State.ABORTED))
    assert engine.snapshot().axes[0].command < 500
    engine.reset()
    assert engine.wait(5, is_in(State.READY))
    engine.set_speed(0)
    engine.start()
    assert engine.wait(10, is_in(State.DONE))
    assert engine.snapshot().axes[0].command == 500.0


def test_single_block_stops_at_every_block(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job("G90 G21\nG1 X5 F3000\nX10\nX15\nM30\n"))
    ends = []
    for _ in range(12):
        engine.step()
        assert engine.wait(5, is_in(State.STEP, State.DONE))
        engine.wait(0.05, lambda s: False)
        assert engine.wait(5, is_in(State.STEP, State.DONE))
        ends.append(engine.snapshot().axes[0].command)
        if engine.snapshot().state is State.DONE:
            break
    assert engine.snapshot().single_block
    assert sorted(set(ends) - {0.0}) == [5.0, 10.0, 15.0]


def test_override_ramps_and_refuses_zero(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job("G90 G21\nG1 X500 F600\nX-500\nM30\n"))
    engine.set_speed(1)
    engine.start()
    assert engine.wait(5, lambda s: s.feed_actual > 590)
    engine.set_override(0.0)
    assert engine.wait(1, lambda s: "refused" in s.message)
    engine.set_override(0.5)
    assert engine.wait(3, lambda s: s.override_effective == 0.5)
    assert engine.snapshot().override_set == 0.5
    assert engine.snapshot().feed_actual == pytest.approx(300.0)


def test_a_paced_run_is_the_run(job: Callable[..., Path]) -> None:
    path = job("G90 G21 G17\nG1 X20 F3000\nG3 X30 Y10 I0 J10\nM30\n")
    results = []
    for speed in (0.0, 3.0):
        engine = SimEngine(speed=speed)
        loaded(engine, path)
        engine.start()
        assert engine.wait(20, is_in(*RESTS))
        done = engine.snapshot()
        results.append((done.state, done.machine_time_s, done.deviation_max_mm, done.deviation_max_line))
        engine.close()
    assert results[0] == results[1]


def test_examples_run_in_the_engine(engine: SimEngine) -> None:
    engine.load(str(ROOT / "examples" / "jobs" / "cam.nc"))
    assert engine.wait(5, is_in(State.READY))
    engine.start()
    for _ in range(20):
        assert engine.wait(20, is_in(State.STOPPED, *RESTS))
        if engine.snapshot().state is not State.STOPPED:
            break
        engine.resume()
        engine.wait(0.05, lambda s: False)
    assert engine.snapshot().state is State.DONE


def test_alarms_have_code_text_and_language(job: Callable[..., Path], tmp_path: Path) -> None:
    text = (ROOT / "examples" / "machines" / "mill3.toml").read_text()
    weak = tmp_path / "weak.toml"
    lines = ["mpe = 0.005" if line.strip().startswith("mpe") else line for line in text.splitlines()]
    weak.write_text("\n".join(lines))
    engine = SimEngine(str(weak), language="de", speed=0)
    loaded(engine, job(PROGRAM))
    engine.start()
    assert engine.wait(10, lambda s: len(s.alarms) > 0)
    alarm = engine.snapshot().alarms[0]
    assert (alarm.code, alarm.axis) == ("E107", "X")
    assert alarm.text.startswith("Schleppfehler 0.005") and "> 0.005 mm (mpe); Antrieb" in alarm.text
    engine.close()


def test_an_alarm_names_its_bit_and_a_bouncing_contact_is_one(tmp_path: Path) -> None:
    faults = ROOT / "examples" / "faults"
    for name, expected in {
        "blocked_axis": [("E107", "X", "mpe", 5)],
        "emergency_out": [("E101", axis, "eo", 7) for axis in "XYZ"],
        "limit_tom": [("E104", "X", "lsrh", 5), ("E107", "X", "mpe", 0)],
    }.items():
        job = tmp_path / f"{name}.nc"
        job.write_text((faults / "contour.nc").read_text())
        job.with_suffix(".stim").write_text((faults / f"{name}.stim").read_text())
        engine = SimEngine(str(faults / "machine.toml"), speed=0)
        loaded(engine, job)
        engine.start()
        assert engine.wait(20, is_in(*RESTS))
        snapshot = engine.snapshot()
        assert [(a.code, a.axis, a.name, a.line) for a in snapshot.alarms] == expected
        assert snapshot.why == expected[0][2], "what stopped the job, not what came of it"
        bits = {axis.name: axis.bits for axis in snapshot.axes}
        assert all(alarm.name in bits[alarm.axis] for alarm in snapshot.alarms), "until the reset"
        assert 20 < snapshot.path_done_mm < 110 and snapshot.line in (5, 7), "where it stopped, not 0, not the end"
        engine.close()


@pytest.mark.parametrize("speed", [0.0, 40.0])
def test_a_fault_of_the_world_outside_is_an_alarm_that_stopped(tmp_path: Path, speed: float) -> None:
    faults = ROOT / "examples" / "faults"
    rules = (faults / "limit_smd.stim").read_text()
    machine = tmp_path / "faults.toml"
    machine.write_text(f"stimulus = '''\n{rules}'''\n" + (faults / "machine.toml").read_text())
    engine = SimEngine(str(machine), language="de", speed=speed)
    loaded(engine, faults / "contour.nc")
    engine.start()
    assert engine.wait(20, is_in(*RESTS))
    snapshot = engine.snapshot()
    assert snapshot.state is State.ALARM
    alarm = snapshot.alarms[0]
    assert (alarm.code, alarm.axis, alarm.line, alarm.stopped) == ("E103", "X", 10, True)
    assert "linker Hardware-Endschalter" in alarm.text
    assert -6.1 < snapshot.axes[0].actual < -5.5, "braked and at rest"
    engine.close()


def test_the_outcome_is_that_of_run(engine: SimEngine, cli: Cli) -> None:
    """What the terminal reports of an undisturbed run is what `cnc-front run` reports."""
    path = ROOT / "examples/faults/contour.nc"
    loaded(engine, path)
    assert engine.outcome() is None
    engine.start()
    assert engine.wait(20, is_in(*RESTS))
    outcome = engine.outcome()
    assert outcome is not None and outcome.number == 1 and outcome.code == 0
    ran = cli("run", path, "--json").object
    for key in ("verdict", "deviation", "following_error", "machine_time_s", "samples", "alarms", "findings", "axes"):
        assert outcome.run[key] == ran[key], key
    assert outcome.worst[0].line == ran["deviation"]["actual"]["worst"]["line"]
    engine.start()
    assert engine.wait(20, lambda s: engine.outcome() is not outcome)
    again = engine.outcome()
    assert again is not None and again.number == 2


def test_progress_stands_still_in_a_hold(engine: SimEngine) -> None:
    """Also in the middle of a block: what a hold cut off is not taken for the whole block."""
    loaded(engine, ROOT / "examples/faults/contour.nc")
    engine.set_speed(1)
    engine.start()
    assert engine.wait(10, lambda s: s.path_done_mm > 20)
    engine.hold()
    assert engine.wait(5, is_in(State.HOLD))
    held = engine.snapshot()
    assert 20 < held.path_done_mm < 60 and held.path_done_mm == pytest.approx(held.axes[0].command + 1.0, abs=1e-6)
    assert held.axes[0].to_go == pytest.approx(50 - held.axes[0].command, abs=1e-9) and held.axes[1].to_go == 0.0


def test_a_second_run_begins_where_the_first_left_the_machine(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job("G90 G21 G17\nG1 X10.12345678 Y3.3333333 F3000\nG1 X1.7654321\nM30\n"))
    for number in (1, 2):
        engine.start()
        assert engine.wait(20, lambda s, n=number: (o := engine.outcome()) is not None and o.number == n)  # type: ignore[misc]
        outcome = engine.outcome()
        assert outcome is not None and outcome.run["verdict"]["word"] == "PASS", outcome.run["verdict"]


def test_the_outcome_of_an_aborted_run(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job("G90 G21 G17\nG1 X400 F300\nM30\n"))
    engine.set_speed(5)
    engine.start()
    assert engine.wait(5, lambda s: s.path_done_mm > 1)
    engine.reset()
    assert engine.wait(10, is_in(State.ABORTED))
    outcome = engine.outcome()
    assert outcome is not None and outcome.code == 130 and outcome.run["status"] == "stopped"
    assert [reason["id"] for reason in outcome.run["verdict"]["reasons"]] == ["interrupted"]


def test_a_load_that_nobody_wants_any_more_replaces_nothing(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job(PROGRAM))
    with pytest.raises(UsageError, match="not wanted"):
        engine.load(str(job("G90 G21 F500\nG1 X5\nM30\n", "other.nc")), lambda: False)
    assert not engine.wait(0.1, lambda s: s.revision > 1)
    view = engine.current_job()
    assert view is not None and view.name != "other.nc" and view.path_mm == pytest.approx(40 + 5 * np.pi + 30 + 50 + 40)


def test_a_fault_by_hand_is_an_alarm_until_the_axes_move_again(tmp_path: Path) -> None:
    machine = tmp_path / "weak.toml"
    text = (ROOT / "examples" / "faults" / "machine.toml").read_text()
    machine.write_text(text.replace("mpe = 1.0 ", "mpe = 0.002 "))
    engine = SimEngine(str(machine), speed=0)
    engine.jog("X", 10.0)
    assert engine.wait(5, lambda s: bool(s.alarms))
    (alarm,) = engine.snapshot().alarms
    assert (alarm.code, alarm.axis, alarm.name, alarm.stopped) == ("E107", "X", "mpe", True)
    assert "> 0.002 mm (mpe)" in alarm.text and "mpe" in engine.snapshot().axes[0].bits
    engine.close()
