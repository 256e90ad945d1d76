"""Report sections of cnc_front.evidence: named findings, circular tests, checks of each axis."""

from __future__ import annotations

import math
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from cnc_front.evidence import finding_text
from cnc_front.report.words_evidence import WORDS

#: Named findings at the head of the page, circles drawn as polar plots.
HEAD = 5
PLOTS = 12


def circle_curves(evidence: dict[str, Any], figures: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What the polar plots draw: radius beyond the nominal one (um) by angle, for the circles that have figures."""
    curves: list[dict[str, Any]] = []
    for circle in evidence["circles"]:
        if len(curves) == len(figures) or len(curves) == PLOTS:
            break
        if np.mean(circle["samples"] > 0) < 0.95:
            continue
        driven = circle["samples"] > 0
        middle = (np.arange(len(driven)) + 0.5) * (2 * math.pi / len(driven))
        bands = [np.round(circle[name][driven] * 1e3, 4).tolist() for name in ("min_mm", "max_mm")]
        curves.append({"angle": np.round(middle[driven], 5).tolist(), "low": bands[0], "high": bands[1]})
    return curves


def named(run: dict[str, Any], language: str) -> list[str]:
    """The findings of the head in words, the gravest first."""
    return [finding_text(found, language) for found in (run.get("findings") or [])[:HEAD]]


def sections(run: dict[str, Any], units: dict[str, str], language: str) -> str:
    """HTML of the sections; empty where the run says nothing of it (a recording of an older version)."""
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    source = (files("cnc_front.report") / "evidence.html.j2").read_text(encoding="utf-8")
    return environment.from_string(source).render(
        run=run,
        words=WORDS[language],
        units=units,
        circles=(run.get("circularity") or [])[:64],
        plots=min(PLOTS, len(run.get("circularity") or [])),
        checks=run.get("axes") or {},
        motors=run.get("motor_command") or {},
        findings=[finding_text(found, language) for found in run.get("findings") or []],
    )


def plot_data(run: dict[str, Any], curves: list[dict[str, Any]], language: str) -> dict[str, Any]:
    """For the script of the page."""
    figures = (run.get("circularity") or [])[: len(curves)]
    words = WORDS[language]
    circles = [
        curve
        | {
            "title": f"{words['line']} {figure['line']}, {' '.join(figure['plane'])}, R {figure['radius_mm']:g} mm, "
            f"F {figure['feed_mm_min']:g}, {words[figure['direction']]}",
            "centreUm": [1e3 * value for value in figure["centre_mm"]],
            "axes": figure["plane"],
            "radiusMm": figure["radius_mm"],
        }
        for curve, figure in zip(curves, figures, strict=True)
    ]
    axes = {
        name: {
            "acceleration": axis["acceleration_histogram"],
            "accelerationLimit": axis["acceleration_limit"],
            "jerk": axis["jerk_histogram"],
        }
        for name, axis in (run.get("axes") or {}).items()
    }
    return {"circles": circles, "checks": axes, "checkWords": words}


def write_pictures(curves: list[dict[str, Any]], folder: Path) -> None:
    """png/circle-1.png ... as on the page."""
    from toolpaths.polar import polar_picture
    from toolpaths.raster import write_png

    for number, curve in enumerate(curves, 1):
        low, high = np.array(curve["low"]), np.array(curve["high"])
        write_png(folder / f"circle-{number}.png", polar_picture(np.array(curve["angle"]), low, high))
