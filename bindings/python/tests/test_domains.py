"""Meshes of domains: sources, bounds, sizes, and the same mesh as the program's."""

import functools
import math
import pickle

import numpy as np
import pytest

import ltbw

DOMAINS = ["cube-octahedron", "cube-in-cube", "tee", "gear", "wedge"]


@pytest.mark.parametrize("kind", DOMAINS)
def test_hash_is_the_programs(program, tmp_path, kind):
    path = tmp_path / "d.poly"
    program("generate", kind, "-o", path)
    expected = program("mesh", path).split()[-1]
    mesh = ltbw.tetrahedralize(path)
    assert mesh.hash == expected and mesh.outcome == "met" and mesh.certificate.passed


def test_arrays_make_the_same_mesh_as_a_file(cube, tmp_path):
    corners, faces = cube
    path = tmp_path / "cube.off"
    lines = ["OFF", f"{len(corners)} {len(faces)} 0"]
    lines += [" ".join(map(str, p)) for p in corners]
    lines += [" ".join(map(str, [len(f), *f])) for f in faces]
    path.write_text("\n".join(lines) + "\n")
    from_file = ltbw.tetrahedralize(path, max_volume=0.01)
    assert ltbw.tetrahedralize((corners, faces), max_volume=0.01).hash == from_file.hash
    assert ltbw.tetrahedralize(str(path), max_volume=0.01, threads=2).hash == from_file.hash


def test_boundary_and_markers(cube):
    corners, faces = cube
    mesh = ltbw.tetrahedralize((corners, faces, range(10, 16)), max_volume=0.01)
    assert sorted(set(mesh.triface_markers.tolist())) == [10, 11, 12, 13, 14, 15]
    # The boundary of the unit cube has the area 6.
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    assert np.isclose(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2, 6.0)
    for face in mesh.triangles[:10]:
        assert any(set(face) <= set(tet) for tet in mesh.simplices)
    assert (mesh.regions == 1).all()
    assert (mesh.find_simplex([[0.5, 0.5, 0.5], [2, 0, 0]]) >= 0).tolist() == [True, False]


def test_sizes_refine_where_they_are_small(cube):
    bare = len(ltbw.tetrahedralize(cube).simplices)
    constant = ltbw.tetrahedralize(cube, size=0.2)
    at_vertices = ltbw.tetrahedralize(cube, size=[0.1] * 4 + [0.5] * 4)
    called = []

    def size(p):
        called.append(p)
        return 0.1 + 0.4 * p[0]

    by_function = ltbw.tetrahedralize(cube, size=size)
    assert all(mesh.outcome == "met" for mesh in (constant, at_vertices, by_function))
    assert len(constant.simplices) > 10 * bare
    assert len(called) > 100 and all(isinstance(p, tuple) and len(p) == 3 for p in called)
    for mesh in (at_vertices, by_function):
        middle = mesh.points[mesh.simplices].mean(axis=1)
        assert (middle[:, 0] < 0.5).sum() > 2 * (middle[:, 0] > 0.5).sum()


def test_sizes_may_be_those_of_a_solution(cube):
    # The field of a function at the vertices of a coarse mesh, linear in between.
    coarse = ltbw.tetrahedralize(cube, size=0.3)
    sizes = 0.06 + 0.4 * coarse.points[:, 0]
    fine = ltbw.tetrahedralize(cube, size=sizes, background=coarse)
    again = ltbw.tetrahedralize(cube, size=sizes, background=(coarse.points, coarse.simplices))
    assert fine.outcome == "met" and fine.hash == again.hash
    assert fine.hash == ltbw.tetrahedralize(cube, size=sizes, background=coarse.to_meshio()).hash
    middle = fine.points[fine.simplices].mean(axis=1)
    assert (middle[:, 0] < 0.5).sum() > 4 * (middle[:, 0] > 0.5).sum()
    # Points of a background mesh are places of the surface, wherever that lies.
    far = (np.array(cube[0]) + 2.0**20, cube[1])
    on = (coarse.points + 2.0**20, coarse.simplices)
    with pytest.warns(UserWarning, match="far from the origin"):
        assert len(ltbw.tetrahedralize(far, size=sizes, background=on).simplices) > 100
    for wrong in (
        {"size": sizes[1:], "background": coarse},
        {"size": 0.1, "background": coarse},
        {"background": coarse},
        {"size": sizes, "background": 7},
        {"size": sizes, "background": (coarse.points, [])},
        {"size": sizes, "background": (coarse.points, [[0, 1, 2, len(sizes)]])},
    ):
        with pytest.raises(ltbw.InputError):
            ltbw.tetrahedralize(cube, **wrong)


