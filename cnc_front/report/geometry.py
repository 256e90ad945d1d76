"""Sections of the report for drawing, collisions and material: pictures and words; the figures are those of the run."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

from cnc_front.messages import text
from cnc_front.report.data import ReportInput

#: Findings in the table of the page; report.json lists more.
ROWS = 100

WORDS: dict[str, dict[str, str]] = {
    "en": {
        "reference": "Against the drawing",
        "drawing": "drawing",
        "contour": "contour",
        "surface": "surface",
        "pieces": "pieces",
        "skipped": "left out",
        "offset": "offset",
        "capture": "capture",
        "plus_is": "+ is",
        "left": "left of the motion",
        "outside": "outside",
        "material left": "material left",
        "max": "max",
        "rms": "RMS",
        "plus": "+",
        "minus": "-",
        "line": "line",
        "setpoint": "set point",
        "actual": "actual (load side)",
        "driven": "driven mm",
        "extra": "not of the drawing mm",
        "wrong_side": "wrong side mm",
        "missing": "Not driven",
        "of": "of",
        "from": "from",
        "to": "to",
        "length": "length mm",
        "nothing": "nothing",
        "collisions": "Collisions and rapids through material",
        "what": "what",
        "body": "body",
        "tool": "tool",
        "size": "depth mm",
        "time": "time s",
        "largest": "the largest {shown} of {all}",
        "material": "Material",
        "removed": "removed",
        "nodes": "nodes",
        "rest": "rest",
        "gouge": "gouge",
        "limit": "limit µm",
        "judged": "judged",
        "yes": "yes",
        "no": "no",
        "area": "area above limit mm²",
        "volume": "volume above limit mm³",
        "place": "place",
        "along_z": "Along Z at the nodes of the map; within a cell of a wall of the target only what exceeds the wall.",
        "follows": "cut along",
    },
    "de": {
        "reference": "Gegen die Zeichnung",
        "drawing": "Zeichnung",
        "contour": "Kontur",
        "surface": "Fläche",
        "pieces": "Stücke",
        "skipped": "ausgelassen",
        "offset": "Versatz",
        "capture": "Fangabstand",
        "plus_is": "+ heißt",
        "left": "links der Bewegung",
        "outside": "außen",
        "material left": "Material bleibt stehen",
        "max": "max",
        "rms": "RMS",
        "plus": "+",
        "minus": "-",
        "line": "Zeile",
        "setpoint": "Soll",
        "actual": "Ist (Lastseite)",
        "driven": "gefahren mm",
        "extra": "nicht aus der Zeichnung mm",
        "wrong_side": "falsche Seite mm",
        "missing": "Nicht gefahren",
        "of": "von",
        "from": "von",
        "to": "bis",
        "length": "Länge mm",
        "nothing": "nichts",
        "collisions": "Kollisionen und Eilgang durch Material",
        "what": "was",
        "body": "Körper",
        "tool": "Werkzeug",
        "size": "Tiefe mm",
        "time": "Zeit s",
        "largest": "die größten {shown} von {all}",
        "material": "Material",
        "removed": "abgetragen",
        "nodes": "Knoten",
        "rest": "Restmaterial",
        "gouge": "Untermaß",
        "limit": "Grenze µm",
        "judged": "bewertet",
        "yes": "ja",
        "no": "nein",
        "area": "Fläche über Grenze mm²",
        "volume": "Volumen über Grenze mm³",
        "place": "Stelle",
        "along_z": "Längs Z an den Knoten; bis eine Zelle neben Wänden des Fertigteils nur, was über sie hinausgeht.",
        "follows": "geschnitten längs",
    },
}


def pictures(report: ReportInput) -> dict[str, Any]:
    """Images by the names of their files."""
    checks = report.checks
    if checks is None:
        return {}
    from toolpaths.relief import difference_picture, height_picture, reference_picture

    drawn: dict[str, Any] = {}
    limit_um = report.run["verdict"]["tolerance_mm"] * 1e3
    if checks.reference is not None:
        reference = checks.figures["reference"]
        plot = checks.meters["actual"].plot()
        missing, worst = reference["missing"] or [], reference["actual"]["worst"]
        drawn["reference"] = reference_picture(checks.reference.drawing, plot, limit_um, missing, worst)
    if checks.removal is not None and checks.removal.stock is not None:
        grid = checks.setup.shop.grid
        drawn["material"] = height_picture(checks.removal.stock.z(), grid, checks.listed(), checks.setup.shop.fixtures)
        if checks.compared is not None:
            target = checks.figures["material"]["target"]
            sides = (target["rest"], target["gouge"])
            drawn["material-target"] = difference_picture(checks.compared.difference, grid, *sides)
    return drawn


def write_pictures(report: ReportInput, folder: Path) -> dict[str, str]:
    """Writes the pictures as PNG into a folder; returns them as data for the page."""
    from toolpaths.raster import write_png

    folder.mkdir(exist_ok=True)
    inline = {}
    for name, image in pictures(report).items():
        path = folder / f"{name}.png"
        write_png(path, image)
        inline[name] = "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")
    return inline


def sections(report: ReportInput, language: str, inline: dict[str, str]) -> dict[str, Any]:
    """What the templates of the sections need."""
    run = report.run
    collisions = run.get("collisions")
    rows = []
    for number, found in enumerate(collisions["findings"] if collisions else [], 1):
        rows.append(found | {"number": number, "what": text(found["kind"], language)})
    rows = sorted(rows, key=lambda row: -row["size_mm"])[:ROWS]
    names = {key: run.get(key) for key in ("reference", "material", "collisions")}
    return names | {"rows": rows, "pictures": inline, "w": WORDS[language], "stock": text("stock", language)}
