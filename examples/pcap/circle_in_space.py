"""A 3-D circle around a tilted axis, and a helix: every set point lies on the surface it should (4.4.30, 4.4.35)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motion_kernel import Machine, Mcu

AXES = ["X", "Y", "Z"]


def main() -> None:
    mcu = Mcu(Machine.load(Path(__file__).with_name("cell.toml")))
    mcu.cl(AXES)
    centre, normal = np.array([20.0, 10.0, 0.0]), np.array([1.0, -2.0, 3.0])
    mcu.smca3d(dict(zip(AXES, centre, strict=True)), normal.tolist(), 540.0, ac=300.0, vl=30.0)
    mcu.ssms(AXES)
    mcu.advance(12000)
    way = mcu.trace.dp[mcu.trace.entry > 0]
    radius = np.linalg.norm(way - centre, axis=1)
    height = (way - centre) @ normal / np.linalg.norm(normal)
    print(f"radius {radius.mean():.4f} +- {np.ptp(radius):.1e}, out of its plane by {np.ptp(height):.1e}")
    start = np.array([mcu.rddp(axis) for axis in AXES])
    mcu.smhr({"X": -15.0, "Y": 0.0}, 720.0, {"Z": -8.0}, ac=300.0, vl=30.0)
    mcu.ssms(AXES)
    mcu.advance(12000)
    end = np.array([mcu.rddp(axis) for axis in AXES])
    print("helix of two turns: moved by", " ".join(f"{x:.3f}" for x in np.round(end - start, 6) + 0.0))


if __name__ == "__main__":
    main()
