"""Time-optimal motion along arcs and helices by toppra, which the extra `optimal` installs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import toppra
from toppra.algorithm import TOPPRA
from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint
from toppra.interpolator import AbstractGeometricPath

if TYPE_CHECKING:
    from toolpaths.optimal import Arc

toppra.setup_logging("ERROR")
Floats = npt.NDArray[np.float64]
FREE = 1e9


class Curve(AbstractGeometricPath):  # type: ignore[misc]
    """The two axes of the plane, and the path length itself as a third axis: its velocity is that of the path."""

    def __init__(self, arc: Arc, length: float) -> None:
        self.arc, self.length = arc, length

    def __call__(self, s: Floats | float, order: int = 0) -> Floats:
        """Positions at path lengths, or their first or second derivative."""
        s = np.asarray(s, dtype=float)[..., np.newaxis]
        arc = self.arc
        turning = arc.radius * np.exp(1j * (arc.angle + arc.bend * s)) * (1j * arc.bend) ** order
        along = (s, 1 + 0 * s, 0 * s)[order]
        return np.concatenate([turning.real, turning.imag, along], axis=-1)

    @property
    def dof(self) -> int:
        """Axes."""
        return 3

    @property
    def path_interval(self) -> Floats:
        """The piece that toppra sees."""
        return np.array([0.0, self.length])

    @property
    def waypoints(self) -> None:
        """There are none."""
        return


def arc_time(arc: Arc, length: float, v: tuple[float, float], v_max: float, grid: int) -> float | None:
    """Seconds for the first `length` mm of an arc between two path velocities; None where toppra finds no motion."""
    # the speeds at the ends may lie on the limits
    velocity = np.array([FREE, FREE, max(v_max, *v)]) * (1 + 1e-7)
    acceleration = np.array([*arc.plane, min(arc.path_acc, FREE)]) * (1 + 1e-7)
    constraints = [
        JointVelocityConstraint(np.stack([-velocity, velocity], axis=1)),
        JointAccelerationConstraint(np.stack([-acceleration, acceleration], axis=1)),
    ]
    # closer at the ends, where the speeds may be small
    points = length * (1 - np.cos(np.linspace(0, np.pi, grid + 1))) / 2
    algorithm = TOPPRA(constraints, Curve(arc, length), gridpoints=points)
    _, speeds, _ = algorithm.compute_parameterization(*v)
    if speeds is None or not np.all(speeds[1:] + speeds[:-1] > 0):
        return None
    return float(np.sum(2 * np.diff(points) / (speeds[1:] + speeds[:-1])))