def test_angles_are_counted_before_slivers_are_split_and_after(cube):
    mesh = ltbw.tetrahedralize(cube, max_volume=1e-3)
    before, after = mesh.quality["least_dihedral_before"], mesh.quality["least_dihedral"]
    assert (after["low"], after["high"], len(after["counts"])) == (0.0, 72.0, 72)
    assert sum(after["counts"]) == len(mesh.simplices)
    assert sum(after["counts"][:8]) == 0 < sum(before["counts"][:8])
    assert before["least"] < 8 <= after["least"] == pytest.approx(mesh.quality["dihedral"]["least"][0])
    # As many as there are without slivers, in a mesh with them.
    plain = ltbw.tetrahedralize(cube, max_volume=1e-3, min_dihedral=0).quality
    assert plain["least_dihedral_before"] is None and plain["least_dihedral"] == before
    two = ltbw.tetrahedralize(cube, max_volume=1e-3, threads=2).quality
    assert two["least_dihedral_before"] == before
    assert ltbw.delaunay(mesh.points).quality["least_dihedral_before"] is None
    assert pickle.loads(pickle.dumps(mesh)).quality == mesh.quality


def test_vertices_inside_are_moved(cube):
    plain = ltbw.tetrahedralize(cube, max_volume=1e-3)
    mesh = ltbw.tetrahedralize(cube, max_volume=1e-3, smooth=2)
    assert mesh.certificate.passed and len(mesh.points) == len(plain.points)
    least = lambda m: m.quality["dihedral"]["least"][0]
    assert mesh.hash != plain.hash and least(mesh) >= least(plain)
    assert ltbw.check(mesh.points, mesh.simplices, cube, max_volume=1e-3, radius_edge=2).passed
    for wrong in (17, -1, 0.5):
        with pytest.raises(ltbw.InputError):
            ltbw.tetrahedralize(cube, smooth=wrong)


def test_points_are_vertices(cube, program, tmp_path):
    inside, on_facet, on_edge = [0.25, 0.375, 0.625], [1.0, 0.25, 0.75], [0.125, 1.0, 0.0]
    outside, corner = [0.5, 0.5, 1.5], [1.0, 1.0, 1.0]
    given = [outside, inside, on_facet, corner, on_edge, inside]
    mesh = ltbw.tetrahedralize(cube, points=given)
    assert mesh.outcome == "met" and mesh.certificate.passed
    assert mesh.points[8:11].tolist() == [inside, on_facet, on_edge]
    assert set(range(11)) <= set(mesh.simplices.ravel().tolist())
    assert "1 point left out: outside" in mesh.notes
    told = "given: 3 points: 1 inside, 1 on facets, 1 on edges; 2 are at a vertex, or given twice"
    assert told in mesh.notes
    # As the program does, by any number of threads, and through files.
    np.save(tmp_path / "p.npy", np.array(given))
    lines = ["OFF", f"{len(cube[0])} {len(cube[1])} 0"]
    lines += [" ".join(map(str, p)) for p in cube[0]]
    lines += [" ".join(map(str, [len(f), *f])) for f in cube[1]]
    (tmp_path / "c.off").write_text("\n".join(lines) + "\n")
    expected = program("mesh", tmp_path / "c.off", "--points", tmp_path / "p.npy").split()[-1]
    assert mesh.hash == expected
    assert ltbw.tetrahedralize(cube, points=tmp_path / "p.npy", threads=2).hash == expected
    with pytest.raises(ltbw.DomainError) as caught:
        ltbw.tetrahedralize(cube, points=given, strict=True)
    assert caught.value.code == "domain.strict" and "outside" in str(caught.value)
    assert ltbw.tetrahedralize(cube, points=given[1:], strict=True).hash == expected
    for wrong in ([[0.0, 1.0]], [[np.nan] * 3], "nothing.npy"):
        with pytest.raises(ltbw.Error):
            ltbw.tetrahedralize(cube, points=wrong)


