"""ENDAT encoders through the resource interface (chapter 6)."""

from __future__ import annotations

import pytest

import sympas
from motion_kernel import Machine, Mcu
from motion_kernel.resources import DEVICES, WRITE, Code, ObjectDescriptor
from tests.conformance.conftest import MILL


@pytest.fixture
def endat() -> Mcu:
    """mill3 in open loop, X with an encoder of 20 bits."""
    mcu = Mcu(Machine.load(MILL))
    mcu.resources.fit("RESOURCE", "ENDAT")
    mcu.resources.fit_endat("X", 20)
    mcu.environment["MT0"] = "11"
    mcu.rs()
    return mcu


def read(mcu: Mcu, device: int, sub: int = 0) -> tuple[int, int, int]:
    """Repeats while BUSY: return code, value, and how many times it was BUSY."""
    descriptor = ObjectDescriptor(device, 0, sub)
    for times in range(10):
        code, value = mcu.resources.rdoptionint(descriptor)
        if code != Code.BUSY:
            return code, value, times
        mcu.advance(1)
    raise AssertionError("busy for ever")


def write(mcu: Mcu, device: int, value: int, sub: int = 0) -> int:
    descriptor = ObjectDescriptor(device, 0, sub, access=WRITE)
    for _ in range(10):
        code = mcu.resources.wroptionint(descriptor, value)
        if code != Code.BUSY:
            return code
        mcu.advance(1)
    raise AssertionError("busy for ever")


@pytest.mark.shows(
    "res.endat.option", "res.endat.versions", "res.dev-3000-3100.group", "res.endat.environment", "res.endat.auto-init"
)
def test_option_and_encoder(endat: Mcu) -> None:
    assert {d.first for d in DEVICES.values() if 3000 <= d.first <= 3100} == {*range(3000, 3005), *range(3010, 3014)}
    for mt, version in (("16", 22), ("1", None), ("11", 21), ("", None), ("99999999999", None), ("16", 22)):
        before = read(endat, 3000)[0]
        endat.environment["MT0"] = mt
        assert read(endat, 3000)[0] == before, "the environment counts at the next boot or rs"
        endat.rs()
        setup = endat.resources.endat_setup("X")
        assert (setup.version if setup else None) == version
        assert read(endat, 3000)[0] == (Code.OK if version else Code.UNKNOWN)
    assert endat.resources.rdoptionint(ObjectDescriptor(3000, 1))[0] == Code.UNKNOWN
    endat.resources.fit("RESOURCE")
    assert read(endat, 3000)[0] == Code.UNKNOWN
    endat.rs()
    assert endat.resources.endat_setup("X") is None


@pytest.mark.shows("res.endat.auto-init")
def test_set_up_from_the_data_of_the_encoder(endat: Mcu) -> None:
    assert endat.resources.endat_setup("X") == (21, 20, True, 2**20)
    assert endat.resources.endat_setup("Y") is None
    endat.shp("X", 0.0)
    endat.ol(["X"])
    endat.resources.fit_endat("X", 32, rotary=False, steps=100)
    assert endat.resources.endat_setup("X") is None, "the new encoder is not known yet"
    endat.rs()
    assert endat.resources.endat_setup("X") == (21, 32, False, 100)
    endat.resources.fit_endat("X", 8, steps=70_000)
    endat._card.read_environment()
    endat._card.emulator.reboot()
    assert endat.resources.endat_setup("X") == (21, 8, True, 70_000)
    endat.cl(["X"])
    endat.ja({"X": 3.0})
    endat.advance(3000)
    code, word, _ = read(endat, 3000)
    assert code == Code.OK and word == round(3.0 * endat.rdslsp("X") / endat.rdgf("X")) % 2**8, "8 bits"
    endat.resources.disturb_endat("X", timeouts=1)
    endat.rs()
    assert endat.resources.endat_setup("X") is None and endat.rdifs().bus_error, "it does not answer"
    endat.rs()
    assert endat.resources.endat_setup("X") is not None
    with pytest.raises(ValueError, match="1 to 32"):
        endat.resources.fit_endat("X", 33)


