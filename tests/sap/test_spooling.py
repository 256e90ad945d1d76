"""A program against a full spooler (AutoSpool, 6.3.1.5 bit 5), and the units it shares with the PC (4.4.11)."""

from __future__ import annotations

import pytest

from tests.sap.jobs import Job

AUTO_SPOOL = 0x20
OVERRUN = 0x10
PATH = "TRAC := 500.0; TRVL := 50.0; TRTVL := 50.0; "


def spooling(command: str, times: int, modereg: int, then: str = "") -> Job:
    """A program that spools a command that often without ever starting the spoolers."""
    return Job(
        f"var i : integer; begin cl(A1, A2, A3); MODEREG := {modereg}; {PATH}"
        f"for i := 1 to {times} do {command}; CI0 := 1; {then} end."
    )


@pytest.mark.shows("modereg.autospool", "modereg.autospool.waits-for-space")
def test_a_full_spooler_starts_by_itself_and_nothing_is_lost() -> None:
    job = spooling("smlr(A1 := 0.06, A2 := 0.08)", 2000, 0x101 | AUTO_SPOOL)
    job.mcu.advance(70)
    assert job.mcu.rddp("A1") == 0.0 and job.mcu.rdlsm("A1") > 0, "not before it is full"
    job.mcu.advance(50)
    assert job.mcu.rddp("A1") > 0.0 and job.ci(0) == 0, "full: it runs, and the program waits for space"
    job.run()
    job.mcu.ssms(["A1", "A2"])
    job.mcu.advance(20_000)
    assert (job.mcu.rddp("A1"), job.mcu.rddp("A2")) == pytest.approx((120.0, 160.0), abs=1e-6)
    assert job.ci(0) == 1 and job.mcu.rderrorreg() & OVERRUN == 0
    assert job.mcu.rddp("A3") == 0.0


def test_without_autospool_a_full_spooler_takes_no_more() -> None:
    job = spooling("smlr(A1 := 0.06, A2 := 0.08)", 2000, 0x101).run()
    assert job.ci(0) == 1 and job.mcu.rderrorreg() & OVERRUN
    assert job.mcu.rddp("A1") == 0.0, "nothing starts"
    entered = job.mcu.rdmcis("A1")
    assert entered < 2000
    job.mcu.ssms(["A1", "A2"])
    job.mcu.advance(20_000)
    assert job.mcu.rddp("A1") == pytest.approx(entered * 0.06, abs=1e-6), "the rest is lost"


COMMANDS = {
    "smla(A1 := 0.06 * i, A2 := 0.08 * i)": True,
    "smlr(A1 := 0.06, A2 := 0.08)": True,
    "smca(A1 := 10.0, A2 := 0.0, PHI := 2.0)": True,
    "smcr(A1 := 10.0, A2 := 0.0, PHI := 2.0)": True,
    "smha(A1 := 10.0, A2 := 0.0, A3 := 0.1 * i, PHI := 2.0)": True,
    "smhr(A1 := 10.0, A2 := 0.0, A3 := 0.1, PHI := 2.0)": True,
    "smca3d(A1 := 10.0, A2 := 0.0, A3 := 0.0, PN1 := 0.0, PN2 := 0.0, PN3 := 1.0, PHI := 2.0)": False,
    "smcr3d(A1 := 10.0, A2 := 0.0, A3 := 0.0, PN1 := 0.0, PN2 := 0.0, PN3 := 1.0, PHI := 2.0)": False,
}


@pytest.mark.shows("modereg.autospool.commands")
@pytest.mark.parametrize(("command", "starts"), COMMANDS.items())
def test_autospool_knows_six_commands(command: str, starts: bool) -> None:
    job = spooling(command, 1600, 0x100 | AUTO_SPOOL).run()
    assert job.ci(0) == 1
    assert (job.mcu.rddp("A2") != 0.0) is starts
    assert (job.mcu.rderrorreg() & OVERRUN == 0) is starts


@pytest.mark.shows("pcap.ctru.sap")
def test_units_of_ctru_are_those_of_a_program() -> None:
    job = Job(
        "begin cl(A1); repeat until CI0 = 1; CI1 := PU; CI2 := TU; TRAC := 1000.0; TRVL := 60.0; TRTVL := 0.0; "
        "mlrw(A1 := 1.0); PU := 2; CI3 := 1; end."
    )
    job.mcu.advance(10)
    job.mcu.ctru("inch", "min")
    job.mcu.wrci(0, 1)
    job.run()
    assert [job.ci(n) for n in (1, 2, 3)] == [1, 1, 1]
    assert job.mcu.rddp("A1") == pytest.approx(25.4), "one inch"
    # and the other way round: PU of the program is the unit of the PC's commands
    job.mcu.mlr({"A1": 0.01}, ac=3600.0, vl=60.0)
    job.mcu.advance(2000)
    assert job.mcu.rddp("A1") == pytest.approx(35.4), "0.01 m"
