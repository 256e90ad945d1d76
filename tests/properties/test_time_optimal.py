"""No entry of a chain is faster than toppra's time-optimal motion along the same piece of path (design D27): between
the speeds that the kernel had there, under axis limits that contain what is programmed. On lines it is as fast, too."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import toppra
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from toppra.algorithm import TOPPRA
from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint
from toppra.interpolator import AbstractGeometricPath

from motion_kernel import Machine, Mcu, ModeReg

toppra.setup_logging("ERROR")
Floats = npt.NDArray[np.float64]

MAXACC = 800.0
AXES = ("X", "Y", "Z")
# a sample takes 64 us, so that the first and the last of an entry lie close to its junctions
MACHINE = "[controller]\nsample_ticks = 1\n" + "".join(
    f'[[axis]]\nname = "{name}"\nletter = "{name}"\ncounts_per_unit = 1e4\nrapid = 200\nacceleration = 1000\n'
    f"mdvel = 0.5\nmaxacc = {MAXACC}\njerkrel = 0.8\n"
    for name in AXES
)
TA = 64e-6
GRID = 300
CLOSE = 5e-5  # toppra's grid costs it less than that


class Curve(AbstractGeometricPath):  # type: ignore[misc]
    """A line (`turn` None) or a helix of X and Y by path length, from `start`."""

    def __init__(self, start: Floats, way: Floats, turn: tuple[Floats, float] | None) -> None:
        self.start, self.way, self.turn = start, way, turn
        self.radius = 0.0 if turn is None else float(np.hypot(*turn[0]))
        angle = 0.0 if turn is None else turn[1]
        self.length = float(np.hypot(np.linalg.norm(way), self.radius * angle))
        self.bend = angle / self.length
        self.span = (0.0, self.length)

    def __call__(self, s: Floats | float, order: int = 0) -> Floats:
        """Positions at path lengths, or their first or second derivative."""
        s = np.asarray(s, dtype=float)[..., np.newaxis]
        rate = self.way / self.length
        line = (self.start + s * rate, rate + 0 * s, 0 * (s + rate))[order]
        if self.turn is None:
            return line
        center = self.turn[0]
        out = -center[0] - 1j * center[1]
        around = out * (np.exp(1j * self.bend * s) * (1j * self.bend) ** order - (order == 0))
        return np.asarray(line + np.concatenate([around.real, around.imag, 0 * s], axis=-1))

    @property
    def dof(self) -> int:
        """Axes."""
        return 3

    @property
    def path_interval(self) -> Floats:
        """The piece that toppra sees."""
        return np.array(self.span)

    @property
    def waypoints(self) -> None:
        """There are none."""
        return

    def along(self, points: Floats) -> Floats:
        """Path lengths of points of the curve, in order."""
        if self.turn is None:
            return np.asarray((points - self.start) @ self.way / self.length)
        from_center = points[:, :2] - self.start[:2] - self.turn[0]
        first = np.arctan2(-self.turn[0][1], -self.turn[0][0])
        angle = np.unwrap(np.concatenate([[first], np.arctan2(from_center[:, 1], from_center[:, 0])]))[1:] - first
        return np.asarray(angle / self.bend)


@dataclass(frozen=True)
class Element:
    """A line by its way, or an arc with `center` from its start and `phi` degrees; Z runs along."""

    way: tuple[float, float, float]
    center: tuple[float, float] | None
    phi: float
    vl: float
    ac: float

    def curve(self, start: Floats) -> Curve:
        """Its place in a chain."""
        if self.center is None:
            return Curve(start, np.array(self.way), None)
        return Curve(start, np.array([0, 0, self.way[2]]), (np.array(self.center), float(np.radians(self.phi))))

    def limits(self, curve: Curve, over: float) -> tuple[Floats, Floats]:
        """The velocities and accelerations of the axes that contain what is programmed."""
        if curve.turn is None:
            share = np.abs(curve.way) / curve.length
            return share * self.vl, share * self.ac * over
        v = min(self.vl, np.sqrt(curve.radius * MAXACC))
        flat, deep = abs(curve.bend) * curve.radius, abs(curve.way[2]) / curve.length
        a = float(np.hypot(self.ac * over * flat, (v * flat) ** 2 / curve.radius))
        return v * np.array([flat, flat, deep]), np.array([a, a, deep * self.ac * over])


def least_time(
    element: Element, curve: Curve, piece: tuple[float, float], v: tuple[float, float], over: float
) -> float:
    """Seconds that toppra needs for a piece of the curve between two path velocities."""
    curve.span = piece
    velocity, acceleration = (np.maximum(most, 1e-6) for most in element.limits(curve, over))
    # the speeds at the ends may lie on the limits
    velocity, acceleration = velocity * (1 + 1e-7), acceleration * (1 + 1e-7)
    constraints = [
        JointVelocityConstraint(np.stack([-velocity, velocity], axis=1)),
        JointAccelerationConstraint(np.stack([-acceleration, acceleration], axis=1)),
    ]
    # closer at the ends, where the speeds may be small
    grid = piece[0] + (piece[1] - piece[0]) * (1 - np.cos(np.linspace(0, np.pi, GRID + 1))) / 2
    _, speeds, _ = TOPPRA(constraints, curve, gridpoints=grid).compute_parameterization(*v)
    assert speeds is not None, "the limits contain the plan, so there is a motion"
    return float(np.sum(2 * np.diff(grid) / (speeds[1:] + speeds[:-1])))


tenths = st.integers(-150, 150).map(lambda n: n / 10)
way = st.tuples(tenths, tenths, tenths).filter(lambda way: np.linalg.norm(way) > 0.5)
center = st.tuples(tenths, tenths).filter(lambda center: np.hypot(*center) > 0.3)
phi = st.builds(lambda phi, sign: phi * sign, st.floats(20, 400), st.sampled_from([-1, 1]))
elements = st.lists(
    st.builds(Element, way, st.none() | center, phi, st.floats(10, 90), st.floats(200, 1500)), min_size=1, max_size=5
)


@settings(max_examples=15, phases=[Phase.generate])  # shrinking would take minutes
@given(elements, st.booleans())
def test_no_entry_is_faster_than_toppra(chain: list[Element], shaped: bool) -> None:
    mcu = Mcu(Machine.parse(MACHINE))
    mcu.cl(AXES)
    mcu.wrmodereg(ModeReg.of("LookAhead", "ExactTargetPos", *["SProfile"][: int(shaped)]))
    curves: list[Curve] = []
    for n, element in enumerate(chain):
        start = curves[-1](curves[-1].length) if curves else np.zeros(3)
        curve = element.curve(start)
        curves.append(curve)
        dynamics = {"vl": element.vl, "ac": element.ac, "tvl": element.vl if n + 1 < len(chain) else 0.0}
        end = dict(zip(AXES, curve(curve.length), strict=True))
        if curve.turn is None:
            assert mcu.smla(end, **dynamics)
        else:
            middle = start[:2] + curve.turn[0]
            assert mcu.smha({"X": middle[0], "Y": middle[1]}, element.phi, {"Z": end["Z"]}, **dynamics)
    mcu.ssms(AXES)
    over = 1.8 if shaped else 1.0
    seconds = sum(
        curve.length / element.vl + element.vl / element.ac for element, curve in zip(chain, curves, strict=True)
    )
    mcu.advance(int(4 * seconds / TA) + 20_000)
    assert mcu.rdaxst("X").pe
    for n, (element, curve) in enumerate(zip(chain, curves, strict=True)):
        here = np.flatnonzero(mcu.trace.entry == n + 1)
        first, last = int(here[0]), int(here[-1])
        s = curve.along(mcu.trace.dp[first : last + 1])
        v = mcu.trace.v_plan[[first, last]]
        least = least_time(element, curve, (s[0], s[-1]), (v[0], v[1]), over)
        taken = (last - first) * TA
        assert taken >= least * (1 - CLOSE), f"entry {n}: {taken} s, toppra needs {least} s"
        if curve.turn is None and not shaped:
            assert taken <= least * (1 + CLOSE), f"entry {n}: {taken} s, toppra only {least} s"
