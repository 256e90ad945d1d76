"""References from drawings: known errors come back with their size, in the right line; what was not driven is named."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from tests.app.conftest import Cli
from tests.geometry.programs import circle_dxf, square_dxf
from toolpaths.drawing import ARC, SEGMENT, Drawing, contour, surface
from toolpaths.meshes import GeometryError
from toolpaths.reference import Offset, ReferenceMeter

Points = NDArray[np.float64]
NONE = Offset()


def circle(radius: float) -> Drawing:
    data = np.zeros((1, 9))
    data[0, 2], data[0, 4] = radius, 2 * math.pi
    return Drawing(np.array([ARC], np.uint8), data)


def measured(
    drawing: Drawing, points: Points, offset: Offset = NONE, capture: float = 0.5, chunk: int = 10**9
) -> dict[str, Any]:
    meter = ReferenceMeter(drawing, offset, capture)
    n = len(points)
    lines, cutting, entries = np.arange(n) // 100 + 1, np.ones(n, bool), np.arange(n) // 100 + 1
    for a in range(0, n, chunk):
        b = a + chunk
        meter.feed(points[a:b], cutting[a:b], lines[a:b], entries[a:b], a)
    return meter.finish()


def around(radius: float, n: int = 2001, turns: float = 1.0) -> Points:
    angle = np.linspace(0, 2 * math.pi * turns, n)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(n, -1.0)])


def test_a_circle_of_another_radius_is_off_by_the_difference() -> None:
    figures = measured(circle(10.0), around(10.02))
    assert figures["max_mm"] == pytest.approx(0.02, abs=1e-12)
    assert figures["rms_mm"] == pytest.approx(0.02, abs=1e-9)
    assert figures["p99_mm"] == pytest.approx(0.02, rel=1e-3)
    assert figures["minus_mm"] == pytest.approx(0.02, abs=1e-12), "counter-clockwise and outside: right of the drawing"
    assert figures["plus_mm"] == 0.0
    assert figures["missing_mm"] == 0.0 and figures["extra_mm"] == 0.0
    assert figures["driven_mm"] == pytest.approx(2 * math.pi * 10.02, rel=1e-5)


@pytest.mark.parametrize(
    ("side", "turns", "wrong"), [("right", 1.0, 0.0), ("left", 1.0, 62.8 + 18.8), ("left", -1.0, 0.0)]
)
def test_the_tool_runs_beside_the_drawing_on_one_side(side: str, turns: float, wrong: float) -> None:
    figures = measured(circle(10.0), around(12.995, turns=turns), Offset(side, 3.0))
    assert figures["max_mm"] == pytest.approx(0.005, abs=1e-12)
    assert figures["minus_mm"] == pytest.approx(0.005, abs=1e-12), "5 um too deep"
    assert figures["wrong_side_mm"] == pytest.approx(wrong, abs=0.2)
    assert figures["missing_mm"] == 0.0


def test_what_was_not_driven_is_missing_and_has_a_place() -> None:
    figures = measured(circle(10.0), around(10.0, turns=0.75), capture=0.1)
    # the capture reaches a little round the ends
    assert figures["missing_mm"] == pytest.approx(2 * math.pi * 10 / 4 - 0.2, abs=0.05)
    assert figures["missing_pct"] == pytest.approx(25, abs=0.5)
    (stretch,) = figures["missing"]
    assert stretch["from"] == pytest.approx([0, -10], abs=0.15) and stretch["to"] == pytest.approx([10, 0], abs=0.15)


def test_lead_ins_are_extra_and_no_deviation() -> None:
    way_in = np.column_stack([np.linspace(20, 10, 100), np.zeros(100), np.zeros(100)])
    figures = measured(circle(10.0), np.vstack([way_in, around(10.0)]))
    assert figures["max_mm"] < 1e-6
    assert figures["extra_mm"] == pytest.approx(10.0 * 99 / 99, abs=0.2)
    assert figures["extra"][0]["line"] == 1


def test_chunks_of_any_size_give_the_same_figures() -> None:
    rng = np.random.default_rng(1)
    points = around(10.0, 5000, 2.0) + rng.normal(0, 0.003, (5000, 3))
    whole = measured(circle(10.0), points)
    for chunk in (1, 37, 100, 1024):
        assert measured(circle(10.0), points, chunk=chunk) == whole


def test_distances_are_those_of_all_pieces_one_by_one() -> None:
    rng = np.random.default_rng(2)
    corners = rng.uniform(-20, 20, (60, 2))
    segments = np.zeros((59, 2, 3))
    segments[:, 0, :2], segments[:, 1, :2] = corners[:-1], corners[1:]
    points = np.column_stack([rng.uniform(-25, 25, (3000, 2)), np.zeros(3000)])
    from cnc_front._native.toolpaths import Nearest

    drawing = contour(segments)
    distance, foot, shape, *_ = Nearest(drawing.kinds, drawing.data).find(points)
    a, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    t = np.clip(np.einsum("pkj,kj->pk", points[:, None] - a, along) / np.einsum("kj,kj->k", along, along), 0, 1)
    exact = np.linalg.norm(points[:, None] - a - t[..., None] * along, axis=2)
    assert np.abs(distance - exact.min(axis=1)).max() < 1e-12
    assert np.abs(np.linalg.norm(points - foot, axis=1) - distance).max() < 1e-12
    assert np.abs(exact[np.arange(3000), shape] - distance).max() < 1e-12


@pytest.mark.parametrize("step", [1e-4, 0.03, 2.0])
def test_a_search_that_is_left_out_changes_nothing(step: float) -> None:
    """Along a path the last answer is kept as long as no other piece can have come nearer."""
    from cnc_front._native.toolpaths import Nearest

    rng = np.random.default_rng(5)
    walk = np.cumsum(rng.normal(0, step, (4000, 3)) * (1, 1, 0), axis=0)
    segments = np.zeros((80, 2, 3))
    segments[..., :2] = rng.uniform(-1, 1, (80, 2, 2)) * max(1.0, 40 * step)
    drawing = contour(segments)
    nearest = Nearest(drawing.kinds, drawing.data)
    together = nearest.find(walk)[0]
    alone = np.array([nearest.find(walk[k : k + 1])[0][0] for k in range(4000)])
    assert (together == alone).all()


def test_a_ball_on_a_sphere_is_the_difference_of_the_radii() -> None:
    body = trimesh.creation.icosphere(subdivisions=5, radius=20.0)
    drawing = surface(np.asarray(body.triangles, dtype=np.float64))
    rng = np.random.default_rng(4)
    direction = rng.normal(size=(2000, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    tip = direction * (20 + 3 - 0.04) - (0, 0, 3.0)
    figures = measured(drawing, tip, Offset("ball", 3.0))
    facet = 20 - np.linalg.norm(np.asarray(body.triangles).mean(axis=1), axis=1).min()
    assert 0.04 - facet - 1e-9 <= figures["minus_mm"] <= 0.04 + 1e-9
    assert figures["plus_mm"] <= max(0.0, facet - 0.04) + 1e-9
    assert "missing_mm" not in figures


def test_inside_and_outside_of_a_surface_also_at_edges() -> None:
    from cnc_front._native.toolpaths import Nearest

    body = trimesh.creation.box(extents=(10, 10, 10))
    drawing = surface(np.asarray(body.triangles, dtype=np.float64))
    rng = np.random.default_rng(6)
    points = rng.uniform(-8, 8, (5000, 3))
    distance, *_, side = Nearest(drawing.kinds, drawing.data).find(points)
    inside = (np.abs(points) < 5).all(axis=1)
    assert ((side < 0) == inside)[distance > 1e-9].all()
    outside = np.linalg.norm(np.maximum(np.abs(points) - 5, 0), axis=1)
    exact = np.where(inside, (5 - np.abs(points)).min(axis=1), outside)
    assert np.abs(distance - exact).max() < 1e-12


def test_offsets_that_do_not_fit_are_refused() -> None:
    with pytest.raises(GeometryError):
        ReferenceMeter(circle(10.0), Offset("ball", 3.0), 0.5)
    body = surface(np.asarray(trimesh.creation.box().triangles, dtype=np.float64))
    with pytest.raises(GeometryError):
        ReferenceMeter(body, Offset("left", 3.0), 0.5)


# ---- through the command

SQUARE = """%1
N10 G90 G17 G71 G0 X-10 Y-5
N20 G1 X0 Y0 F600
N30 X20
N40 Y20
N50 X0
N60 Y0
N70 G0 X-10 Y-5
N80 M30
"""


@pytest.fixture
def square(tmp_path: Path) -> Path:
    (tmp_path / "square.nc").write_text(SQUARE)
    (tmp_path / "square.dxf").write_bytes(square_dxf(20.0))
    return tmp_path


def test_a_true_part_passes(cli: Cli, square: Path) -> None:
    ran = cli("run", str(square / "square.nc"), "--reference", str(square / "square.dxf"), "--json")
    reference = ran.object["reference"]
    assert ran.code == 0
    assert reference["kind"] == "contour" and reference["pieces"] == 4
    assert reference["setpoint"]["max_mm"] < 1e-9
    assert 0 < reference["actual"]["max_mm"] < 0.05
    assert reference["missing_mm"] == 0.0
    assert [row["line"] for row in reference["actual"]["extra"]] == [3], "the way in, at feed"


def test_a_block_shifted_by_20_um_is_found_in_its_line(cli: Cli, square: Path) -> None:
    (square / "off.nc").write_text(SQUARE.replace("N40 Y20", "N40 X20.02 Y20").replace("N30 X20", "N30 X20.02"))
    ran = cli(
        "run", str(square / "off.nc"), "--reference", str(square / "square.dxf"), "--json", "--tolerance", "0.015"
    )
    found = ran.object["reference"]["setpoint"]
    assert ran.code == 1
    assert found["max_mm"] == pytest.approx(0.02, rel=0.02)
    assert found["worst"]["line"] in (5, 6)
    assert ran.object["deviation"]["setpoint"]["max_mm"] < 1e-9, "true to the program, which is wrong"
    assert {reason["id"] for reason in ran.object["verdict"]["reasons"]} >= {"reference"}


def test_a_part_at_another_place_is_never_fitted(cli: Cli, square: Path) -> None:
    job, drawing = str(square / "square.nc"), str(square / "square.dxf")
    away = cli("run", job, "--reference", drawing, "--reference-at", "100,0", "--json")
    assert away.code == 1
    assert {reason["id"] for reason in away.object["verdict"]["reasons"]} == {"reference_missing", "reference_far"}
    assert away.object["reference"]["missing_pct"] == pytest.approx(100)
    inches = cli("run", job, "--reference", drawing, "--reference-unit", "inch", "--json")
    assert inches.code == 1


def test_a_missing_side_fails(cli: Cli, square: Path) -> None:
    (square / "short.nc").write_text(SQUARE.replace("N60 Y0\n", ""))
    ran = cli("run", str(square / "short.nc"), "--reference", str(square / "square.dxf"))
    assert ran.code == 1
    assert "of the drawing" in ran.out


@pytest.mark.parametrize(
    ("arguments", "id"),
    [
        (["nothing.dxf"], "RF100"),
        (["square.nc"], "RF101"),
        (["square.dxf", "--reference-z", "1"], "RF102"),
        (["square.dxf", "--reference-offset", "ball:3"], "RF103"),
        (["square.dxf", "--reference-layer", "NONE"], "RF104"),
        (["empty.stl"], "RF104"),
    ],
)
def test_drawings_that_cannot_be_used(cli: Cli, square: Path, arguments: list[str], id: str) -> None:
    (square / "empty.stl").write_text("solid x\nendsolid x\n")
    ran = cli("run", str(square / "square.nc"), "--json", "--reference", str(square / arguments[0]), *arguments[1:])
    assert ran.code == 2
    assert ran.object["error"]["id"] == id
    assert f":1:1: {id}: " in ran.no_traceback().err


@pytest.mark.parametrize(
    "arguments",
    [
        ["--reference-at", "1,2"],
        ["--reference", "x.dxf", "--reference-at", "1"],
        ["--reference", "x.dxf", "--reference-offset", "left"],
        ["--reference", "x.dxf", "--reference-offset", "left:-1"],
        ["--reference", "x.dxf", "--reference-offset", "none:1"],
        ["--reference", "x.dxf", "--reference-capture", "0"],
        ["--reference", "x.dxf", "--reference-z", "nan"],
    ],
)
def test_wrong_usage(cli: Cli, square: Path, arguments: list[str]) -> None:
    ran = cli("run", str(square / "square.nc"), *arguments)
    assert ran.code == 2
    assert len(ran.no_traceback().err.splitlines()) == 1


def test_a_circle_with_tool_radius_against_its_dxf(cli: Cli, tmp_path: Path) -> None:
    (tmp_path / "c.nc").write_text("%1\nG90 G17 G71 G0 X-13 Y0\nG2 X-13 Y0 I13 J0 F600\nM30\n")
    (tmp_path / "c.dxf").write_bytes(circle_dxf(10.0))
    arguments = ["run", str(tmp_path / "c.nc"), "--reference", str(tmp_path / "c.dxf"), "--json", "--reference-offset"]
    right_way = cli(*arguments, "left:3")
    assert right_way.code == 0
    assert right_way.object["reference"]["setpoint"]["max_mm"] < 1e-9
    wrong_way = cli(*arguments, "right:3")
    assert wrong_way.code == 1
    assert "reference_side" in {reason["id"] for reason in wrong_way.object["verdict"]["reasons"]}


def test_segments_have_their_kind() -> None:
    assert contour(np.zeros((1, 2, 3))).kinds.tolist() == [SEGMENT]
