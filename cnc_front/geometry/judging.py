"""What of the checks against drawing and setup makes a verdict FAIL."""

from __future__ import annotations

from typing import Any

from cnc_front.messages import text
from cnc_front.verdict import Reason

#: Contour that was driven on the wrong side may be as long as a corner takes, mm.
WRONG_SIDE_MM = 0.1


def geometry_reasons(figures: dict[str, Any], limit_mm: float) -> tuple[Reason, ...]:
    """Deviation from the drawing, what of it was not driven, collisions, gouges, rest where it is limited."""
    return (
        *_reference(figures["reference"], limit_mm),
        *_collisions(figures["collisions"]),
        *_target(figures["material"]),
    )


def _reference(reference: dict[str, Any] | None, limit_mm: float) -> list[Reason]:
    if reference is None:
        return []
    reasons, actual = [], reference["actual"]
    if actual["max_mm"] is not None and actual["max_mm"] > limit_mm:
        values = {"max_um": actual["max_mm"] * 1e3, "limit_um": limit_mm * 1e3, "line": actual["worst"]["line"]}
        reasons.append(Reason("reference", values))
    if reference["missing_mm"]:
        values = {"missing_mm": reference["missing_mm"], "missing_pct": reference["missing_pct"]}
        reasons.append(Reason("reference_missing", values))
    if actual["max_mm"] is None:
        reasons.append(Reason("reference_far", {"capture_mm": reference["capture_mm"]}))
    if actual["wrong_side_mm"] > WRONG_SIDE_MM:
        reasons.append(Reason("reference_side", {"length_mm": actual["wrong_side_mm"]}))
    return reasons


def _collisions(collisions: dict[str, Any] | None) -> list[Reason]:
    rows = collisions["findings"] if collisions is not None else []
    keys = ("kind", "body", "tool", "line", "t_s", "size_mm")
    return [Reason("collision", {key: row[key] for key in keys}) for row in sorted(rows, key=lambda r: -r["size_mm"])]


def _target(material: dict[str, Any] | None) -> list[Reason]:
    target = material["target"] if material is not None else None
    reasons = []
    for name in ("gouge", "rest"):
        side = target[name] if target is not None else None
        if side is not None and side["judged"] and side["max_mm"] > side["limit_mm"]:
            values = {"max_um": side["max_mm"] * 1e3, "limit_um": side["limit_mm"] * 1e3, "line": side["line"] or 0}
            reasons.append(Reason(name, values | side["place"]))
    return reasons


def geometry_rows(run: dict[str, Any], language: str) -> list[tuple[str, str]]:
    """Label and figures of a run against drawing and setup, for the text of a result."""
    rows, reference, material = [], run.get("reference"), run.get("material")
    if reference is not None:
        most = reference["actual"]["max_mm"]
        parts = [] if most is None else [f"{most * 1e3:.1f} um"]
        if reference["missing_mm"] is not None:
            missing = f"{reference['missing_mm']:.2f} mm ({reference['missing_pct']:.2f} %)"
            parts.append(f"{text('not_driven', language)} {missing}")
        parts.append(f"{text('extra', language)} {reference['actual']['extra_mm']:.2f} mm")
        rows.append(("from_drawing", ", ".join(parts)))
    if material is not None and "removed_mm3" in material:
        rows.append(("removed", f"{material['removed_mm3']:.1f} mm3"))
        if material["target"] is not None:
            sides = ((text(f"{name}_word", language), material["target"][name]) for name in ("gouge", "rest"))
            rows.append(("against_target", ", ".join(f"{word} {side['max_mm'] * 1e3:.1f} um" for word, side in sides)))
    if run.get("collisions") is not None:
        rows.append(("collisions", str(run["collisions"]["count"])))
    return rows
