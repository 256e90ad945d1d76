"""The engine under the operator's hand: jogs, homing, offsets, inputs, MDI, switches, overrides, start at block."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from cnc_front.engine import Mode, Snapshot, State, Stop, Switches
from cnc_front.errors import CompileError, UsageError
from cnc_front.german import localized
from cnc_front.sim import SimEngine
from tests.app.conftest import ROOT

CELL = str(ROOT / "examples" / "pcap" / "cell.toml")
SWITCHES = str(ROOT / "examples" / "faults" / "machine.toml")
JOB = "G90 G21\nN10 G0 X10\nN20 G1 X50 F3000\nN30 Y10\nN40 X0 Y0\nM30\n"


@pytest.fixture
def engine() -> Iterator[SimEngine]:
    engine = SimEngine(speed=0)
    yield engine
    engine.close()


def settled(engine: SimEngine, act: Callable[[], None], seconds: float = 20.0) -> Snapshot:
    """Does something, and waits until nothing moves any more."""
    done: list[int] = []
    act()
    engine._wish(lambda: done.append(1))
    deadline = time.monotonic() + seconds
    while not done or engine._machine.moves_on or not engine._wishes.empty():
        assert time.monotonic() < deadline
        time.sleep(0.002)
    time.sleep(0.02)
    return engine.snapshot()


def commands(snapshot: Snapshot) -> list[float]:
    return [axis.command for axis in snapshot.axes]


def mdi(engine: SimEngine, block: str) -> Snapshot:
    engine.check_mdi(block)
    return settled(engine, engine.start_mdi)


def loaded(engine: SimEngine, path: Path) -> None:
    engine.load(str(path))
    assert engine.wait(5, lambda s: s.state is State.READY)


def run(engine: SimEngine) -> Snapshot:
    engine.start()
    assert engine.wait(5, lambda s: s.state is not State.READY and s.state is not State.NO_JOB)
    assert engine.wait(20, lambda s: s.state in (State.DONE, State.STOPPED, State.ALARM))
    return settled(engine, lambda: None)


# ---- manual


def test_a_jog_is_one_step_and_presses_during_it_are_dropped(engine: SimEngine) -> None:
    after = settled(engine, lambda: [engine.jog("X", 10.0) for _ in range(5)] and None)
    assert commands(after) == [10.0, 0.0, 0.0]
    assert after.mode is Mode.MANUAL
    assert commands(settled(engine, lambda: engine.jog("Z", -0.001))) == pytest.approx([10.0, 0.0, -0.001])


def test_a_jog_does_not_pass_a_limit_and_not_through_a_job(engine: SimEngine, job: Callable[..., Path]) -> None:
    refused = settled(engine, lambda: engine.jog("X", 601.0))
    assert commands(refused)[0] == 0.0 and "software limit" in refused.message
    loaded(engine, job("G90 G21\nG1 X50 F600\nM00\nM30\n"))
    run(engine)
    refused = settled(engine, lambda: engine.jog("X", 1.0))
    assert refused.state is State.STOPPED and commands(refused)[0] == 50.0 and "busy" in refused.message


def test_hold_stops_a_jog_on_its_own_ramp(engine: SimEngine) -> None:
    engine.set_speed(1)
    engine.jog("X", 500.0)
    assert engine.wait(5, lambda s: s.axes[0].command > 1.0)
    assert engine.snapshot().state is State.RUNNING
    engine.hold()
    assert engine.wait(2, lambda s: s.state is State.NO_JOB)
    after = engine.snapshot()
    assert 1.0 < after.axes[0].command < 400.0 and after.stop is Stop.FAST_STOP
    assert commands(settled(engine, lambda: engine.jog("X", 1.0)))[0] == pytest.approx(after.axes[0].command + 1.0)


def test_homing_finds_the_same_place_from_anywhere() -> None:
    engine = SimEngine(CELL, speed=0)
    home = settled(engine, lambda: engine.home(["X", "Y"]))
    assert home.message == ""
    assert [axis.homing for axis in home.axes] == ["switch+index", "switch+index", ""]
    shift = engine._machine.bench.place.shift
    # switches at -80 and -50; the index pulses behind them at 1.3 - 16 * 5 and 3.1 - 10 * 5: those are the reference 0
    assert shift == pytest.approx((78.7, 46.9, 0.0), abs=2e-3)
    settled(engine, lambda: engine.jog("X", 33.3))
    settled(engine, lambda: engine.home(["X"]))
    assert engine._machine.bench.place.shift[0] == pytest.approx(shift[0], abs=2e-3)
    refused = settled(engine, lambda: engine.home(["Z"]))
    assert "Z" in refused.message and "reference switch" in refused.message
    engine.close()


def test_homing_goes_where_the_machine_file_says(tmp_path: Path) -> None:
    machine = tmp_path / "right.toml"
    text = Path(CELL).read_text().replace("while X < -80: input 1", "while X > 250: input 1")
    machine.write_text(text.replace('name = "X"', 'name = "X"\nhome_direction = "right"', 1))
    engine = SimEngine(str(machine), speed=0)
    home = settled(engine, lambda: engine.home(["Y", "X"]))
    assert home.message == "" and [axis.home_side for axis in home.axes] == ["right", "left", "left"]
    assert [axis.home_place for axis in home.axes] == [1, 2, 0]
    # onto the switch at 250 from the left, then back to the last index pulse before it: 1.3 + 49 * 5
    assert engine._machine.bench.place.shift == pytest.approx((-246.3, 46.9, 0.0), abs=0.03)
    engine.close()


def test_a_search_that_finds_nothing_says_so_and_ends() -> None:
    engine = SimEngine(SWITCHES, speed=0)  # without its rules nothing actuates the switch
    after = settled(engine, lambda: engine.home(["X"]))
    assert after.state is State.NO_JOB and "X: reference not found" in after.message
    engine.close()


def test_an_input_can_be_forced_whatever_its_inversion() -> None:
    engine = SimEngine(SWITCHES, speed=0)
    before = engine.snapshot().inputs
    on = settled(engine, lambda: engine.force_input(5, True))
    assert on.inputs == before | 1 << 4
    assert settled(engine, lambda: engine.force_input(5, False)).inputs == before
    # input 3 is inverted: forced active it is the left limit switch of X
    switch = settled(engine, lambda: engine.force_input(3, True))
    assert "lslh" in switch.axes[0].bits
    engine.close()


@pytest.mark.parametrize("by", ["reset", "release_inputs"])
def test_forced_inputs_stay_until_they_are_released(engine: SimEngine, job: Callable[..., Path], by: str) -> None:
    settled(engine, lambda: engine.force_input(5, True))
    settled(engine, lambda: engine.force_input(5, False))
    settled(engine, lambda: engine.force_input(2, True))
    assert settled(engine, lambda: engine.force_input(5, True)).forced == (2, 5)
    loaded(engine, job("G90 G21\nG1 X5 F3000\nM00\nM30\n"))
    stands = run(engine)
    assert stands.state is State.STOPPED and stands.forced == (2, 5) and stands.inputs == 0b10010
    free = settled(engine, getattr(engine, by))
    assert free.forced == () and free.inputs == 0
    assert not engine._machine.bench.is_changed


def test_a_work_offset_counts_in_programs(engine: SimEngine, job: Callable[..., Path]) -> None:
    settled(engine, lambda: engine.jog("X", 10.0))
    assert settled(engine, lambda: engine.set_zero("X")).axes[0].zero == 10.0
    loaded(engine, job("G90 G21\nG1 X5 F3000\nM30\n"))
    assert commands(run(engine))[0] == 15.0


# ---- MDI


def test_modes_carry_over_from_block_to_block(engine: SimEngine) -> None:
    assert commands(mdi(engine, "G1 X20 F3000")) == [20.0, 0.0, 0.0]
    assert commands(mdi(engine, "Y5")) == [20.0, 5.0, 0.0]
    relative = mdi(engine, "G91 X1")
    assert "G91" in relative.mdi_modal and relative.state is State.DONE and relative.mode is Mode.MDI
    settled(engine, lambda: engine.jog("Z", 3.0))
    assert commands(mdi(engine, "X1")) == [22.0, 5.0, 3.0]  # a jog changes the place, not the modes
    assert mdi(engine, "S500 M3").spindle == "M3 S500"
    assert mdi(engine, "X1").spindle == "M3 S500"
    assert commands(mdi(engine, "G90 G20 X1"))[0] == pytest.approx(25.4)
    settled(engine, lambda: engine.jog("Z", 1.0))
    assert commands(mdi(engine, "Y0")) == pytest.approx([25.4, 0.0, 4.0])


def test_a_tool_is_asked_for_once(engine: SimEngine) -> None:
    asked = mdi(engine, "T3 M06")
    assert asked.state is State.STOPPED and asked.why == "M06"
    assert settled(engine, engine.resume).state is State.DONE
    assert mdi(engine, "G1 X5 F600").state is State.DONE, "the tool is in"


@pytest.mark.parametrize(
    ("block", "id", "column"), [("G1 X20 U", "GC202", 8), ("M30", "CF210", 1), ("nonsense(;", None, None)]
)
def test_a_bad_block_is_explained_and_starts_nothing(
    engine: SimEngine, block: str, id: str | None, column: int | None
) -> None:
    with pytest.raises(CompileError) as error:
        engine.check_mdi(block)
    first = error.value.diagnostics[0]
    assert first.line == 1
    assert id is None or (first.id, first.column) == (id, column)
    assert settled(engine, engine.start_mdi).state is State.NO_JOB


def test_statements_of_the_controller_language(engine: SimEngine) -> None:
    assert mdi(engine, "CI20 := 7;").output == ()
    assert mdi(engine, "writeln('CI20 is ', CI20);").output == ("CI20 is 7",)
    assert commands(mdi(engine, "jrw(X := 7.5);"))[0] == 7.5
    assert "runtime error" in mdi(engine, "writeln(1 / 0);").message
    assert commands(mdi(engine, "G1 X8 F600"))[0] == 8.0, "G-code goes on where the statement left the axis"


def test_variables_outlive_blocks_of_both_languages(engine: SimEngine) -> None:
    mdi(engine, "CI20 := 7; CD30 := 2.5; CI99 := 4;")
    assert mdi(engine, "G1 X8 F600").state is State.DONE
    assert mdi(engine, "T3 M06").state is State.STOPPED and settled(engine, engine.resume).state is State.DONE
    assert mdi(engine, "writeln(CI20, ' ', CD30);").output[-1].split() == ["7", "2.5"]
    assert mdi(engine, "S500 M3").spindle == "M3 S500"


def test_a_program_begins_with_none_of_them(engine: SimEngine, job: Callable[..., Path]) -> None:
    mdi(engine, "CI20 := 7;")
    loaded(engine, job(JOB))
    run(engine)
    assert mdi(engine, "writeln(CI20);").output[-1].strip() == "0"


RATES = "TRAC := 500.0; TRVL := 50.0; TRTVL := 0.0; "


def held(engine: SimEngine, statement: str) -> Snapshot:
    """Holds a statement in the middle of its motion."""
    engine.set_speed(1)
    engine.check_mdi(statement)
    engine.start_mdi()
    assert engine.wait(5, lambda s: s.axes[0].command > 1.0)
    engine.hold()
    assert engine.wait(2, lambda s: s.state not in (State.RUNNING, State.HOLDING))
    return settled(engine, lambda: engine.set_speed(0))


def test_a_jog_in_a_statement_ends_at_a_hold_and_says_so(engine: SimEngine) -> None:
    after = held(engine, "jr(X := 100);")
    assert after.state is State.NO_JOB and after.stop is Stop.FAST_STOP and "FAST STOP" in after.message
    assert 1.0 < commands(settled(engine, engine.resume))[0] < 50.0


def test_a_contour_in_a_statement_goes_on_behind_a_hold(engine: SimEngine) -> None:
    after = held(engine, RATES + "smlr(X := 100); ssms(X);")
    assert (after.state, after.stop, after.why) == (State.HOLD, Stop.HOLD, "hold")
    assert commands(settled(engine, engine.resume))[0] == pytest.approx(100.0)


def test_of_a_contour_and_a_jog_a_hold_says_which_one_ended(engine: SimEngine) -> None:
    after = held(engine, RATES + "smlr(X := 100); ssms(X); jr(Z := 20);")
    assert after.state is State.HOLD and after.why == "jog" and "jog of Z has ended" in after.message
    at = settled(engine, engine.resume)
    assert commands(at)[0] == pytest.approx(100.0) and commands(at)[2] < 10.0 and at.message == ""


def test_mdi_is_refused_while_a_job_is_under_way(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job("G90 G21\nG1 X50 F600\nM00\nM30\n"))
    run(engine)
    with pytest.raises(UsageError):
        engine.check_mdi("G0 X0")


def test_a_block_that_was_checked_elsewhere_is_not_executed(engine: SimEngine) -> None:
    engine.check_mdi("G1 X20 F3000")
    settled(engine, lambda: engine.jog("Y", 1.0))
    after = settled(engine, engine.start_mdi)
    assert commands(after) == [0.0, 1.0, 0.0] and "Enter checks the block again" in after.message


# ---- programs


def test_a_job_begins_where_the_machine_stands(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job(JOB))
    revision = engine.snapshot().revision
    settled(engine, lambda: engine.jog("Y", -5.0))
    done = run(engine)
    assert done.state is State.DONE and done.revision == revision + 1
    seen = engine.current_job()
    assert seen is not None and seen.extents["Y"] == (-5.0, 10.0), "checked again from there"
    assert commands(done) == [0.0, 0.0, 0.0]


def test_hold_takes_back_a_start_that_waits_for_its_check(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job(JOB))
    settled(engine, lambda: engine.jog("Y", -5.0))
    engine.start()
    engine.hold()
    assert engine.wait(5, lambda s: "checked again" in s.message)
    after = settled(engine, lambda: None)
    assert after.state is State.READY and commands(after)[1] == -5.0
    assert run(engine).state is State.DONE


def test_a_job_that_no_longer_fits_does_not_start(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job("G91 G21\nG1 X550 F6000\nM30\n"))
    settled(engine, lambda: engine.jog("X", 100.0))
    after = settled(engine, engine.start)
    assert engine.wait(5, lambda s: "not started" in s.message), after
    assert commands(engine.snapshot())[0] == 100.0


def test_dry_run_feed_and_program_test(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job("G90 G21\nG1 X50 F600\nX0\nM00\nM30\n"))
    normal = run(engine)
    settled(engine, engine.resume)
    engine.set_switches(Switches(dry_run=True))
    dry = run(engine)
    assert dry.switches.dry_run
    assert normal.machine_time_s > 9.5 and 1.0 < dry.machine_time_s < 1.5, "100 mm/s, the feed limit, and not F600"
    refused = settled(engine, lambda: engine.set_switches(Switches()))
    assert refused.switches.dry_run and "refused" in refused.message
    settled(engine, engine.resume)
    settled(engine, lambda: engine.set_switches(Switches(program_test=True)))
    settled(engine, lambda: engine.jog("X", 4.0))
    test = run(engine)
    assert test.state is State.DONE, "M00 stops nobody"
    assert test.path_done_mm == pytest.approx(96.0) and commands(test)[0] == 4.0, "no axis moved"


def test_the_dry_run_feed_is_the_operators_else_that_of_the_machine_file(
    tmp_path: Path, job: Callable[..., Path]
) -> None:
    text = (ROOT / "examples/machines/mill3.toml").read_text()
    (tmp_path / "m.toml").write_text(text.replace("[gcode] ", "[gcode]\ndry_feed = 25.0 ", 1))
    engine = SimEngine(str(tmp_path / "m.toml"), speed=0)
    loaded(engine, job("G90 G21\nG1 X50 F600\nX0\nM30\n"))
    engine.set_switches(Switches(dry_run=True))
    assert run(engine).machine_time_s == pytest.approx(4.0, abs=0.6) and engine.snapshot().dry_feed == 1500.0
    engine.set_switches(Switches(dry_run=True, dry_feed=3000.0))
    assert run(engine).machine_time_s == pytest.approx(2.0, abs=0.6) and engine.snapshot().dry_feed == 3000.0
    done = engine.outcome()
    assert done is not None and done.run["verdict"]["word"] == "WARN", "the programmed feed was not tried"
    assert {"id": "dry_feed_run", "feed": 3000.0} in done.run["verdict"]["reasons"]
    engine.close()


def test_rapid_override_acts_on_rapids_alone(engine: SimEngine, job: Callable[..., Path]) -> None:
    text = "G90 G21\nG0 X300\nG1 X310 F600\nG0 X0\nM30\n"
    loaded(engine, job(text))
    full = run(engine).machine_time_s
    settled(engine, lambda: engine.set_rapid(0.25))
    slow = run(engine)
    assert slow.rapid_set == 0.25 and slow.override_set == 1.0
    assert slow.machine_time_s > full + 4.0, "300 + 310 mm at 50 instead of 200 mm/s"
    settled(engine, lambda: engine.set_override(0.2))
    assert run(engine).machine_time_s > slow.machine_time_s, "the lower one counts"


def test_start_at_a_block_shows_the_state_and_goes_there(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job(JOB))
    start = engine.search("N30")
    assert start["line"] == 4 and start["feed"] == 3000.0 and start["program"]["X"] == 50.0
    engine.start_at("N30")
    assert engine.wait(5, lambda s: s.start_line == 4)
    done = run(engine)
    assert commands(done) == [0.0, 0.0, 0.0] and done.state is State.DONE
    engine.start_at("")
    assert engine.wait(5, lambda s: s.start_line == 0)
    with pytest.raises(CompileError):
        engine.search("N77")


@pytest.mark.parametrize("text", ["G4 P60000", "M10"])
def test_waits_say_for_what(tmp_path: Path, job: Callable[..., Path], text: str) -> None:
    machine = tmp_path / "waits.toml"
    machine.write_text((ROOT / "examples/machines/mill3.toml").read_text() + "[gcode.outputs]\nclamp_wait = [5]\n")
    engine = SimEngine(str(machine), speed=1)
    loaded(engine, job(f"G90 G21\n{text}\nG1 X1 F600\nM30\n"))
    engine.start()
    assert engine.wait(5, lambda s: s.state is State.WAITING)
    waits = engine.snapshot()
    assert (waits.why, waits.waits_for) == (("dwell", ()) if text[0] == "G" else ("inputs", (5,)))
    if text == "M10":
        engine.force_input(5, True)
        assert engine.wait(5, lambda s: s.state is State.DONE)
    engine.close()


def test_the_four_stops_have_names(engine: SimEngine, job: Callable[..., Path]) -> None:
    loaded(engine, job("G90 G21\nG1 X500 F600\nX0\nM30\n"))
    engine.set_speed(1)
    engine.start()
    assert engine.wait(5, lambda s: s.axes[0].command > 1)
    engine.hold()
    assert engine.wait(5, lambda s: s.state is State.HOLD) and engine.snapshot().stop is Stop.HOLD
    engine.reset()
    assert engine.wait(5, lambda s: s.state is State.ABORTED) and engine.snapshot().stop is Stop.ABORT
    engine.set_single_block(True)
    engine.set_speed(0)
    engine.start()
    assert engine.wait(5, lambda s: s.state is State.STEP and s.axes[0].command == 500.0)
    assert engine.snapshot().stop is Stop.BLOCK_END


def test_what_mdi_refuses_is_said_in_german(engine: SimEngine) -> None:
    with pytest.raises(CompileError) as error:
        engine.check_mdi("M30")
    first = localized(error.value.diagnostics, "de")[0]
    assert first.message.startswith("dahinter kann kein Satz folgen") and first.hint == "in ein Teileprogramm schreiben"
