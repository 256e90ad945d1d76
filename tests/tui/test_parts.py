"""The parts of the screen by themselves: raster, program view, rows; and how fast they are."""

from __future__ import annotations

import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.style import Style
from textual.strip import Strip

from tests.tui.fake import make_job
from tui.look import GLYPHS, THEMES, choose_look, make_look
from tui.plot import PathPicture
from tui.program import ProgramView, block_name, find_block
from tui.raster import PARTS, Window, cells, draw, fit
from tui.rows import Row, changed_span
from tui.words import TEXTS, Words

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("glyphs", GLYPHS)
def test_millimetres_are_square(glyphs: str) -> None:
    window = Window(0.0, 0.0, 1.0, 80, 24, glyphs)
    across, down = PARTS[glyphs]
    (x0, y0), (x1, y1) = window.pixels(np.array([[0.0, 0.0], [10.0, -10.0]]))
    assert (x1 - x0) / across == pytest.approx(10) and (y1 - y0) / down == pytest.approx(5)  # a cell is 1:2


@pytest.mark.parametrize("glyphs", GLYPHS)
def test_the_whole_path_fits(glyphs: str) -> None:
    points = make_job().plot.points[:, :2]
    window = fit(points, 50, 20, glyphs)
    pixels, (height, width) = window.pixels(points), window.shape
    assert (pixels >= 0).all() and (pixels[:, 0] < width).all() and (pixels[:, 1] < height).all()


coordinate = st.floats(-200, 200, allow_nan=False)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(st.tuples(coordinate, coordinate), min_size=2, max_size=12))
def test_a_drawn_line_is_the_line(places: list[tuple[float, float]]) -> None:
    """Every drawn part is near the polyline, and every place of the polyline in the bitmap is near a drawn part."""
    points = np.array(places)
    bitmap = np.zeros((40, 60), np.uint8)
    draw(bitmap, points, 0, len(points), np.ones(len(points), np.uint8))
    share = np.linspace(0, 1, 2000)[:, None]
    along = np.vstack([a + (b - a) * share for a, b in pairwise(points)])
    inside = along[((along > 1) & (along < np.array([59.0, 39.0]))).all(axis=1)]
    lit = np.argwhere(bitmap)[:, ::-1] + 0.5
    if len(inside):
        gaps = np.abs(inside[::7, None, :] - lit[None, :, :]).max(axis=2).min(axis=1)
        assert gaps.max() <= 1.51
    for spot in lit:
        assert np.abs(along - spot).max(axis=1).min() <= 1.51


def test_the_worst_class_in_a_cell_wins() -> None:
    bitmap = np.zeros((2, 2), np.uint8)
    bitmap[0, 0], bitmap[1, 1] = 1, 4
    assert cells(bitmap, "quadrant", " .-*#") == (["▚"], np.array([[4]]))
    texts, classes = cells(np.array([[0, 1, 2, 3, 4]], np.uint8), "ascii", " .-*#")
    assert texts == [" .-*#"] and classes.tolist() == [[0, 1, 2, 3, 4]]


def test_what_is_driven_bit_by_bit_looks_as_if_drawn_at_once() -> None:
    job, look = make_job(), make_look("dark", "braille")
    values = np.linspace(0, 0.02, 401).astype(np.float32)
    at_once, by_bits = PathPicture(look), PathPicture(look)
    for picture in (at_once, by_bits):
        picture.take(job)
    at_once.driven(401, values)
    for start in range(0, 401, 37):
        by_bits.rows(60, 20, None, 0)
        by_bits.driven(min(start + 37, 401), values[start : start + 37])
    assert by_bits.rows(60, 20, None, 0) == at_once.rows(60, 20, None, 0)
    assert by_bits.over == at_once.over and set(by_bits.over) == {9}
    by_bits.driven(0, values[:0])
    assert by_bits.reached == 0 and not by_bits.over


def seconds(work: object, times: int = 3) -> float:
    best = float("inf")
    for _ in range(times):
        began = time.perf_counter()
        work()  # type: ignore[operator]
        best = min(best, time.perf_counter() - began)
    return best


def test_a_hundred_thousand_points_are_drawn_quickly() -> None:
    job = make_job(points=100_000)
    picture = PathPicture(make_look("dark", "quadrant"))
    picture.take(job)

    def whole() -> None:
        picture.fit_all()
        picture.rows(63, 35, (0.0, 0.0, 0.0), 0)

    assert seconds(whole) < 0.3  # 20 ms on an idle machine
    picture.driven(50_000, np.zeros(50_000, np.float32))
    assert seconds(lambda: picture.rows(63, 35, (0.0, 0.0, 0.0), 0)) < 0.05  # 2 ms
    # the mark of a chosen block is looked for once, not at every frame
    assert seconds(lambda: picture.rows(63, 35, (0.0, 0.0, 0.0), 9)) < 0.05  # 2 ms


