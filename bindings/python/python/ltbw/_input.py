"""Points and surfaces, as users have them, made into arrays."""

import inspect
import math
import operator
import os

import numpy as np

from . import _markers, _native
from .errors import InputError


def coordinates(points, what="points"):
    """An array of shape (n, 3), float64, in C order; anything that numpy takes for one."""
    if np.ma.is_masked(points):
        raise InputError(f"{what}: some are masked", "points.masked")
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


def places(given):
    """Points as :func:`ltbw.delaunay` takes them: an array, a path, or what has ``points``."""
    if isinstance(given, (str, os.PathLike)):
        return _native.read_points(os.fspath(given))
    if not isinstance(given, np.ndarray) and hasattr(given, "points"):
        given = given.points
    return coordinates(given)


def number(given, what, code):
    """A float; not a bool, not a text."""
    try:
        if isinstance(given, (bool, np.bool_, str, bytes)):
            raise TypeError
        return float(given)
    except (TypeError, ValueError):
        raise InputError(f"{what}: a number, not {given!r}", code) from None


def whole(given, what, code, least, most):
    """A whole number within limits; floats that are whole are taken, too."""
    try:
        if isinstance(given, (float, np.floating)):
            value = int(given)
            if value != given:
                raise TypeError
        else:
            value = operator.index(given)
        if isinstance(given, (bool, np.bool_)) or not least <= value <= most:
            raise TypeError
        return value
    except (TypeError, ValueError, OverflowError):
        text = f"{what}: a whole number from {least} to {most}, not {given!r}"
        raise InputError(text, code) from None


def numbers(given, what, code):
    """A list of numbers of points."""
    array = np.asarray(given)
    if array.size == 0:
        return []
    if array.ndim != 1 or array.dtype.kind not in "iu":
        text = f"{what}: a list of whole numbers is wanted, not {array.dtype} of shape {array.shape}"
        raise InputError(text, code)
    if not 0 <= int(array.min()) <= int(array.max()) < 2**32:
        raise InputError(f"{what}: numbers from 0 on are wanted", "without.unknown")
    return array.tolist()


def truth(given, what):
    """A bool, Python's or numpy's."""
    if isinstance(given, (bool, np.bool_)):
        return bool(given)
    raise InputError(f"{what}: True or False, not {given!r}", f"{what}.type")


def function(given, what):
    """A function or None."""
    if given is None or callable(given):
        return given
    raise InputError(f"{what}: a function, not {given!r}", f"{what}.type")


def corners(rows, width, what):
    """An array of shape (m, width), int64, or int32 where it is that, in C order."""
    try:
        array = np.asarray(rows)
    except ValueError as error:
        raise InputError(f"{what}: {error}", f"{what}.shape") from error
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
    for number, face in enumerate(faces):
        starts.append(len(flat))
        try:
            flat.extend(operator.index(v) for v in face)
        except TypeError:
            text = f"face {number}: whole numbers of corners are wanted, not {face!r}"
            raise InputError(text, "faces.type", [number]) from None
    return flat, starts


def _markers_of(given, count):
    """A marker for each of ``count`` faces."""
    limits = ("faces.markers", -(2**31), 2**31 - 1)
    given = list(given)
    if len(given) != count:
        raise InputError(f"{len(given)} markers for {count} faces", "faces.markers")
    return [whole(m, f"marker of face {k}", *limits) for k, m in enumerate(given)]


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
        markers = None
        if len(given) == 3 and given[2] is not None:
            markers = _markers_of(given[2], len(starts))
        return coordinates(given[0], "vertices"), flat, starts, markers
    # pyvista: grids have cells of any kind, PolyData `faces` in one line; both have `points`.
    if hasattr(given, "extract_surface") and not hasattr(given, "faces"):
        kind = type(given).__name__
        text = f"a pyvista {kind} is no surface: give its extract_surface()"
        raise InputError(text, "surface.type")
    if getattr(given, "n_strips", 0):
        given = given.triangulate()
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
    # An infinite bound bounds nothing.
    return {
        name: None if value is None or value == math.inf else number(value, name, f"{name}.type")
        for name, value in given.items()
    }


