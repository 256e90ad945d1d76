"""DMA-RTS and the scanner of the resource interface (chapters 1 and 7)."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from motion_kernel import Machine, Mcu
from motion_kernel.resources import DEVICES, WRITE, Code, DataType, ObjectDescriptor, ResourceError
from motion_kernel.system import REVISION
from tests.conformance.conftest import TA

AXIS = '[[axis]]\nname = "{}"\ndrive = "{}"\ncounts_per_unit = 10000\nrapid = 400\nacceleration = 4000\n'
SERVO = "pidf = { kp = 1.2, kfcv = 0.003 }\n"
STOP, INIT, DIAG, LPR, STROBE, BLOCK, ANALOG = 8000, 8001, 8010, 8011, 8012, 8013, 8014
COUNT = 1e-4


def machine(*options: str, drives: str = "servo servo servo") -> Mcu:
    """Axes X, Y, Z ... in closed loop, on a board for DMA-RTS."""
    names = "XYZABCUVW"
    axes = (
        AXIS.format(name, drive) + (SERVO if drive == "servo" else "")
        for name, drive in zip(names, drives.split(), strict=False)
    )
    mcu = Mcu(Machine.parse("".join(axes)))
    mcu.cl(mcu.machine.axis_names)
    mcu.resources.fit("RESOURCE", "PCI", "DMARTS", "EP1K50", *options)
    return mcu


def order(mcu: Mcu, device: int) -> int:
    return mcu.resources.wroptionint(ObjectDescriptor(device, access=WRITE), 1)


def read(mcu: Mcu, device: int, index: int = 0, sub: int = 0, kind: DataType = DataType.INTEGER) -> tuple[int, int]:
    return mcu.resources.rdoptionint(ObjectDescriptor(device, index, sub, kind))


def block(mcu: Mcu, axes: str = "X", rows: int = 16, *, analog: bool = False) -> ObjectDescriptor:
    """A data block that was read once."""
    descriptor = mcu.resources.datablock(list(axes), rows, analog=analog)
    assert mcu.resources.rdoptionint(descriptor)[0] in (Code.BUSY, Code.OK)
    return descriptor


def scanned(mcu: Mcu, samples: int, name: str = "RTS_DATABLOCK") -> NDArray[np.void]:
    mcu.advance(samples)
    return mcu.resources.scanned[name]


@pytest.mark.shows(
    "res.rts.option", "res.rts.hardware", "res.return.hardware-8", "res.rts.device-range", "res.rts.datatype-6",
    "res.rts.analog-replaces",
)  # fmt: skip
def test_options_and_hardware() -> None:
    assert int(REVISION.split(".")[3]) >= 66 and REVISION.startswith("V2.5.3.")
    mcu = machine()
    numbers = {d.first for d in DEVICES.values() if d.first >= 8000}
    assert numbers == {STOP, INIT, DIAG, LPR, STROBE, BLOCK, ANALOG} and DataType.DATA_BLOCK == 6
    index = 1 | 1 << 16
    assert read(mcu, BLOCK, index, 8, DataType.DATA_BLOCK)[0] == Code.BUSY
    assert read(mcu, BLOCK, index, 8, DataType.INTEGER)[0] == Code.UNKNOWN
    assert read(mcu, ANALOG, index, 8, DataType.DATA_BLOCK)[0] == Code.UNKNOWN
    mcu.resources.fit("RESOURCE", "DMARTS", "EP1K50", "RTS_ANALOGIN")
    assert read(mcu, ANALOG, index, 8, DataType.DATA_BLOCK)[0] == Code.BUSY
    assert read(mcu, BLOCK, index, 8, DataType.DATA_BLOCK)[0] == Code.UNKNOWN
    mcu.resources.fit("RESOURCE", "DMARTS")
    assert read(mcu, BLOCK, index, 8, DataType.DATA_BLOCK)[0] == order(mcu, INIT) == Code.HARDWARE == 8
    mcu.resources.fit("RESOURCE", "EP1K50")
    assert read(mcu, BLOCK, index, 8, DataType.DATA_BLOCK)[0] == order(mcu, INIT) == Code.UNKNOWN


@pytest.mark.shows(
    "res.rts.subindex.sizing", "res.rts.block.row-per-edge", "res.rts.block.valid-rows", "res.rts.8013-DATABLOCK",
    "res.rts.sequence", "res.rts.read-before-scan", "res.rts.read.busy-without-init", "res.rts.read.handle-valid",
    "res.rts.8001-Init", "res.rts.8000-Stop", "res.rts.read.value",
)  # fmt: skip
def test_ten_kilohertz_give_12_or_13_rows_a_sample() -> None:
    mcu = machine()
    fresh = mcu.resources.datablock(["X"], 16)
    with pytest.raises(ResourceError, match="read before"):
        mcu.resources.scan([fresh])
    assert mcu.resources.rdoptionint(fresh) == (Code.BUSY, 0) and fresh.handle != 0
    mcu.resources.scan([fresh])
    mcu.add_stimulus("at 0.01 s: input 14 pulsing 10 kHz\n")
    assert not scanned(mcu, 20)["count"].any(), "no RTS_Init yet"
    assert order(mcu, INIT) == Code.OK
    assert read(mcu, BLOCK, 1 | 1 << 16, 16, DataType.DATA_BLOCK) == (Code.OK, 0)
    mcu.advance(1)
    assert read(mcu, BLOCK, 1 | 1 << 16, 16, DataType.DATA_BLOCK) == (Code.OK, 1)
    rows = scanned(mcu, 1000)
    counts = rows["count"]
    assert set(counts) == {12, 13} and not rows["status"].any()
    # one row per edge: edge k is at 0.01 s + k / 10 kHz
    edges = np.floor((np.arange(21, 1022) * TA - 0.01) * 1e4 - 1e-9)
    assert np.array_equal(counts, np.diff(edges).astype(int))
    assert order(mcu, STOP) == Code.OK
    assert not scanned(mcu, 10)["count"].any()
    mcu.resources.scan([])
    mcu.advance(5)
    assert mcu.resources.scanned == {}


@pytest.mark.shows("res.rts.latched-positions", "res.rts.trigger-input")
@pytest.mark.parametrize("hz", [10_000.0, 30_000.0])
def test_positions_are_those_of_the_strobe(hz: float) -> None:
    """The motor runs at a constant speed: the latch shows where it was at each edge, within a count."""
    mcu = machine()
    mcu.smla({"X": 100.0, "Y": -50.0}, ac=2000.0, vl=120.0)
    mcu.ssms(["X", "Y"])
    mcu.advance(200)
    mcu.resources.scan(["rp.X", "rp.Y", block(mcu, "XY", 48)])
    mcu.add_stimulus(f"at 0.3 s: input 14 pulsing {hz / 1000} kHz\nat 0.3 s: input 15 pulsing 7 kHz\n")
    assert order(mcu, INIT) == Code.OK
    mcu.advance(200)
    data = mcu.resources.scanned["RTS_DATABLOCK"]
    ends = (np.arange(200, 400) + 1) * TA
    valid = np.arange(48) < data["count"][:, None]
    assert not data["status"].any() and valid.sum() == np.ceil((ends[-1] - 0.3) * hz - 1e-9), "input 15 records nothing"
    times = 0.3 + np.arange(valid.sum()) / hz
    for column, axis in enumerate("XY"):
        positions = data["positions"][:, :, column][valid]
        ideal = np.interp(times, ends, mcu.resources.scanned[f"rp.{axis}"])
        assert np.abs(positions - ideal).max() <= 1.5 * COUNT and np.abs(np.diff(positions)).min() > 0
    assert valid.sum(axis=1).max() == np.ceil(hz * TA)


@pytest.mark.shows("res.rts.latched-positions")
def test_inside_a_sample_the_motor_moves_as_its_drive() -> None:
    """Open loop, a step of the motor command: speed v (1 - exp(-t / lag)), not the line between two samples."""
    text = AXIS.replace("10000", "1000000").format("X", "servo") + "plant = { lag_s = 0.0005, full_speed = 500 }\n"
    mcu = Mcu(Machine.parse(text))
    mcu.resources.fit("RESOURCE", "DMARTS", "EP1K50")
    mcu.add_stimulus("at 0 s: input 14 pulsing 25 kHz\n")
    mcu.resources.scan([block(mcu, "X", 40)])
    order(mcu, INIT)
    mcu.advance(10)
    mcu.wrmcp("X", 32767)
    mcu.advance(3)
    data = mcu.resources.scanned["RTS_DATABLOCK"]
    positions = np.concatenate([row["positions"][: row["count"], 0] for row in data])
    first = int(np.ceil(10 * TA * 25e3 - 1e-9))
    t = (first + np.arange(len(positions))) / 25e3 - 10 * TA
    ideal = 500.0 * (t - 0.0005 * (1.0 - np.exp(-t / 0.0005)))
    assert np.abs(positions - ideal).max() < 1e-6
    line = np.interp(t, np.arange(4) * TA, [0.0, *np.interp(np.arange(1, 4) * TA, t, ideal)])
    assert np.abs(line - ideal).max() > 0.01, "a line between samples would not do"


@pytest.mark.shows("res.rts.block.overflow")
def test_overflow_is_reported() -> None:
    mcu = machine()
    mcu.add_stimulus("at 0 s: input 14 pulsing 10 kHz\n")
    mcu.resources.scan([block(mcu, "X", 12)])
    order(mcu, INIT)
    data = scanned(mcu, 100)
    assert set(data["count"]) == {12} and set(data["status"]) == {0, 4}
    assert np.isclose((data["status"] == 4).mean(), 0.8, atol=0.02), "12.8 rows a sample into 12"
    fast = machine()
    fast.add_stimulus("at 0 s: input 14 pulsing 50 kHz\n")
    fast.resources.scan([block(fast, "X", 128)])
    order(fast, INIT)
    data = scanned(fast, 100)
    assert (data["status"] == 4).all() and data["count"].max() < 40, "faster than the channel carries"


@pytest.mark.shows("res.rts.8001-Init.before-scan")
def test_init_long_before_the_scanner_overflows_once() -> None:
    mcu = machine()
    mcu.add_stimulus("at 0 s: input 14 pulsing 10 kHz\n")
    waiting = block(mcu, "X", 16)
    order(mcu, INIT)
    mcu.advance(100)
    mcu.resources.scan([waiting])
    data = scanned(mcu, 20)
    assert data["status"][0] == 4 and data["count"][0] == 16 and not data["status"][1:].any()
    order(mcu, INIT)
    assert not scanned(mcu, 20)["status"].any(), "directly before the scan nothing is lost"


@pytest.mark.shows(
    "res.rts.block.header", "res.rts.block.fixed-size", "res.rts.block.columns", "res.rts.block.rows",
    "res.rts.index.axis-mask", "res.rts.index.more-axes",
)  # fmt: skip
def test_bytes_of_a_block() -> None:
    mcu = machine()
    for axis, position in zip("XYZ", (1.0, 2.0, 3.0), strict=True):
        mcu.shp(axis, position)
    for columns, mask, rows, first in ((1, 0b010, 16, [2.0]), (2, 0b101, 14, [1.0, 3.0]), (2, 0b111, 128, [1.0, 2.0])):
        descriptor = ObjectDescriptor(BLOCK, columns | mask << 16, rows, DataType.DATA_BLOCK)
        mcu.resources.rdoptionint(descriptor)
        mcu.resources.scan([descriptor])
        mcu.add_stimulus(f"at {mcu.samples * TA} s: input 14 pulsing 10 kHz\n")
        order(mcu, INIT)
        mcu.advance(4)
        raw = mcu.trace.scan_blocks
        assert raw.shape == (4, 16 + rows * columns * 8)
        count, status, *reserved = raw[1].tobytes()[:16][::4]
        assert count in (12, 13) and status == 0 and reserved == [0, 0]
        values = np.frombuffer(raw[1].tobytes()[16:], np.float64).reshape(rows, columns)
        assert np.allclose(values[:count], first, atol=2 * COUNT) and not values[count:].any()
        order(mcu, STOP)


@pytest.mark.shows("res.rts.index.max-8-axes", "res.rts.subindex.max-128", "res.rts.incremental-only")
def test_what_a_block_cannot_be() -> None:
    mcu = machine(drives="servo " * 8 + "stepper")

    def code(columns: int, mask: int, rows: int) -> int:
        return read(mcu, BLOCK, columns | mask << 16, rows, DataType.DATA_BLOCK)[0]

    assert code(8, 0xFF, 128) == Code.BUSY
    for bad in ((9, 0xFF, 8), (0, 1, 8), (1, 1, 129), (1, 1, 0), (1, 1, -1), (1, 0, 8), (1, 0x100, 8)):
        assert code(*bad) == Code.STATE_ERR
    steps = machine(drives="servo stepper")
    assert read(steps, BLOCK, 1 | 1 << 16, 8, DataType.DATA_BLOCK)[0] == Code.BUSY
    assert read(steps, BLOCK, 1 | 2 << 16, 8, DataType.DATA_BLOCK)[0] == Code.HARDWARE
    steps.resources.fit_endat("X")
    assert read(steps, BLOCK, 1 | 1 << 16, 8, DataType.DATA_BLOCK)[0] == Code.HARDWARE


@pytest.mark.shows("res.rts.8010-DIAG", "res.rts.8011-LPR", "res.rts.8012-STROBE")
def test_diagnosis() -> None:
    mcu = machine()
    order(mcu, INIT)
    mcu.shp("X", -1.5)
    mcu.advance(3)
    assert read(mcu, DIAG)[0] == Code.BUSY and read(mcu, STROBE, kind=DataType.SHORT) == (Code.OK, 0)
    mcu.add_stimulus(f"at {3.5 * TA} s: input 14 on\nat {4.5 * TA} s: input 16 on\n")
    mcu.advance(1)
    assert read(mcu, DIAG) == (Code.OK, 1) and read(mcu, STROBE, kind=DataType.SHORT) == (Code.OK, 1)
    mcu.advance(1)
    assert read(mcu, DIAG) == (Code.OK, 1) and read(mcu, STROBE, kind=DataType.SHORT) == (Code.OK, 5)
    assert read(mcu, LPR, 0, kind=DataType.SHORT) == (Code.OK, -15000)
    mcu.ol(["X"])
    mcu.wrrp("X", 100.0)
    mcu.add_stimulus(f"at {6.5 * TA} s: input 14 off\nat {7.5 * TA} s: input 14 on\n")
    mcu.advance(5)
    assert read(mcu, LPR, 0, kind=DataType.SHORT) == (Code.OK, 1_000_000 % 2**16), "its low 16 bits"
    for axis in (3, 8, -1):
        assert read(mcu, LPR, axis, kind=DataType.SHORT)[0] == Code.STATE_ERR


@pytest.mark.shows(
    "res.rts.8014-DATAANALOGBLOCK", "res.rts.analog.rows", "res.rts.analog.valid-rows", "res.rts.analog.overflow"
)
def test_analog_rows() -> None:
    mcu = machine("RTS_ANALOGIN")
    for channel in range(8):
        mcu.resources.set_analog_input(channel, 1000 * channel - 4000)
    mcu.add_stimulus("at 0 s: input 14 pulsing 10 kHz\n")
    mcu.resources.scan([block(mcu, "XY", 13, analog=True)])
    order(mcu, INIT)
    data = scanned(mcu, 50, "RTS_DATAANALOGBLOCK")
    assert mcu.trace.scan_blocks.shape[1] == 16 + 13 * (2 * 8 + 8 * 2) and not data["status"].any()
    valid = np.arange(13) < data["count"][:, None]
    assert (data["analog"][valid] == np.arange(8) * 1000 - 4000).all() and not data["analog"][~valid].any()
    assert {12, 13} == set(data["count"])
    mcu.resources.set_analog_input(7, -1)
    assert (scanned(mcu, 5, "RTS_DATAANALOGBLOCK")["analog"][:, 0, 7] == -1).all()
    mcu.resources.scan([block(mcu, "X", 5, analog=True)])
    assert set(scanned(mcu, 5, "RTS_DATAANALOGBLOCK")["status"]) == {4}


# ---- the scanner


@pytest.mark.shows("res.access.scanner")
def test_columns_are_what_reads_would_answer() -> None:
    names = ["dp.X", "rp.Y", "poserr.X", "cp.X.3.0", "scntr", "CI.12", "SYNCMODE.Z", "axst.X"]
    scanning, reading = machine(), machine()
    for mcu in (scanning, reading):
        mcu.resources.cp["X", 3, 0] = 0.25
        mcu.smla({"X": 20.0, "Y": 5.0}, ac=1000.0, vl=100.0)
        mcu.ssms(["X", "Y"])
    scanning.resources.scan(names)
    scanning.advance(300)
    columns = scanning.resources.scanned
    assert list(columns) == names and columns["cp.X.3.0"][0] == 0.25
    assert np.array_equal(columns["dp.X"], scanning.trace.dp[:, 0]) and np.ptp(columns["dp.X"]) > 10
    for k in range(300):
        reading.advance(1)
        r = reading.resources
        now = [r.dp["X"], r.rp["Y"], r.poserr["X"], 0.25, r.scntr[0], 0, 0, r.axst["X"]]
        assert [column[k] for column in columns.values()] == now
    assert np.array_equal(scanning.trace.scan, np.column_stack(list(columns.values())))


@pytest.mark.shows("res.access.scanner", "res.dev-0101.WTLSTRB")
def test_the_scanner_waits_for_the_strobe() -> None:
    mcu = machine()
    mcu.resources.scan(["WTLSTRB.0", "dp.X"])
    mcu.add_stimulus(f"at {10.5 * TA} s: input 14 on\n")
    mcu.advance(20)
    columns = mcu.resources.scanned
    assert np.flatnonzero(~np.isnan(columns["dp.X"])).tolist() == [10] and columns["WTLSTRB.0"][10] == 1


@pytest.mark.shows("res.handle.no-clear-in-use")
def test_no_clear_while_scanning() -> None:
    mcu = machine()
    mcu.resources.scan(["dp.X"])
    with pytest.raises(ResourceError, match="80 hex"):
        mcu.resources.clear()
    mcu.advance(2)
    mcu.resources.scan([])
    mcu.resources.clear()


def test_what_cannot_be_scanned() -> None:
    mcu = machine()
    for name, words in (
        ("poser.X", "did you mean poserr"), ("dp.Q", "no axis Q; it has X, Y, Z"), ("dp", "needs an axis"),
        ("dp.X.1.2", "no such index"), ("CI.x", "whole number"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=words):
            mcu.resources.scan(["rp.X", name])
    for name, words in (("CI.1000", "80 hex"), ("AOUT.0", "code 1"), ("FASTPULSEOUT", "code 1"), ("dp.7", "80 hex")):
        with pytest.raises(ResourceError, match=words):
            mcu.resources.scan([name])
    with pytest.raises(ValueError, match="twice"):
        mcu.resources.scan(["dp.X", "dp.X"])
    memory = mcu.resources.allocphysmem(8)
    mcu.resources.HostMemPhysAdr[0] = memory.phys_adr
    for names in (["HostMemInt.0"], [f"CI.{n}" for n in range(65)]):
        with pytest.raises(ResourceError, match="at most 64"):
            mcu.resources.scan(names)
    mcu.advance(1)
    assert mcu.resources.scanned == {}


def test_a_reboot_ends_the_scan() -> None:
    mcu = machine()
    mcu.resources.scan(["dp.X"])
    mcu._card.emulator.reboot()
    mcu.advance(2)
    assert mcu.resources.scanned == {}