def test_a_million_lines_cost_no_more_than_a_page() -> None:
    view = ProgramView(make_look("dark", "ascii"))
    view.take([f"N{n} G1 X{n % 100}" for n in range(1, 1_000_001)])

    def page() -> None:
        view.choose(987_654)
        view.rows(56, 25, 1, {})
        view.choose(5)
        view.rows(56, 25, 1, {})

    assert seconds(page) < 0.05  # 0.5 ms
    assert find_block(view.lines, "n999999") == 999_999


def test_names_of_blocks() -> None:
    lines = ["%", "N10 G0", "/N20 G1", "/2 n30", "X5", ""]
    assert [block_name(lines, n) for n in range(1, 8)] == ["L1", "N10", "N20", "N30", "L5", "L6", "L7"]
    assert [find_block(lines, t) for t in ("N20", "n30", "5", "0", "99", "N", "x", "", "N" + "9" * 30)] == [
        3, 4, 5, None, None, None, None, None, None,
    ]  # fmt: skip


def test_the_program_flips_pages_and_keeps_the_current_block_in_sight() -> None:
    view = ProgramView(make_look("mono", "ascii"))
    view.take([f"N{n}" for n in range(1, 101)])
    tops = []
    for current in range(1, 101):
        rows = view.rows(20, 10, current, {})
        assert any(row.text.startswith(f">N{current} ") for row in rows)
        tops.append(view.top)
    assert len(set(tops)) < 20


def test_control_characters_never_reach_the_terminal() -> None:
    strip = Row(Style()).add("a\x1b[2Jb\tc\x07\x9b").strip(20)
    assert strip.text == "a·[2Jb c··".ljust(20)


def test_only_what_differs_is_drawn() -> None:
    style = Style(bold=True)
    old = Row(style).add("X  ").add("+1.00").add("  rest").strip(20)
    new = Row(style).add("X  ").add("+2.00").add("  rest").strip(20)
    assert changed_span(old, old) is None and changed_span(old, new) == (3, 8)


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("glyphs", GLYPHS)
def test_every_segment_has_a_style(theme: str, glyphs: str) -> None:
    picture = PathPicture(make_look(theme, glyphs))
    picture.take(make_job())
    rows: list[Strip] = picture.rows(40, 12, (0.0, 0.0, 0.0), 5)
    assert all(segment.style is not None for row in rows for segment in row)


def test_the_environment_chooses_colours_and_glyphs() -> None:
    def chosen(**environment: str) -> tuple[str, str]:
        look = choose_look(None, None, environment)
        return look.name, look.glyphs

    assert chosen(TERM="xterm-256color") == ("dark", "quadrant")
    assert chosen(TERM="linux") == ("ansi", "ascii")
    assert chosen(TERM="dumb") == ("mono", "ascii")
    assert chosen(TERM="xterm", NO_COLOR="1") == ("mono", "quadrant")
    assert choose_look("light", "braille", {"TERM": "dumb", "NO_COLOR": "1"}).name == "light"


def contrast(one: str, other: str) -> float:
    """WCAG 2 contrast ratio of two #rrggbb colours."""

    def light(colour: str) -> float:
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        r, g, b = (p / 12.92 if p <= 0.03928 else ((p + 0.055) / 1.055) ** 2.4 for p in parts)
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    high, low = sorted((light(one), light(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_contrast(theme: str) -> None:
    for name, style in THEMES[theme].items():
        assert contrast(style.color.name, style.bgcolor.name) >= 4.5, name


def test_both_languages_know_the_same_facts() -> None:
    import string

    for id, texts in TEXTS.items():
        english, german = ({field for _, field, _, _ in string.Formatter().parse(text) if field} for text in texts)
        assert english == german, id
        assert all(texts), id
    assert Words("de")("to_go") == "RESTWEG"


def test_importing_tui_loads_nothing_heavy() -> None:
    code = "import tui, sys; print(*sorted({name.split('.')[0] for name in sys.modules}))"
    light = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert not {"cv2", "scipy", "matplotlib", "numpy", "textual"} & set(light.stdout.split())
    code = code.replace("import tui,", "import tui.app,")
    whole = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert not {"cv2", "scipy", "matplotlib", "jinja2", "mcap"} & set(whole.stdout.split())
