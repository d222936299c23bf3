"""Meshes a domain with TetGen (the package `tetgen`), for `cargo xtask bench refine`.

    run.py DOMAIN.poly MAX_VOLUME

DOMAIN is a .poly file as ltbw writes it, without holes in facets. Quality bound 2, no smoothing, no
optimisation: what Delaunay refinement alone takes. Prints the number of tetrahedra, the processor
seconds of the call, and the peak memory of this process in KiB.
"""

import resource
import sys
import time

import numpy
import tetgen


def read(path):
    """Vertices, triangles (a fan of each polygon) and hole points."""
    with open(path) as file:
        rows = [line.split("#")[0].split() for line in file]
    rows = iter([row for row in rows if row])
    count = int(next(rows)[0])
    points = [[float(c) for c in next(rows)[1:4]] for _ in range(count)]
    triangles = []
    for _ in range(int(next(rows)[0])):
        polygons, *rest = (int(word) for word in next(rows))
        if rest and rest[0] > 0:
            raise ValueError("facets with holes are not understood")
        for _ in range(polygons):
            corners = [int(word) for word in next(rows)]
            if corners[0] != len(corners) - 1:
                raise ValueError("polygons over several lines are not understood")
            corners = corners[1:]
            fan = zip(corners[1:], corners[2:])
            triangles += [[corners[0], a, b] for a, b in fan]
    holes = [[float(c) for c in next(rows)[1:4]] for _ in range(int(next(rows)[0]))]
    return numpy.array(points), numpy.array(triangles, dtype=numpy.int32), holes


def main():
    points, triangles, holes = read(sys.argv[1])
    mesher = tetgen.TetGen(points, triangles)
    for hole in holes:
        mesher.add_hole(hole)
    switches = f"pq2/0s0/0a{sys.argv[2]}O0/0/0CQ"
    start = time.process_time()
    mesher.tetrahedralize(switches=switches)
    seconds = time.process_time() - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print("result", len(mesher.elem), seconds, peak)


if __name__ == "__main__":
    main()