def holes(given):
    """What is void, as the native half takes it: None, whether bodies inside others are, points."""
    if given is None:
        return None
    if isinstance(given, str):
        if given in ("none", "auto"):
            return given == "auto"
        raise InputError(f"holes: 'none', 'auto' or points, not {given!r}", "holes.name")
    return coordinates(given, "holes").tolist()


FRAMES = {"auto": None, "own": True, "local": False}


def frame(given):
    """The frame's name as the native half takes it."""
    if isinstance(given, str) and given in FRAMES:
        return FRAMES[given]
    raise InputError(f"frame: 'auto', 'own' or 'local', not {given!r}", "frame.name")


def wishes(**given):
    """All that the native half wants to know of a domain's mesh, with the usual values."""
    usual = {
        "max_volume": None,
        "radius_edge": None,
        "min_dihedral": None,
        "smooth": 0,
        "size": None,
        "max_edge": None,
        "near": [],
        "size_at": [],
        "curvature": None,
        "growth": None,
        "max_points": None,
        "holes": None,
        "regions": [],
        "repair": 0.0,
        "fill": 0,
        "simplify": 0.0,
        "flat_tolerance": None,
        "feature_angle": None,
        "exact_input": False,
        "strict": False,
        "own_frame": None,
        "check": True,
        "excused_share": None,
        "threads": 1,
    }
    return {**usual, **given}


def size(given):
    """A wanted edge length: a number, one for each vertex, or a function of the place."""
    if given is None:
        return None
    if callable(given):
        return _of_coordinates(given)
    try:
        array = np.asarray(given)
    except ValueError:
        array = np.empty(0, object)
    if array.dtype.kind not in "fiu" or array.ndim > 1:
        raise InputError("size: a number, one for each vertex, or a function", "size.type")
    if array.ndim == 0:
        return float(array)
    return [float(s) for s in array]


def _of_coordinates(function):
    """A function of the place; one that takes three coordinates is told them one by one."""
    kinds = inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD
    try:
        own = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        # Functions of other languages may have no signature: they are asked as they always were.
        return function
    needed = [p for p in own if p.kind in kinds and p.default is p.empty]
    return (lambda p: function(*p)) if len(needed) == 3 else function


def near(given):
    """Short edges near places: a list of (place, length, radius)."""
    try:
        return [_near(*own) for own in given]
    except InputError:
        raise
    except (TypeError, ValueError):
        text = f"near: a list of (place, length) or (place, length, radius), not {given!r}"
        raise InputError(text, "near.layout") from None


def _near(place, length, radius=0.0):
    x, y, z = place
    return (float(x), float(y), float(z)), float(length), float(radius)


def size_at(given):
    """Short edges at parts of the boundary: a list of (part, length)."""
    try:
        return [(str(part), float(length)) for part, length in dict(given).items()]
    except (TypeError, ValueError):
        text = f"size_at: a dict of lengths by part (a name or a marker), not {given!r}"
        raise InputError(text, "size_at.layout") from None


def size_on(mesh, given):
    """Edge lengths at the points of a tetrahedral mesh: its points, its tetrahedra, the lengths."""
    sizes = size(given)
    if not isinstance(sizes, list):
        raise InputError("size: one for each point of the background mesh", "size.type")
    if isinstance(mesh, tuple) and len(mesh) == 2:
        points, tets = mesh
    elif hasattr(mesh, "points") and hasattr(mesh, "simplices"):
        points, tets = mesh.points, mesh.simplices
    elif hasattr(mesh, "points") and hasattr(mesh, "cells_dict"):
        points, tets = mesh.points, mesh.cells_dict.get("tetra", ())
        tets = mesh.cells_dict.get(10, tets)
    else:
        text = f"background: a mesh, or (points, tetrahedra), not {type(mesh).__name__}"
        raise InputError(text, "background.type")
    tets = corners(tets, 4, "background")
    if tets.size and not 0 <= int(tets.min()) <= int(tets.max()) < 2**32:
        raise InputError("background: it names a point that is not there", "background.index")
    return coordinates(points, "background").tolist(), tets.tolist(), sizes