def test_a_size_function_may_raise(cube):
    class Mine(Exception):
        pass

    def raises(p):
        raise Mine("no size here")

    with pytest.raises(Mine, match="no size here"):
        ltbw.tetrahedralize(cube, size=raises)
    with pytest.raises(TypeError):
        ltbw.tetrahedralize(cube, size=lambda p: "wide")


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan")])
def test_a_size_that_is_no_length_is_told_with_its_place(cube, bad):
    with pytest.raises(ltbw.InputError, match="size at .* is"):
        ltbw.tetrahedralize(cube, size=lambda p: bad)
    with pytest.raises(ltbw.InputError):
        ltbw.tetrahedralize(cube, size=bad)
    with pytest.raises(ltbw.InputError) as caught:
        ltbw.tetrahedralize(cube, size=[1.0] * 5 + [bad] + [1.0] * 2)
    assert caught.value.ids == [5]


def test_regions_and_holes(cube):
    corners, faces = cube
    inner = (np.array(corners) * 0.5 + 0.25).tolist()
    both = (corners + inner, faces + [[v + 8 for v in f] for f in faces])
    regions = [((0.5, 0.5, 0.5), 7.0, 1e-3), ((0.1, 0.1, 0.1), 3.0)]
    mesh = ltbw.tetrahedralize(both, holes=[], regions=regions)
    assert set(mesh.regions.tolist()) == {1, 2}
    with_hole = ltbw.tetrahedralize(both, holes=[[0.5, 0.5, 0.5]])
    volume = lambda m: volumes(m).sum()
    assert np.isclose(volume(mesh), 1.0) and np.isclose(volume(with_hole), 0.875)
    assert volumes(mesh)[mesh.regions == mesh.regions[mesh.find_simplex([0.5, 0.5, 0.5])]].max() <= 1e-3
    with pytest.raises(ltbw.InputError):
        ltbw.tetrahedralize(both, regions=[1.0])


def volumes(mesh):
    a, b, c, d = (mesh.points[mesh.simplices[:, k]] for k in range(4))
    return np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)) / 6


@pytest.mark.parametrize(
    "change, error, code",
    [
        (lambda c, f: (c, f[:5]), ltbw.DomainError, "domain.defects"),
        (lambda c, f: (c, []), ltbw.DomainError, None),
        (lambda c, f: (c, [[0, 1, 99]]), ltbw.InputError, "faces.index"),
        (lambda c, f: (c, [[0, 1, -2]]), ltbw.InputError, "faces.index"),
        (lambda c, f: (c, np.zeros((2, 3))), ltbw.InputError, "faces.type"),
        (lambda c, f: (c, f, [1, 2]), ltbw.InputError, "faces.markers"),
        (lambda c, f: ([[np.nan] * 3] + c[1:], f), ltbw.DomainError, None),
        (lambda c, f: 17, ltbw.InputError, "surface.type"),
        (lambda c, f: "nothing.stl", ltbw.FileError, "file.read"),
        (lambda c, f: "nothing.docx", ltbw.InputError, "file.format"),
    ],
)
def test_what_is_no_domain_is_told(cube, change, error, code):
    with pytest.raises(error) as caught:
        ltbw.tetrahedralize(change(*cube))
    assert code in (None, caught.value.code), caught.value


@pytest.mark.parametrize("wish", [{"max_volume": -1.0}, {"radius_edge": 0.5}, {"repair": -1.0}, {"flat_tolerance": -1.0}, {"simplify": -1.0},
                                  {"simplify": math.nan}, {"simplify": 0.09}, {"min_dihedral": 12.5}, {"min_dihedral": math.nan},
                                  {"min_dihedral": -1.0}])
