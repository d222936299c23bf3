#!/usr/bin/env python3
"""Reads what `ltbw` writes with meshio, PyVista and Gmsh, and lets `ltbw` read what they write.

usage: readback.py LTBW FOLDER

LTBW is the program, FOLDER an empty folder to work in. Both directions compare the numbers of
points and tetrahedra, coordinates on bits, and tags. The exit code is 0 if all agree, 1 if not,
and 3 if a package is missing (the reason is on stdout).
"""

import subprocess
import sys
from pathlib import Path

try:
    import gmsh
    import meshio
    import numpy as np
    import parted
    import pyvista
except (ImportError, OSError) as error:
    print(f"a Python package, or a library that it needs, is missing: {error}")
    sys.exit(3)

LTBW = Path(sys.argv[1]).resolve()
FOLDER = Path(sys.argv[2]).resolve()
checks = 0
failures = []


def run(*args):
    """Runs ltbw in the folder."""
    done = subprocess.run([LTBW, *map(str, args)], cwd=FOLDER, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"ltbw {' '.join(map(str, args))}: {done.stderr.strip()}")


def agree(what, found, wanted):
    """Notes whether two arrays are equal, coordinates on bits."""
    global checks
    checks += 1
    found, wanted = np.asarray(found), np.asarray(wanted)
    if wanted.dtype == np.float64:
        # A reader may keep coordinates as it likes; what counts are the doubles.
        found, wanted = found.astype(np.float64).view(np.int64), wanted.view(np.int64)
    if found.shape != wanted.shape:
        failures.append(f"{what}: shape {found.shape}, not {wanted.shape}")
    elif not np.array_equal(found, wanted):
        failures.append(f"{what}: {np.sum(found != wanted)} of {found.size} values differ")


class Mesh:
    """Points, tetrahedra and their tags."""

    def __init__(self, points, tets, tags=None, regions=None):
        self.points = np.ascontiguousarray(points, dtype=np.float64)
        self.tets = np.asarray(tets, dtype=np.int64).reshape(-1, 4)
        self.tags = None if tags is None else np.asarray(tags)
        self.regions = None if regions is None else np.asarray(regions)

    def compare(self, what, other, tags=True, regions=True):
        """Compares with `other`, which is right."""
        agree(f"{what}: points", self.points, other.points)
        # Gmsh's files hold tetrahedra by region.
        rows, wanted = self.sorted(regions), other.sorted(regions)
        agree(f"{what}: tetrahedra and regions", rows, wanted)
        if tags:
            agree(f"{what}: tags", [] if self.tags is None else self.tags, other.tags)

    def compare_digits(self, what, other, tags=True, regions=True):
        """Compares with `other`, of whose coordinates only some digits were written."""
        near = np.allclose(self.points, other.points, rtol=1e-9, atol=1e-30)
        agree(f"{what}: points, nearly", near, True)
        self.points = other.points
        self.compare(what, other, tags, regions)

    def sorted(self, regions):
        """Corners and regions, in an order that depends on them alone."""
        columns = [self.tets]
        if regions:
            missing = np.full(len(self.tets), -99)
            columns.append((missing if self.regions is None else self.regions)[:, None])
        rows = np.hstack(columns).astype(np.int64)
        return rows[np.lexsort(rows.T[::-1])]


def write_pair(stem, mesh):
    """Writes TetGen's files, the form in which this script hands meshes to ltbw."""
    with open(FOLDER / f"{stem}.node", "w") as out:
        print(len(mesh.points), 3, 0, 0 if mesh.tags is None else 1, file=out)
        for i, p in enumerate(mesh.points.tolist()):
            print(i, *map(repr, p), *([] if mesh.tags is None else [mesh.tags[i]]), file=out)
    with open(FOLDER / f"{stem}.ele", "w") as out:
        print(len(mesh.tets), 4, 0 if mesh.regions is None else 1, file=out)
        for i, t in enumerate(mesh.tets.tolist()):
            print(i, *t, *([] if mesh.regions is None else [mesh.regions[i]]), file=out)


