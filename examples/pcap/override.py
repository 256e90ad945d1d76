"""Override: a ramp down and up again in the middle of a path, which stays what it was (4.4.132, 4.4.174, 4.4.175)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motion_kernel import Machine, Mcu

PLANE = ["X", "Y"]


def main() -> None:
    mcu = Mcu(Machine.load(Path(__file__).with_name("cell.toml")))
    mcu.cl(PLANE)
    mcu.wrtrovrst(0.5)  # s for a change by 1.0
    mcu.smla({"X": 50.0, "Y": 0.0}, ac=500.0, vl=40.0)
    mcu.smca({"X": 0.0, "Y": 0.0}, 360.0, ac=500.0, vl=40.0)
    mcu.ssms(PLANE)
    ways = []
    for factor, seconds in [(1.0, 2.5), (0.25, 2.0), (1.5, 1.5), (1.0, 8.0)]:
        mcu.wrtrovr(factor)
        mcu.utrovr(PLANE)
        mcu.advance(round(seconds / mcu.machine.sample_time_s))
        ways.append(mcu.trace.dp[:, :2])
        v = np.hypot(*np.diff(mcu.trace.dp[:, :2], axis=0).T) / mcu.machine.sample_time_s
        print(f"factor {mcu.rdtrovr():g}: path velocity {v[len(v) // 2]:.2f} mm/s, jog override {mcu.rdjovr('X'):g}")
    way = np.concatenate(ways)
    on_circle = way[np.argmax(way[:, 1] > 1e-6) :]
    print(f"off the circle by {np.abs(np.hypot(*on_circle.T) - 50.0).max():.1e} mm")


if __name__ == "__main__":
    main()
