"""CNC tasks seen from the PC: states, output strings, common variables and buffers (3.1, 4.4.13, 4.4.47 to 4.4.50)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import gcode
import sympas
from motion_kernel import Machine, Mcu, PcapError
from tests.app.conftest import ROOT

MILL = ROOT / "examples" / "machines" / "mill3.toml"


@pytest.fixture
def mcu() -> Mcu:
    return Mcu(Machine.load(MILL))


def load(mcu: Mcu, task: int, text: str) -> None:
    mcu.load(task, gcode.compile(text, mcu.machine))


@pytest.mark.shows("kernel.tasks.pc-and-cnc", "pcap.mode.async-execution")
def test_commands_of_the_pc_run_beside_the_program_of_a_task() -> None:
    axis = '[[axis]]\nname = "{}"\nletter = "{}"\ndrive = "stepper"\n'
    axis += "counts_per_unit = 1000\nrapid = 100\nacceleration = 1000\n"
    mcu = Mcu(Machine.parse(axis.format("X", "X") + axis.format("Feeder", "")))
    load(mcu, 0, "G90 G21\nG1 X20 F1200\nM30\n")
    mcu.prepare_gcode()
    mcu.startcnct(0)
    mcu.advance(200)
    assert mcu.ja({"Feeder": 4.0}), "the order comes back at once"
    assert mcu.rddp("Feeder") == 0.0
    mcu.wrci(3, 9)
    assert mcu.rdci(3) == 9, "and the PC goes on meanwhile"
    mcu.advance(1500)
    steps = np.diff(mcu.trace.dp, axis=0)
    assert ((steps[:, 0] > 0.0) & (steps[:, 1] > 0.0)).any(), "both move in the same samples"
    assert (mcu.rddp("X"), mcu.rddp("Feeder")) == (20.0, 4.0)
    assert mcu.ja({"Feeder": 0.0}), "a new order"
    mcu.advance(1500)
    assert mcu.rddp("Feeder") == 0.0


@pytest.mark.shows("sap.tasks.numbers", "pcap.startcnct")
def test_tasks_are_0_to_3(mcu: Mcu) -> None:
    mcu.prepare_gcode()
    for task in range(4):
        load(mcu, task, "G4 P1000\nM30\n")
        mcu.startcnct(task)
        mcu.advance(1)
        assert [mcu.rdcncts(n).running & 1 for n in range(4)] == [int(n <= task) for n in range(4)]
    for call in (mcu.startcnct, mcu.stopcnct, mcu.contcnct, mcu.stepcnct, mcu.rdcncts, mcu.gettskinfo, mcu.gettskstr):
        for task in (4, 99):
            with pytest.raises(IndexError, match="0 to 3"):
                call(task)


@pytest.mark.shows("struct.cncts.running-bit3")
def test_a_task_that_waits_for_the_end_of_motion_says_so(mcu: Mcu) -> None:
    load(mcu, 0, "G90 G21\nG1 X5 F1200\nG75\nX0\nM30\n")
    mcu.prepare_gcode()
    mcu.startcnct(0)
    mcu.advance(50)
    status = mcu.rdcncts(0)
    assert (status.running & 0b1001, status.csrcline) == (0b1001, 3)
    mcu.advance(1000)
    assert mcu.rdcncts(0).running == 0


@pytest.mark.shows(
    "pcap.gettskinfo", "pcap.gettskinfo.bit0", "pcap.gettskinfo.bit1", "pcap.gettskinfo.reset",
    "pcap.gettskinfo.ret-0", "pcap.gettskstr",
    "pcap.gettskstr.ret-count", "pcap.gettskstr.szbuffer", "pcap.gettskstr.reset-bits",
)  # fmt: skip
def test_output_strings(mcu: Mcu) -> None:
    load(mcu, 1, 'write "part "\nG4 P100\nwriteln "is ready"\nM30\n')
    mcu.prepare_gcode()
    assert (mcu.gettskinfo(1), mcu.gettskstr(1)) == (0, "")
    for most, text in [(None, "part is ready"), (4, "part"), (0, "")]:
        mcu.startcnct(1)
        mcu.advance(20)
        assert mcu.gettskinfo(1) == 1, "an open string"
        mcu.advance(200)
        assert (mcu.gettskinfo(1), mcu.gettskinfo(0)) == (2, 0)
        assert (mcu.gettskstr(1) if most is None else mcu.gettskstr(1, most)) == text
        assert mcu.gettskinfo(1) == 0
    mcu.bootfile("nowhere.elf")
    with pytest.raises(PcapError) as error:
        mcu.gettskinfo(1)
    assert error.value.status != 0


@pytest.mark.shows("pcap.rdcd", "pcap.wrcd", "pcap.rdci", "pcap.wrci", "pcap.wrcd.persist")
def test_common_variables(mcu: Mcu) -> None:
    numbers = [0, 1, 99, 101, 500, 999]
    for n in numbers:
        mcu.wrci(n, -n)
        mcu.wrcd(n, n / 8)
    mcu.rs()
    assert [mcu.rdci(n) for n in numbers] == [-n for n in numbers]
    assert [mcu.rdcd(n) for n in numbers] == [n / 8 for n in numbers]
    for n in (-1, 1001):
        for read in (mcu.rdci, mcu.rdcd):
            with pytest.raises((IndexError, OverflowError)):
                read(n)
        for write in (mcu.wrci, mcu.wrcd):
            with pytest.raises((IndexError, OverflowError)):
                write(n, 1)


@pytest.mark.shows(
    "pcap.rdcd.all-100", "pcap.rdcd.all-1000", "pcap.rdci.all-100", "pcap.rdci.all-1000", "pcap.wrcd.block-index",
    "pcap.wrci.block-index",
)  # fmt: skip
def test_block_indices_are_for_reading(mcu: Mcu) -> None:
    for n in range(1000):
        mcu.wrci(n, n)
        mcu.wrcd(n, n / 2)
    assert mcu.rdci(100) == list(range(100))
    assert mcu.rdcd(100) == [n / 2 for n in range(100)]
    assert mcu.rdci(1000) == list(range(1000))
    assert mcu.rdcd(1000) == [n / 2 for n in range(1000)]
    mcu.wrci(100, -5)
    mcu.wrcd(100, -2.5)
    mcu.wrci(1000, 7)
    mcu.wrcd(1000, 7.0)
    assert mcu.rdci(1000) == [-5 if n == 100 else n for n in range(1000)]
    assert mcu.rdcd(1000) == [-2.5 if n == 100 else n / 2 for n in range(1000)]


@pytest.mark.shows(
    "struct.cbcnct.tasknr", "struct.cbcnct.size", "struct.cbcnct.capacity", "pcap.rdcbcnct", "pcap.rdcbcnct.partial",
    "pcap.rdcbcnct.ret-0", "pcap.rdcbcnct.ret-bit0", "pcap.rdcbcnct.ret-bit1", "pcap.wrcbcnct",
    "pcap.wrcbcnct.partial", "pcap.wrcbcnct.ret-0", "pcap.wrcbcnct.ret-bit0", "pcap.wrcbcnct.ret-bit1",
)  # fmt: skip
def test_common_buffers(mcu: Mcu) -> None:
    full = [bytes((n * 7 + task) & 0xFF for n in range(1000)) for task in range(4)]
    for task, data in enumerate(full):
        assert mcu.wrcbcnct(task, data) == 0
    mcu.rs()
    assert [mcu.rdcbcnct(task) for task in range(4)] == full
    assert mcu.wrcbcnct(2, b"abc") == 0
    assert mcu.rdcbcnct(2, 5) == b"abc" + full[2][3:5]
    assert mcu.rdcbcnct(2)[3:] == full[2][3:]
    assert mcu.rdcbcnct(3, 0) == b""
    for task, size, status in [(4, 10, 1), (-1, 10, 1), (0, 1001, 2), (4, 1001, 3)]:
        assert mcu.wrcbcnct(task, bytes(size)) == status
        with pytest.raises(PcapError) as error:
            mcu.rdcbcnct(task, size)
        assert error.value.status == status
    assert mcu.rdcbcnct(0) == full[0], "nothing was written"


@pytest.mark.shows("pcap.stopcnct", "pcap.contcnct", "pcap.clearci99")
def test_a_task_stops_and_one_waits_for_the_pc(mcu: Mcu) -> None:
    load(mcu, 0, "G90 G21\nG4 P500\nCI1 = 1\nM06 T1\nCI1 = 2\nM30\n")
    mcu.prepare_gcode()
    mcu.startcnct(0)
    mcu.stopcnct(0)
    mcu.advance(1000)
    assert (mcu.rdci(1), mcu.rdcncts(0).running) == (0, 0)
    mcu.contcnct(0)
    mcu.advance(1000)
    assert mcu.rdci(1) == 1 and mcu.rdci(99) != 0
    mcu.clearci99()
    mcu.advance(5)
    assert (mcu.rdci(99), mcu.rdci(1)) == (0, 2)


COUNT = "{{$TASK {task}}}\nbegin CI{task} := {value}; while true do CI9 := CI9 + 1; end.\n"


def autocode(folder: Path, task: int, value: int) -> Path:
    """An autocode file: its program sets the common integer of its task, then counts CI9 for ever."""
    path = folder / f"count{task}-{value}.cnc"
    sympas.compile(COUNT.format(task=task, value=value), Machine.load(MILL)).save(path)
    return path


@pytest.mark.shows(
    "pcap.txbf2.types", "pcap.txbf2.cnc-overwrites", "pcap.txbf2.cnc-stops-task", "pcap.txbf2.cnc-task-in-file",
    "pcap.txbf2.cnc-start",
)  # fmt: skip
def test_an_autocode_file_goes_into_its_task(mcu: Mcu, tmp_path: Path) -> None:
    assert mcu.txbf2(MILL) == mcu.txbf2(autocode(tmp_path, 2, 11)) == 0
    mcu.advance(10)
    assert (mcu.rdci(2), mcu.rdcncts(2).running) == (0, 0), "it does not run by itself"
    mcu.startcnct(2)
    mcu.advance(10)
    assert (mcu.rdci(2), mcu.rdcncts(2).running & 1) == (11, 1)
    assert mcu.txbf2(autocode(tmp_path, 2, 22)) == 0
    counted = mcu.rdci(9)
    mcu.advance(10)
    assert (mcu.rdci(9), mcu.rdcncts(2).running) == (counted, 0), "the task was stopped"
    mcu.startcnct(2)
    mcu.advance(10)
    assert mcu.rdci(2) == 22, "another program"
    assert [mcu.rdci(n) for n in (0, 1, 3)] == [0, 0, 0]


@pytest.mark.shows("pcap.txbf2.ret-21", "pcap.txbf2.ret-22", "pcap.txbf2.ret-24")
def test_autocode_files_that_are_refused(mcu: Mcu, tmp_path: Path) -> None:
    good = autocode(tmp_path, 1, 5).read_bytes()
    path = tmp_path / "file.CNC"
    for data, status in [(good, 0), (good[1:], 22), (b"", 22), (good[:-1], 24), (good[:-1] + b"\x55", 24)]:
        path.write_bytes(data)
        assert mcu.txbf2(path) == status
    with path.open("wb") as file:
        file.truncate(65 * 1024 * 1024)  # takes no room on the disk
    assert mcu.txbf2(path) == 21
    mcu.startcnct(1)
    mcu.advance(5)
    assert mcu.rdci(1) == 5, "what was refused changed nothing"
