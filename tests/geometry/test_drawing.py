"""Drawings and meshes: what DXF, SVG, STL, PLY and 3MF say in millimetres, and what is refused."""

from __future__ import annotations

import contextlib
import io
import math
import time

import ezdxf
import numpy as np
import pytest
import trimesh
from ezdxf.document import Drawing as Document

from toolpaths.drawing import ARC, SEGMENT, read_drawing
from toolpaths.meshes import GeometryError, read_mesh, section


def saved(document: Document) -> bytes:
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue().encode()


def test_lines_arcs_circles_and_bulges_stay_exact() -> None:
    document = ezdxf.new(units=4)
    space = document.modelspace()
    space.add_line((0, 0), (3, 4))
    space.add_circle((10, 0), 2)
    space.add_arc((0, 0), 5, 350, 20)
    space.add_lwpolyline([(0, 0, 1.0), (2, 0, 0.0)], format="xyb", close=True)
    space.add_text("no contour")
    drawing = read_drawing(saved(document), "dxf")
    assert drawing.kinds.tolist() == [SEGMENT, ARC, ARC, ARC, SEGMENT]
    half_turn = math.pi * 1.0
    assert drawing.lengths() == pytest.approx([5, 4 * math.pi, 5 * math.radians(30), half_turn, 2])
    assert drawing.skipped == {"TEXT": 1}


@pytest.mark.parametrize(("unit", "mm"), [(1, 25.4), (4, 1.0), (5, 10.0), (6, 1000.0), (0, 1.0)])
def test_units_of_a_dxf_file(unit: int, mm: float) -> None:
    document = ezdxf.new()
    document.header["$INSUNITS"] = unit
    document.modelspace().add_line((0, 0), (2, 0))
    assert read_drawing(saved(document), "dxf").lengths() == pytest.approx([2 * mm])
    assert read_drawing(saved(document), "dxf", 25.4).lengths() == pytest.approx([50.8])


def test_blocks_turned_over_arcs_layers_and_curves() -> None:
    document = ezdxf.new(units=4)
    space = document.modelspace()
    document.layers.add("OFF").off()
    block = document.blocks.new("B")
    block.add_line((0, 0), (1, 0))
    space.add_blockref("B", (10, 20), dxfattribs={"rotation": 90, "layer": "PART"})
    space.add_line((0, 0), (9, 9), dxfattribs={"layer": "OFF"})
    space.add_arc((5, 0), 1, 0, 90, dxfattribs={"extrusion": (0, 0, -1)})
    space.add_ellipse((0, 0), (4, 0), 0.5)
    drawing = read_drawing(saved(document), "dxf")
    assert drawing.data[0, :6] == pytest.approx([10, 20, 0, 10, 21, 0])
    turned = drawing.data[1]
    ends = [
        (turned[0] + turned[2] * math.cos(a), turned[1] + turned[2] * math.sin(a))
        for a in (turned[3], turned[3] + turned[4])
    ]
    assert np.array(ends) == pytest.approx(np.array([(-6, 0), (-5, 1)]), abs=1e-9)
    chords = drawing.data[2:, :2]
    assert np.abs((chords[:, 0] / 4) ** 2 + (chords[:, 1] / 2) ** 2 - 1).max() < 1e-9
    on_layer = read_drawing(saved(document), "dxf", layer="part")
    assert len(on_layer.kinds) == 1
    with pytest.raises(GeometryError, match="layer NONE"):
        read_drawing(saved(document), "dxf", layer="NONE")


def test_a_block_in_itself_ends() -> None:
    document = ezdxf.new(units=4)
    block = document.blocks.new("B")
    block.add_blockref("B", (1, 0))
    document.modelspace().add_blockref("B", (0, 0))
    with pytest.raises(GeometryError):
        read_drawing(saved(document), "dxf")


SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="50mm" viewBox="0 0 200 100">
<g transform="translate(20 0)"><path d="M0 100 L40 100 A20 20 0 0 0 40 60 C40 20 0 20 0 60 Z"/></g>
<circle cx="100" cy="50" r="10"/><text x="0" y="0">no</text></svg>"""


def test_svg_in_millimetres_with_its_page_upright() -> None:
    drawing = read_drawing(SVG.encode(), "svg")
    assert drawing.data[0, :6] == pytest.approx([10, 0, 0, 30, 0, 0]), "two units a mm, the lower edge is 0"
    kind, arc = drawing.kinds[1], drawing.data[1]
    assert kind == ARC and arc[:3] == pytest.approx([30, 10, 10])
    assert arc[3] == pytest.approx(-math.pi / 2) and arc[4] == pytest.approx(math.pi), "right of the centre, upwards"
    t = np.linspace(0, 1, 2001)[:, None]
    a, b, c, d = (np.array(p, dtype=float) / 2 for p in ((60, 40), (60, 80), (20, 80), (20, 40)))
    curve = a * (1 - t) ** 3 + 3 * b * t * (1 - t) ** 2 + 3 * c * t**2 * (1 - t) + d * t**3
    chords = drawing.data[2:, :][(drawing.kinds[2:] == SEGMENT) & (drawing.data[2:, 0] != drawing.data[2:, 3])]
    ends = chords[:, 0:2]
    nearest = np.sqrt(((curve[:, None] - ends[None]) ** 2).sum(axis=2)).min(axis=0)
    assert nearest.max() < 0.02
    assert drawing.skipped == {"TEXT": 1}
    circles = drawing.kinds == ARC
    assert drawing.lengths()[circles][1:].sum() == pytest.approx(2 * math.pi * 5, abs=1e-12)


def test_flattened_curves_keep_their_tolerance() -> None:
    page = '<svg xmlns="http://www.w3.org/2000/svg" width="50mm" height="50mm" viewBox="0 0 50 50">'
    text = page + '<ellipse cx="25" cy="25" rx="20" ry="5"/></svg>'
    drawing = read_drawing(text.encode(), "svg")
    middle = (drawing.data[:, 0:2] + drawing.data[:, 3:5]) / 2 - 25.0
    inside = 1 - np.hypot(middle[:, 0] / 20, middle[:, 1] / 5)
    assert (inside * 20).max() < 1.05e-4 and inside.min() >= -1e-12


@pytest.mark.parametrize("data", [b"", b"nothing", b"0\nSECTION\n", b"\x00\xff" * 50, b"<svg", b"<html></html>"])
@pytest.mark.parametrize("kind", ["dxf", "svg"])
def test_nonsense_is_refused(kind: str, data: bytes) -> None:
    with pytest.raises(GeometryError):
        read_drawing(data, kind)


@pytest.mark.parametrize("far", ["99999999", "-1e300", "1e9"])
def test_a_curve_to_far_away_is_refused_at_once(far: str) -> None:
    text = f'<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0 C0 9 {far} 5 9 9 A9 {far} 0 0 1 3 3"/></svg>'
    begun = time.monotonic()
    with pytest.raises(GeometryError, match="unit"):
        read_drawing(text.encode(), "svg")
    assert time.monotonic() - begun < 5


def test_coordinates_that_are_no_lengths_are_refused() -> None:
    document = ezdxf.new(units=4)
    document.modelspace().add_line((0, 0), (1e9, 0))
    with pytest.raises(GeometryError, match="unit"):
        read_drawing(saved(document), "dxf")


# ---- meshes


def exported(mesh: trimesh.Trimesh, kind: str) -> bytes:
    data = mesh.export(file_type=kind)
    return data if isinstance(data, bytes) else data.encode()


@pytest.mark.parametrize("kind", ["stl", "stl_ascii", "ply", "3mf"])
def test_meshes_of_all_formats(kind: str) -> None:
    mesh = trimesh.creation.box(extents=(10, 20, 30))
    triangles = read_mesh(exported(mesh, kind), kind.split("_")[0], 2.0)
    assert triangles.shape == (12, 3, 3)
    assert triangles.max(axis=(0, 1)) == pytest.approx([10, 20, 30])


def broken(change: str) -> bytes:
    mesh = trimesh.creation.box(extents=(10, 20, 30))
    triangles = np.array(mesh.triangles)
    if change == "open":
        triangles = triangles[:-1]
    elif change == "nan":
        triangles[0, 0, 0] = np.nan
    elif change == "huge":
        triangles *= 1e6
    elif change == "inside out":
        triangles = triangles[:, ::-1]
    elif change == "one turned":
        triangles[0] = triangles[0][::-1]
    elif change == "empty":
        return b"solid x\nendsolid x\n"
    rows = ["solid x"]
    for triangle in triangles:
        rows += [
            "facet normal 0 0 0",
            "outer loop",
            *(f"vertex {x:.9g} {y:.9g} {z:.9g}" for x, y, z in triangle),
            "endloop",
            "endfacet",
        ]
    return "\n".join([*rows, "endsolid x", ""]).encode()


@pytest.mark.parametrize("change", ["open", "nan", "huge", "inside out", "one turned", "empty"])
def test_meshes_that_are_no_bodies_are_refused(change: str) -> None:
    assert len(read_mesh(broken(""), "stl")) == 12
    with pytest.raises(GeometryError):
        read_mesh(broken(change), "stl")


@pytest.mark.parametrize("kind", ["stl", "ply", "3mf"])
@pytest.mark.parametrize(
    "data", [b"", b"x", b"ply\nformat ascii 1.0\nend_header\n", b"PK\x03\x04" + b"\0" * 100, bytes(range(256)) * 4]
)
def test_nonsense_is_no_mesh(kind: str, data: bytes) -> None:
    with pytest.raises(GeometryError):
        read_mesh(data, kind)


def test_a_damaged_3mf_is_refused() -> None:
    data = bytearray(exported(trimesh.creation.box(), "3mf"))
    for place in range(0, len(data), 7):
        damaged = data.copy()
        damaged[place] ^= 0x5A
        with contextlib.suppress(GeometryError):
            read_mesh(bytes(damaged), "3mf")


def test_the_section_of_a_body() -> None:
    triangles = read_mesh(broken(""), "stl")
    lines = section(triangles, 1.0)
    assert np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum() == pytest.approx(60)
    with pytest.raises(GeometryError, match="no section"):
        section(triangles, 99.0)
