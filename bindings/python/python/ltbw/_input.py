"""Points and surfaces, as users have them, made into arrays."""

import os

import numpy as np

from . import _markers
from ._errors import InputError


def coordinates(points, what="points"):
    """An array of shape (n, 3), float64, in C order; anything that numpy takes for one."""
    try:
        array = np.asarray(points)
        if array.dtype == object or array.dtype.kind not in "fiu":
            raise InputError(f"{what}: numbers are wanted, not {array.dtype}", "points.type")
        array = np.ascontiguousarray(array, dtype=np.float64)
    except (TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{what}: {error}", "points.type") from error
    if array.size == 0 and array.ndim < 2:
        array = array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"{what}: shape (n, 3) is wanted, not {array.shape}", "points.shape")
    return array


def corners(rows, width, what):
    """An array of shape (m, width), int64, or int32 where it is that, in C order."""
    array = np.asarray(rows)
    if array.size == 0:
        return np.zeros((0, width), dtype=np.int64)
    if array.dtype.kind not in "iu":
        raise InputError(f"{what}: whole numbers are wanted, not {array.dtype}", f"{what}.type")
    if array.ndim != 2 or array.shape[1] != width:
        raise InputError(f"{what}: shape (m, {width}) is wanted, not {array.shape}", f"{what}.shape")
    return np.ascontiguousarray(array, dtype=np.int32 if array.dtype == np.int32 else np.int64)


def _rows(faces):
    """Flat corners and the place where each polygon begins."""
    if isinstance(faces, np.ndarray) and faces.ndim == 2:
        if faces.dtype.kind not in "iu":
            raise InputError(f"faces: whole numbers are wanted, not {faces.dtype}", "faces.type")
        starts = range(0, faces.size, faces.shape[1]) if faces.size else range(0)
        return faces.ravel().tolist(), list(starts)
    flat, starts = [], []
    for face in faces:
        starts.append(len(flat))
        flat.extend(int(v) for v in face)
    return flat, starts


def _padded(faces):
    """Polygons as pyvista has them: a count, then as many corners."""
    faces = np.asarray(faces).tolist()
    flat, starts, at = [], [], 0
    while at < len(faces):
        count = faces[at]
        if count < 0 or at + 1 + count > len(faces):
            raise InputError(f"faces: a count of {count} at {at}", "faces.layout", [at])
        starts.append(len(flat))
        flat.extend(faces[at + 1 : at + 1 + count])
        at += 1 + count
    return flat, starts


def _of_faces(poly, count):
    """The markers among pyvista's data of cells: vertices, lines, then the faces."""
    cells = getattr(poly, "cell_data", {})
    before = 0 if poly.n_cells == count else poly.n_verts + poly.n_lines
    arrays = [(name, np.asarray(cells[name])[before : before + count]) for name in cells.keys()]
    return _markers.among(arrays)


def surface(given):
    """What the native half takes for a source: a path, or vertices, corners, starts, markers."""
    if isinstance(given, (str, os.PathLike)):
        return os.fspath(given)
    if isinstance(given, tuple) and len(given) in (2, 3):
        flat, starts = _rows(given[1] if isinstance(given[1], np.ndarray) else list(given[1]))
        markers = [int(m) for m in given[2]] if len(given) == 3 and given[2] is not None else None
        if markers is not None and len(markers) != len(starts):
            text = f"{len(markers)} markers for {len(starts)} faces"
            raise InputError(text, "faces.markers")
        return coordinates(given[0], "vertices"), flat, starts, markers
    # pyvista: PolyData has `faces` in one line, and `points`.
    if hasattr(given, "points") and hasattr(given, "faces"):
        flat, starts = _padded(given.faces)
        return coordinates(given.points, "points"), flat, starts, _of_faces(given, len(starts))
    # meshio: cells in blocks by kind.
    if hasattr(given, "points") and hasattr(given, "cells"):
        flat, starts, taken = [], [], []
        for k, block in enumerate(given.cells):
            if block.type in ("triangle", "quad", "polygon"):
                own, places = _rows(np.asarray(block.data))
                starts.extend(len(flat) + place for place in places)
                flat.extend(own)
                taken.append(k)
        data = getattr(given, "cell_data", {})
        named = ((n, v) for n, v in data.items() if taken and n in _markers.NAMES)
        arrays = [(n, np.concatenate([v[k] for k in taken])) for n, v in named]
        return coordinates(given.points, "points"), flat, starts, _markers.among(arrays)
    # trimesh and others.
    if hasattr(given, "vertices") and hasattr(given, "faces"):
        flat, starts = _rows(np.asarray(given.faces))
        data = getattr(given, "face_attributes", {})
        return coordinates(given.vertices, "vertices"), flat, starts, _markers.among(data.items())
    raise InputError(
        "a surface is a path, (vertices, faces), a pyvista PolyData, or a meshio mesh, "
        f"not {type(given).__name__}",
        "surface.type",
    )


def bounds(max_volume, radius_edge, flat_tolerance):
    """Bounds by their names, as numbers."""
    given = {
        "max_volume": max_volume,
        "radius_edge": radius_edge,
        "flat_tolerance": flat_tolerance,
    }
    return {name: None if value is None else float(value) for name, value in given.items()}


def wishes(**given):
    """All that the native half wants to know of a domain's mesh, with the usual values."""
    usual = {
        "max_volume": None,
        "radius_edge": None,
        "size": None,
        "max_points": None,
        "holes": None,
        "regions": [],
        "repair": 0.0,
        "flat_tolerance": None,
        "exact_input": False,
        "check": True,
        "threads": 1,
    }
    return {**usual, **given}


def size(given):
    """A wanted edge length: a number, one for each vertex, or a function of the place."""
    if given is None or callable(given):
        return given
    array = np.asarray(given)
    if array.dtype.kind not in "fiu" or array.ndim > 1:
        raise InputError("size: a number, one for each vertex, or a function", "size.type")
    if array.ndim == 0:
        return float(array)
    return [float(s) for s in array]