def test_bounds_that_make_no_sense_are_told(cube, wish):
    with pytest.raises(ltbw.InputError):
        ltbw.tetrahedralize(cube, **wish)


def test_budget_and_progress(cube):
    few = ltbw.tetrahedralize(cube, max_volume=1e-5, max_points=100)
    assert few.outcome == "budget"
    told = []
    ltbw.tetrahedralize(cube, max_volume=3e-6, progress=lambda *figures: told.append(figures))
    assert told
    stopped = ltbw.tetrahedralize(cube, max_volume=3e-6, progress=lambda *_: False)
    assert stopped.outcome == "cancelled" and stopped.certificate is None


def test_files_are_read_back(cube, tmp_path):
    import meshio

    mesh = ltbw.tetrahedralize((cube[0], cube[1], range(6)), max_volume=0.01)
    for name in ("a.vtu", "a.mesh", "a.msh"):
        mesh.save(tmp_path / name)
        read = meshio.read(tmp_path / name)
        assert len(read.cells_dict["tetra"]) == len(mesh.simplices), name
        kinds = {"a.vtu": "marker", "a.mesh": "medit:ref", "a.msh": "gmsh:physical"}
        markers = read.cell_data_dict[kinds[name]]["triangle"]
        # Gmsh has no group 0: the free one, 6, is named `marker 0`.
        expected = np.where((mesh.triface_markers == 0) & (name == "a.msh"), 6, mesh.triface_markers)
        as_rows = lambda rows, m: sorted((*sorted(r), int(k)) for r, k in zip(rows.tolist(), m))
        found = as_rows(read.cells_dict["triangle"], markers)
        assert found == as_rows(mesh.triangles, expected), name
    assert read.field_data["marker 0"].tolist() == [6, 2]
    with pytest.raises(ltbw.InputError):
        mesh.save(tmp_path / "a.docx")
    with pytest.raises(ltbw.FileError):
        mesh.save(tmp_path / "no" / "a.vtu")
    own = mesh.to_meshio()
    assert len(own.cells_dict["triangle"]) == len(mesh.triangles)
    own.write(tmp_path / "b.vtu")
    # A meshio mesh of the boundary is a surface again.
    shell = meshio.Mesh(mesh.points, [("triangle", mesh.triangles)])
    assert ltbw.tetrahedralize(shell).outcome == "met"


def test_a_surface_is_simplified():
    # A cube whose sides are cut into 6 by 6 squares, of two triangles each.
    n, numbers, faces = 6, {}, []
    for axis in range(3):
        for end in (0, n):
            for i in range(n):
                for j in range(n):
                    square = []
                    for a, b in [(0, 0), (1, 0), (1, 1), (0, 1)][:: 1 if end else -1]:
                        corner = [0, 0, 0]
                        corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3] = end, i + a, j + b
                        square.append(numbers.setdefault(tuple(corner), len(numbers)))
                    faces += [square[:3], [square[0], *square[2:]]]
    points = np.array(list(numbers), dtype=float)
    mesh = ltbw.tetrahedralize((points, faces), simplify=0.01)
    assert any(note.startswith("simplified: 432 triangles became ") for note in mesh.notes)
    assert mesh.certificate.passed
    assert len(mesh.points) < len(ltbw.tetrahedralize((points, faces)).points) / 2


def test_pyvista_surfaces_and_grids(cube):
    pyvista = pytest.importorskip("pyvista")
    box = pyvista.Box(level=2).triangulate()
    mesh = ltbw.tetrahedralize(box, max_volume=0.05)
    assert mesh.outcome == "met"
    assert np.isclose(mesh.grid.volume, box.volume)
    assert mesh.grid.n_cells == len(mesh.simplices)
    grid = box.ltbw.tetrahedralize(max_volume=0.05)
    assert grid.n_cells == mesh.grid.n_cells
    # Quads of a torus are flat up to rounding.
    torus = pyvista.ParametricTorus(u_res=25, v_res=25, w_res=25).triangulate().clean()
    exactly = ltbw.tetrahedralize(torus, flat_tolerance=0.0)
    assert exactly.certificate.report["patches"] == 0
    within = ltbw.tetrahedralize(torus, flat_tolerance=1e-6)
    assert within.certificate.passed and within.certificate.report["patches"] > 0
    assert len(within.simplices) < len(exactly.simplices)
    usual = ltbw.tetrahedralize(torus)
    assert usual.certificate.passed and usual.certificate.report["patches"] > 0
    assert ltbw.delaunay(box.points).grid.n_cells == box.ltbw.delaunay().n_cells


