#!/usr/bin/env python3
"""The conformance kit through the C interface: predicates, and Delaunay meshes by their hash.

    ltbw vectors run --executor python3 -- bindings/c/tests/executor.py LIBRARY
"""

import ctypes
import json
import sys

library = ctypes.CDLL(sys.argv[1])
library.ltbw_last_error.restype = ctypes.c_char_p
for name in ("tets", "hull"):
    function = getattr(library, f"ltbw_mesh_{name}")
    function.restype = ctypes.POINTER(ctypes.c_uint32)
    function.argtypes = [ctypes.c_void_p, ctypes.POINTER(ctypes.c_size_t)]
library.ltbw_delaunay.argtypes = [
    ctypes.c_void_p,
    ctypes.c_size_t,
    ctypes.c_void_p,
    ctypes.POINTER(ctypes.c_void_p),
]
library.ltbw_mesh_hash.argtypes = [ctypes.c_void_p, ctypes.c_char_p]
library.ltbw_mesh_free.argtypes = [ctypes.c_void_p]

PREDICATES = ("orient3d", "insphere", "side_of_sphere", "side_of_hull_facet")
SHOWN = 40  # meshes of so many tetrahedra or fewer are listed


def rows(mesh, name, width):
    count = ctypes.c_size_t()
    found = getattr(library, f"ltbw_mesh_{name}")(mesh, ctypes.byref(count))
    return [[found[width * k + i] for i in range(width)] for k in range(count.value)]


def answer(ask):
    points = [[float.fromhex(c) for c in point] for point in ask.get("points", [])]
    if ask["op"] in PREDICATES:
        places = [(ctypes.c_double * 3)(*point) for point in points]
        return {"sign": getattr(library, f"ltbw_{ask['op']}")(*places)}
    if ask["op"] == "delaunay":
        flat = (ctypes.c_double * (3 * len(points)))(*(c for point in points for c in point))
        mesh = ctypes.c_void_p()
        if library.ltbw_delaunay(flat, len(points), None, ctypes.byref(mesh)):
            return {"error": library.ltbw_last_error().decode()}
        hash = ctypes.create_string_buffer(65)
        library.ltbw_mesh_hash(mesh, hash)
        tets = sorted(sorted(tet) for tet in rows(mesh, "tets", 4))
        hull = len(rows(mesh, "hull", 3))
        library.ltbw_mesh_free(mesh)
        listed = tets if len(tets) <= SHOWN else None
        return {"hash": hash.value.decode(), "hull": hull, "tets": len(tets), "list": listed}
    return {"unsupported": True}


for line in sys.stdin:
    print(json.dumps(answer(json.loads(line))), flush=True)
