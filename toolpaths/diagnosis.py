"""What a deviation comes from, as far as the data support it: pure functions over the sums of Tracker.evidence.

Every named finding is a hypothesis that explains nearly all of what it is made from (`EXPLAINED`) with a size that is
certain enough (`CERTAIN`); what nothing explains stays a "deviation". Terms: set point `dp` and load side (design D21)
are measured against the programmed path, in the metric of design D7 (mm); nothing is fitted to the path itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Share of the squared offsets that a hypothesis must explain, and standard error that its size may have.
EXPLAINED = 0.95
CERTAIN = 0.01
#: One cause for a whole run must explain more than a block's own could by chance.
WHOLE = 0.98
#: With more unknowns than a shift a short arc can be made to fit anything: then nearly all must be explained.
NEARLY_ALL = 0.9999
#: Smaller faults of the load side are within what a closed loop does by itself.
LEAST_SHIFT_MM = 0.003
LEAST_SAMPLES = 20
EXPLAINED_OF_LOAD = 0.98
LEAST_PLAY_MM = 0.002
LEAST_LAG_SAMPLES = 0.3
LEAST_LAG_MM = 0.001
#: Offsets of neighbouring blocks that differ by less are one finding; a fault of one block stands out this much.
ALIKE = 0.02
STANDS_OUT = 0.5
#: A set point this much off the path (beyond merging) is a fault, mm (design 3.1).
SETPOINT_MM = 1e-6

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Finding:
    """One cause with the place where it was worst and its size.

    `kind`: block_shifted, centre_off, radius_off, effradius, axis_scale, axis_lags, axes_swapped, axis_reversed,
    reversal_error or deviation. `block`: number in Path.blocks. `size_mm` is what the kind is about (shift, distance of
    the centres, play, largest deviation); `values` says more: `lag_s`, `factor`, `radius_mm`, `vector_mm`.
    """

    kind: str
    trace: str
    block: int
    size_mm: float
    max_mm: float
    axes: tuple[int, ...] = ()
    blocks: int = 1
    values: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Setting:
    """What the run was: sample time, limit, mm per unit of each axis, which are rotary, share of merging."""

    sample_time_s: float
    tolerance_mm: float
    mm_per_unit: Sequence[float]
    rotary: Sequence[bool]
    merged_mm: float = 0.0


def diagnose(evidence: dict[str, Any], summary: dict[str, Any], setting: Setting) -> list[Finding]:
    """All findings of a run, set points first, the largest first within each kind of trace."""
    off = summary["setpoint"]["max_mm"] > setting.merged_mm + SETPOINT_MM
    commanded = _of_setpoints(evidence["setpoint"], setting) if off else []
    known = {finding.block + k for finding in commanded for k in range(finding.blocks)}
    everywhere = any(finding.kind in WHOLE_RUN for finding in commanded)
    driven = [] if everywhere else _of_load(evidence, setting, known)
    rest = _unexplained(summary, [*commanded, *driven], setting)
    return [*_sorted(commanded), *_sorted(driven), *rest]


#: Causes that act in the whole run, not in a block.
WHOLE_RUN = frozenset({"axis_lags", "axis_scale", "effradius", "reversal_error", "axes_swapped", "axis_reversed"})


def _sorted(findings: list[Finding]) -> list[Finding]:
    return sorted(findings, key=lambda finding: -finding.max_mm)


def _of_setpoints(trace: dict[str, Any], setting: Setting) -> list[Finding]:
    exchanged = _exchanges(trace, "setpoint")
    if exchanged:
        return exchanged
    whole = _lag_on_path(trace) + _scales(trace, setting)
    found = [f for fit in trace["blocks"] if (f := _of_block(fit, "setpoint", setting)) is not None]
    blocks = _grouped(found)
    if not whole:
        return blocks
    # one cause for all of it, unless one for one block explains it better
    best = max(whole, key=lambda finding: finding.values["explained"])
    alone = len(blocks) == 1 and len(trace["blocks"]) == len(found)
    if alone and min(f.values["explained"] for f in found) > best.values["explained"]:
        return blocks
    return [best]


def _of_load(evidence: dict[str, Any], setting: Setting, known: set[int]) -> list[Finding]:
    trace = evidence["actual"]
    exchanged = [found for found in _exchanges(trace, "actual") if found.block not in known]
    axes = _reversal_errors(evidence, setting) + _lags(evidence, setting)
    if exchanged or axes:
        return exchanged + axes
    blocks = [_of_block(fit, "actual", setting) for fit in trace["blocks"] if fit["block"] not in known]
    samples = {fit["block"]: fit["summed"] for fit in trace["blocks"]}
    large = [
        found
        for found in blocks
        if found is not None
        and found.size_mm >= LEAST_SHIFT_MM
        and found.values["explained"] >= EXPLAINED_OF_LOAD
        and samples[found.block] >= LEAST_SAMPLES
    ]
    return [found for found in _grouped(large) if _stands_out(found, trace["blocks"])]


def _exchanges(trace: dict[str, Any], name: str) -> list[Finding]:
    kinds = {"swapped": "axes_swapped", "reversed": "axis_reversed"}
    episodes: dict[tuple[str, tuple[int, ...]], list[dict[str, Any]]] = {}
    for episode in trace["exchanges"]:
        episodes.setdefault((kinds[episode["kind"]], tuple(dict.fromkeys(episode["axes"]))), []).append(episode)
    found = []
    for (kind, axes), same in episodes.items():
        most = max(episode["max_mm"] for episode in same)
        found.append(Finding(kind, name, same[0]["block"], most, most, axes))
    return found


# ---- causes of an axis, in the whole run


def _lag_on_path(trace: dict[str, Any]) -> list[Finding]:
    """One axis whose set point is late: its offset is minus lag times its velocity, as far as that is normal."""
    found = []
    for a, share in enumerate(trace["axes"]):
        if share["wvv"] <= 0 or share["squares"] <= 0:
            continue
        lag = -share["ev"] / share["wvv"]
        explained = share["ev"] ** 2 / share["wvv"] / share["squares"]
        if explained >= WHOLE and lag > 0:
            values = {"lag_s": lag, "explained": explained}
            most = share["most_mm"]
            found.append(Finding("axis_lags", "setpoint", share["block"], most, most, (a,), values=values))
    return found


def _scales(trace: dict[str, Any], setting: Setting) -> list[Finding]:
    """One axis whose way is too long or too short: its offset grows with its position."""
    found = []
    for a, share in enumerate(trace["axes"]):
        normal = np.array([[share["w"], share["wx"]], [share["wx"], share["wxx"]]])
        right = np.array([share["e"], share["ex"]])
        if share["squares"] <= 0 or np.linalg.det(normal) <= 1e-9 * normal[0, 0] * normal[1, 1]:
            continue
        offset, slope = np.linalg.solve(normal, right)
        explained = float(right @ (offset, slope)) / share["squares"]
        # a mere offset is no scale
        alone = share["e"] ** 2 / share["w"] / share["squares"]
        if explained >= WHOLE and alone < 0.9 * explained:
            kind = "effradius" if setting.rotary[a] else "axis_scale"
            values = {"factor": 1 + float(slope), "explained": explained, "mm_per_unit": share["mm_per_unit"]}
            most = share["most_mm"]
            found.append(Finding(kind, "setpoint", share["block"], most, most, (a,), values=values))
    return found


@dataclass(frozen=True, slots=True)
class _Relation:
    """Set point minus load of an axis = lag * v + a2 * a + half_play * direction + constant, with standard errors.

    `gain` is the share of what remains without a term that the term explains."""

    value: Vector
    error: Vector
    gain: Vector


def _relation(axis: dict[str, Any]) -> _Relation | None:
    normal, right, n = axis["normal"], axis["right"], axis["samples"]
    scale = np.sqrt(np.diag(normal))
    if n < 20 or not (scale > 0).all():
        return None
    scaled = normal / np.outer(scale, scale)
    if np.linalg.cond(scaled) > 1e8:
        return None
    inverse = np.linalg.inv(scaled)
    value = inverse @ (right / scale)
    rest = max(float(axis["squares"] - value @ (right / scale)), 0.0)
    error = np.sqrt(rest / (n - len(right)) * np.diag(inverse))
    # what a term explains beyond all others: value² / inverse_kk
    own = value**2 / np.diag(inverse)
    gain = own / np.maximum(own + rest, 1e-300)
    return _Relation(value / scale, error / scale, gain)


VELOCITY, DIRECTION = 0, 2


def _reversal_errors(evidence: dict[str, Any], setting: Setting) -> list[Finding]:
    """Axes whose load is behind by half a play whichever way they go: twice that is lost at a reversal."""
    found = []
    for a, axis in enumerate(evidence["axes"]):
        relation = _relation(axis)
        if relation is None or axis["reversals"] == 0 or relation.gain[DIRECTION] < STANDS_OUT:
            continue
        play = 2 * float(relation.value[DIRECTION]) * setting.mm_per_unit[a]
        certain = relation.error[DIRECTION] <= CERTAIN * abs(relation.value[DIRECTION])
        if play >= LEAST_PLAY_MM and certain:
            share = evidence["actual"]["axes"][a]
            found.append(Finding("reversal_error", "actual", share["block"], play, share["most_mm"], (a,)))
    return found


def _lags(evidence: dict[str, Any], setting: Setting) -> list[Finding]:
    """Axes that are later than the others: what all are late is no deviation from the path."""
    relations = {a: r for a, axis in enumerate(evidence["axes"]) if (r := _relation(axis)) is not None}
    found = []
    for a, relation in relations.items():
        others = [other for b, other in relations.items() if b != a]
        if not others:
            continue
        late = float(relation.value[VELOCITY]) - _usual_lag(others)
        certain = relation.error[VELOCITY] <= CERTAIN * abs(late) and relation.gain[VELOCITY] >= STANDS_OUT
        share = evidence["actual"]["axes"][a]
        large = late >= LEAST_LAG_SAMPLES * setting.sample_time_s and share["most_mm"] >= LEAST_LAG_MM
        if certain and large:
            most = share["most_mm"]
            found.append(Finding("axis_lags", "actual", share["block"], most, most, (a,), values={"lag_s": late}))
    return found


def _usual_lag(relations: list[_Relation]) -> float:
    """The median of what others lag, each as heavy as it is certain."""
    ranked = sorted(relations, key=lambda r: float(r.value[VELOCITY]))
    weights = np.cumsum([1 / max(float(r.error[VELOCITY]), 1e-15) for r in ranked])
    return float(ranked[int(np.searchsorted(weights, weights[-1] / 2))].value[VELOCITY])


# ---- causes of a block


def _of_block(fit: dict[str, Any], trace: str, setting: Setting) -> Finding | None:
    return _of_line(fit, trace) if fit["circle"] is None else _of_circle(fit, trace, setting)


def _of_line(fit: dict[str, Any], trace: str) -> Finding | None:
    """A line that lies beside where it should be: the same offset all along."""
    mean: Vector = fit["mean_mm"]
    square = float(mean @ mean)
    if square < EXPLAINED * fit["mean_square"]:
        return None
    values = {"vector_mm": mean, "explained": square / fit["mean_square"]}
    return Finding("block_shifted", trace, fit["block"], math.sqrt(square), fit["max_mm"], values=values)


#: Hypotheses of a circle: columns of the normal equations (cos, sin, 1).
CIRCLES = (("radius_off", (2,)), ("centre_off", (0, 1)), ("centre_off", (0, 1, 2)))


def _of_circle(fit: dict[str, Any], trace: str, setting: Setting) -> Finding | None:
    c1, c2, _ = fit["circle"]
    out_of_plane = fit["mean_mm"].copy()
    out_of_plane[[c1, c2]] = 0.0
    aside = float(out_of_plane @ out_of_plane)
    if aside >= EXPLAINED * fit["mean_square"]:
        size = math.sqrt(aside)
        values = {"vector_mm": out_of_plane, "explained": aside / fit["mean_square"]}
        return Finding("block_shifted", trace, fit["block"], size, fit["max_mm"], values=values)
    hypotheses = [(kind, columns) for kind, columns in CIRCLES if kind != "radius_off" or trace == "setpoint"]
    # nearly exact first, whatever it takes; else only what needs few numbers
    for kind, columns in hypotheses:
        if (solved := _solve(fit, columns, NEARLY_ALL)) is not None:
            return _circle_finding(kind, *solved, fit, trace)
    if setting.rotary[c1] != setting.rotary[c2] and (found := _scaled_circle(fit, trace, setting)) is not None:
        return found
    for kind, columns in hypotheses[:-1]:
        if (solved := _solve(fit, columns, EXPLAINED)) is not None:
            return _circle_finding(kind, *solved, fit, trace)
    return None


def _scaled_circle(fit: dict[str, Any], trace: str, setting: Setting) -> Finding | None:
    """A circle that was driven with other scales of its two axes is an ellipse along them: v² = p - ratio² u² + ...;
    the ratio of the scales is that of the effective radii."""
    c1, c2, radius = fit["circle"]
    normal, right = fit["conic_normal"], fit["conic_right"]
    if np.linalg.cond(normal) > 1e13:
        return None
    value = np.linalg.solve(normal, right)
    # v² of the conic is out by twice the radial deviation, in radii
    rest = float(fit["conic_squares"] - value @ right) * radius**2 / 4
    if value[0] >= 0 or abs(rest) > (1 - NEARLY_ALL) * fit["radial_squares"]:
        return None
    first_to_second = 1 / math.sqrt(-float(value[0]))
    axis = c1 if setting.rotary[c1] else c2
    factor = first_to_second if axis == c1 else 1 / first_to_second
    explained = 1 - abs(rest) / fit["radial_squares"]
    values = {"factor": factor, "explained": explained, "mm_per_unit": fit["mm_per_unit"][axis]}
    most = fit["max_mm"]
    return Finding("effradius", trace, fit["block"], most, most, (axis,), values=values)


def _solve(fit: dict[str, Any], columns: tuple[int, ...], wanted: float) -> tuple[Vector, float] | None:
    """Least squares over some columns, zeros elsewhere, and the share that it explains; None where that is too little
    or uncertain."""
    pick = list(columns)
    normal, right = fit["normal"][np.ix_(pick, pick)], fit["right"][pick]
    squares = fit["radial_squares"]
    if squares < EXPLAINED * fit["mean_square"] * fit["weight"] or fit["summed"] <= len(pick):
        return None
    if np.linalg.cond(normal) > 1e10:
        return None
    value = np.linalg.solve(normal, right)
    rest = max(float(squares - value @ right), 0.0)
    error = np.sqrt(rest / (fit["summed"] - len(pick)) * np.diag(np.linalg.inv(normal)))
    size = float(np.linalg.norm(value))
    if rest > (1 - wanted) * squares or float(np.linalg.norm(error)) > 0.02 * size or size > 100 * fit["max_mm"]:
        return None
    full = np.zeros(3)
    full[pick] = value
    return full, 1 - rest / squares


def _circle_finding(kind: str, solved: Vector, explained: float, fit: dict[str, Any], trace: str) -> Finding:
    c1, c2, radius = fit["circle"]
    block, most = fit["block"], fit["max_mm"]
    if kind == "radius_off":
        values = {"radius_mm": radius + float(solved[2]), "explained": explained}
        return Finding(kind, trace, block, abs(float(solved[2])), most, values=values)
    vector = np.zeros(len(fit["mean_mm"]))
    vector[[c1, c2]] = solved[:2]
    values = {"vector_mm": vector, "explained": explained}
    return Finding(kind, trace, block, float(np.hypot(*solved[:2])), most, values=values)


def _grouped(findings: list[Finding]) -> list[Finding]:
    """Neighbouring blocks with the same offset are one finding."""
    groups: list[list[Finding]] = []
    for finding in sorted(findings, key=lambda f: f.block):
        before = groups[-1][-1] if groups else None
        if before is not None and finding.block == before.block + 1 and _same(before, finding):
            groups[-1].append(finding)
        else:
            groups.append([finding])
    return [_joined(group) for group in groups]


def _same(one: Finding, other: Finding) -> bool:
    a, b = one.values.get("vector_mm"), other.values.get("vector_mm")
    if one.kind != other.kind or a is None or b is None:
        return False
    return bool(np.linalg.norm(a - b) <= ALIKE * max(one.size_mm, other.size_mm))


def _joined(group: list[Finding]) -> Finding:
    first, most = group[0], max(finding.max_mm for finding in group)
    return Finding(first.kind, first.trace, first.block, first.size_mm, most, first.axes, len(group), first.values)


def _stands_out(found: Finding, fits: list[dict[str, Any]]) -> bool:
    """The blocks beside it are much nearer to the path: what all blocks have is no fault of one."""
    beside = {found.block - 1, found.block + found.blocks}
    near = [fit["mean_square"] for fit in fits if fit["block"] in beside]
    return all(math.sqrt(square) < STANDS_OUT * found.size_mm for square in near)


def _unexplained(summary: dict[str, Any], named: list[Finding], setting: Setting) -> list[Finding]:
    """Deviations beyond a limit that no named finding of that trace explains."""
    limits = {"setpoint": setting.merged_mm + SETPOINT_MM, "actual": setting.tolerance_mm}
    traces = {finding.trace for finding in named}
    rest = []
    for trace, limit in limits.items():
        most = summary[trace]["max_mm"]
        # a set point that is off takes the load side with it
        if most > limit and trace not in traces and "setpoint" not in traces:
            rest.append(Finding("deviation", trace, -1, most, most))
            break
    return rest