def read_pair(stem):
    """Reads TetGen's files as ltbw writes them."""
    nodes = [line.split() for line in open(FOLDER / f"{stem}.node")]
    cells = [line.split() for line in open(FOLDER / f"{stem}.ele")]
    tagged, regioned = nodes[0][3] == "1", cells[0][2] == "1"
    return Mesh(
        [[float(c) for c in row[1:4]] for row in nodes[1:]],
        [[int(c) for c in row[1:5]] for row in cells[1:]],
        [int(row[4]) for row in nodes[1:]] if tagged else None,
        [int(row[5]) for row in cells[1:]] if regioned else None,
    )


def first(data, *names):
    """The first of some arrays that is there, its blocks joined."""
    for name in names:
        if name in data:
            array = data[name]
            return np.concatenate(array) if isinstance(array, list) else np.asarray(array)
    return None


def of_meshio(mesh):
    tets = [c.data for c in mesh.cells if c.type == "tetra"]
    tags = first(mesh.point_data, "tag", "medit:ref", "tetgen:ref")
    regions = first(mesh.cell_data, "region", "gmsh:physical", "medit:ref", "tetgen:ref")
    return Mesh(mesh.points, np.concatenate(tets), tags, regions)


def of_pyvista(grid):
    tags, regions = first(grid.point_data, "tag"), first(grid.cell_data, "region")
    return Mesh(grid.points, grid.cells_dict[pyvista.CellType.TETRA], tags, regions)


def ltbw_to_python(mesh):
    """What ltbw writes is read by meshio, and what VTK can read also by PyVista."""
    outputs = [
        ("m.vtu", []),
        ("text.vtu", ["--ascii"]),
        ("m.vtk", []),
        ("text.vtk", ["--ascii"]),
        ("m.msh", []),
        ("text.msh", ["--ascii"]),
        ("old.msh", ["--msh2"]),
        ("oldtext.msh", ["--msh2", "--ascii"]),
        ("m.mesh", []),
        ("m.ele", []),
    ]
    write_pair("in", mesh)
    for name, options in outputs:
        run("convert", "in.ele", name, *options)
        of_meshio(meshio.read(FOLDER / name)).compare(f"{name} by meshio", mesh)
        if name.endswith((".vtu", ".vtk")):
            of_pyvista(pyvista.read(FOLDER / name)).compare(f"{name} by PyVista", mesh)
    for name, options in [("m.ply", []), ("text.ply", ["--ascii"])]:
        run("convert", "in.ele", name, *options)
        cloud = meshio.read(FOLDER / name)
        agree(f"{name} by meshio: points", cloud.points, mesh.points)
        agree(f"{name} by meshio: tags", cloud.point_data["tag"], mesh.tags)
        # VTK keeps coordinates of this format as 32-bit floats.
        points = pyvista.read(FOLDER / name).points
        agree(f"{name} by PyVista: points", points, mesh.points.astype(np.float32).astype(float))
    run("convert", "in.ele", "m.npy")
    agree("m.npy by NumPy", np.load(FOLDER / "m.npy"), mesh.points)
    run("convert", "in.ele", "m.txt")
    agree("m.txt by NumPy", np.loadtxt(FOLDER / "m.txt"), mesh.points)


def meshio_to_ltbw(mesh):
    """What meshio writes is read by ltbw."""

    def write(name, tags, regions, **options):
        data = meshio.Mesh(
            mesh.points,
            [("tetra", mesh.tets)],
            point_data={t: mesh.tags for t in tags},
            cell_data={r: [mesh.regions] for r in regions},
        )
        data.write(FOLDER / name, **options)
        run("convert", name, "back.ele")
        back = read_pair("back")
        # As text, meshio writes 11 digits of a double into this format.
        digits = name.endswith(".vtu") and not options["binary"]
        compare = back.compare_digits if digits else back.compare
        compare(f"{name} {options} from meshio", mesh, bool(tags), bool(regions))

    for options in [
        {"binary": False},
        {"binary": True, "compression": None},
        {"binary": True, "compression": "zlib"},
        {"binary": True, "compression": "zlib", "header_type": "UInt64"},
        {"binary": True, "compression": "lzma"},
    ]:
        write("from.vtu", ["tag"], ["region"], **options)
    groups = ["gmsh:physical", "gmsh:geometrical"]
    for binary in [True, False]:
        # Text views hold `np.int64(5)` when meshio writes them with NumPy 2: no values.
        tags = ["tag"] if binary else []
        write("from.msh", tags, groups, file_format="gmsh22", binary=binary)
        # The newer form holds groups only with entities, which meshio does not make up.
        write("from.msh", tags, ["region"] if binary else [], file_format="gmsh", binary=binary)
    write("from.mesh", ["medit:ref"], ["medit:ref"])
    write("from.ele", ["tetgen:ref"], ["tetgen:ref"], file_format="tetgen")


