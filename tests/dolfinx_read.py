#!/usr/bin/env python3
"""Reads a domain's mesh with DOLFINx on the processes of this job, and compares with what Gmsh reads.

usage: mpirun -n 2 python3 dolfinx_read.py WHOLE.msh

DOLFINx takes meshes of Gmsh as Gmsh has read them (`gmshio.model_to_mesh`), deals tetrahedra to the
processes, and numbers all anew. Compared are vertices, tetrahedra and volumes by region, and marked
triangles by marker. The exit code is 0 if all agree, 1 if not, and 3 if a package is missing (the
reason is on stdout).
"""

import sys
from collections import Counter

import numpy as np

try:
    import dolfinx
    import gmsh
    from dolfinx.io import gmshio
    from mpi4py import MPI
except (ImportError, OSError) as error:
    print(f"a Python package, or a library that it needs, is missing: {error}")
    sys.exit(3)


def volume(corners):
    return abs(np.linalg.det(corners[1:] - corners[0])) / 6


def of_gmsh():
    """What Gmsh has: vertices; by region tetrahedra and volume; by marker triangles."""
    tags, places, _ = gmsh.model.mesh.getNodes()
    place = dict(zip(tags, places.reshape(-1, 3)))
    counts, volumes, marked, used = Counter(), Counter(), Counter(), set()
    for dimension, tag in gmsh.model.getPhysicalGroups():
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag):
            _, _, nodes = gmsh.model.mesh.getElements(dimension, entity)
            for corners in np.concatenate(nodes).reshape(-1, dimension + 1):
                if dimension == 2:
                    marked[tag] += 1
                else:
                    counts[tag] += 1
                    volumes[tag] += volume(np.array([place[v] for v in corners]))
                    used.update(corners)
    return len(used), counts, volumes, marked


def of_dolfinx(mesh, cells, facets):
    """What this process has of it, of its own alone."""
    own = [mesh.topology.index_map(dimension).size_local for dimension in (2, 3)]
    counts, volumes, marked = Counter(), Counter(), Counter()
    for cell, tag in zip(cells.indices, cells.values):
        if cell < own[1]:
            counts[tag] += 1
            volumes[tag] += volume(mesh.geometry.x[mesh.geometry.dofmap.links(cell)])
    for facet, tag in zip(facets.indices, facets.values):
        marked[tag] += int(facet < own[0])
    return counts, volumes, marked


def main():
    comm = MPI.COMM_WORLD
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    if comm.rank == 0:
        gmsh.open(sys.argv[1])
    mesh, cells, facets = gmshio.model_to_mesh(gmsh.model, comm, 0, gdim=3)
    vertices = mesh.geometry.index_map().size_global
    found = comm.gather(of_dolfinx(mesh, cells, facets), 0)
    if comm.rank != 0:
        return 0
    counts, volumes, marked = (sum((own[k] for own in found), Counter()) for k in range(3))
    expected = of_gmsh()
    same = (vertices, counts, marked) == (expected[0], expected[1], expected[3])
    same &= all(abs(volumes[tag] / own - 1) < 1e-9 for tag, own in expected[2].items())
    print(
        f"DOLFINx {dolfinx.__version__} on {comm.size}: {vertices} vertices, {sum(counts.values())} "
        f"tetrahedra in {len(counts)} regions, {sum(marked.values())} marked triangles"
        f"{'' if same else f', Gmsh has {expected}'}"
    )
    return 0 if same and counts else 1


sys.exit(main())
