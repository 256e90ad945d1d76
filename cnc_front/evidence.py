"""What a run says beyond its deviations: named findings, circular tests, checks of each axis; keys of `run --json`.

Computed from what the tracker measured, so a recording gives the same figures as its run; only how much of the motor
command was used comes from the controller itself, and stands in the result of the recording.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnc_front._native import motion_kernel as native_kernel
from cnc_front._native import toolpaths as native_paths
from cnc_front.messages import text
from toolpaths.circularity import circles
from toolpaths.diagnosis import Finding, Setting, diagnose

#: Full scale of the motor command, digits (errata 4.4.88).
FULL_SCALE = 32767.0


def evidence_keys(
    tracker: native_paths.Tracker,
    summary: dict[str, Any],
    machine: native_kernel.Machine,
    tolerance_mm: float,
) -> dict[str, Any]:
    """`findings`, `circularity` and `axes` of the object of `run --json`."""
    evidence = tracker.evidence()
    lines: dict[int, int] = evidence["lines"]
    setting = Setting(
        sample_time_s=machine.sample_time_us * 1e-6,
        tolerance_mm=tolerance_mm,
        mm_per_unit=tracker.mm_per_unit,
        rotary=[kind == "rotary" for kind in machine.kinds],
        merged_mm=summary["merged"][1],
    )
    named = diagnose(evidence, summary, setting)
    return {
        "findings": [_finding(found, summary, lines, machine, setting) for found in named],
        "circularity": [_circle(entry, lines, machine.axis_names) for entry in circles(evidence["circles"])],
        "axes": _axes(evidence, summary, machine),
    }


def _finding(
    found: Finding, summary: dict[str, Any], lines: dict[int, int], machine: native_kernel.Machine, setting: Setting
) -> dict[str, Any]:
    names = machine.axis_names
    line = lines[found.block] if found.block >= 0 else summary[found.trace]["worst"]["line"]
    entry: dict[str, Any] = {
        "kind": found.kind,
        "trace": found.trace,
        "line": line,
        "blocks": found.blocks,
        "axes": [names[a] for a in found.axes],
        "size_mm": found.size_mm,
        "max_mm": found.max_mm,
    }
    values = found.values
    if "vector_mm" in values:
        entry["vector_mm"] = dict(zip(names, map(float, values["vector_mm"]), strict=False))
    if "lag_s" in values:
        entry |= {"lag_s": values["lag_s"], "lag_samples": values["lag_s"] / setting.sample_time_s}
    if "radius_mm" in values:
        entry["radius_mm"] = values["radius_mm"]
    if "factor" in values:
        entry["factor"] = values["factor"]
    if found.kind == "effradius":
        radius = math.degrees(values["mm_per_unit"])
        # what turns too far turns by a radius that is too small
        entry |= {"programmed_radius_mm": radius, "effradius_mm": radius / values["factor"]}
    return entry


def finding_text(entry: dict[str, Any], language: str) -> str:
    """One finding in words, with its size and place."""
    values = {
        "size_um": entry["size_mm"] * 1e3,
        "max_um": entry["max_mm"] * 1e3,
        "line": entry["line"],
        "file": entry.get("file"),
        "axes": " ".join(entry["axes"]),
        "samples": entry.get("lag_samples", 0.0),
        "ms": entry.get("lag_s", 0.0) * 1e3,
        "radius": entry.get("effradius_mm", entry.get("radius_mm", 0.0)),
        "programmed": entry.get("programmed_radius_mm", 0.0),
        "percent": (entry.get("factor", 1.0) - 1) * 100,
    }
    side = text(f"trace_{entry['trace']}", language)
    if entry.get("task"):  # of a rw_SymPas job; that of task 0 needs no name
        side = f"Task {entry['task']}, {side}"
    return text(f"finding_{entry['kind']}", language, **values) + f" ({side})"


def remedy_text(entry: dict[str, Any], language: str) -> str:
    """What to do about a finding."""
    return text(f"remedy_{entry['kind']}", language, axes=" ".join(entry["axes"]), line=entry["line"])


def _circle(entry: dict[str, Any], lines: dict[int, int], names: Sequence[str]) -> dict[str, Any]:
    first, last = entry["blocks"]
    a, b = entry["axes"]
    chosen = {key: value for key, value in entry.items() if key not in ("blocks", "axes", "velocity_mm_s")}
    place = {"line": lines[first], "last_line": lines[last], "plane": [names[a], names[b]]}
    return place | {"feed_mm_min": entry["velocity_mm_s"] * 60} | chosen


def _axes(evidence: dict[str, Any], summary: dict[str, Any], machine: native_kernel.Machine) -> dict[str, Any]:
    """Range against software limits, following error against mpe, dynamics against limits, in axis units."""
    edges: NDArray[np.float64] = evidence["bin_edges"]
    limits, following = machine.limits, summary["following_error"]
    measured = zip(machine.axis_names, evidence["axes"], strict=True)
    rows = zip(measured, limits, machine.mpe, machine.dynamics(), following, strict=True)
    return {
        name: {
            "range": list(axis["range"]),
            "limits": list(limits) if limits else None,
            "limit_margin": min(axis["range"][0] - limits[0], limits[1] - axis["range"][1]) if limits else None,
            "following_max": following[0],
            "mpe": mpe,
            "following_of_mpe_pct": 100 * following[0] / mpe if mpe > 0 else None,
            "velocity_max": axis["velocity"],
            "velocity_limit": dynamics[1],
            "acceleration_max": axis["acceleration"],
            "acceleration_limit": dynamics[2],
            "jerk_max": axis["jerk"],
            "acceleration_histogram": _histogram(axis["acceleration_bins"], edges),
            "jerk_histogram": _histogram(axis["jerk_bins"], edges),
        }
        for (name, axis), limits, mpe, dynamics, following in rows
    }


def _histogram(counts: NDArray[np.uint64], edges: NDArray[np.float64]) -> list[list[float]]:
    """[upper edge, samples] of the classes that are not empty; each reaches down to 4/5 or less of its edge."""
    return [[float(edges[k]), int(counts[k])] for k in np.nonzero(counts)[0]]


def motor_commands(mcu: native_kernel.Mcu, names: Sequence[str]) -> dict[str, dict[str, float]]:
    """Per axis: peak of the motor command in % of full scale, and the share of samples at its end in %."""
    total = max(1, mcu.samples())
    return {
        name: {"peak_pct": 100 * peak / FULL_SCALE, "saturated_pct": 100 * saturated / total}
        for name, (peak, saturated) in zip(names, mcu.motor_commands(), strict=True)
    }
