"""docs/resources.md: its table is that of the controller, its examples run."""

from __future__ import annotations

import re

import numpy as np

from motion_kernel import Machine, Mcu
from motion_kernel.devices import DEVICES
from tests.conformance.resources_page import PAGE, page, rows


def test_the_table_is_current() -> None:
    text = PAGE.read_text("utf-8")
    assert text == page(text), "run python -m tests.conformance.resources_page"
    lines = list(rows())
    assert len(lines) == len(DEVICES) and not any("| - |\n" in line for line in lines), "every device has a meaning"


def test_its_examples_run() -> None:
    names = {"np": np, "Machine": Machine, "Mcu": Mcu}
    for example in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL):
        exec(example, names)  # one after the other, as a reader would type them
