"""Material removal against closed forms: slots, scallops, bull noses, ramps, and an independent dense stamping."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from cnc_front._native.toolpaths import Chords
from toolpaths.material import Fixture, Grid, Removal, Tool, Workshop, compare

FLAT = Tool(1, "flat", 3.0, 0.0)
BALL = Tool(1, "ball", 3.0, 3.0)
BULL = Tool(1, "bull", 3.0, 1.0)


def cut(tool: Tool, points: list[tuple[float, float, float]], step: float = 0.1, rapid: bool = False) -> Removal:
    """A blank of 40 x 30 x 10, its upper face at 0, cut along a polyline."""
    grid = Grid.over((0, 0), (40, 30), step)
    removal = Removal(Workshop({1: tool}, 1, grid, grid.flat(0.0), -10.0, resolution=step))
    rows = np.array(points, dtype=np.float64)
    n = len(rows)
    lines, rapids, tools = np.full(n, 7, np.uint32), np.full(n, rapid), np.ones(n, np.int64)
    removal.feed(rows, lines, rapids, tools, 0)
    removal.finish()
    return removal


def heights(removal: Removal) -> NDArray[np.float64]:
    assert removal.stock is not None
    return removal.stock.z()


def test_a_slot_of_a_flat_tool_has_exact_area_and_depth() -> None:
    removal = cut(FLAT, [(-10, 15, -2), (50, 15, -2)])
    z = heights(removal)
    assert set(np.unique(z)) == {-2.0, 0.0}
    assert np.count_nonzero(z < 0) * 0.01 == pytest.approx(40 * 6, abs=1e-9)
    assert removal.volume == pytest.approx(40 * 6 * 2, abs=1e-9)


def test_a_plunge_of_a_flat_tool_is_its_circle() -> None:
    z = heights(cut(FLAT, [(20, 15, 5), (20, 15, -3)], 0.02))
    # bound of the grid: half a cell along the rim
    assert np.count_nonzero(z == -3.0) * 0.0004 == pytest.approx(math.pi * 9, abs=2 * math.pi * 3 * 0.01)


@pytest.mark.parametrize("stepover", [0.4, 0.8, 1.6])
def test_scallops_of_a_ball_have_the_height_of_the_closed_form(stepover: float) -> None:
    points = []
    for k in range(round(20 / stepover)):
        y = 5 + k * stepover
        points += [(-10.0, y, -4.0), (50.0, y, -4.0), (50.0, y, 5.0), (-10.0, y, 5.0)]
    step = 0.05
    z = heights(cut(BALL, points, step))
    inside = z[round(8 / step) : round(20 / step), round(10 / step) : round(30 / step)]
    scallop = 3 - math.sqrt(9 - (stepover / 2) ** 2)
    # the nodes lie up to half a cell beside the ridge, where the ball is as steep as there
    slope = (stepover / 2) / math.sqrt(9 - (stepover / 2) ** 2)
    assert scallop - slope * step / 2 - 1e-9 <= inside.max() + 4.0 <= scallop + 1e-9
    assert inside.min() + 4.0 <= 3 - math.sqrt(9 - (step / 2) ** 2) + 1e-9


def test_a_bull_nose_leaves_its_corner_radius() -> None:
    z = heights(cut(BULL, [(-10, 15, -4), (50, 15, -4)]))[:, 200]
    y = (np.arange(len(z)) + 0.5) * 0.1
    over = np.clip(np.abs(y - 15) - 2.0, 0, None)
    expected = np.where(np.abs(y - 15) < 3.0, -4 + 1 - np.sqrt(np.clip(1 - over**2, 0, None)), 0.0)
    assert np.abs(z - expected).max() < 1e-9


@pytest.mark.parametrize("tool", [FLAT, BALL, BULL], ids=["flat", "ball", "bull"])
@pytest.mark.parametrize("end", [(25.0, 18.0, -6.0), (31.0, 12.0, -0.5), (13.0, 9.5, -2.00003)])
def test_a_slanting_move_is_what_dense_stamping_leaves(tool: Tool, end: tuple[float, float, float]) -> None:
    start = (12.0, 9.0, -2.0)
    swept = heights(cut(tool, [start, end], 0.25))
    grid = Grid.over((0, 0), (40, 30), 0.25)
    x, y = np.meshgrid((np.arange(grid.nx) + 0.5) * 0.25, (np.arange(grid.ny) + 0.5) * 0.25)
    stamped = np.zeros_like(swept)
    for t in np.linspace(0, 1, 4001):
        px, py, pz = (a + t * (b - a) for a, b in zip(start, end, strict=True))
        r = np.hypot(x - px, y - py)
        over = np.clip(r - (tool.radius - tool.corner), 0, tool.corner)
        z = pz + tool.corner - np.sqrt(tool.corner**2 - over**2)
        stamped = np.where(r < tool.radius - 1e-9, np.minimum(stamped, z), stamped)
    # stamping leaves ridges: it is never lower, and higher by its step at most but at the steep rim of the tool
    assert (swept <= stamped + 1.01e-4).all()
    far = np.abs(swept - stamped) > 0.004
    assert np.count_nonzero(far) <= 12, "only nodes at the rim, which a stamp may just miss"


def test_the_map_is_symmetric_where_the_path_is() -> None:
    points = [(5.0, 15.0, -1.0), (20.0, 25.0, -3.0), (35.0, 15.0, -1.0)]
    for tool in (FLAT, BALL, BULL):
        z = heights(cut(tool, points))
        assert np.abs(z - z[:, ::-1]).max() < 1e-9


def test_nothing_is_cut_below_the_blank() -> None:
    removal = cut(FLAT, [(-10, 15, -14), (50, 15, -14)])
    assert heights(removal).min() == -10.0
    assert removal.volume == pytest.approx(40 * 6 * 10, abs=1e-6)


def test_a_pass_twice_cuts_once() -> None:
    once, twice = cut(BALL, [(0, 15, -2), (40, 15, -2)]), cut(BALL, [(0, 15, -2), (40, 15, -2), (0, 15, -2)])
    assert np.abs(heights(once) - heights(twice)).max() < 1e-12


def against_a_plane(z_mm: float, target_mm: float) -> tuple[dict[str, object], dict[str, object]]:
    removal = cut(FLAT, [(-10, 15, z_mm), (50, 15, z_mm)])
    grid = Grid.over((0, 0), (40, 30), 0.1)
    target = grid.flat(target_mm)
    target[:100], target[200:] = -np.inf, -np.inf  # only 10 <= y < 20 has a target
    assert removal.stock is not None
    compared = compare(removal.stock.z(), target, grid)
    lines = removal.stock.line()
    return compared.side(1, 0.01, lines), compared.side(-1, 0.01, lines)


def test_a_z_wrong_by_20_um_is_a_gouge_of_20_um() -> None:
    rest, gouge = against_a_plane(-2.02, -2.0)
    assert gouge["max_mm"] == pytest.approx(0.020, abs=1e-9)
    assert gouge["line"] == 7
    assert gouge["area_mm2"] == pytest.approx(40 * 6, abs=1e-9)
    assert gouge["volume_mm3"] == pytest.approx(40 * 6 * 0.02, abs=1e-9)
    assert rest["max_mm"] == pytest.approx(2.0, abs=1e-9), "beside the slot the blank still stands"


def test_a_z_too_high_is_rest() -> None:
    rest, gouge = against_a_plane(-1.985, -2.0)
    assert gouge["max_mm"] == 0.0 and gouge["place"] is None and gouge["line"] is None
    assert rest["max_mm"] == pytest.approx(2.0)


def test_walls_hide_less_than_a_cell_and_show_more() -> None:
    grid = Grid.over((0, 0), (10, 10), 0.1)
    target = grid.flat(-5.0)
    target[:, 50:] = 0.0  # a wall at x = 5

    def gouge_of(wall: int) -> float:
        cut_to = grid.flat(-5.0)
        cut_to[:, wall:] = 0.0
        return float(np.nanmax(-compare(cut_to, target, grid).difference))

    assert gouge_of(50) == 0.0 and gouge_of(51) == 0.0
    assert gouge_of(52) == 5.0


def test_an_inner_corner_keeps_what_a_round_tool_cannot_reach() -> None:
    grid = Grid.over((0, 0), (40, 30), 0.05)
    corners = [(8.0, 8.0), (32.0, 8.0), (32.0, 22.0), (8.0, 22.0)]
    path = [(x + (3 if x < 20 else -3), y + (3 if y < 15 else -3), -2.0) for x, y in corners]
    spiral = [(20.0, 15.0, -2.0), *path, path[0]]
    spiral += [(12.0 + 1.0 * k, 11.0 if k % 2 else 19.0, -2.0) for k in range(18)]
    removal = cut(FLAT, spiral, 0.05)
    target = grid.flat(0.0)
    target[round(8 / 0.05) : round(22 / 0.05), round(8 / 0.05) : round(32 / 0.05)] = -2.0
    assert removal.stock is not None
    compared = compare(removal.stock.z(), target, grid)
    rest, gouge = (compared.side(sign, 0.01, removal.stock.line()) for sign in (1, -1))
    assert gouge["max_mm"] == 0.0
    # four corners of r^2 (1 - pi / 4), less the cell beside the walls
    exact, border = 4 * 9 * (1 - math.pi / 4), 4 * 2 * 3.0 * 0.05
    assert exact - border - 0.1 <= rest["area_mm2"] <= exact + 0.1
    assert rest["max_mm"] == pytest.approx(2.0)


# ---- what meets what


def test_a_rapid_through_material_is_found_with_its_depth() -> None:
    removal = cut(FLAT, [(-10, 15, -2), (50, 15, -2)], rapid=True)
    (found,) = removal.findings
    assert (found.kind, found.body, found.line, found.tool) == ("rapid_stock", "stock", 7, 1)
    assert found.size == pytest.approx(2.0 - 0.05, abs=1e-9), "the tool counts as smaller by the margin"


def test_a_rapid_out_of_the_own_slot_meets_nothing() -> None:
    grid = Grid.over((0, 0), (40, 30), 0.1)
    removal = Removal(Workshop({1: FLAT}, 1, grid, grid.flat(0.0), -10.0))
    points = np.array([(-10, 15, -2), (20, 15, -2), (20.003, 15.002, -2.001), (20.001, 15, 9)], dtype=np.float64)
    lines = np.array([1, 1, 2, 2], np.uint32)
    removal.feed(points, lines, np.array([False, False, True, True]), np.ones(4, np.int64), 0)
    removal.finish()
    assert not removal.findings


@pytest.mark.parametrize(("z", "size"), [(-14.0, 4.0), (-9.9, None)])
def test_the_holder_touches_the_blank_when_the_tool_is_short(z: float, size: float | None) -> None:
    holder = Tool(1, "flat", 3.0, 0.0, bodies=((8.0, 10.0),))
    removal = cut(holder, [(20, 15, 5), (20, 15, z)])
    kinds = {f.kind: f.size for f in removal.findings}
    assert kinds == ({} if size is None else {"holder_stock": pytest.approx(size)})


def test_deeper_than_the_flutes() -> None:
    tool = Tool(1, "flat", 3.0, 0.0, flute=1.5)
    removal = cut(tool, [(-10, 15, -2), (50, 15, -2)])
    assert {f.kind: f.size for f in removal.findings} == {"flutes_stock": pytest.approx(0.5)}


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> NDArray[np.float64]:
    import trimesh

    return np.asarray(trimesh.creation.box(bounds=[low, high]).triangles, dtype=np.float64)


@pytest.mark.parametrize("clearance", [0.0, 1.0])
def test_a_fixture_is_met_from_its_border_on(clearance: float) -> None:
    clamp = Fixture("clamp", box((20, 10, -10), (25, 20, 3)), clearance)
    step = 0.2

    def met(x: float) -> list[float]:
        shop = Workshop({1: FLAT}, 1, fixtures=(clamp,), resolution=step)
        removal = Removal(shop)
        rows = np.array([(x, 0, 1), (x, 30, 1)], dtype=np.float64)
        removal.feed(rows, np.full(2, 3, np.uint32), np.zeros(2, bool), np.ones(2, np.int64), 0)
        removal.finish()
        return [f.size for f in removal.findings]

    border = 20 - 3.0 - clearance
    assert met(border + 0.01) == [pytest.approx(2.0)], "never missed"
    assert met(border - step * (math.sqrt(0.5) + 1)) == [], "no farther off than a cell and a half"


def test_a_wall_thinner_than_a_cell_is_not_missed() -> None:
    fin = Fixture("fin", box((20.01, 10, -10), (20.02, 20, 3)))
    shop = Workshop({1: Tool(1, "ball", 0.5, 0.5)}, 1, fixtures=(fin,), resolution=1.0)
    removal = Removal(shop)
    removal.feed(
        np.array([(0, 15, 1), (40, 15, 1)], dtype=np.float64),
        np.full(2, 3, np.uint32),
        np.zeros(2, bool),
        np.ones(2, np.int64),
        0,
    )
    removal.finish()
    assert [f.kind for f in removal.findings] == ["tool_fixture"]


# ---- chords


def test_chords_stay_within_their_tolerance_in_any_chunks() -> None:
    rng = np.random.default_rng(3)
    t = np.linspace(0, 20, 5000)
    points = np.column_stack([10 * np.cos(t), 10 * np.sin(t), 0.1 * t]) + rng.normal(0, 1e-4, (5000, 3))
    tags = (t > 7).astype(np.uint64)
    whole = Chords(0.002)
    rows = [whole.feed(points, tags, 0), whole.finish()]
    moves, kinds, samples = (np.concatenate(part) for part in zip(*rows, strict=True))
    pieces = Chords(0.002)
    parts = [pieces.feed(points[a : a + 37], tags[a : a + 37], a) for a in range(0, 5000, 37)] + [pieces.finish()]
    assert all(
        (np.concatenate(part) == one).all()
        for part, one in zip(zip(*parts, strict=True), (moves, kinds, samples), strict=True)
    )
    assert len(moves) < 900
    assert (moves[1:, :3] == moves[:-1, 3:]).all(), "no gap"
    owner = np.searchsorted(samples, np.arange(5000), side="right") - 1
    start, along = moves[owner, :3], moves[owner, 3:] - moves[owner, :3]
    part_of = np.clip(np.einsum("ij,ij->i", points - start, along) / np.einsum("ij,ij->i", along, along), 0, 1)
    off = np.linalg.norm(points - start - part_of[:, None] * along, axis=1)
    assert off.max() <= 0.002
