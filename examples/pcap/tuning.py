"""Tuning a loop: following error with and without feed-forward, and what a poor gain looks like (2.1.2, 4.4.131)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motion_kernel import Machine, Mcu


def jog_with(mcu: Mcu, kp: float, kfcv: float, kfca: float) -> tuple[float, float]:
    """Largest following error of a jog, and how much the axis trembles behind it, mm."""
    mcu.rs()
    mcu.uf("X", kp=kp, ki=0.0, kd=0.0, kfcv=kfcv, kfca=kfca)
    mcu.cl("X")
    mcu.jr({"X": 40.0})
    mcu.advance(1200)
    error = np.abs(mcu.trace.dp[:, 0] - mcu.trace.rp[:, 0]).max()
    tremble = np.ptp(mcu.trace.rp[-100:, 0])
    mcu.ol("X")
    mcu.advance(200)
    mcu.wrrp("X", 0.0)
    return float(error), float(tremble)


def main() -> None:
    mcu = Mcu(Machine.load(Path(__file__).with_name("cell.toml")))
    good = mcu.rdf("X")
    for name, kp, kfcv, kfca in [
        ("P alone", good.kp, 0.0, 0.0),
        ("with velocity", good.kp, good.kfcv, 0.0),
        ("with both", good.kp, good.kfcv, good.kfca),
        ("20 times the gain", 20 * good.kp, good.kfcv, good.kfca),
    ]:
        error, tremble = jog_with(mcu, kp, kfcv, kfca)
        print(f"{name:18} {error:6.3f} mm behind, trembles by {tremble:.3f} mm")


if __name__ == "__main__":
    main()
