"""A flying saw: the carriage Y meets the workpiece on the conveyor X and runs along with it (chapter 3).

`python flying_saw.py [PICTURE.png]` also draws what happened."""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from motion_kernel import Machine, Mcu

Points = NDArray[np.float64]

BELT = 80.0  # mm/s
ACCELERATION = 800.0  # of the carriage, mm/s2
CUT = 120.0  # position of the belt at which the saw is beside its mark, mm
LEAD = BELT**2 / (2 * ACCELERATION)  # way of the carriage until it is as fast as the belt


def saw(speed: float = BELT) -> Mcu:
    """One cut at any speed of the belt; the trace holds X and Y."""
    mcu = Mcu(Machine.load(Path(__file__).with_name("cell.toml")))
    mcu.cl(["X", "Y"])
    r = mcu.resources
    r.MASTERAXIS["Y"], r.SYNCSOURCE["Y"] = 0, 1  # the belt as its encoder sees it
    r.STARTPOSITION["Y"], r.MASTERVELOCITY["Y"] = CUT, BELT
    r.POSITIONOFFSET["Y"] = -2 * LEAD  # way of the belt while the carriage accelerates
    r.SYNCMODE["Y"] = 1
    mcu.smla({"Y": 200.0}, ac=ACCELERATION, vl=BELT)
    mcu.ssms(["Y"])
    mcu.smla({"X": 400.0}, ac=2000.0, vl=speed)
    mcu.ssms(["X"])
    mcu.advance(round((400.0 / speed + 0.3) / mcu.machine.sample_time_s))
    return mcu


def picture(path: Path, t_s: Points, belt: Points, carriage: Points) -> None:
    """Way over time of belt and carriage, and where they run together."""
    height, width, left, bottom = 420, 760, 60, 370
    image = np.full((height, width, 3), 255, np.uint8)
    x = left + t_s / t_s[-1] * (width - left - 20)

    def curve(way: Points, color: tuple[int, int, int], thickness: int) -> None:
        points = np.stack([x, bottom - way / 400.0 * (bottom - 30)], axis=1)
        cv2.polylines(image, [np.round(points).astype(np.int32)], False, color, thickness, cv2.LINE_AA)

    together = np.abs(belt - CUT + LEAD - carriage) < 0.1
    first, last = np.flatnonzero(together)[[0, -1]]
    cv2.rectangle(image, (int(x[first]), 30), (int(x[last]), bottom), (225, 240, 225), -1)
    curve(belt, (160, 110, 30), 2)
    curve(carriage, (40, 60, 200), 2)
    cv2.line(image, (left, bottom), (width - 20, bottom), (90, 90, 90), 1)
    cv2.line(image, (left, 30), (left, bottom), (90, 90, 90), 1)
    for text, at, color in (
        ("belt X", (left + 150, 130), (160, 110, 30)),
        ("saw carriage Y", (left + 330, 345), (40, 60, 200)),
        ("running together", (int(x[first]) + 8, 48), (60, 120, 60)),
        ("400 mm", (4, 36), (90, 90, 90)),
        (f"{t_s[-1]:.1f} s", (width - 60, bottom + 22), (90, 90, 90)),
    ):
        cv2.putText(image, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.5, color, 1, cv2.LINE_AA)
    if not cv2.imwrite(str(path), image):
        raise SystemExit(f"{path} cannot be written")


def main() -> None:
    for speed in (80.0, 40.0, 100.0):
        mcu = saw(speed)
        belt, carriage = mcu.trace.rp[:, 0], mcu.trace.rp[:, 1]
        apart = belt - (CUT - LEAD) - carriage  # 0 where the carriage runs beside its mark
        beside = (belt > CUT) & (carriage < 200.0 - 2 * LEAD)
        way, off = np.ptp(belt[beside]), 1000 * np.abs(apart[beside]).max()
        print(f"belt at {speed:3.0f} mm/s: beside the mark over {way:.0f} mm, to {off:.0f} um")
        if speed == BELT and len(sys.argv) > 1:
            t_s = (np.arange(len(belt)) + 1) * mcu.machine.sample_time_s
            picture(Path(sys.argv[1]), t_s, belt, carriage)


if __name__ == "__main__":
    main()
