"""The cell of examples/cell: four CNC tasks and a PC, with an emergency stop in the middle of a part."""

from __future__ import annotations

import importlib.util
import re
import sys
from functools import cache
from pathlib import Path
from typing import Any

import pytest

EXAMPLE = Path(__file__).parents[2] / "examples" / "cell" / "cell.py"


@cache
def example() -> Any:
    spec = importlib.util.spec_from_file_location("cell_example", EXAMPLE)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def done() -> Any:
    return example().main()


def test_the_order_is_done_in_spite_of_the_stop(done: Any) -> None:
    stop = next(line for line in done.said if line.startswith("stopped"))
    told = [line for line in done.said if line is not stop]
    assert told == ["cell ready", "part 1 of 3 done", "goes on", "part 2 of 3 done", "part 3 of 3 done"]
    x, y = map(float, re.findall(r"[XY]=(-?[\d.]+)", stop))
    assert 5.0 < x < 55.0 and 5.0 < y < 35.0, "in the middle of the slot"
    assert done.where()[2] == 3 and done.mcu.rdci(example().EMERGENCIES) == 1


def test_the_axes_end_referenced_where_the_contour_ends(done: Any) -> None:
    x, y, _ = done.where()
    assert (x, y) == pytest.approx((10.0, 10.0), abs=0.01)
    assert done.mcu.rdaxst("X").referenced and not done.mcu.rdaxst("X").eo


def test_the_outputs_are_at_rest(done: Any) -> None:
    assert [done.mcu.rddigob("X", n) for n in (1, 2, 3)] == [0, 0, 0]


def test_it_is_the_same_every_time() -> None:
    first, second = example().main(), example().main()
    assert first.said == second.said and first.mcu.samples == second.mcu.samples


def test_a_following_error_is_served_like_an_emergency() -> None:
    module = example()
    cell = module.Cell()
    cell.wait(0.5)
    cell.mcu.wrci(module.ORDER, 1)
    cell.switch(module.PART, True)
    cell.until(23, 1)
    cell.wait(0.4)
    cell.mcu.play("block", "X")
    cell.until(module.STOPPED, 1)
    assert cell.mcu.rdci(31) == 1 and cell.mcu.rddigob("X", 3) == 1
    cell.mcu.play("block", "X", on=False)
    cell.wait(0.5)
    cell.mcu.wrci(module.STOPPED, 2)
    cell.until(module.MADE, 1)
