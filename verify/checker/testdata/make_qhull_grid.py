#!/usr/bin/env python3
"""Writes qhull_grid_4x4x4.txt: a 4 x 4 x 4 integer grid meshed by scipy (Qhull).

Qhull splits cospherical cells without regard to flat simplices: of the 200 tetrahedra, 38 have
volume exactly zero. The checker must find them. Written with scipy 1.17.1; should another version
give other counts, the script refuses to write.

    pip install scipy && python3 make_qhull_grid.py

Format: "points N", N lines of three coordinates, "tets T", T lines of four indices from 0.
"""

import itertools
import pathlib

import numpy as np
import scipy.spatial

points = np.array(list(itertools.product(range(4), repeat=3)), dtype=float)
tets = scipy.spatial.Delaunay(points).simplices
edges = (points[tets[:, 1:]] - points[tets[:, :1]]).astype(int)
a, b, c = edges[:, 0], edges[:, 1], edges[:, 2]
flat = int(np.sum(np.sum(a * np.cross(b, c), axis=1) == 0))
print(f"scipy {scipy.__version__}: {len(tets)} tetrahedra, {flat} flat")
if (len(tets), flat) != (200, 38):
    raise SystemExit("expected 200 tetrahedra, 38 of them flat: not written")

lines = [f"points {len(points)}"]
lines += [" ".join(str(int(x)) for x in p) for p in points]
lines += [f"tets {len(tets)}"]
lines += [" ".join(str(int(v)) for v in t) for t in tets]
target = pathlib.Path(__file__).with_name("qhull_grid_4x4x4.txt")
target.write_text("\n".join(lines) + "\n")
