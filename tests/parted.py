#!/usr/bin/env python3
"""Reads the parts of a mesh with the programs that solvers take them by, and compares with the whole.

usage: parted.py FOLDER WHOLE.vtu STEM PARTS

In FOLDER are the mesh as one process writes it, and the files STEM_%.msh, STEM.mfem, STEM.pvtu and
STEM.vtkhdf of the same mesh in PARTS parts. Compared are numbers, volumes, places, and what parts share. Gmsh's
part is what deal.II calls of Gmsh in `read_partitioned_msh`. The exit code is 0 if all agree, 1 if
not, and 3 if a package is missing (the reason is on stdout). PyMFEM and h5py read files, too, if
they are there.
"""

import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

try:
    import gmsh
    import pyvista
except (ImportError, OSError) as error:
    print(f"a Python package, or a library that it needs, is missing: {error}")
    sys.exit(3)


def volumes(points, tets):
    a, b, c, d = (points[tets[:, k]] for k in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6


def places(points):
    """Points as bytes, in which the sign of zero is none."""
    return [p.tobytes() for p in np.ascontiguousarray(points, dtype=np.float64) + 0.0]


def names(points, tets):
    """Tetrahedra as sets of places."""
    all_places = places(points)
    return [frozenset(all_places[v] for v in tet) for tet in tets]


class Parts:
    """Points and tetrahedra of the parts, and which parts have what."""

    def __init__(self, what, whole, agree):
        self.what, self.whole, self.agree = what, whole, agree
        self.pieces = []

    def add(self, points, tets):
        tets = np.asarray(tets, dtype=np.int64).reshape(-1, 4)
        self.pieces.append((np.asarray(points).reshape(-1, 3), tets))

    def compare(self):
        """Compares with the whole; returns the parts of each place that several have."""
        points, tets = self.whole
        all_names = [name for piece in self.pieces for name in names(*piece)]
        self.agree(f"{self.what}: tetrahedra", len(all_names), len(tets))
        self.agree(f"{self.what}: the same", set(all_names) == set(names(points, tets)), True)
        found = sum(volumes(*piece).sum() for piece in self.pieces)
        wanted = volumes(points, tets).sum()
        self.agree(f"{self.what}: volume", bool(np.isclose(found, wanted, rtol=1e-12)), True)
        least = min((volumes(*piece).min() for piece in self.pieces if len(piece[1])), default=0)
        self.agree(f"{self.what}: oriented", bool(least > 0), bool(volumes(points, tets).min() > 0))
        owners = defaultdict(set)
        for k, (points, _) in enumerate(self.pieces):
            for place in places(points):
                owners[place].add(k)
        self.agree(f"{self.what}: vertices", set(owners) == set(places(self.whole[0])), True)
        return {place: parts for place, parts in owners.items() if len(parts) > 1}


def by_gmsh(folder, stem, count, whole, agree):
    """Each file as deal.II takes it: entities, copies by entity, nodes, elements by entity."""
    parts = Parts(f"{stem}_%.msh by Gmsh", whole, agree)
    # Gmsh is one session a process: one that the caller began is left to him.
    ours = not gmsh.isInitialized()
    if ours:
        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
    owned, copies, nodes = {}, [], {}
    try:
        for k in range(count):
            gmsh.clear()
            gmsh.open(str(folder / f"{stem}_{k + 1}.msh"))
            agree(f"{stem}_{k + 1}.msh: partitions", gmsh.model.getNumberOfPartitions(), count)
            tags, at, _ = gmsh.model.mesh.getNodes()
            place = {int(tag): i for i, tag in enumerate(tags)}
            at = np.asarray(at).reshape(-1, 3)
            for tag, i in place.items():
                known = nodes.setdefault(tag, at[i])
                if not np.array_equal(known, at[i]):
                    agree(f"node {tag}: one place", at[i], known)
            own = []
            for dimension, entity in gmsh.model.getEntities(3):
                kinds, numbers, corners = gmsh.model.mesh.getElements(dimension, entity)
                ghosts = gmsh.model.mesh.getGhostElements(dimension, entity)
                owner = dict(zip(map(int, ghosts[0]), map(int, ghosts[1])))
                for kind, numbers, corners in zip(kinds, numbers, corners):
                    agree(f"{stem}_{k + 1}.msh: kind", int(kind), 4)
                    for number, tet in zip(map(int, numbers), corners.reshape(-1, 4)):
                        tet = tuple(map(int, tet))
                        if number in owner:
                            copies.append((k, owner[number] - 1, number, tet))
                        else:
                            owned[number] = (k, tet)
                            own.append([place[tag] for tag in tet])
            used = np.unique(np.asarray(own, dtype=int).reshape(-1))
            renamed = np.searchsorted(used, np.asarray(own, dtype=int).reshape(-1, 4))
            parts.add(at[used], renamed)
    finally:
        if ours:
            gmsh.finalize()
    shared = parts.compare()
    agree("numbers of nodes", sorted(nodes), list(range(1, len(whole[0]) + 1)))
    agree("numbers of tetrahedra", sorted(owned), list(range(1, len(whole[1]) + 1)))
    # The owner of a vertex is the first part that has it: part by part they count on.
    at = {place: tag for tag, place in zip(nodes, places(np.array(list(nodes.values()))))}
    owners = [min(shared[p]) if p in shared else None for p in sorted(at, key=at.get)]
    known = [k for k in owners if k is not None]
    agree("nodes that a part owns follow each other", known == sorted(known), True)
    # Copies: those that their owner has, and all that touch a part.
    agree("copies are their owner's", all(owned[n] == (k, t) for _, k, n, t in copies), True)
    touched = defaultdict(set)
    for number, (k, tet) in owned.items():
        for tag in tet:
            touched[tag].add(k)
    wanted = {(j, n) for n, (k, t) in owned.items() for tag in t for j in touched[tag] - {k}}
    agree("copies", {(k, n) for k, _, n, _ in copies} == wanted, True)
    return shared


def read_mfem(path):
    """A file of MFEM's parallel format: tetrahedra, vertices, groups, what they share."""
    lines = [line.split() for line in open(path) if line.strip() and not line.startswith("#")]
    lines = iter(lines)

    def rows(kind):
        return [list(map(kind, next(lines))) for _ in range(int(next(lines)[-1]))]

    def word(*wanted):
        found = next(lines)
        assert found == list(wanted), (found, wanted)

    word("MFEM", "mesh", "v1.2")
    word("dimension"), word("3"), word("elements")
    tets = rows(int)
    word("boundary")
    hull = rows(int)
    word("vertices")
    count = int(next(lines)[0])
    word("3")
    points = np.array([list(map(float, next(lines))) for _ in range(count)]).reshape(-1, 3)
    word("mfem_serial_mesh_end"), word("communication_groups")
    groups = [tuple(row[1:]) for row in rows(int)]
    for _ in range(3):
        next(lines)
    shared = [[rows(int) for _ in range(3)] for _ in groups[1:]]
    word("mfem_mesh_end")
    return points, tets, hull, groups, shared


def by_mfem(folder, stem, count, whole, shared, agree):
    """What each says that it shares is shared, in one order; PyMFEM reads each file."""
    what = f"{stem}.mfem"
    parts, lists = Parts(what, whole, agree), defaultdict(list)
    total, on_hull = 0, 0
    for k in range(count):
        points, tets, hull, groups, own = read_mfem(folder / f"{stem}.{k:06d}")
        parts.add(points, [row[2:] for row in tets])
        agree(f"{what}: kinds", {row[1] for row in tets} <= {4} and {row[1] for row in hull} <= {2}, True)
        agree(f"{what}: the first group", groups[0], (k,))
        at = places(points)
        for group, all_rows in zip(groups[1:], own):
            vertices, edges, faces = all_rows
            told = [[tuple(at[v] for v in row) for row in rows] for rows in (vertices, edges)]
            told.append([tuple(at[v] for v in row[1:]) for row in faces])
            lists[group].append(told)
            total += len(vertices)
            agree(f"{what}: faces of pairs", len(faces) == 0 or len(group) == 2, True)
        on_hull += len(hull)
    agree(f"{what}: one list a group", all(told == own[0] for own in lists.values() for told in own), True)
    agree(f"{what}: each has its groups", all(len(own) == len(g) for g, own in lists.items()), True)
    found = {row[0]: set(g) for g, own in lists.items() for row in own[0][0]}
    agree(f"{what}: shared vertices", found == shared == parts.compare(), True)
    faces = defaultdict(int)
    for tet in whole[1]:
        for k in range(4):
            faces[frozenset(np.delete(tet, k).tolist())] += 1
    agree(f"{what}: the boundary", on_hull, sum(n == 1 for n in faces.values()))
    try:
        import mfem.ser as mfem
    except (ImportError, OSError) as error:
        print(f"SKIPPED: {what} by PyMFEM: {error}")
        return
    size, volume = 0, 0.0
    for k in range(count):
        mesh = mfem.Mesh(str(folder / f"{stem}.{k:06d}"), 1, 1)
        size += mesh.GetNE()
        volume += sum(mesh.GetElementVolume(t) for t in range(mesh.GetNE()))
    agree(f"{what} by PyMFEM: tetrahedra", size, len(whole[1]))
    close = bool(np.isclose(volume, volumes(*whole).sum(), rtol=1e-12))
    agree(f"{what} by PyMFEM: volume", close, True)


def by_vtk(folder, stem, count, whole, shared, agree):
    """Numbers and owners of points, by PyVista."""
    what = f"{stem}.pvtu by PyVista"
    parts, numbers, owners = Parts(what, whole, agree), {}, {}
    for k in range(count):
        piece = pyvista.read(folder / f"{stem}_{k}.vtu")
        tets = piece.cells_dict.get(pyvista.CellType.TETRA, np.empty((0, 4), dtype=int))
        parts.add(piece.points, tets)
        told = zip(places(piece.points), piece.point_data["GlobalPointIds"], piece.point_data["owner"])
        for place, number, owner in told:
            if numbers.setdefault(place, number) != number or owners.setdefault(place, owner) != owner:
                agree(f"{what}: one number and owner", (number, owner), (numbers[place], owners[place]))
            if place not in shared and owner != k:
                agree(f"{what}: the owner of an inner point", owner, k)
    agree(f"{what}: shared vertices", parts.compare() == shared, True)
    agree(f"{what}: a number each", len(set(numbers.values())), len(numbers))
    agree(f"{what}: owners", {p: owners[p] for p in shared} == {p: min(k) for p, k in shared.items()}, True)


def by_vtkhdf(folder, stem, count, whole, shared, agree):
    """All parts of the one file, by PyVista."""
    what = f"{stem}.vtkhdf by PyVista"
    parts = Parts(what, whole, agree)
    pieces = list(pyvista.read(folder / f"{stem}.vtkhdf"))
    agree(f"{what}: parts", len(pieces), count)
    for k, piece in enumerate(pieces):
        listed = pyvista.read(folder / f"{stem}_{k}.vtu")
        tets = piece.cells_dict.get(pyvista.CellType.TETRA, np.empty((0, 4), dtype=int))
        parts.add(piece.points, tets)
        for name in ["GlobalPointIds", "owner"]:
            same = np.array_equal(piece.point_data[name], listed.point_data[name])
            agree(f"{what}: {name} of part {k}", bool(same), True)
        agree(f"{what}: worker", set(piece.cell_data["worker"].tolist()) <= {k}, True)
    agree(f"{what}: shared vertices", parts.compare() == shared, True)
    try:
        import h5py
    except (ImportError, OSError) as error:
        print(f"SKIPPED: {stem}.vtkhdf by h5py: {error}")
        return
    with h5py.File(folder / f"{stem}.vtkhdf") as file:
        told = file["VTKHDF/NumberOfCells"][:].tolist()
        agree(f"{what}: sizes", told, [len(tets) for _, tets in parts.pieces])
        agree(f"{what}: points", len(file["VTKHDF/Points"]), sum(len(p) for p, _ in parts.pieces))


def compare(folder, whole, stem, count, agree):
    """Compares all files of parts with the whole, by all readers."""
    grid = pyvista.read(folder / whole)
    tets = grid.cells_dict[pyvista.CellType.TETRA]
    # Points that equal another one are no vertices.
    used = np.unique(tets)
    whole = (np.asarray(grid.points)[used], np.searchsorted(used, tets))
    shared = by_gmsh(folder, stem, count, whole, agree)
    by_mfem(folder, stem, count, whole, shared, agree)
    by_vtk(folder, stem, count, whole, shared, agree)
    by_vtkhdf(folder, stem, count, whole, shared, agree)


def main():
    folder, whole, stem, count = Path(sys.argv[1]), sys.argv[2], sys.argv[3], int(sys.argv[4])
    failures, checks = [], [0]

    def agree(what, found, wanted):
        checks[0] += 1
        if found != wanted:
            failures.append(f"{what}: {found}, not {wanted}"[:300])

    compare(folder, whole, stem, count, agree)
    for failure in failures:
        print(failure)
    print(f"{checks[0]} comparisons, {len(failures)} failed")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