def areas(mesh):
    """The area of the boundary by marker."""
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    return {int(m): round(area[mesh.triface_markers == m].sum(), 9) for m in set(mesh.triface_markers)}


@pytest.mark.parametrize("name", ["marker", "gmsh:physical", "medit:ref", "MarkerId"])
def test_markers_of_meshios_surfaces_are_kept(cube, name, tmp_path):
    import meshio

    corners, faces = cube
    triangles = [[a, b, c] for a, b, c, _ in faces[:2]] + [[a, c, d] for a, _, c, d in faces[:2]]
    blocks = [("triangle", triangles), ("line", [[0, 1]]), ("quad", faces[2:])]
    data = {name: [[4, 5, 4, 5], [77], [6, 7, 8, -9]], "other": [[1.5] * 4, [0], [2] * 4]}
    # Data that is none of ours may have any shape.
    data["apart"] = [np.zeros((4, 3)), [0], np.zeros(4)]
    given = meshio.Mesh(corners, blocks, cell_data=data)
    expected = {4: 1.0, 5: 1.0, 6: 1.0, 7: 1.0, 8: 1.0, -9: 1.0}
    assert areas(ltbw.tetrahedralize(given, max_volume=0.01)) == expected
    # And through a file, as meshio names them there.
    mesh = ltbw.tetrahedralize((corners, faces, range(1, 7)))
    for file in ("a.msh", "a.mesh", "a.vtu"):
        mesh.save(tmp_path / file)
        assert areas(ltbw.tetrahedralize(meshio.read(tmp_path / file))) == dict.fromkeys(range(1, 7), 1.0)


def test_markers_of_pyvistas_surfaces_are_kept(cube):
    pyvista = pytest.importorskip("pyvista")
    corners, faces = cube
    poly = pyvista.PolyData(np.array(corners), np.hstack([[4, *f] for f in faces]))
    # Its smooth parts.
    assert areas(ltbw.tetrahedralize(poly)) == dict.fromkeys(range(1, 7), 1.0)
    assert areas(ltbw.tetrahedralize(poly, feature_angle=0)) == {0: 6.0}
    poly.cell_data["marker"] = [3, 1, 4, 1, 5, 9]
    poly.cell_data["Normals"] = np.zeros((6, 3))
    expected = {3: 1.0, 1: 2.0, 4: 1.0, 5: 1.0, 9: 1.0}
    assert areas(ltbw.tetrahedralize(poly)) == expected
    grid = poly.ltbw.tetrahedralize()
    assert grid.n_cells == len(ltbw.tetrahedralize(poly).simplices)
    # Cells of lines come before those of faces.
    with_line = pyvista.PolyData(np.array(corners), np.hstack([[4, *f] for f in faces]), lines=[2, 0, 1])
    with_line.cell_data["MarkerId"] = [77, 3, 1, 4, 1, 5, 9]
    assert areas(ltbw.tetrahedralize(with_line)) == expected


def test_markers_that_are_not_clear_are_warned_about(cube):
    pyvista = pytest.importorskip("pyvista")
    corners, faces = cube
    poly = pyvista.PolyData(np.array(corners), np.hstack([[4, *f] for f in faces]))
    poly.cell_data["gmsh:physical"] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    poly.cell_data["medit:ref"] = [7] * 6
    with pytest.warns(UserWarning, match="'gmsh:physical' is taken for markers, not 'medit:ref'"):
        mesh = ltbw.tetrahedralize(poly)
    assert areas(mesh) == dict.fromkeys(range(1, 7), 1.0)
    for bad in ([0.5] * 6, [2**31] * 6, [np.nan] * 6):
        other = pyvista.PolyData(np.array(corners), np.hstack([[4, *f] for f in faces]))
        other.cell_data["marker"] = bad
        with pytest.warns(UserWarning, match="not taken for markers"):
            assert areas(ltbw.tetrahedralize(other, feature_angle=0)) == {0: 6.0}