@pytest.mark.shows("res.endat.3013-BUSERR.event", "event.EVENDAT")
def test_a_transmission_error_raises_the_event(endat: Mcu) -> None:
    text = "procedure EVENDAT; begin CI0 := CI0 + 1; end;\nbegin enev(EVENDAT); while CI1 = 0 do ; end.\n"
    endat.load(0, sympas.compile(text, endat.machine))
    endat.startcnct(0)
    endat.advance(100)
    assert endat.rdci(0) == 0
    endat.resources.disturb_endat("X", crc_errors=1)
    assert read(endat, 3000)[0] == Code.STATE_ERR
    endat.advance(100)
    assert endat.rdci(0) == 1
    endat.resources.disturb_endat("X", crc_errors=1)
    assert write(endat, 3013, 0) == Code.OK
    endat.advance(100)
    assert read(endat, 3000)[0] == Code.STATE_ERR
    endat.advance(100)
    assert endat.rdci(0) == 2


@pytest.mark.shows("res.endat.3000-TPV", "res.endat.3000-TPV.duration", "res.endat.busy-is-normal")
def test_position(endat: Mcu) -> None:
    counts = endat.rdslsp("X") / endat.rdgf("X")
    assert read(endat, 3000) == (Code.OK, 0, 1), "a sample is longer than 1 ms"
    endat.cl(["X"])
    for target in (10.0, -0.5):
        endat.ja({"X": target})
        endat.advance(3000)
        code, word, _ = read(endat, 3000)
        assert code == Code.OK and word == round(endat.rdrp("X") * counts) % 2**20


@pytest.mark.shows(
    "res.endat.3001-SMA", "res.endat.3002-TP", "res.endat.3003-RP", "res.endat.3003-RP.readback",
    "res.endat.sma-before-parameters",
)  # fmt: skip
def test_parameters(endat: Mcu) -> None:
    assert read(endat, 3002, 5)[0] == Code.STATE_ERR and write(endat, 3003, 1, 5) == Code.STATE_ERR
    for area in (0xA1, 0xA9):
        assert write(endat, 3001, area) == Code.OK
        assert write(endat, 3003, area * 3, 5) == Code.OK and write(endat, 3003, 0xFFFF, 255) == Code.OK
    for area in (0xA1, 0xA9):
        assert write(endat, 3001, area) == Code.OK
        assert read(endat, 3002, 5) == (Code.OK, area * 3, 1)
        assert read(endat, 3002, 255)[1] == 0xFFFF and read(endat, 3002, 6)[1] == 0
    assert read(endat, 3002, 256)[0] == write(endat, 3003, 65536) == write(endat, 3001, 256) == Code.STATE_ERR


@pytest.mark.shows("res.endat.3004-RR", "res.endat.3004-RR.open-loop", "res.return.state-err-80")
def test_reset(endat: Mcu) -> None:
    endat.cl(["X"])
    assert write(endat, 3004, 0) == Code.STATE_ERR and endat.resources.endat_resets("X") == 0
    endat.ol(["X"])
    assert write(endat, 3004, 0) == Code.OK and endat.resources.endat_resets("X") == 1


@pytest.mark.shows(
    "res.endat.3000-TPV.supervision", "res.endat.3010-RA", "res.endat.3011-CRCERRS", "res.endat.3012-TOERRS",
    "res.endat.3013-BUSERR",
)  # fmt: skip
def test_errors_and_alarm(endat: Mcu) -> None:
    registers = (3010, 3011, 3012, 3013)

    def state() -> list[int]:
        return [read(endat, device)[1] for device in registers]

    endat.resources.disturb_endat("X", alarm=True, crc_errors=2, timeouts=1)
    assert state() == [0, 0, 0, 0], "nothing was read yet"
    codes = [read(endat, 3000)[0] for _ in range(4)]
    assert codes == [Code.STATE_ERR] * 3 + [Code.OK]
    assert state() == [1, 2, 1, 1] and endat.rdifs().bus_error
    endat.resources.disturb_endat("X", timeouts=1)
    assert read(endat, 3000)[0] == Code.STATE_ERR and state() == [1, 2, 2, 2]
    assert read(endat, 3000)[0] == Code.OK and state() == [0, 2, 2, 2]
    for device in registers[1:]:
        assert write(endat, device, 5) == Code.STATE_ERR and write(endat, device, 0) == Code.OK
    assert state() == [0, 0, 0, 0]
    assert endat.resources.wroptionint(ObjectDescriptor(3010, access=WRITE), 0) == Code.UNKNOWN
