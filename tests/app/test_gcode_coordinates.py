"""Resources RefOffset, Mirror and PositionFactor act on part programs (din66025.md, section 10)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import gcode
from motion_kernel import Machine, Mcu
from tests.app.conftest import ROOT, Cli

MILL = ROOT / "examples" / "machines" / "mill3.toml"
#: What the next command moves in its first sample, mm
FIRST_SAMPLE = 3000 / 60 * 1.28e-3 + 1e-9
PART = """G90 G21 G17 G94
G54 G0 X0 Y0
G1 X20 Y5 F3000
G3 X20 Y25 I0 J10
G55
G1 X10 Y0
G91 G1 X-4
G59
G90 G1 X0 Y0 Z1
M30
"""


def corners(mcu: Mcu) -> NDArray[np.float64]:
    """Runs the part on a new controller; where each motion command but the first ended, X and Y."""
    mcu.prepare_gcode()
    mcu.load(0, gcode.compile(PART, mcu.gcode_machine))
    mcu.startcnct(0)
    mcu.advance(9000)
    entry, dp = mcu.trace.entry, mcu.trace.dp[:, :2]
    assert entry[-1] == 0 and entry.max() == 6
    return np.array([*(dp[np.flatnonzero(entry == n)[-1] + 1] for n in range(2, 6)), dp[-1]])


def expected(offsets: dict[int, tuple[float, float]], factor: float, factor_y: float) -> NDArray[np.float64]:
    """machine = factor * word + RefOffset; an incremental word knows no offset."""
    words = [(0, 20, 5), (0, 20, 25), (1, 10, 0), (1, 6, 0), (5, 0, 0)]
    return np.array([(factor * x + offsets[n][0], factor_y * y + offsets[n][1]) for n, x, y in words])


@pytest.mark.shows("res.dev-0016.RefOffset", "res.dev-0017.Mirror", "res.dev-0018.PositionFactor")
@pytest.mark.parametrize(("mirror", "factor"), [(0, -1.0), (1, -1.0), (1, 0.5), (0, 0.5)])
def test_offsets_and_mirror_of_the_controller_act_on_the_next_program(mirror: int, factor: float) -> None:
    mcu = Mcu(Machine.load(MILL))
    r = mcu.resources
    assert [r.RefOffset["X", n] for n in range(6)] == [0.0] * 6 and r.Mirror["X"] == 0
    offsets = {0: (1.0, -2.0), 1: (3.0, 4.0), 5: (-7.0, 0.5)}
    for n, values in offsets.items():
        r.RefOffset["X", n], r.RefOffset["Y", n] = values
    r.Mirror["X"], r.PositionFactor["X"], r.PositionFactor["Y"] = mirror, factor, 7.0
    scaled = 1.0
    if mirror and abs(factor) != 1.0:
        with pytest.raises(gcode.CompileError, match="GC412"):
            corners(mcu)  # a circle of an axis that is scaled alone is none
        r.Mirror["Y"], r.PositionFactor["Y"], scaled = 1, factor, factor
    wanted = expected(offsets, factor if mirror else 1.0, scaled)
    assert np.allclose(corners(mcu), wanted, atol=FIRST_SAMPLE)
    assert mcu.rdzerooffset("X") == 0.0, "the controller's own zero point stays where it is (GC805)"


def test_the_machine_file_sets_the_resources() -> None:
    text = MILL.read_text() + "\n[gcode.position_factors]\nX = -2.0\n[gcode.offsets]\nG55 = { X = 5.0 }\n"
    mcu = Mcu(Machine.parse(text))
    r = mcu.resources
    assert (r.Mirror["X"], r.PositionFactor["X"], r.Mirror["Y"], r.PositionFactor["Y"]) == (1, -2.0, 0, -1.0)
    assert [r.RefOffset["X", n] for n in range(6)] == [0.0, 5.0, 0.0, 0.0, 0.0, 0.0]
    assert mcu.gcode_machine.show() == mcu.machine.show()
    r.RefOffset["Y", 3], r.Mirror["X"] = 1.5, 0
    shown = mcu.gcode_machine.show()
    assert "Y = 1.5" in shown and "-2" not in shown.split("[gcode.position_factors]")[1].split("[")[0]


@pytest.mark.parametrize("factors", [{"X": -1.0}, {"X": -1.0, "Y": -1.0}, {"Y": -1.0}, {"X": 2.0, "Y": 2.0}])
def test_the_path_is_kept_exactly(
    cli: Cli, job: Callable[..., Path], tmp_path: Path, factors: dict[str, float]
) -> None:
    """Mirrored and scaled programs with arcs and radius correction: the set point lies on the programmed path."""
    machine = tmp_path / "mill.toml"
    table = "".join(f"{axis} = {factor}\n" for axis, factor in factors.items())
    offsets = "[gcode.offsets]\nG54 = { X = 3.0, Y = -4.0 }\n"
    tool = "[[gcode.tool]]\nnumber = 1\nradius = 2.0\nlength = 0.0\n"
    machine.write_text(f"{MILL.read_text()}\n[gcode.position_factors]\n{table}{offsets}{tool}")
    part = job("G90 G21 G94\nT1\nG41 G1 X10 Y0 F2000 D1\nX30\nG3 X30 Y20 I0 J10\nG1 X10\nG40 G1 X0 Y0\nM30\n")
    ran = cli("run", part, "--machine", machine, "--json")
    assert ran.code == 0, ran.err
    assert ran.object["deviation"]["setpoint"]["max_mm"] < 1e-9
