"""The lines of the Run screen as pure functions of what the engine reports (ui-guide section 2)."""

from __future__ import annotations

from dataclasses import dataclass

from cnc_front.engine import AxisValues, Job, Snapshot
from tui.looks import Line, justified
from tui.words import Say


@dataclass(frozen=True, slots=True)
class Shown:
    """All that a line may depend on."""

    snapshot: Snapshot
    job: Job | None
    say: Say
    wide: bool
    #: seconds since the snapshot changed while it should have
    stale: bool = False
    clock: str = ""


def header(shown: Shown, width: int) -> Line:
    """Target, mode, state, job, block, modes, override, alarms."""
    s, say = shown.snapshot, shown.say
    speed = f"x{s.speed_factor:g}" if s.speed_factor > 0 else "max"
    symbol, style, word = say.state(s.state.value)
    left: Line = [(f"[SIM {speed}]", "sim"), (" AUTO ", "text"), (f" {symbol} {word} ", style)]
    if s.why and s.why != "hold":
        left.append((f" {s.why}", "warn"))
    if s.state.value == "RUNNING" and s.override_effective < 0.2:
        left.append((f" {say('low_override')}", "warn"))
    if shown.job is not None:
        left.append((f" {shown.job.name}", "text"))
        if shown.wide and s.line:
            left.append((f"   {say('line')} {s.line}", "text"))
    right: Line = [(" SB ", "inverse" if s.single_block else "soft")]
    right.append((f" OVR {s.override_set * 100:.0f} ", "warn" if s.override_set != 1 else "text"))
    right.append((f" ! {len(s.alarms)}", "bad" if s.alarms else "soft"))
    if shown.clock:
        right.append((f"  {shown.clock} ", "soft"))
    return justified(left, right, width)


def axis_head(shown: Shown) -> Line:
    """Head of the axis table."""
    say = shown.say
    return [(f"      {say('actual'):>8} mm {say('to_go'):>9} mm  {say('follow'):<12}0 {say('limit'):>6}", "soft")]


def axis_line(axis: AxisValues, stale: bool) -> Line:
    """Position, distance to go, following error with a bar against mpe, referenced."""
    style = "soft" if stale else "text"
    share = min(1.0, abs(axis.following) / axis.mpe) if axis.mpe > 0 else 0.0
    bar = "#" * round(share * 8)
    grade = "bad" if share >= 1 else "warn" if share > 0.5 else "text"
    mark = "R" if axis.referenced else "?"
    return [
        (f" {axis.name:<2} {axis.actual:>+13.4f} {axis.to_go:>+12.4f} {axis.following * 1e3:>+10.1f}  ", style),
        (f"|{bar:<8}|", grade),
        (f" {mark}" + ("?" if stale else ""), style),
    ]


def figures(shown: Shown) -> list[Line]:
    """Feed, override, path, deviation, spooler: seven lines for the wide screen."""
    s, say = shown.snapshot, shown.say
    bad = "bad" if shown.job is not None and s.deviation_max_mm > shown.job.tolerance_mm else "text"
    worst = f"max {s.deviation_max_mm * 1e3:.1f} um @{s.deviation_max_line}" if s.deviation_max_line else ""
    tolerance = f"{say('tol')} {shown.job.tolerance_mm * 1e3:g} um" if shown.job else ""
    fills = " ".join(f"{a.name} {a.spool_fill * 100:.0f} %" for a in s.axes[:4])
    override = f"{say('set')} {s.override_set * 100:.0f} % {say('eff')} {s.override_effective * 100:.0f} %"
    return [
        [(f" F     {s.feed_actual:.0f} / {s.feed_programmed:.0f} mm/min   OVR {override}", "text")],
        [(f" {say('path'):<5} {s.path_done_mm:.1f} / {s.path_total_mm:.1f} mm    {times(shown)}", "text")],
        [
            (" DEV   ", "text"),
            (f"{say('now')} {s.deviation_now_mm * 1e3:.1f} um   {worst}   ", bad),
            (tolerance, "soft"),
        ],
        [(f" SPOOL {fills}   {say('empty_in')} {s.spool_empty_s:.1f} s", "text")],
        [(f" {s.modal}  T{s.tool}  {s.spindle}  {s.coolant}", "soft")],
    ]


