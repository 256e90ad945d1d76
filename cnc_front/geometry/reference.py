"""The drawing of `--reference`: reading the file, placing it, and its object in `run --json`."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import CompileError
from cnc_front.geometry.arguments import ReferenceOptions
from cnc_front.jobs import read_bytes, shown

if TYPE_CHECKING:
    from toolpaths.drawing import Drawing

DRAWINGS, MESHES = ("dxf", "svg"), ("stl", "ply", "3mf")
FILE_BYTES = 256 << 20
MM = {"mm": 1.0, "inch": 25.4}
#: What the sign of a deviation means, by the kind of offset.
SIGNS = {"none": "left", "left": "material left", "right": "material left", "ball": "material left"}


@dataclass(frozen=True, slots=True)
class Reference:
    """A drawing in its place, and where it came from."""

    path: str
    data: bytes
    options: ReferenceOptions
    drawing: Drawing

    def as_json(self) -> dict[str, Any]:
        """How the drawing was taken."""
        o = self.options
        plus = "outside" if self.drawing.is_surface and o.offset == "none" else SIGNS[o.offset]
        return {
            "path": shown(self.path),
            "sha256": hashlib.sha256(self.data).hexdigest(),
            "kind": "surface" if self.drawing.is_surface else "contour",
            "pieces": len(self.drawing.kinds),
            "skipped": self.drawing.skipped,
            "at": list(o.at),
            "offset": o.offset,
            "radius_mm": o.radius,
            "section_z": o.section_z,
            "capture_mm": o.capture_mm,
            "plus_is": plus,
        }


def load_reference(path: str, options: ReferenceOptions) -> Reference:
    """Reads a drawing; raises CompileError (RF100 ...)."""
    return parse_reference(read_bytes(path, FILE_BYTES, "RF100"), path, options)


def parse_reference(data: bytes, path: str, options: ReferenceOptions) -> Reference:
    """As `load_reference`, from bytes."""
    from toolpaths.drawing import contour, read_drawing, surface
    from toolpaths.meshes import GeometryError, read_mesh, section

    kind = Path(path).suffix.lower().lstrip(".")
    scale = MM[options.unit] if options.unit else None
    if kind not in (*DRAWINGS, *MESHES):
        raise CompileError(
            [_fault(path, "RF101", "is no drawing: DXF, SVG, STL, PLY or 3MF", "save it as one of these")]
        )
    if options.layer is not None and kind != "dxf":
        raise CompileError([_fault(path, "RF102", "has no layers", "give --reference-layer for DXF files only")])
    if options.section_z is not None and kind in DRAWINGS:
        raise CompileError([_fault(path, "RF102", "is flat", "give --reference-z for meshes only")])
    try:
        if kind in DRAWINGS:
            drawing = read_drawing(data, kind, scale, options.layer)
        else:
            triangles = read_mesh(data, kind, scale or 1.0)
            flat = options.section_z is not None
            drawing = contour(section(triangles, float(options.section_z or 0.0))) if flat else surface(triangles)
        if (options.offset == "ball") != drawing.is_surface and options.offset != "none":
            fits = "none or ball:R" if drawing.is_surface else "none, left:R or right:R"
            what = "surface" if drawing.is_surface else "contour"
            raise CompileError([_fault(path, "RF103", f"is a {what}", f"give --reference-offset {fits}")])
    except GeometryError as error:
        raise CompileError(
            [_fault(path, "RF104", str(error), "save the drawing again, contours and bodies only")]
        ) from None
    return Reference(path, data, options, drawing.moved(options.at))


def _fault(path: str, id: str, message: str, hint: str) -> Diagnostic:
    return Diagnostic(shown(path), 1, 1, 1, id, f"the drawing {message}", hint)