def vtk_to_ltbw(mesh):
    """What VTK writes (ParaView is VTK) is read by ltbw, in all of VTK's ways."""
    grid = pyvista.UnstructuredGrid({pyvista.CellType.TETRA: mesh.tets}, mesh.points)
    grid.point_data["tag"], grid.cell_data["region"] = mesh.tags, mesh.regions
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    for mode in ["Ascii", "Binary", "Appended"]:
        for compressor in ["None", "ZLib", "LZ4", "LZMA"]:
            for order in ["LittleEndian", "BigEndian"]:
                for header in ["UInt32", "UInt64"]:
                    for encode in [False, True] if mode == "Appended" else [False]:
                        writer = vtkXMLUnstructuredGridWriter()
                        writer.SetFileName(str(FOLDER / "vtk.vtu"))
                        writer.SetInputData(grid)
                        getattr(writer, f"SetDataModeTo{mode}")()
                        getattr(writer, f"SetByteOrderTo{order}")()
                        getattr(writer, f"SetHeaderTypeTo{header}")()
                        getattr(writer, f"SetCompressorTypeTo{compressor}")()
                        writer.SetEncodeAppendedData(encode)
                        if not writer.Write():
                            raise RuntimeError("VTK cannot write")
                        run("convert", "vtk.vtu", "back.ele")
                        what = f"{mode} {order} {header} {compressor} base64={encode} from VTK"
                        read_pair("back").compare(what, mesh)


def legacy_to_ltbw(mesh):
    """VTK's legacy files, as VTK and meshio write them: meshes and surfaces."""
    from vtkmodules.vtkIOLegacy import vtkPolyDataWriter, vtkUnstructuredGridWriter

    grid = pyvista.UnstructuredGrid({pyvista.CellType.TETRA: mesh.tets}, mesh.points)
    grid.point_data["tag"], grid.cell_data["region"] = mesh.tags, mesh.regions
    poly = pyvista.Sphere(theta_resolution=8, phi_resolution=6)
    poly = pyvista.PolyData.from_regular_faces(poly.points.astype(float), poly.regular_faces)
    for version in [42, 51]:
        for mode in ["ASCII", "Binary"]:
            for data, writer in [(grid, vtkUnstructuredGridWriter()), (poly, vtkPolyDataWriter())]:
                writer.SetFileName(str(FOLDER / "vtk.vtk"))
                writer.SetInputData(data)
                writer.SetFileVersion(version)
                getattr(writer, f"SetFileTypeTo{mode}")()
                if not writer.Write():
                    raise RuntimeError("VTK cannot write")
                what = f"{mode} legacy {version} from VTK"
                if data is grid:
                    run("convert", "vtk.vtk", "back.ele")
                    back = read_pair("back")
                    (back.compare if mode == "Binary" else back.compare_digits)(what, mesh)
                    continue
                run("check", "vtk.vtk")
                run("convert", "vtk.vtk", "back.ply")
                run("convert", "back.ply", "back.vtk")
                back = pyvista.read(FOLDER / "back.vtk")
                agree(f"{what}: points", np.allclose(back.points, poly.points), True)
                agree(f"{what}: triangles", back.regular_faces, poly.regular_faces)
    for options in [
        {"file_format": "vtk42", "binary": True},
        {"file_format": "vtk51", "binary": True},
        {"file_format": "vtk42", "binary": False},
        {"file_format": "vtk51", "binary": False},
    ]:
        data = meshio.Mesh(
            mesh.points,
            [("tetra", mesh.tets)],
            point_data={"tag": mesh.tags},
            cell_data={"region": [mesh.regions]},
        )
        data.write(FOLDER / "meshio.vtk", **options)
        run("convert", "meshio.vtk", "back.ele")
        back = read_pair("back")
        (back.compare if options["binary"] else back.compare_digits)(f"{options} from meshio", mesh)