def times(shown: Shown) -> str:
    """Machine time so far and of the whole job."""
    s = shown.snapshot
    total = clock(s.time_total_s) if s.time_total_s is not None else "?"
    return f"{shown.say('time')} {clock(s.machine_time_s)} / {total} ({shown.say('sim')})"


def clock(seconds: float) -> str:
    """0:49 or 1:02:03."""
    whole = int(seconds)
    hours, minutes = whole // 3600, whole // 60 % 60
    return f"{hours}:{minutes:02}:{whole % 60:02}" if hours else f"{minutes}:{whole % 60:02}"


def progress(shown: Shown, width: int) -> Line:
    """Bar and share by the motion model's time, else by path length."""
    s = shown.snapshot
    by_time = s.machine_time_s / s.time_total_s if s.time_total_s else None
    by_path = s.path_done_mm / s.path_total_mm if s.path_total_mm > 0 else 0.0
    share = 1.0 if s.state.value == "DONE" else min(1.0, by_time if by_time is not None else by_path)
    room = max(4, width - 9)
    done = round(share * room)
    return [(f" [{'#' * done}{'.' * (room - done)}] {share * 100:3.0f} %", "text")]


def narrow_sides(shown: Shown) -> list[Line]:
    """What stands right of the axis table on 80 columns."""
    s, say = shown.snapshot, shown.say
    bad = "bad" if shown.job is not None and s.deviation_max_mm > shown.job.tolerance_mm else "text"
    fill = max((a.spool_fill for a in s.axes), default=0.0)
    override = f"{say('set')} {s.override_set * 100:.0f} {say('eff')} {s.override_effective * 100:.0f} %"
    return [
        [(f"F   {s.feed_actual:.0f}/{s.feed_programmed:.0f}", "text")],
        [(f"OVR {override}", "text")],
        [(f"DEV {s.deviation_now_mm * 1e3:.1f} max {s.deviation_max_mm * 1e3:.1f} um", bad)],
        [(f"SPOOL {fill * 100:.0f} % {s.spool_empty_s:.1f} s", "text")],
        [(f"T{s.tool} {s.spindle} {s.coolant}", "soft")],
    ]


def values(shown: Shown, width: int) -> list[Line]:
    """The values panel in either size."""
    axes = shown.snapshot.axes
    if shown.wide:
        table = [axis_line(axis, shown.stale) for axis in axes] or [[("", "text")]]
        lines = figures(shown)
        return [axis_head(shown), *table, [("", "text")], *lines[:2], progress(shown, width), *lines[2:]]
    sides = narrow_sides(shown)
    left = [axis_head(shown), *(axis_line(axis, shown.stale) for axis in axes[:4])]
    rows = max(len(sides), len(left))
    left += [[("", "text")]] * (rows - len(left))
    sides += [[("", "text")]] * (rows - len(sides))
    body = [_beside(a, b, 58) for a, b in zip(left, sides, strict=True)]
    s = shown.snapshot
    bar = progress(shown, 38)
    bar.append((f"  {times(shown)}  {s.path_done_mm:.0f}/{s.path_total_mm:.0f} mm", "text"))
    return [*body, bar]


def _beside(left: Line, right: Line, column: int) -> Line:
    used = sum(len(text) for text, _ in left)
    return [*left, (" " * max(1, column - used), "text"), *right]


def keys(shown: Shown, width: int) -> Line:
    """The key line; what does not fit is left out from the right."""
    say = shown.say
    names = [
        ("SPACE", "key_hold"), ("r", "key_start"), ("t", "key_step"), ("b", "key_sb"), ("+ -", "key_ovr"),
        ("^X", "key_reset"), ("v", "key_plot"), (", .", "key_speed"), ("F1", "key_help"), ("F2", "key_open"),
        ("F6", "key_alarms"),
    ]  # fmt: skip
    line: Line = []
    for key, id in names:
        piece = f" {key} {say(id)} "
        if sum(len(text) for text, _ in line) + len(piece) > width:
            break
        line += [(f" {key} ", "inverse"), (f"{say(id)} ", "panel")]
    return line
