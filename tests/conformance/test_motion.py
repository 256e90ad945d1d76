"""Motion commands as Python calls them: where each ends, absolute and relative, direct and spooled (4.4.19 ...)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from motion_kernel import Machine, Mcu, ModeReg
from tests.app.conftest import ROOT

AXES = ["X", "Y", "Z"]
V = {"ac": 1000.0, "vl": 50.0}
CELL = ROOT / "examples" / "pcap" / "cell.toml"


@pytest.fixture
def cell() -> Mcu:
    """The cell of the examples in closed loop at (10, 20, 30)."""
    mcu = Mcu(Machine.load(CELL))
    mcu.wrmodereg(ModeReg.of("ExactTargetPos"))
    mcu.cl(AXES)
    mcu.mla({"X": 10.0, "Y": 20.0, "Z": 30.0}, **V)
    mcu.advance(2000)
    return mcu


def where(mcu: Mcu) -> list[float]:
    return [mcu.rddp(axis) for axis in AXES]


Move = Callable[[Mcu], bool]
# command, and where it ends from (10, 20, 30)
MOVES: list[tuple[str, Move, tuple[float, float, float]]] = [
    ("ja", lambda m: m.ja({"X": 5.0, "Z": 31.0}), (5.0, 20.0, 31.0)),
    ("jr", lambda m: m.jr({"X": 5.0, "Z": 1.0}), (15.0, 20.0, 31.0)),
    ("mla", lambda m: m.mla({"Y": 22.0, "X": 11.0}, **V), (11.0, 22.0, 30.0)),
    ("mlr", lambda m: m.mlr({"Y": 22.0, "X": 11.0}, **V), (21.0, 42.0, 30.0)),
    ("mca", lambda m: m.mca({"X": 14.0, "Y": 20.0}, 90.0, **V), (14.0, 16.0, 30.0)),
    ("mcr", lambda m: m.mcr({"X": 4.0, "Y": 0.0}, -90.0, **V), (14.0, 24.0, 30.0)),
    ("mha", lambda m: m.mha({"X": 14.0, "Y": 20.0}, 450.0, {"Z": 25.0}, **V), (14.0, 16.0, 25.0)),
    ("mhr", lambda m: m.mhr({"X": 4.0, "Y": 0.0}, -90.0, {"Z": 25.0}, **V), (14.0, 24.0, 55.0)),
    ("mha", lambda m: m.mha({"X": 14.0, "Y": 20.0}, 0.0, {"X": 18.0, "Y": 20.0, "Z": 3.0}, **V), (18.0, 20.0, 3.0)),
    ("mca3d", lambda m: m.mca3d({"X": 10.0, "Y": 24.0, "Z": 30.0}, (1, 0, 0), 90.0, **V), (10.0, 24.0, 26.0)),
    ("mcr3d", lambda m: m.mcr3d({"X": 0.0, "Y": 4.0, "Z": 0.0}, (-1, 0, 0), 90.0, **V), (10.0, 24.0, 34.0)),
    ("smla", lambda m: m.smla({"Y": 22.0, "X": 11.0}, **V), (11.0, 22.0, 30.0)),
    ("smlr", lambda m: m.smlr({"Y": 22.0, "X": 11.0}, **V), (21.0, 42.0, 30.0)),
    ("smca", lambda m: m.smca({"X": 14.0, "Y": 20.0}, 90.0, **V), (14.0, 16.0, 30.0)),
    ("smcr", lambda m: m.smcr({"X": 4.0, "Y": 0.0}, -90.0, **V), (14.0, 24.0, 30.0)),
    ("smha", lambda m: m.smha({"X": 14.0, "Y": 20.0}, 450.0, {"Z": 25.0}, **V), (14.0, 16.0, 25.0)),
    ("smhr", lambda m: m.smhr({"X": 4.0, "Y": 0.0}, -90.0, {"Z": 25.0}, **V), (14.0, 24.0, 55.0)),
    ("smca3d", lambda m: m.smca3d({"X": 10.0, "Y": 24.0, "Z": 30.0}, (1, 0, 0), 90.0, **V), (10.0, 24.0, 26.0)),
    ("smcr3d", lambda m: m.smcr3d({"X": 0.0, "Y": 4.0, "Z": 0.0}, (-1, 0, 0), 90.0, **V), (10.0, 24.0, 34.0)),
]


@pytest.mark.shows(
    "pcap.ja", "pcap.jr", "pcap.mla", "pcap.mlr", "pcap.mca", "pcap.mcr", "pcap.mha", "pcap.mhr", "pcap.mca3d",
    "pcap.mcr3d", "pcap.smla", "pcap.smlr", "pcap.smca", "pcap.smcr", "pcap.smha", "pcap.smhr", "pcap.smca3d",
    "pcap.smcr3d", "pcap.ssms", "kernel.mode.s-prefix",
)  # fmt: skip
@pytest.mark.parametrize(("name", "move", "end"), MOVES)
def test_where_a_move_ends(cell: Mcu, name: str, move: Move, end: tuple[float, float, float]) -> None:
    assert move(cell)
    cell.advance(50)
    begun = where(cell) != [10.0, 20.0, 30.0]
    assert begun == (not name.startswith("s")), "spooled commands wait for ssms"
    if not begun:
        cell.ssms(AXES)
    cell.advance(3000)
    assert where(cell) == pytest.approx(end, abs=1e-9)
    assert all(cell.rdaxst(axis).pe for axis in AXES)
    assert cell.rderrorreg() == 0


@pytest.mark.shows("pcap.js", "pcap.ms")
@pytest.mark.parametrize("stop", ["js", "ms"])
def test_stops(cell: Mcu, stop: str) -> None:
    cell.wrsdec("X", 250.0)
    cell.mla({"X": 100.0}, **V)
    cell.advance(200)
    before = cell.rddp("X")
    getattr(cell, stop)("X")
    cell.advance(1000)
    brake = 250.0 if stop == "js" else 1000.0
    assert cell.rddp("X") - before == pytest.approx(50.0**2 / 2 / brake, abs=0.1)
    assert cell.rdaxst("X").pe


@pytest.mark.shows("pcap.sstps", "pcap.sdels", "pcap.rdlsm", "pcap.rdmcis", "pcap.ssf", "pcap.sstvl")
def test_the_spooler(cell: Mcu) -> None:
    free = cell.rdlsm("X")
    for x in (20.0, 30.0, 40.0):
        cell.smla({"X": x}, **V)
    cell.ssf("X", 7, 5)
    assert (cell.rdmcis("X"), cell.rdmcis("Y")) == (3, 0)
    assert cell.rdlsm("X") < free == cell.rdlsm("Y")
    cell.ssms("X")
    cell.advance(20)
    cell.sstps("X")
    cell.advance(1000)
    assert (cell.rddp("X"), cell.rdmcis("X"), cell.rdci(7)) == (20.0, 2, 0)
    cell.ssms("X")
    cell.advance(1000)
    assert (cell.rddp("X"), cell.rdci(7)) == (40.0, 5)
    cell.smla({"X": 50.0}, **V)
    cell.sstvl("X", 20.0)
    cell.spd("X", [50.0 + 20.0 * 1.28e-3 * n for n in range(1, 11)])
    cell.ssms("X")
    cell.advance(600)
    v = np.diff(cell.trace.dp[:, 0]) / 1.28e-3
    end = int(np.searchsorted(cell.trace.dp[:, 0], 50.0))
    assert v[end - 3 : end + 8].min() > 19.0, "no stop between them"
    cell.smla({"X": 70.0}, **V)
    cell.sdels("X")
    assert (cell.rdmcis("X"), cell.rdlsm("X")) == (0, free)


@pytest.mark.shows("pcap.spd", "pcap.spda", "pcap.spdr")
@pytest.mark.parametrize(("name", "base"), [("spd", 0.0), ("spda", 0.0), ("spdr", 10.0)])
def test_points(cell: Mcu, name: str, base: float) -> None:
    points = [10.0 + 0.01 * n - base for n in range(1, 6)]
    assert getattr(cell, name)("X", points, *([] if name == "spd" else [1]))
    cell.ssms("X")
    cell.advance(5)
    assert cell.trace.dp[:, 0] == pytest.approx([10.01, 10.02, 10.03, 10.04, 10.05])
    assert not getattr(cell, name)("X", [], *([] if name == "spd" else [1]))
    assert not getattr(cell, name)("X", [0.0] * 1001, *([] if name == "spd" else [1]))


@pytest.mark.shows("pcap.jhi", "pcap.jhl", "pcap.jhr", "pcap.shp", "pcap.rdlpndx", "pcap.wrlpndx")
def test_homing(cell: Mcu) -> None:
    cell.jhl("X")
    cell.advance(6000)
    assert cell.rdrp("X") == pytest.approx(-80.4, abs=0.1), "switch at -80, then braking"
    cell.wrlpndx("X", 99.0)
    cell.jhi({"X": 6.0})
    cell.advance(1000)
    assert cell.rdlpndx("X") == pytest.approx(-78.7)
    cell.shp("X", 7.0)
    assert cell.rdrp("X") == 7.0 and cell.rdaxst("X").referenced
    cell.jhr("X")
    cell.advance(500)
    assert not cell.rdaxst("X").pe and cell.rdrp("X") > 7.0, "no switch on the way: endless"
    cell.js("X")


@pytest.mark.shows("pcap.lps", "pcap.rdlp", "pcap.wrlp")
def test_latching_in_step(cell: Mcu) -> None:
    cell.mla({"X": 30.0}, **V)
    cell.lps("X", 25)
    cell.advance(25)
    assert cell.rdaxst("X").lpsf
    assert cell.rdlp("X") == cell.trace.rp[24, 0]
    assert not cell.rdaxst("X").lpsf, "reading clears it"
    cell.lps("X", 0)
    cell.wrlp("X", 4.5)
    assert cell.rdlp("X") == cell.rdap("X").lp == 4.5
    with pytest.raises(ValueError, match="mst"):
        cell.lps("X", -1)


@pytest.mark.shows(
    "pcap.cl",
    "pcap.ol",
    "pcap.clv",
    "pcap.rptodp",
    "pcap.wrdp",
    "pcap.wrrp",
    "pcap.wrmcp",
    "pcap.rdmcp",
    "pcap.rdrv",
)
def test_loops(cell: Mcu) -> None:
    cell.ol("X")
    assert not cell.rdaxst("X").cl
    cell.wrdigo("X", 0b11)  # power
    cell.wrmcp("X", 3277)  # 1 V: 25 mm/s
    cell.advance(500)
    assert (cell.rdmcp("X"), cell.rdrv("X")) == (3277, pytest.approx(25.0, abs=1.0))
    cell.clv("X")
    cell.advance(100)
    assert cell.rddv("X") == pytest.approx(25.0, abs=1.0), "it goes on as fast"
    cell.js("X")
    cell.advance(200)
    cell.wrdp("X", cell.rddp("X") + 0.5)
    cell.advance(200)
    assert cell.rdposerr("X") == pytest.approx(0.0, abs=1e-3)
    cell.play("block", "X")
    cell.wrdp("X", cell.rddp("X") + 0.5)
    cell.rptodp("X")
    assert cell.rdposerr("X") == 0.0
    cell.play("block", "X", on=False)
    cell.ol("X")
    cell.wrrp("X", -3.0)
    cell.cl("X")
    assert (cell.rdrp("X"), cell.rddp("X")) == (-3.0, -3.0)
