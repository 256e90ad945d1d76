"""The side from which the path is shown: chosen by where the program goes, changed by a key, the same in each plane."""

from __future__ import annotations

import numpy as np
import pytest

from cnc_front.engine import PathPlot
from cnc_front.jobs import CompileOptions, JobSource, load_machine
from cnc_front.sim_job import load_source
from tests.app.conftest import ROOT
from tests.tui.fake import FakeEngine
from tests.tui.stage import Stage, play
from tui.plane import ISOMETRIC, planes_of

CUBE = np.array([[0, 0, 0], [10, 0, 0], [10, 20, 0], [0, 20, 5.0]])


def shown(points: np.ndarray, axes: tuple[str, str, str] = ("X", "Y", "Z"), plane: str = "G17") -> list[str]:
    plot = PathPlot(points, np.ones(len(points), np.uint32), np.zeros(len(points), bool), axes, plane)
    return [p.name for p in planes_of(plot, points)]


@pytest.mark.parametrize(
    ("moves", "axes", "plane", "names"),
    [
        ((1, 1, 1), ("X", "Y", "Z"), "G17", ["XY", "XZ", "YZ", "ISO"]),
        ((1, 1, 1), ("X", "Y", "Z"), "G18", ["XY", "XZ", "YZ", "ISO"]),
        ((1, 0, 1), ("X", "Y", "Z"), "G17", ["XZ", "XY", "YZ", "ISO"]),
        ((1, 0, 1), ("X", "Y", "Z"), "G18", ["ZX", "XY", "YZ", "ISO"]),
        ((0, 1, 1), ("X", "Y", "Z"), "G19", ["YZ", "XY", "XZ", "ISO"]),
        ((0, 0, 1), ("X", "Y", "Z"), "G17", ["XY", "XZ", "YZ", "ISO"]),
        ((1, 0, 1), ("X", "Z", ""), "G18", ["ZX"]),
        ((1, 0, 1), ("X", "Z", ""), "G17", ["ZX"]),
        ((1, 1, 0), ("X", "Y", ""), "G17", ["XY"]),
        ((1, 0, 0), ("U", "", ""), "G17", ["U"]),
    ],
)
def test_the_first_plane_follows_from_the_path(
    moves: tuple[int, ...], axes: tuple[str, str, str], plane: str, names: list[str]
) -> None:
    assert shown(CUBE * moves, axes, plane) == names


def test_a_lathe_has_z_to_the_right_and_x_up() -> None:
    plot = PathPlot(CUBE, np.ones(4, np.uint32), np.zeros(4, bool), ("X", "Z", ""), "G18")
    (plane,) = planes_of(plot, CUBE)
    assert plane.project(np.array([[3.0, 7.0, 0.0]])).tolist() == [[7.0, 3.0]]


def test_the_isometric_view_is_from_the_right_in_front_and_above() -> None:
    right, up = ISOMETRIC.project(np.eye(3)).T
    assert right == pytest.approx([0.5**0.5, 0.5**0.5, 0])
    assert up[0] < 0 < up[1] < up[2] and np.linalg.norm(ISOMETRIC.project(np.eye(3)), axis=1) == pytest.approx(
        [(2 / 3) ** 0.5] * 3
    )


def test_rotary_axes_are_not_drawn_in_millimetres() -> None:
    machine = load_machine(str(ROOT / "examples/machines/mill4a.toml"))
    loaded = load_source(JobSource("a.nc", b"G1 X10 Y5 A90 F500\n", "din66025"), machine, CompileOptions(), None)
    assert loaded.view.plot.axes == ("X", "Y", "Z") and "A" in machine.machine.axis_names


def test_a_program_in_g18_is_told_from_one_in_g17() -> None:
    machine = load_machine(None)
    for word in ("G17", "G18"):
        text = f"{word} G1 X10 Z5 F500\nG1 X20 Z-5\n".encode()
        plot = load_source(JobSource("a.nc", text, "din66025"), machine, CompileOptions(), None).view.plot
        assert planes_of(plot, plot.points)[0].name == {"G17": "XZ", "G18": "ZX"}[word]


@pytest.mark.parametrize("size", [(80, 24), (120, 40)])
def test_the_key_goes_round_and_every_plane_has_colours_mark_and_tool(size: tuple[int, int]) -> None:
    async def script(stage: Stage) -> None:
        stage.engine.job.plot.points[:, 2] = np.linspace(-10, 30, len(stage.engine.job.plot.points))
        await stage.load()
        stage.engine.run_half()
        stage.app.program.choose(5)
        seen = []
        for _ in range(5):
            text = await stage.frame()
            seen.append(stage.app.picture.plane)
            assert f" {seen[-1]} " in text
            strips = stage.app.screen._compositor.render_strips()
            colours = {s.style.color.name for strip in strips for s in strip if s.style and s.style.color}
            assert {"#56b4e9", "#f0e442", "#ff6a13", "#7a8793"} <= colours
            look, top = stage.app.look, stage.app.page.areas.picture
            cells = [segment for strip in strips[top.y + 1 : top.bottom + 1] for segment in strip]
            assert any(s.style == look.inverse for s in cells) and any(s.text == "@" for s in cells)
            await stage.press("0", "shift+left", "s")
        assert seen == ["XY", "XZ", "YZ", "ISO", "XY"]

    play(script, FakeEngine(), size=size)


def test_the_chosen_side_stays_when_the_job_is_loaded_again() -> None:
    async def script(stage: Stage) -> None:
        await stage.load()
        await stage.press("s")
        await stage.load()
        assert stage.app.picture.plane == "XZ"

    play(script)


def test_a_click_chooses_the_block_in_any_plane() -> None:
    async def script(stage: Stage) -> None:
        points = stage.engine.job.plot.points
        points[:, 2] = np.linspace(0, 40, len(points))
        await stage.load()
        await stage.press("s", "s")
        picture, window = stage.app.picture, stage.app.picture._window
        assert picture.plane == "YZ" and window is not None
        y, z = points[20, 1], points[20, 2]
        column = (y - window.x_mm) / window.mm_per_column + window.columns / 2 - 0.5
        row = (window.y_mm - z) / window.mm_per_column / 2 + window.rows / 2 - 0.5
        assert picture.line_at(round(column), round(row)) == 5

    play(script)