def test_neighbours_in_a_domain_are_across_faces(cube):
    mesh = ltbw.tetrahedralize(cube, max_volume=0.01)
    for corners, across in zip(mesh.simplices, mesh.neighbors):
        for k, other in enumerate(across):
            if other >= 0:
                assert corners[k] not in mesh.simplices[other]
                assert set(np.delete(corners, k)) <= set(mesh.simplices[other])


def test_anybodys_mesh_is_checked_against_its_domain(cube):
    corners, faces = cube
    mesh = ltbw.tetrahedralize(cube, max_volume=0.01)
    points, tets = mesh.points, mesh.simplices
    assert ltbw.check(points, tets, cube, max_volume=0.01, radius_edge=2).passed
    small = ltbw.check(points, tets, plc=cube, max_volume=1e-4)
    assert not small.passed
    assert [c["breach"] for c in small.report["breach_counts"]] == ["volume_exceeded"]
    assert not ltbw.check(points, tets[1:], cube).passed
    moved = np.asarray(corners, dtype=float) * [1, 1, 2]
    assert not ltbw.check(points, tets, (moved, faces)).passed
    shuffled = tets.copy()
    shuffled[0] = shuffled[0][[1, 0, 2, 3]]
    assert not ltbw.check(points, shuffled, cube).passed
    assert ltbw.check(points, shuffled, cube, any_order=True).passed
    with pytest.raises(ltbw.DomainError):
        ltbw.check(points, tets, (corners, faces[1:]))
    for wrong in ({"max_volume": 1}, {"plc": cube, "all_points": True}, {"plc": cube, "delaunay": True}):
        with pytest.raises(ltbw.InputError):
            ltbw.check(points, tets, **wrong)


def test_a_certificate_has_three_words():
    # Around the poles of a sphere angles are too small for the bound.
    rows, columns = 30, 30
    angles = np.pi * np.arange(1, rows - 1) / (rows - 1)
    around = 2 * np.pi * np.arange(columns) / columns
    rings = [
        [np.sin(a) * np.cos(b) / 2, np.sin(a) * np.sin(b) / 2, np.cos(a) / 2]
        for a in angles
        for b in around
    ]
    vertices = np.array([[0, 0, 0.5], *rings, [0, 0, -0.5]], np.float32)
    south = len(vertices) - 1

    def at(row, column):
        return 1 + row * columns + column % columns

    faces = []
    for i in range(columns):
        faces += [[0, at(0, i), at(0, i + 1)], [south, at(rows - 3, i + 1), at(rows - 3, i)]]
        for row in range(1, rows - 2):
            (a, b), (c, d) = (at(row - 1, i), at(row - 1, i + 1)), (at(row, i), at(row, i + 1))
            faces += [[a, c, d], [a, d, b]]
    sphere = (vertices, faces)
    mesh = ltbw.tetrahedralize(sphere, max_volume=5e-5)
    assert mesh.outcome == "excused" and 0 < len(mesh.excuses) < 0.01 * len(mesh.simplices)
    assert mesh.certificate and mesh.certificate.verdict == "excused"
    assert repr(mesh.certificate) == "<ltbw.Certificate excused>" and not mesh.certificate.passed
    strict = ltbw.tetrahedralize(sphere, max_volume=5e-5, excused_share=0)
    assert strict.hash == mesh.hash and strict.outcome == "excused"
    assert not strict.certificate and strict.certificate.verdict == "failed"
    for share in (0.051, -0.01, float("nan")):
        with pytest.raises(ltbw.InputError) as caught:
            ltbw.tetrahedralize(sphere, excused_share=share)
        assert caught.value.code == "refine.bound"
    cube = ltbw.check(np.eye(4, 3), [[0, 1, 2, 3]], any_order=True)
    assert cube and cube.verdict == "passed"


