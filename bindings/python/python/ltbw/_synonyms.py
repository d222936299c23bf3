"""Names of arguments that other packages have, and what they are called here."""

import functools
import inspect

# TetGen's (Python's and its switches'), Gmsh's, fTetWild's, and slips.
SYNONYMS = {
    "switches": "each switch is an argument: -q is radius_edge, -a is max_volume, -Y is not there",
    "maxvolume": "max_volume",
    "max_vol": "max_volume",
    "volume": "max_volume",
    "minratio": "radius_edge",
    "min_ratio": "radius_edge",
    "quality": "radius_edge (on by itself: 2.0)",
    "mindihedral": "min_dihedral",
    "min_dihedral_angle": "min_dihedral",
    "lc": "size",
    "h": "size",
    "edge_length": "size",
    "element_size": "size",
    "mesh_size": "size",
    "MeshSizeMax": "size",
    "size_field": "size",
    "bgmesh": "size, an array or a function",
    "steinerleft": "max_points",
    "max_steiner": "max_points",
    "order": "linear elements alone",
    "nobisect": "not there: boundaries are split where a Delaunay mesh needs it",
    "verbose": "progress",
    "callback": "progress",
    "num_threads": "threads",
    "n_threads": "threads",
    "nthreads": "threads",
    "workers": "threads",
    "void": "holes",
    "plc": "surface",
    "furthest_site": "not there",
    "incremental": "always so: Mesh.add_points",
    "qhull_options": "not there: all is exact",
}


def helpful(function):
    """A function that names the argument that was meant where it does not know one."""
    known = inspect.signature(function).parameters

    @functools.wraps(function)
    def called(*args, **kwargs):
        unknown = next((name for name in kwargs if name not in known), None)
        if unknown is None:
            return function(*args, **kwargs)
        text = f"{function.__name__}() has no argument {unknown!r}"
        meant = SYNONYMS.get(unknown)
        if meant is None:
            import difflib

            close = difflib.get_close_matches(unknown, known, 1)
            meant = close[0] if close else None
        raise TypeError(text if meant is None else f"{text}: {meant}")

    return called
