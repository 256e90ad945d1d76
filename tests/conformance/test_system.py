"""Boot, initialisation, files, cards, environment, interrupt of the PC (4.4.5 to 4.4.18, 4.4.32 to 4.4.34, 4.4.129)."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from motion_kernel import MAXAXIS, CommandRefused, Machine, Mcu, PcapError
from tests.app.conftest import ROOT

MILL = ROOT / "examples" / "machines" / "mill3.toml"
LATHE = '[[axis]]\nname = "{name}"\ncounts_per_unit = 1000\nrapid = 100\nacceleration = 1000\njog_velocity = 7\n'


@pytest.fixture
def mcu() -> Mcu:
    return Mcu(Machine.load(MILL))


@pytest.fixture
def other(tmp_path: Path) -> Path:
    """A machine file of one axis, W."""
    path = tmp_path / "other.toml"
    path.write_text(LATHE.format(name="W"))
    return path


def elf(
    *, magic: bytes = b"\x7fELF", machine: int = 8, entry: int = 0x1000, length: int = 64, order: str = ">"
) -> bytes:
    """An operating system file with one segment of 64 bytes at 0x1000."""
    ident = magic + bytes([1, 1 if order == "<" else 2, 1]) + bytes(9)
    header = struct.pack(f"{order}HHIIIIIHHHHHH", 2, machine, 1, entry, 52, 0, 0, 52, 32, 1, 0, 0, 0)
    segment = struct.pack(f"{order}8I", 1, 84, 0x1000, 0x1000, length, length, 5, 4)
    return ident + header + segment + bytes(64)


@pytest.fixture
def rwmos(tmp_path: Path) -> Path:
    path = tmp_path / "rwmos.elf"
    path.write_bytes(elf())
    return path


@pytest.mark.shows("pcap.bootfile", "pcap.bootfile.ret-0", "pcap.bootfile.reset-first", "pcap.bootfile.init-needed")
def test_boot_then_initialise(mcu: Mcu, rwmos: Path) -> None:
    mcu.cl("X")
    mcu.wrci(5, 17)
    mcu.ja({"X": 100.0})
    mcu.advance(100)
    assert mcu.bootfile(rwmos, 0) == 0
    with pytest.raises(PcapError, match="system data"):
        mcu.rdrp("X")
    assert mcu.initmcusystem2(MILL).status == 0
    assert (mcu.rdrp("X"), mcu.rdci(5), mcu.samples) == (0.0, 0, 0), "the card was reset"
    assert not mcu.rdaxst("X").cl
    mcu.bootfile(rwmos)
    assert mcu.initmcusystem3(MILL).status == 0
    assert mcu.rdrp("X") == 0.0


@pytest.mark.shows(
    "pcap.bootfile.ret-10", "pcap.bootfile.ret-11", "pcap.bootfile.ret-12", "pcap.bootfile.ret-13",
    "pcap.bootfile.ret-14", "pcap.bootfile.ret-15",
)  # fmt: skip
@pytest.mark.parametrize(
    ("data", "status"),
    [
        (elf(), 0),
        (elf(order="<"), 0),
        (b"", 12),
        (elf(magic=b"MZ\0\0"), 12),
        (elf()[:30], 13),
        (elf()[:100], 13),
        (elf(length=4096), 13),
        (elf(entry=0x0FFF), 14),
        (elf(entry=0x1040), 14),
        (elf(machine=62), 15),
    ],
)
def test_operating_system_files(mcu: Mcu, tmp_path: Path, data: bytes, status: int) -> None:
    path = tmp_path / "os.elf"
    path.write_bytes(data)
    assert mcu.bootfile(path) == status
    assert mcu.bootfile("") == mcu.bootfile("a\0b") == 10
    assert mcu.bootfile(tmp_path / "nowhere.elf") == 11
    assert mcu.bootfile(tmp_path) == 11, "a folder"


@pytest.mark.shows("pcap.initmcusystem.ret-32", "pcap.mcuinit.online-check", "pcap.return.other-nonzero")
def test_a_card_without_operating_system_does_not_answer(mcu: Mcu, other: Path) -> None:
    assert mcu.mcuinit().number_axis == 3
    assert mcu.bootfile("nowhere.elf") == 11
    assert mcu.initmcusystem().status == mcu.initmcusystem2(other).status == mcu.initmcusystem3(other).status == 32
    assert mcu.mcuinit() == ("", 0, 0)
    assert mcu.wrtrovrst(1.0) == -4, "writers return the code"
    assert mcu.wrcbcnct(0, b"x") == -4
    for call in (lambda: mcu.rdtrovrst(), lambda: mcu.gettskinfo(0), lambda: mcu.cl("X"), lambda: mcu.advance(1)):
        with pytest.raises(PcapError) as error:
            call()
        assert error.value.status == -4
    assert mcu.wrmodereg is not None


@pytest.mark.shows(
    "pcap.initmcusystem", "pcap.initmcusystem.an", "pcap.initmcusystem.sysfile", "pcap.initmcusystem.readback",
    "pcap.initmcusystem.ret-0", "struct.rosi.sysfile-loaded", "struct.rosi.once-per-start", "pcap.mcuinit.sysfile",
    "pcap.mcuinit", "struct.rosi.revision", "struct.rosi.number-axis",
)  # fmt: skip
def test_system_data_are_sent_once(mcu: Mcu, rwmos: Path, other: Path) -> None:
    assert mcu.bootfile(rwmos) == 0
    assert mcu.mcuinit() == ("V2.5.3.126", 3, 0)
    done = mcu.initmcusystem()
    assert (done.status, mcu.mcuinit().sysfile_loaded) == (0, 1)
    assert [tsrp.an for tsrp in done.tsrp] == [0, 1, 2]
    assert done.tsrp == [mcu.rdap(n) for n in range(3)]
    mcu.wrjvl("X", 3.0)
    again = mcu.initmcusystem()
    assert (again.status, again.tsrp[0].jvl) == (0, 3.0), "not sent again: what was written stays"
    assert mcu.initmcusystem2(other).tsrp[0].jvl == 3.0
    assert mcu.machine.axis_names == ["X", "Y", "Z"]
    mcu.bootfile(rwmos)
    assert mcu.txbf2(other) == 0
    assert mcu.mcuinit().sysfile_loaded == 1


@pytest.mark.shows(
    "pcap.initmcusystem2", "pcap.initmcusystem2.ret", "pcap.initmcusystem3", "pcap.initmcusystem3.ret",
    "pcap.initmcusystem3.rosi", "pcap.initmcusystem3.board-32", "pcap.initmcusystem.ret-lderr",
)  # fmt: skip
@pytest.mark.parametrize("method", ["initmcusystem2", "initmcusystem3"])
def test_initialisation_with_a_file_of_its_own(mcu: Mcu, rwmos: Path, other: Path, method: str) -> None:
    initialise = getattr(mcu, method)
    mcu.bootfile(rwmos)
    for name, status in [("nowhere.toml", 20), (rwmos, 22)]:
        assert initialise(name).status == status
        assert mcu.mcuinit().sysfile_loaded == 0
    damaged = other.with_name("damaged.toml")
    damaged.write_text(LATHE)
    assert initialise(damaged).status == 24
    done = initialise(other, 0)
    assert (done.status, done.boardtype, done.rosi) == (0, 32, mcu.mcuinit())
    assert done.rosi.number_axis == 1
    assert [tsrp.jvl for tsrp in done.tsrp] == [7.0]


@pytest.mark.shows("pcap.mcuinit.no-reset")
def test_mcuinit_resets_nothing(mcu: Mcu) -> None:
    mcu.cl("X")
    mcu.ja({"X": 10.0})
    mcu.advance(50)
    position = mcu.rddp("X")
    mcu.mcuinit()
    assert mcu.rddp("X") == position > 0.0
    mcu.advance(3000)
    assert mcu.rddp("X") == 10.0


@pytest.mark.shows(
    "pcap.txbf2", "pcap.txbf2.path-allowed", "pcap.txbf2.sysfile-init", "pcap.txbf2.sysfile-overwrites",
    "pcap.txbf2.ret-0", "pcap.txbf2.once", "pcap.txbf2.sysfile-filter",
)  # fmt: skip
def test_a_system_file_initialises_all_axes(mcu: Mcu, other: Path) -> None:
    mcu.cl("X")
    mcu.wrjvl("X", 3.0)
    mcu.uf("X", kp=9.0, ki=0.0, kd=0.0)
    mcu.wrcd(3, 1.5)
    gains, jvl = Mcu(Machine.load(MILL)).rdf("X"), Mcu(Machine.load(MILL)).rdjvl("X")
    assert mcu.txbf2(MILL) == 0
    assert (mcu.rdjvl("X"), mcu.rdf("X"), mcu.rdaxst("X").cl) == (jvl, gains, False)
    mcu.cl("X")
    mcu.wrdp("X", 0.01)
    mcu.advance(2)
    assert mcu.rdmcp("X") == pytest.approx(gains.kp * 100, abs=2), "the filter has the coefficients of the file"
    assert mcu.rdcd(3) == 1.5, "common variables stay"
    assert mcu.txbf2(str(other)) == 0
    assert mcu.machine.axis_names == ["W"]
    mcu.cl("W")
    mcu.ja({"W": 1.0})
    mcu.advance(1000)
    assert mcu.rddp("W") == 1.0, "no further transfer is needed"


@pytest.mark.shows("pcap.txbf2.ret-20", "pcap.txbf2.ret-22", "pcap.txbf2.ret-24", "pcap.txbf")
def test_files_that_cannot_be_sent(mcu: Mcu, other: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("nowhere.toml", "", "a\0b.toml", str(tmp_path)):
        assert mcu.txbf2(name) == 20
    (tmp_path / "text.txt").write_text("hello")
    assert mcu.txbf2(tmp_path / "text.txt") == 22
    (tmp_path / "bad.dat").write_bytes(b"\xff\xfe")
    assert mcu.txbf2(tmp_path / "bad.dat") == 24
    assert mcu.machine.axis_names == ["X", "Y", "Z"], "nothing was taken over"
    assert mcu.txbf(str(other)) == 20, "no path"
    monkeypatch.chdir(tmp_path)
    (tmp_path / "system.dat").write_text(LATHE.format(name="V"))
    assert mcu.txbf("system.dat") == 0
    assert mcu.machine.axis_names == ["V"]
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert mcu.txbf("other.toml") == 0, "found along PATH"


@pytest.mark.shows("pcap.booterrorreport", "pcap.initmcuerrorreport", "pcap.txbferrorreport", "pcap.msgtoscreen")
def test_reports_say_return_codes_in_words(mcu: Mcu) -> None:
    assert mcu.booterrorreport("x.elf", mcu.bootfile("x.elf")) == "x.elf: the file cannot be opened"
    mcu.msgtoscreen(0)
    assert "bootfile" in mcu.initmcuerrorreport(mcu.initmcusystem().status)
    mcu.msgtoscreen(1)
    assert mcu.txbferrorreport("y.cnc", 99) == "y.cnc: unknown error 99"
    assert mcu.messages == ["x.elf: the file cannot be opened", "y.cnc: unknown error 99"]


@pytest.mark.shows("pcap.getenvstr", "pcap.getenvstr.ret-length", "pcap.getenvstr.ret-0")
def test_environment_strings(mcu: Mcu) -> None:
    mcu.environment.update(SerialNumber="04711", Empty="")
    assert mcu.getenvstr("SerialNumber") == "04711"
    assert [len(mcu.getenvstr(name)) for name in ("SerialNumber", "Empty", "Nothing")] == [5, 0, 0]


@pytest.mark.shows(
    "pcap.cardselect", "pcap.cardselect.duration", "pcap.cardselect.ret-index", "pcap.cardselect.ret-fail"
)
def test_several_cards() -> None:
    mcu = Mcu(Machine.load(MILL), Machine.parse(LATHE.format(name="W")))
    assert mcu.cardselect(1) == 1
    mcu.cl("W")
    mcu.ja({"W": 7.0})
    mcu.wrci(1, 11)
    mcu.environment["SerialNumber"] = "two"
    mcu.advance(200)
    position = mcu.rddp("W")
    assert 0.0 < position < 7.0
    assert mcu.cardselect(0) == 0
    assert (mcu.machine.axis_names, mcu.rdci(1), mcu.getenvstr("SerialNumber")) == (["X", "Y", "Z"], 0, "")
    assert mcu.samples == 200, "time is the same for both"
    mcu.bootfile("nowhere.elf")
    with pytest.raises(PcapError):
        mcu.advance(1)
    assert mcu.cardselect(1) == 1
    assert mcu.rddp("W") == position, "no time passes for a card that does not run"
    mcu.cardselect(0)
    mcu = Mcu(Machine.load(MILL), Machine.parse(LATHE.format(name="W") + "[controller]\nsample_ticks = 30\n"))
    mcu.cardselect(1)
    mcu.cl("W")
    mcu.ja({"W": 7.0})
    mcu.cardselect(0)
    for _ in range(100):
        mcu.advance(1)
    mcu.cardselect(1)
    assert mcu.samples == 66, "of 1.92 ms, in 100 of 1.28 ms"
    assert mcu.rddp("W") > 0.1, "it works while the other card is selected"
    assert mcu.cardselect(2) == -1
    assert mcu.machine.axis_names == ["X", "Y", "Z"], "card 0"
    mcu.cardselect(1)
    assert mcu.cardselect(-1) == -1
    assert mcu.machine.axis_names == ["X", "Y", "Z"]


@pytest.mark.shows(
    "pcap.setboardintroutine", "pcap.setboardintroutine.call", "pcap.resetboardintroutine", "ssf.1101", "pcap.rdirqpc",
)  # fmt: skip
def test_the_interrupt_routine(mcu: Mcu) -> None:
    mcu.cl("X")
    calls: list[tuple[int, float]] = []

    def routine(lines: int) -> None:
        assert mcu.rdirqpc() == 1
        calls.append((lines, mcu.rddp("X")))
        mcu.wrirqpc(0)

    def two_interrupts() -> None:
        start = mcu.rddp("X")
        mcu.smlr({"X": 2.0}, ac=500.0, vl=20.0)
        mcu.ssf("X", 1101, 1)
        mcu.smlr({"X": 2.0}, ac=500.0, vl=20.0)
        mcu.ssf("X", 1101, 1)
        mcu.ssms("X")
        mcu.advance(500)
        assert mcu.rddp("X") == pytest.approx(start + 4.0)

    assert mcu.mcug3_setboardintroutine(routine) == 0
    two_interrupts()
    assert [lines for lines, _ in calls] == [1, 1]
    assert [x for _, x in calls] == pytest.approx([2.0, 4.0], abs=0.02), "as it is raised, not at the end"
    assert mcu.rdirqpc() == 0
    assert len(mcu.trace) == 500, "the recording has no gap"
    assert np.abs(np.diff(mcu.trace.dp[:, 0])).max() < 20.0 * 1.28e-3 + 1e-9
    mcu.mcug3_resetboardintroutine()
    two_interrupts()
    assert len(calls) == 2
    assert mcu.rdirqpc() == 1


def test_an_interrupt_routine_lets_no_time_pass(mcu: Mcu) -> None:
    mcu.cl("X")
    mcu.mcug3_setboardintroutine(lambda _: mcu.advance(1))
    mcu.ssf("X", 1101, 1)
    mcu.ssms("X")
    with pytest.raises(RuntimeError, match="time"):
        mcu.advance(5)
    mcu.mcug3_resetboardintroutine()
    mcu.advance(5)


@pytest.mark.shows("def.maxaxis", "struct.as.zero-based", "pcap.rdaxst", "pcap.rdaxstb")
def test_axes_are_numbered_from_0(mcu: Mcu) -> None:
    assert MAXAXIS == 18
    axes = "".join(LATHE.format(name=f"A{n}") for n in range(MAXAXIS))
    many = Mcu(Machine.parse(axes))
    many.cl([0, 2])
    assert [many.rdaxst(n).cl for n in range(4)] == [True, False, True, False]
    assert many.rdaxst(17) == many.rdaxst("A17")
    assert [many.rdaxstb(2, n) for n in (13, 14, 1, 0, 33)] == [1, 1, 0, 0, 0], "pe and cl, counted from 1"
    with pytest.raises(ValueError, match="MC109"):
        Machine.parse(axes + LATHE.format(name="B"))


@pytest.mark.shows("pcap.general.closed-loop-required")
def test_open_axes_are_refused(mcu: Mcu) -> None:
    mcu.cl("Y")
    moves = [
        lambda: mcu.ja({"X": 1.0}),
        lambda: mcu.jr({"X": 1.0}),
        lambda: mcu.mla({"X": 1.0, "Y": 1.0}, ac=100.0, vl=10.0),
        lambda: mcu.mca({"X": 1.0, "Y": 1.0}, 90.0, ac=100.0, vl=10.0),
        lambda: mcu.mhr({"X": 1.0, "Y": 1.0}, 90.0, {}, ac=100.0, vl=10.0),
        lambda: mcu.smlr({"X": 1.0}, ac=100.0, vl=10.0),
        lambda: mcu.ssf("X", 1003, 1),
    ]
    for move in moves:
        mcu.rs()
        mcu.wrerrorreg()
        mcu.cl("Y")
        with pytest.raises(CommandRefused, match="open loop"):
            move()
        assert mcu.rdaxst("X").dhef and not mcu.rdaxst("Y").dhef
        assert mcu.rderrorreg().names == ("CheckMonitorScreen",)
        mcu.advance(100)
        assert np.ptp(mcu.trace.dp) == 0.0


@pytest.mark.shows("pcap.general.immediate", "pcap.general.pe-flag")
def test_commands_do_not_wait_for_a_profile(mcu: Mcu) -> None:
    mcu.cl(["X", "Y"])
    mcu.mla({"X": 50.0}, ac=500.0, vl=20.0)
    mcu.advance(100)
    assert not mcu.rdaxst("X").pe
    mcu.wrtrovr(0.5)
    mcu.utrovr("X")
    mcu.wrjvl("Y", 4.0)
    mcu.ja({"Y": 1.0})
    assert mcu.rdjvl("Y") == 4.0
    mcu.advance(3)
    assert mcu.trace.dp[2, 1] > 0.0, "the jog runs 2 samples after its call"
    assert mcu.rddv("X") == pytest.approx(10.0), "and the override at once"
    mcu.advance(8000)
    assert mcu.rdaxst("X").pe and mcu.rdaxst("Y").pe
    mcu.smla({"X": 60.0}, ac=500.0, vl=20.0)
    mcu.ssms("X")
    mcu.advance(10)
    assert not mcu.rdaxst("X").pe
    mcu.advance(1000)
    assert mcu.rdaxst("X").pe, "in spool mode as well"


@pytest.mark.shows("pcap.return.distinct", "pcap.return.not-all", "pcap.rdsampletime")
def test_values_and_return_codes_are_different_things(mcu: Mcu) -> None:
    assert mcu.wrtrac(250.0) == 0
    assert mcu.rdtrac() == 250.0
    assert mcu.wrjvl("X", 5.0) is None  # type: ignore[func-returns-value]
    assert mcu.rdsampletime() == 1280