def edges(mesh):
    """The lengths of the edges."""
    pairs = [mesh.simplices[:, [i, j]] for i in range(4) for j in range(i)]
    ends = np.unique(np.sort(np.vstack(pairs), axis=1), axis=0)
    return np.linalg.norm(mesh.points[ends[:, 0]] - mesh.points[ends[:, 1]], axis=1)


def test_sizes_are_usual_and_longest_edges(cube):
    assert 0.9 < edges(ltbw.tetrahedralize(cube, size=0.1)).mean() / 0.1 < 1.1
    by_function = ltbw.tetrahedralize(cube, size=lambda p: 0.1)
    assert by_function.hash == ltbw.tetrahedralize(cube, size=0.1).hash

    def graded(x, y, z, least=0.1):
        return least + 0.3 * x + 0.1 * (y - z) ** 2

    by_place = ltbw.tetrahedralize(cube, size=lambda p: graded(*p))
    for function in (graded, lambda x, y, z: graded(x, y, z), functools.partial(graded, least=0.1)):
        assert ltbw.tetrahedralize(cube, size=function).hash == by_place.hash
    assert ltbw.tetrahedralize(cube, size=lambda *p: 0.1).hash == by_function.hash
    with pytest.raises(TypeError):
        ltbw.tetrahedralize(cube, size=lambda x, y: 0.1)
    longest = ltbw.tetrahedralize(cube, max_edge=0.2)
    assert longest.certificate.passed and edges(longest).max() <= 0.2


def test_edges_are_short_near_places_and_at_parts(cube, program, tmp_path):
    path = tmp_path / "cube.off"
    corners, faces = cube
    lines = ["OFF", f"{len(corners)} {len(faces)} 0"]
    lines += [" ".join(map(str, p)) for p in corners]
    lines += [" ".join(map(str, [len(f), *f])) for f in faces]
    path.write_text("\n".join(lines) + "\n")
    near = {"near": [((1, 1, 1), 0.05, 0.2)], "size_at": {"part 1": 0.1}, "growth": 1.5}
    mesh = ltbw.tetrahedralize(path, size=0.3, **near)
    options = "--size 0.3 --near 1,1,1:0.05:0.2 --size-at 1:0.1 --growth 1.5"
    assert mesh.hash == program("mesh", path, *options.split()).split()[-1]
    assert ltbw.tetrahedralize(cube, size=lambda p: 0.3, **near).hash == mesh.hash
    for name, wrong in (
        ("near", [((1, 1), 0.1)]),
        ("near", [((1, 1, 1), -1.0)]),
        ("size_at", {"nothing": 0.1}),
        ("size_at", 3),
        ("growth", 0.5),
        ("feature_angle", 100),
        ("max_edge", -1),
    ):
        more = {"near": near["near"]} if name == "growth" else {}
        with pytest.raises(ltbw.InputError):
            ltbw.tetrahedralize(cube, **{**more, name: wrong})


def test_parts_have_names(cube, tmp_path):
    mesh = ltbw.tetrahedralize(cube)
    assert list(mesh.parts) == [f"part {k}" for k in range(1, 7)]
    assert sorted(np.concatenate(list(mesh.parts.values()))) == list(range(len(mesh.triangles)))
    assert not ltbw.tetrahedralize(cube, feature_angle=0).triface_markers.any()
    corners, faces = cube
    marked = ltbw.tetrahedralize((corners, faces, range(10, 16)))
    assert "marker 10" in marked.parts
    path = tmp_path / "named.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    for k, face in enumerate(faces):
        lines += [f"g {'bottom' if k == 0 else 'rest'}", "f " + " ".join(str(v + 1) for v in face)]
    path.write_text("\n".join(lines) + "\n")
    named = ltbw.tetrahedralize(path)
    assert set(named.parts) == {"bottom", "rest"}
    axis = np.ptp(named.points[named.triangles[named.parts["bottom"]]].reshape(-1, 3), axis=0)
    assert (axis == 0).sum() == 1
    named.save(tmp_path / "named.msh")
    assert '"bottom"' in (tmp_path / "named.msh").read_bytes().decode("latin-1")
    assert ltbw.delaunay(corners).parts == {}