def numpy_to_ltbw(mesh):
    """Points as NumPy writes them as text and in archives."""

    def check(what, name):
        run("convert", name, "points_back.npy")
        agree(what, np.load(FOLDER / "points_back.npy"), mesh.points)

    for delimiter in [" ", ",", ", "]:
        np.savetxt(FOLDER / "p.txt", mesh.points, delimiter=delimiter, header="x y z")
        check(f"p.txt with {delimiter!r}", "p.txt")
    np.savez(FOLDER / "p.npz", mesh.points)
    check("p.npz, one array", "p.npz")
    np.savez_compressed(FOLDER / "p.npz", tets=mesh.tets, points=np.asfortranarray(mesh.points))
    check("p.npz, compressed, by name", "p.npz")


def surfaces_to_ltbw(mesh):
    """Vertices of surfaces: each format as meshio or PyVista writes it."""
    faces = np.unique(np.sort(mesh.tets[:, :3], axis=1), axis=0)
    used, faces = np.unique(faces, return_inverse=True)
    # Every point in a face, and coordinates that 32 bits hold, which is all that STL has.
    points = mesh.points[used].astype(np.float32).astype(np.float64)
    faces = faces.reshape(-1, 3)
    surface = meshio.Mesh(points, [("triangle", faces)])

    def check(what, name, wanted=points):
        run("convert", name, "surface.npy")
        agree(what, np.load(FOLDER / "surface.npy"), wanted)

    for name, options in [
        ("s.ply", {"binary": True}),
        ("s.ply", {"binary": False}),
        ("s.off", {}),
        ("s.obj", {}),
    ]:
        surface.write(FOLDER / name, **options)
        check(f"{name} {options} from meshio", name)
    # STL repeats a point in each triangle: ltbw reads each once, where it comes first.
    _, seen = np.unique(faces.ravel(), return_index=True)
    once = points[faces.ravel()[np.sort(seen)]]
    for binary in [True, False]:
        surface.write(FOLDER / "s.stl", binary=binary)
        check(f"s.stl binary={binary} from meshio", "s.stl", once)
    poly = pyvista.PolyData.from_regular_faces(points.astype(np.float32), faces)
    for binary in [True, False]:
        poly.save(FOLDER / "p.ply", binary=binary)
        check(f"p.ply binary={binary} from PyVista", "p.ply")
        poly.save(FOLDER / "p.stl", binary=binary)
        # Saving turns faces round, so another corner may come first.
        run("convert", "p.stl", "surface.npy")
        found = np.load(FOLDER / "surface.npy")
        by_place = [a[np.lexsort(a.T)] for a in (found, points)]
        agree(f"p.stl binary={binary} from PyVista", *by_place)


def parts_to_python():
    """A mesh that its workers left distributed is one mesh to PyVista."""
    names = ["whole.vtu", "parts.pvtu", "parts_%.msh", "parts.mfem", "parts.vtkhdf"]
    run("delaunay", "points.npy", "--threads", 3, *[w for name in names for w in ("-o", name)])

    def same(what, found, wanted):
        agree(what, [found == wanted], [True])

    parted.compare(FOLDER, "whole.vtu", "parts", 3, same)
    whole, parts = (pyvista.read(FOLDER / name) for name in ["whole.vtu", "parts.pvtu"])

    def rows(grid):
        # By coordinates: a point between parts is in several. Corners and tetrahedra sorted.
        corners = np.asarray(grid.points)[grid.cells_dict[pyvista.CellType.TETRA]]
        order = [np.lexsort(tet.T) for tet in corners]
        corners = np.array([tet[k] for tet, k in zip(corners, order)]).reshape(-1, 12)
        return corners[np.lexsort(corners.T)]

    agree("parts.pvtu by PyVista: cells", parts.n_cells, whole.n_cells)
    pieces = [pyvista.read(FOLDER / f"parts_{k}.vtu") for k in range(3)]
    workers = np.repeat(np.arange(3), [piece.n_cells for piece in pieces])
    agree("parts.pvtu by PyVista: workers", parts.cell_data["worker"], workers)
    agree("parts.pvtu by PyVista: tetrahedra", rows(parts), rows(whole))


