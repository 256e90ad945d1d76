"""Meshes of parts, blanks and fixtures: read through trimesh, refused unless they are closed bodies."""

from __future__ import annotations

import io
import logging
import zipfile
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Formats by the end of the file's name.
FORMATS = ("stl", "ply", "3mf")
#: Largest file and what it may unpack to, bytes; most triangles; farthest coordinate, mm.
FILE_BYTES = 256 << 20
UNPACKED_BYTES = 1 << 30
MOST_TRIANGLES = 5_000_000
FARTHEST_MM = 1e5

#: Corners of n triangles, mm: (n, 3, 3), counter-clockwise seen from outside.
Triangles = NDArray[np.float64]


class GeometryError(ValueError):
    """A mesh or drawing that cannot be used; the text says why."""


def read_mesh(data: bytes, kind: str, scale: float = 1.0) -> Triangles:
    """The triangles of a closed body from the bytes of an STL, PLY or 3MF file, times `scale` (25.4 for inches).

    Raises GeometryError for what is no mesh, empty, not finite, too large, open or turned inside out.
    """
    import trimesh

    logging.getLogger("trimesh").setLevel(logging.CRITICAL)  # what it did not like comes with the exception
    _check_size(data, kind)
    try:
        with np.errstate(all="ignore"):  # numbers that are none are refused below
            loaded: Any = trimesh.load_mesh(io.BytesIO(data), file_type=kind, process=True)
    except Exception as error:  # a reader of foreign files may raise anything
        raise GeometryError(f"cannot be read as {kind.upper()}: {error or type(error).__name__}") from None
    faces = getattr(loaded, "faces", None)
    if faces is None or len(faces) == 0:
        raise GeometryError("holds no triangles")
    if len(faces) > MOST_TRIANGLES:
        raise GeometryError(f"has {len(faces)} triangles, at most {MOST_TRIANGLES} are read")
    corners = np.asarray(loaded.triangles, dtype=np.float64) * scale
    if not np.isfinite(corners).all():
        raise GeometryError("has corners that are no numbers")
    if np.abs(corners).max() > FARTHEST_MM:
        raise GeometryError(f"reaches farther than {FARTHEST_MM:g} mm from its origin; check its unit")
    if not loaded.is_watertight:
        raise GeometryError("is not closed: some edges belong to one triangle only")
    if not loaded.is_winding_consistent or loaded.volume <= 0:
        raise GeometryError("has triangles that are turned inside out")
    return np.ascontiguousarray(corners)


def _check_size(data: bytes, kind: str) -> None:
    if kind not in FORMATS:
        raise GeometryError(f"is no {', '.join(name.upper() for name in FORMATS)} file")
    if len(data) > FILE_BYTES:
        raise GeometryError(f"is larger than {FILE_BYTES >> 20} MiB")
    if kind != "3mf":
        return
    try:
        unpacked = sum(info.file_size for info in zipfile.ZipFile(io.BytesIO(data)).infolist())
    except Exception as error:  # a reader of foreign files may raise anything
        raise GeometryError(f"cannot be read as 3MF: {error}") from None
    if unpacked > UNPACKED_BYTES:
        raise GeometryError(f"unpacks to more than {UNPACKED_BYTES >> 20} MiB")


def section(triangles: Triangles, z: float) -> NDArray[np.float64]:
    """The cut of a body with the plane at height `z`: segments (n, 2, 3). Raises GeometryError where there is none."""
    import trimesh

    body = trimesh.Trimesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), process=False)
    cut: Any = trimesh.intersections.mesh_plane
    found = np.asarray(cut(body, (0.0, 0.0, 1.0), (0.0, 0.0, z)), dtype=np.float64)
    lines: NDArray[np.float64] = found.reshape(-1, 2, 3)
    lines = lines[np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) > 0]
    if len(lines) == 0:
        low, high = triangles[..., 2].min(), triangles[..., 2].max()
        raise GeometryError(f"has no section at Z {z:g} (it reaches from {low:g} to {high:g})")
    return lines
