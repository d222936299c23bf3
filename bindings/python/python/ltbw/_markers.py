"""Markers of facets among the data that surfaces of other packages carry."""

import os
import sys
import warnings

import numpy as np

HERE = os.path.dirname(__file__)

# Arrays of cells that are markers, by the names that meshio, Gmsh, Medit, TetGen, VTK and this package
# give them; the first that is there is taken.
NAMES = (
    "marker",
    "ltbw:marker",
    "gmsh:physical",
    "medit:ref",
    "tetgen:ref",
    "markers",
    "MarkerId",
    "MarkerID",
    "marker_id",
    "face_marker",
    "face_markers",
    "BoundaryMarker",
    "boundary_marker",
)


def warn(text):
    """Warns at the line outside this package that called it."""
    level, frame = 2, sys._getframe(1)
    while frame.f_back is not None and os.path.dirname(frame.f_code.co_filename) == HERE:
        level, frame = level + 1, frame.f_back
    warnings.warn(text, UserWarning, stacklevel=level - 1)


def _warn(text):
    warn(f"surface: {text}")


def _whole(name, values):
    """The values as a list of whole numbers, or None with a warning."""
    array = np.asarray(values)
    if array.ndim != 1 or array.dtype.kind not in "iuf" or (array != np.trunc(array)).any():
        _warn(f"{name!r} is not a whole number for each face: not taken for markers")
        return None
    if array.size and not (-(2**31) <= array.min() and array.max() < 2**31):
        _warn(f"{name!r} has numbers beyond 32 bits: not taken for markers")
        return None
    return [int(m) for m in array]


def among(arrays):
    """The markers among named arrays of faces, or None.

    ``arrays`` are pairs of a name and a value for each face.
    """
    found = {}
    for name, values in sorted(
        ((n, v) for n, v in arrays if n in NAMES), key=lambda pair: NAMES.index(pair[0])
    ):
        whole = _whole(name, values)
        if whole is not None:
            found[name] = whole
    if not found:
        return None
    (name, markers), *others = found.items()
    different = [other for other, values in others if values != markers]
    if different:
        _warn(f"{name!r} is taken for markers, not {', '.join(map(repr, different))}")
    return markers