# Two cells with a wall between them; the corners of facets, and their markers.
CELLS = [
    ([0, 1, 3, 2], 4), ([0, 1, 7, 6], 0), ([2, 3, 9, 8], 12), ([0, 2, 8, 6], 4), ([1, 3, 9, 7], 30),
    ([1, 4, 5, 3], 4), ([1, 4, 10, 7], 8), ([3, 5, 11, 9], 8), ([4, 5, 11, 10], -7),
    ([6, 7, 9, 8], 4), ([7, 10, 11, 9], 4),
]


def boundary_to_python():
    """The boundary triangles of a domain, with their markers, are the same to all readers."""
    with open(FOLDER / "cells.poly", "w") as out:
        print("12 3 0 0", file=out)
        for k in range(12):
            x = [0, 1, 0, 1, 3, 3][k % 6]
            print(k, x, k % 6 in (2, 3, 5) and 1 or 0, k // 6, file=out)
        print(len(CELLS), 1, file=out)
        for corners, marker in CELLS:
            print(1, 0, marker, file=out)
            print(4, *corners, file=out)
        # No holes, two regions.
        print(0, 2, "0 0.5 0.5 0.5 5", "1 2 0.5 0.5 3", sep="\n", file=out)
    binary = ["b.vtu", "b.vtk", "b.msh", "b.mesh", "b.ele"]
    run("mesh", "cells.poly", "--max-volume", "0.02", *[w for n in binary for w in ("-o", n)])
    run("convert", "b.vtu", "old.msh", "--msh2")
    run("convert", "b.msh", "text.msh", "--ascii")
    run("convert", "b.msh", "back.vtu")

    def rows(triangles, markers):
        # Corners of a triangle sorted, then the triangles.
        corners = np.sort(np.asarray(triangles, dtype=np.int64), axis=1)
        rows = np.hstack([corners, np.asarray(markers, dtype=np.int64)[:, None]])
        return rows[np.lexsort(rows.T[::-1])]

    faces = [line.split() for line in open(FOLDER / "b.face")][1:]
    wanted = rows([row[1:4] for row in faces], [row[4] for row in faces])
    agree("markers of the boundary", np.unique(wanted[:, 3]), [-7, 0, 4, 8, 12, 30])
    # Groups of Gmsh are positive: the others have free numbers, and names.
    names = {0: "marker 0", -7: "marker -7"}
    for name in ["b.vtu", "back.vtu", "b.vtk", "b.mesh"]:
        mesh = meshio.read(FOLDER / name)
        array = "medit:ref" if name.endswith(".mesh") else "marker"
        marks = mesh.cell_data_dict[array]["triangle"]
        agree(f"{name} by meshio: boundary", rows(mesh.cells_dict["triangle"], marks), wanted)
    for name in ["b.vtu", "back.vtu", "b.vtk"]:
        grid = pyvista.read(FOLDER / name)
        marks = grid.cell_data["marker"][grid.celltypes == pyvista.CellType.TRIANGLE]
        triangles = grid.cells_dict[pyvista.CellType.TRIANGLE]
        agree(f"{name} by PyVista: boundary", rows(triangles, marks), wanted)
    for name in ["b.msh", "text.msh", "old.msh"]:
        mesh = meshio.read(FOLDER / name)
        known = {text: marker for marker, text in names.items()}
        groups = [(text, tag) for text, (tag, dim) in mesh.field_data.items() if dim == 2]
        markers = {tag: known.get(text, tag) for text, tag in groups}
        marks = [markers.get(g, g) for g in mesh.cell_data_dict["gmsh:physical"]["triangle"]]
        agree(f"{name} by meshio: boundary", rows(mesh.cells_dict["triangle"], marks), wanted)
        agree(f"{name} by Gmsh: boundary", rows(*of_gmsh(name, known)), wanted)
    # References are numbers of entities there, those that are not positive, too.
    agree("b.mesh by Gmsh: boundary", rows(*of_gmsh_entities("b.mesh")), wanted)


def names_to_mfem():
    """Names of parts and volumes are MFEM's attribute sets, by way of Gmsh's old format."""
    try:
        import mfem.ser as mfem
    except ImportError as error:
        print(f"SKIPPED: names by PyMFEM: {error}")
        return
    lines = ["OFF", "8 6 0", *(f"{v & 1} {v >> 1 & 1} {v >> 2}" for v in range(8))]
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    lines += [" ".join(map(str, (4, *side))) for side in sides]
    (FOLDER / "cube.off").write_text("\n".join(lines) + "\n")
    run("mesh", "cube.off", "-o", "cube.msh")
    run("convert", "cube.msh", "named.msh", "--msh2")
    mesh = mfem.Mesh(str(FOLDER / "named.msh"))
    for sets, wanted in [
        (mesh.bdr_attribute_sets, {f"part {k}": [k] for k in range(1, 7)}),
        (mesh.attribute_sets, {"volume 1": [1]}),
    ]:
        found = {name: sets.GetAttributeSet(name).ToList() for name in sets.GetAttributeSetNames()}
        agree("names by PyMFEM", [found == wanted or found], [True])


def of_gmsh(name, known):
    """The triangles of a file with the markers of their groups, as Gmsh sees them."""
    triangles, markers = [], []
    gmsh.open(str(FOLDER / name))
    for _, group in gmsh.model.getPhysicalGroups(2):
        marker = known.get(gmsh.model.getPhysicalName(2, group), group)
        for entity in gmsh.model.getEntitiesForPhysicalGroup(2, group):
            _, corners = gmsh.model.mesh.getElementsByType(2, entity)
            triangles.extend(corners.reshape(-1, 3).astype(np.int64) - 1)
            markers.extend([marker] * (len(corners) // 3))
    return triangles, markers


def of_gmsh_entities(name):
    """The triangles of a file with the numbers of their entities, as Gmsh sees them."""
    gmsh.open(str(FOLDER / name))
    elements, corners = gmsh.model.mesh.getElementsByType(2)
    # By entity, all elements are those of a negative number.
    entities = [gmsh.model.mesh.getElement(element)[3] for element in elements]
    return corners.reshape(-1, 3).astype(np.int64) - 1, entities


def main():
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    run("generate", "uniform", 400, "--seed", 3, "-o", "points.npy")
    points = np.load(FOLDER / "points.npy")
    # Exponents of all sizes, and the zero with a sign, are doubles like others.
    points[:40] *= 1e-12
    points[40, 0], points[41, 0] = 0.0, -0.0
    np.save(FOLDER / "points.npy", points)
    run("delaunay", "points.npy", "-o", "mesh.ele")
    mesh = read_pair("mesh")
    agree("the points of the mesh", mesh.points, points + 0.0)
    rng = np.random.default_rng(4)
    mesh.tags = rng.integers(-5, 100, len(mesh.points))
    mesh.regions = rng.integers(1, 6, len(mesh.tets))
    for direction in [
        ltbw_to_python,
        meshio_to_ltbw,
        vtk_to_ltbw,
        legacy_to_ltbw,
        numpy_to_ltbw,
        surfaces_to_ltbw,
    ]:
        direction(mesh)
    # Regions that are no physical groups.
    mesh.regions = rng.integers(-3, 4, len(mesh.tets))
    ltbw_to_python(mesh)
    parts_to_python()
    boundary_to_python()
    names_to_mfem()
    gmsh.finalize()
    for failure in failures:
        print(f"FAILED: {failure}")
    print(f"{checks} comparisons, {len(failures)} failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
