#!/usr/bin/env python3
"""Reads the parts of a mesh with the programs that solvers take them by, and compares with the whole.

usage: parted.py FOLDER WHOLE.vtu STEM PARTS

In FOLDER are the mesh as one process writes it, and the files STEM_%.msh, STEM.mfem, STEM.pvtu and
STEM.vtkhdf of the same mesh in PARTS parts. Compared are numbers, volumes, places, what parts share, and of
a domain the regions of tetrahedra and the marked triangles. Gmsh's
part is what deal.II calls of Gmsh in `read_partitioned_msh`. The exit code is 0 if all agree, 1 if
not, and 3 if a package is missing (the reason is on stdout). PyMFEM and h5py read files, too, if
they are there.
"""

import sys
from collections import Counter, defaultdict
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


def labelled(points, cells, labels):
    """How often there is each cell, as a set of places, with each label."""
    return Counter(zip(names(points, cells), map(int, labels)))


def labels_of(grid):
    """Regions of tetrahedra, marked triangles and their markers, of a grid that has them."""
    if "region" not in grid.cell_data:
        return None
    tets, triangles = (grid.celltypes == kind for kind in (pyvista.CellType.TETRA, pyvista.CellType.TRIANGLE))
    corners = grid.cells_dict.get(pyvista.CellType.TRIANGLE, np.empty((0, 3), dtype=int))
    return grid.cell_data["region"][tets], corners, grid.cell_data["marker"][triangles]


class Parts:
    """Points and tetrahedra of the parts, and which parts have what."""

    def __init__(self, what, whole, agree):
        self.what, self.agree = what, agree
        *self.whole, self.labels = whole
        self.pieces, self.regions, self.marked = [], Counter(), Counter()

    def add(self, points, tets, labels=None):
        tets = np.asarray(tets, dtype=np.int64).reshape(-1, 4)
        points = np.asarray(points).reshape(-1, 3)
        self.pieces.append((points, tets))
        if labels is not None:
            regions, triangles, markers = labels
            self.regions += labelled(points, tets, regions)
            self.marked += labelled(points, np.asarray(triangles, dtype=np.int64).reshape(-1, 3), markers)

    def compare_labels(self, rename=lambda marker, _: marker):
        """Compares regions and marked triangles; `rename` is what a format makes of a marker among all."""
        if self.labels is None:
            return
        regions, triangles, markers = self.labels
        points, tets = self.whole
        self.agree(f"{self.what}: regions", self.regions == labelled(points, tets, regions), True)
        known = set(map(int, markers))
        marked = labelled(points, triangles, [rename(int(marker), known) for marker in markers])
        self.agree(f"{self.what}: marked triangles", self.marked == marked, True)
        self.agree(f"{self.what}: some are", len(marked) > 0, True)

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
            own, regions, triangles, markers = [], [], [], []
            for dimension, entity in gmsh.model.getEntities(2):
                groups = gmsh.model.getPhysicalGroupsForEntity(dimension, entity)
                for corners in gmsh.model.mesh.getElements(dimension, entity)[2]:
                    corners = [[place[int(tag)] for tag in row] for row in corners.reshape(-1, 3)]
                    triangles += corners
                    markers += [int(groups[0])] * len(corners)
            for dimension, entity in gmsh.model.getEntities(3):
                groups = gmsh.model.getPhysicalGroupsForEntity(dimension, entity)
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
                            regions += [int(tag) for tag in groups]
            used = np.unique(np.asarray(own, dtype=int).reshape(-1))
            renamed = [
                np.searchsorted(used, np.asarray(cells, dtype=int).reshape(-1, n)) for cells, n in ((own, 4), (triangles, 3))
            ]
            parts.add(at[used], renamed[0], parts.labels and (regions, renamed[1], markers))
    finally:
        if ours:
            gmsh.finalize()
    shared = parts.compare()
    # A physical group of Gmsh has no number 0: it gets the next one that is free.
    parts.compare_labels(lambda marker, known: marker or max(known) + 1)
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
        labels = ([row[0] for row in tets], [row[2:] for row in hull], [row[0] for row in hull])
        parts.add(points, [row[2:] for row in tets], parts.labels and labels)
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
    # MFEM's attributes are positive: where a marker is 0 all are one more.
    parts.compare_labels(lambda marker, known: marker + (0 in known))
    faces = defaultdict(int)
    for tet in whole[1]:
        for k in range(4):
            faces[frozenset(np.delete(tet, k).tolist())] += 1
    boundary = sum(n == 1 for n in faces.values()) if whole[2] is None else len(whole[2][1])
    agree(f"{what}: the boundary", on_hull, boundary)
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
    close = bool(np.isclose(volume, volumes(*whole[:2]).sum(), rtol=1e-12))
    agree(f"{what} by PyMFEM: volume", close, True)


def by_vtk(folder, stem, count, whole, shared, agree):
    """Numbers and owners of points, by PyVista."""
    what = f"{stem}.pvtu by PyVista"
    parts, numbers, owners = Parts(what, whole, agree), {}, {}
    for k in range(count):
        piece = pyvista.read(folder / f"{stem}_{k}.vtu")
        tets = piece.cells_dict.get(pyvista.CellType.TETRA, np.empty((0, 4), dtype=int))
        parts.add(piece.points, tets, labels_of(piece))
        told = zip(places(piece.points), piece.point_data["GlobalPointIds"], piece.point_data["owner"])
        for place, number, owner in told:
            if numbers.setdefault(place, number) != number or owners.setdefault(place, owner) != owner:
                agree(f"{what}: one number and owner", (number, owner), (numbers[place], owners[place]))
            if place not in shared and owner != k:
                agree(f"{what}: the owner of an inner point", owner, k)
    agree(f"{what}: shared vertices", parts.compare() == shared, True)
    parts.compare_labels()
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
        parts.add(piece.points, tets, labels_of(piece))
        for name in ["GlobalPointIds", "owner"]:
            same = np.array_equal(piece.point_data[name], listed.point_data[name])
            agree(f"{what}: {name} of part {k}", bool(same), True)
        agree(f"{what}: worker", set(piece.cell_data["worker"].tolist()) <= {k}, True)
    agree(f"{what}: shared vertices", parts.compare() == shared, True)
    parts.compare_labels()
    try:
        import h5py
    except (ImportError, OSError) as error:
        print(f"SKIPPED: {stem}.vtkhdf by h5py: {error}")
        return
    with h5py.File(folder / f"{stem}.vtkhdf") as file:
        told = file["VTKHDF/NumberOfCells"][:].tolist()
        agree(f"{what}: sizes", told, [piece.n_cells for piece in pieces])
        agree(f"{what}: points", len(file["VTKHDF/Points"]), sum(len(p) for p, _ in parts.pieces))


def compare(folder, whole, stem, count, agree):
    """Compares all files of parts with the whole, by all readers."""
    grid = pyvista.read(folder / whole)
    tets = grid.cells_dict[pyvista.CellType.TETRA]
    # Points that equal another one are no vertices.
    used = np.unique(tets)
    labels = labels_of(grid)
    if labels is not None:
        regions, triangles, markers = labels
        labels = regions, np.searchsorted(used, triangles), markers
    whole = (np.asarray(grid.points)[used], np.searchsorted(used, tets), labels)
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
