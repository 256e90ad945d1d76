"""Small drawings for tests."""

from __future__ import annotations

import io

import ezdxf
from ezdxf.document import Drawing


def _saved(document: Drawing) -> bytes:
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue().encode()


def square_dxf(side: float) -> bytes:
    """A square with a corner at zero."""
    document = ezdxf.new(units=4)
    corners = [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)]
    document.modelspace().add_lwpolyline(corners, close=True)
    return _saved(document)


def circle_dxf(radius: float) -> bytes:
    """A circle about zero."""
    document = ezdxf.new(units=4)
    document.modelspace().add_circle((0, 0), radius)
    return _saved(document)


def box_stl(low: tuple[float, float, float], high: tuple[float, float, float]) -> bytes:
    """A cuboid as ASCII STL."""
    import trimesh

    data = trimesh.creation.box(bounds=[low, high]).export(file_type="stl_ascii")
    return data if isinstance(data, bytes) else data.encode()
