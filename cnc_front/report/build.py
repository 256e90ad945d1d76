"""Writes the folder of a report: report.html, report.json, blocks.csv, png/."""

from __future__ import annotations

import csv
import json
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from typing import Any

from cnc_front import VERSION
from cnc_front.messages import text
from cnc_front.outputs import REPORT_FILE, REPORT_MARK
from cnc_front.recording import VOLATILE
from cnc_front.report import evidence
from cnc_front.report.data import ReportInput, block_table, findings, gaps, plot_data, statistics, worst_vertices
from cnc_front.report.geometry import sections, write_pictures
from cnc_front.report.limits import limit_rows, limit_words
from cnc_front.report.words import WORDS

SCHEMA = "cnc-front/report/1"
#: Parts of the script of the page, in their order.
SCRIPTS = ("plot.js", "limits.js", "path.js", "table.js", "report.js", "evidence.js")


def write_report(report: ReportInput, folder: Path, language: str) -> None:
    """Writes all files of the report; raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = block_table(report)
    vertices = worst_vertices(report)
    figures = report_json(report, findings(report, rows, vertices))
    data = plot_data(report, rows, vertices)
    # first the page, which marks the folder as ours: a later run may then replace what an interrupted one left
    inline = write_pictures(report, folder / "png")
    (folder / REPORT_FILE).write_text(html(report, data, figures, language, inline), encoding="utf-8")
    (folder / "report.json").write_text(json.dumps(figures, indent=1, allow_nan=False), encoding="utf-8")
    _write_blocks(folder / "blocks.csv", rows)
    _write_pictures(report, folder / "png")
    evidence.write_pictures(report.circles, folder / "png")


def report_json(report: ReportInput, worst: list[dict[str, Any]]) -> dict[str, Any]:
    """The figures; the same input gives the same object apart from `run`."""
    result = {key: value for key, value in report.run.items() if key not in VOLATILE}
    run = {key: report.run.get(key) for key in VOLATILE}
    run["date"] = datetime.now(UTC).isoformat(timespec="seconds")
    counts = report.histogram.counts.tolist()
    return {
        "schema": SCHEMA,
        "version": VERSION,
        "result": result,
        "findings": worst,
        "statistics": statistics(report),
        "limits": limit_rows(report.limits, report.axes, report.sample_time_s),
        "time_optimal": report.time_optimal.as_json() if report.time_optimal else None,
        "histogram": counts,
        "note": report.note,
        "run": run,
    }


def html(
    report: ReportInput, data: dict[str, Any], figures: dict[str, Any], language: str, inline: dict[str, str]
) -> str:
    """The page: everything inline (pictures as data), nothing from the network."""
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    room = files("cnc_front.report")
    template = environment.from_string((room / "report.html.j2").read_text(encoding="utf-8"))
    geometry = environment.from_string((room / "geometry.html.j2").read_text(encoding="utf-8"))
    # named findings are told one by one below the reasons
    reasons = [reason for reason in report.run["verdict"]["reasons"] if reason["id"] != "named_findings"]
    units = dict(zip(report.axes, report.units, strict=True))
    shown = evidence.plot_data(report.run, report.circles, language)
    spoken = limit_words(report.limits, report.axes, language)
    return template.render(
        mark=REPORT_MARK,
        language=language,
        words=WORDS[language],
        css=(room / "report.css").read_text(encoding="utf-8"),
        script="\n".join((room / name).read_text(encoding="utf-8") for name in SCRIPTS),
        data=_script_json(data | {"words": WORDS[language], "limitWords": spoken} | shown),
        named=evidence.named(report.run, language),
        evidence=evidence.sections(report.run, units, language),
        limits=figures["limits"],
        limit_words=spoken,
        optimal=figures["time_optimal"],
        figures=_script_json(figures),
        run=report.run,
        date=figures["run"]["date"],
        version=VERSION,
        reasons=[text(r["id"], language, **{k: v for k, v in r.items() if k != "id"}) for r in reasons],
        note=report.note,
        units=units,
        mpe=dict(zip(report.axes, report.mpe, strict=True)),
        axes=report.axes,
        findings=figures["findings"],
        statistics=figures["statistics"],
        geometry=geometry.render(g=sections(report, language, inline)),
    )


def _script_json(value: Any) -> str:
    """JSON inside a script element: no text of a job can end the element or open a comment."""
    plain = json.dumps(value, separators=(",", ":"), allow_nan=False, ensure_ascii=True)
    return plain.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _write_blocks(path: Path, rows: list[dict[str, Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        if not rows:
            return
        writer = csv.DictWriter(file, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def _write_pictures(report: ReportInput, folder: Path) -> None:
    from toolpaths.raster import path_picture, write_png

    folder.mkdir(exist_ok=True)
    points, rapid = report.polyline["points"], report.polyline["rapid"]
    limit_um = report.run["verdict"]["tolerance_mm"] * 1e3
    deviation_um, signed_um = report.plot_deviation_mm * 1e3, report.plot_signed_mm * 1e3
    shown = ~gaps(report)
    for name, (a, b) in views(report.axes).items():
        plane, axes = points[:, [a, b]], (report.axes[a], report.axes[b])
        picture = path_picture(plane, rapid, deviation_um, limit_um, axes=axes, shown=shown)
        write_png(folder / f"path-{name.lower()}.png", picture)
        if (a, b) == (0, 1):  # the plane in which deviations have a sign
            picture = path_picture(plane, rapid, deviation_um, limit_um, axes=axes, shown=shown, signed_um=signed_um)
            write_png(folder / f"path-{name.lower()}-magnified.png", picture)


def path_png(report: ReportInput) -> bytes:
    """The path in the plane of the first two axes, coloured by its deviation, as PNG."""
    import cv2

    from toolpaths.raster import path_picture

    limit_um = report.run["verdict"]["tolerance_mm"] * 1e3
    points, rapid = report.polyline["points"], report.polyline["rapid"]
    plane = points[:, [0, min(1, points.shape[1] - 1)]]
    names = (report.axes[0], report.axes[min(1, len(report.axes) - 1)])
    picture = path_picture(plane, rapid, report.plot_deviation_mm * 1e3, limit_um, axes=names, shown=~gaps(report))
    return bytes(cv2.imencode(".png", picture)[1])


def views(axes: list[str]) -> dict[str, tuple[int, int]]:
    """Pairs of axes that a path is looked at in."""
    pairs = [(a, b) for a in range(min(3, len(axes))) for b in range(a + 1, min(3, len(axes)))]
    return {axes[a] + axes[b]: (a, b) for a, b in pairs}
