"""Meshes a surface with TetGen (the package `tetgen`), for `cargo xtask parts`.

    parts.py SURFACE.poly

SURFACE is a .poly file of triangles as ltbw writes it. Switches `pq2/0Q`: radius-edge ratio 2, no
bound on dihedral angles. Prints the number of tetrahedra and the processor seconds of the call.
"""

import sys
import time

import tetgen
from run import read


def main():
    points, triangles, holes = read(sys.argv[1])
    mesher = tetgen.TetGen(points, triangles)
    for hole in holes:
        mesher.add_hole(hole)
    start = time.process_time()
    mesher.tetrahedralize(switches="pq2/0Q")
    print("result", len(mesher.elem), time.process_time() - start)


main()
