"""Path pictures: true to scale, coloured by grade, worst on top."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from toolpaths import raster


def has(image: raster.Image, colour: tuple[int, int, int]) -> np.ndarray:
    return np.argwhere((image == np.array(colour, np.uint8)).all(axis=2))


def square(side: float = 40.0) -> tuple[np.ndarray, np.ndarray]:
    points = np.array([[0, 0], [side, 0], [side, side], [0, side], [0, 0]], dtype=np.float64)
    return points, np.zeros(5, bool)


@pytest.mark.parametrize("size", [(1600, 1000), (400, 900)])
def test_a_millimetre_is_as_long_across_as_up(size: tuple[int, int]) -> None:
    points, rapid = square()
    image = raster.path_picture(points, rapid, np.full(5, 99.0), 10.0, size)
    frame = raster.Frame.around(points, *size)
    inside = has(image, raster.BAD)
    inside = inside[inside[:, 0] < size[1] - raster.BOTTOM + 4]
    tall, wide = np.ptp(inside, axis=0)
    assert abs(tall - wide) <= 2
    assert wide == pytest.approx(40 * frame.scale, abs=6)


def test_pieces_have_the_colour_of_their_deviation() -> None:
    points, rapid = square()
    image = raster.path_picture(points, rapid, np.array([np.nan, 1.0, 7.0, 20.0, np.nan]), 10.0)
    pixels = raster.Frame.around(points, 1600, 1000).pixels((points[1:] + points[:-1]) / 2)
    colours = [raster.GOOD, raster.WARN, raster.BAD, raster.TODO]
    for (x, y), colour in zip(pixels.round().astype(int), colours, strict=True):
        # a thin line is blended with its background
        assert min(colours, key=lambda c: int(np.abs(image[y, x] - np.array(c)).sum())) == colour, (x, y)


def test_rapids_are_thin_and_never_coloured() -> None:
    points, _ = square()
    image = raster.path_picture(points, np.ones(5, bool), np.full(5, 99.0), 10.0)
    legend = image.shape[0] - raster.BOTTOM + 4
    assert not (has(image, raster.BAD)[:, 0] < legend).any()


def test_a_magnified_deviation_lies_on_its_side() -> None:
    points = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]])
    moved = raster.magnified(points, np.array([0.0, 0.01, np.nan]), 100.0)
    assert moved == pytest.approx(np.array([[0.0, 0.0], [10.0, 1.0], [10.0, 10.0]]))
    assert raster.magnification(np.array([np.nan, 3.0, -7.0]), 1.0) == 100.0
    assert raster.magnification(np.zeros(3), 1.0) == 1.0


def test_a_path_of_one_point_or_none_has_a_picture() -> None:
    for n in (0, 1):
        image = raster.path_picture(np.zeros((n, 2)), np.zeros(n, bool), np.zeros(n), 10.0, (300, 300))
        assert image.shape == (300, 300, 3)


def test_marks_are_round_and_within_the_frame() -> None:
    assert raster._marks(12.0, 10.0, 5.0) == [5.0, 10.0, 15.0, 20.0]
    assert raster._round_up(0.11) == pytest.approx(0.2)
    assert raster._round_down(499.0) == pytest.approx(200.0)


def test_pictures_are_written_as_png(tmp_path: Path) -> None:
    points, rapid = square()
    raster.write_png(tmp_path / "p.png", raster.path_picture(points, rapid, np.zeros(5), 10.0))
    assert (tmp_path / "p.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_opencv_is_loaded_only_for_drawing() -> None:
    code = "import sys, toolpaths.raster; sys.exit('cv2' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
