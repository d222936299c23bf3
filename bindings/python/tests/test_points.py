"""Meshes of points: what comes in, what comes out, and the same mesh as the program's."""

import json

import numpy as np
import pytest
from scipy.spatial import Delaunay

import ltbw


def cloud(n=500, seed=1):
    return np.random.default_rng(seed).random((n, 3))


@pytest.mark.parametrize("kind", ["uniform", "grid", "clusters", "sphere", "planes"])
@pytest.mark.parametrize("count", [100, 333, 2000, 12345])
def test_hash_is_the_programs(program, tmp_path, kind, count):
    path = tmp_path / "p.npy"
    program("generate", kind, count, "--seed", count, "-o", path)
    expected = program("delaunay", path).split()[-1]
    points = np.load(path)
    assert ltbw.delaunay(points).hash == expected
    assert ltbw.delaunay(points, threads=3).hash == expected


def test_simplices_are_scipys():
    points = cloud()
    ours, theirs = ltbw.delaunay(points), Delaunay(points)
    as_sets = lambda rows: {tuple(sorted(row)) for row in rows.tolist()}
    assert as_sets(ours.simplices) == as_sets(theirs.simplices)
    assert as_sets(ours.convex_hull) == as_sets(theirs.convex_hull)
    queries = np.random.default_rng(2).random((4, 25, 3)) * 1.5 - 0.25
    found, expected = ours.find_simplex(queries), theirs.find_simplex(queries)
    assert found.shape == (4, 25)
    inside = expected >= 0
    assert (inside == (found >= 0)).all() and inside.any() and not inside.all()
    same = zip(ours.simplices[found[inside]], theirs.simplices[expected[inside]])
    assert all(set(a) == set(b) for a, b in same)


def test_neighbours_are_across_faces():
    mesh = ltbw.delaunay(cloud())
    for t, (corners, across) in enumerate(zip(mesh.simplices, mesh.neighbors)):
        for k, other in enumerate(across):
            if other >= 0:
                shared = set(corners) & set(mesh.simplices[other])
                assert shared == set(corners) - {corners[k]}
                assert t in mesh.neighbors[other]
    assert (mesh.neighbors == -1).sum() == len(mesh.convex_hull)


def test_points_at_vertices_edges_and_faces_are_found():
    points = np.array([[x, y, z] for x in range(3) for y in range(3) for z in range(3)], float)
    mesh = ltbw.delaunay(points)
    for wanted in (points, points[:18] + [0.5, 0, 0], points[:18] + [0.5, 0.25, 0.0]):
        found = mesh.find_simplex(np.minimum(wanted, 2.0))
        assert (found >= 0).all()
    assert mesh.find_simplex([5.0, 0.0, 0.0]) == -1


@pytest.mark.parametrize(
    "change",
    [
        lambda p: p.astype(np.float32),
        np.asfortranarray,
        lambda p: np.repeat(p, 2, axis=0)[::2],
        lambda p: p[::-1][::-1],
        lambda p: p.tolist(),
        lambda p: p.astype(">f8"),
    ],
    ids=["float32", "fortran", "strided", "reversed", "lists", "big-endian"],
)
def test_any_layout_is_taken(change):
    points = cloud().astype(np.float32).astype(np.float64)
    assert ltbw.delaunay(change(points)).hash == ltbw.delaunay(points).hash


def test_points_are_removed():
    points = cloud()
    mesh = ltbw.delaunay(points, without=np.arange(10, 40), threads=2)
    assert mesh.hash == ltbw.delaunay(np.delete(points, np.s_[10:40], axis=0)).hash
    assert mesh.points.shape == points.shape and mesh.outcome == "complete"
    assert not np.isin(mesh.simplices, np.arange(10, 40)).any()
    assert mesh.check().passed
    # A place is removed once.
    doubled = np.vstack([points, points[:3]])
    mesh = ltbw.delaunay(doubled, without=[1, len(points) + 1])
    assert mesh.hash == ltbw.delaunay(np.delete(points, 1, axis=0)).hash
    assert [row[0] for row in mesh.coplanar.tolist()] == [len(points), len(points) + 2]


@pytest.mark.parametrize(
    "without, code, ids",
    [
        ([4, 5], "without.unknown", [5]),
        ([-1], "without.unknown", []),
        ([0.5], "without.type", []),
        ([[0]], "without.type", []),
        ([4, 3], "without.flat", [3]),
    ],
)
def test_points_that_cannot_be_removed(without, code, ids):
    points = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4], [1, 1, 1]]
    with pytest.raises(ltbw.InputError) as caught:
        ltbw.delaunay(points, without=without)
    assert caught.value.code == code and caught.value.ids == ids


def test_whole_numbers_and_duplicates():
    points = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4], [0, 0, 0], [4, 0, 0]]
    mesh = ltbw.delaunay(points)
    assert mesh.points.dtype == np.float64 and mesh.simplices.dtype == np.int32
    assert mesh.coplanar.tolist() == [[4, 0, 0], [5, 0, 1]]


@pytest.mark.parametrize(
    "points, code, ids",
    [
        (np.zeros((0, 3)), "points.too-few", []),
        ([], "points.too-few", []),
        (np.zeros((5, 3)), "points.too-few", []),
        (np.arange(12.0).reshape(4, 3), "points.collinear", []),
        (np.array([[x, y, 0] for x in (0, 1, 2) for y in (0, 1, 5)]), "points.coplanar", []),
        ([[0, 0, 0], [1, 0, np.nan], [0, 1, 0], [0, 0, 1]], "points.not-finite", [1]),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -np.inf, 1]], "points.not-finite", [3]),
        (np.zeros((5, 2)), "points.shape", []),
        (np.zeros(6), "points.shape", []),
        (np.zeros((2, 3, 3)), "points.shape", []),
        (np.zeros((5, 3), complex), "points.type", []),
        ([["a", "b", "c"]], "points.type", []),
        ([[0, 0, 0], [1, 0]], "points.type", []),
        (None, "points.type", []),
    ],
)
def test_what_is_no_point_set_is_told(points, code, ids):
    with pytest.raises(ltbw.InputError) as caught:
        ltbw.delaunay(points)
    assert (caught.value.code, caught.value.ids) == (code, ids)
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("threads", [0, -1, 1.5, 5000])
def test_threads_are_a_count(threads):
    with pytest.raises(ltbw.InputError):
        ltbw.delaunay(cloud(), threads=threads)


def test_certificates():
    points = cloud()
    mesh = ltbw.delaunay(points)
    full = mesh.check(full=True)
    assert mesh.check().passed and full.passed and full.hash == mesh.hash
    assert ltbw.check(points, mesh.simplices, all_points=True).passed
    theirs = Delaunay(points).simplices
    assert ltbw.check(points, theirs, any_order=True).passed
    for tets in (mesh.simplices, theirs):
        assert ltbw.check(points, tets, any_order=True, delaunay=True).passed
    broken = ltbw.check(points, mesh.simplices[1:], delaunay=True)
    assert not broken.passed and broken.defects
    assert not ltbw.check(points, [[0, 1, 2, 500], [0, 4, 2, 3]]).passed
    json.dumps(full.report)


# Five points: two tetrahedra on both sides of a triangle, or three around the edge through it.
PYRAMIDS = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 1], [1, 1, -1]]
TWO, THREE = [[0, 1, 2, 3], [0, 2, 1, 4]], [[3, 4, 1, 2], [3, 4, 2, 0], [3, 4, 0, 1]]


def test_a_mesh_is_judged_as_one_of_finite_elements(program, tmp_path):
    assert ltbw.delaunay(PYRAMIDS).simplices.shape == (3, 4)
    for tets, is_delaunay in ((THREE, True), (TWO, False)):
        found = ltbw.check(PYRAMIDS, tets, any_order=True)
        assert found.passed and not found.defects
        assert ("not_delaunay" in found.report["information_counts"]) == (not is_delaunay)
        assert found.quality["dihedral"]["least"][0] > 1
        assert found.quality["small_dihedral"] == [(1.0, 0), (5.0, 0)]
        value, tet = found.quality["least_scaled_jacobian"]
        assert 0 < value <= 1 and 0 <= tet < len(tets)
        assert ltbw.check(PYRAMIDS, tets, any_order=True, delaunay=True).passed == is_delaunay
    # Both ways of filling the body at once.
    doubled = ltbw.check(PYRAMIDS, TWO + THREE, any_order=True)
    assert not doubled and doubled.defects
    inverted = ltbw.check(PYRAMIDS, [[0, 1, 2, 3], [0, 1, 2, 4]])
    assert not inverted and inverted.report["mesh"]["negative_tets"] == 1
    # Without a corner it is not convex, and sound.
    points = cloud()
    mesh = ltbw.delaunay(points)
    hollow = mesh.simplices[(mesh.neighbors >= 0).all(axis=1)]
    assert ltbw.check(points, hollow) and not ltbw.check(points, hollow, delaunay=True)
    # The program finds the same.
    path = tmp_path / "m.vtu"
    mesh.save(path)
    program("check", path, "--json", tmp_path / "c.json")
    theirs, ours = json.loads((tmp_path / "c.json").read_text()), ltbw.check(points, mesh.simplices)
    assert theirs["passed"] and theirs["mesh"] == ours.report["mesh"]
    assert theirs["information_counts"] == ours.report["information_counts"]
    least = theirs["quality"]["dihedral"]["least"]
    assert ours.quality["dihedral"]["least"] == (least["value"], least["tet"])


def test_arrays_of_a_mesh_are_read_only(cube):
    doubled = ltbw.delaunay(np.vstack([cloud(), cloud()[:3]]))
    meshes = (doubled, ltbw.tetrahedralize(cube, regions=[([0.5, 0.5, 0.5], 2.0)]))
    names = "points simplices neighbors convex_hull coplanar triangles triface_markers regions"
    for mesh in meshes:
        digest = ltbw.check(mesh.points, mesh.simplices).hash
        for name in f"{names} region_attributes node elem triface".split():
            array = getattr(mesh, name)
            below = [array.base] if isinstance(array.base, np.ndarray) else []
            for view in (array, array[:], *below):
                assert not view.flags.writeable, name
                with pytest.raises(ValueError):
                    view.flags.writeable = True
            if array.size:
                with pytest.raises(ValueError, match="read-only"):
                    array[0] = 0
        grid, copy = mesh.grid, mesh.to_meshio()
        for theirs, ours in (
            (grid.points, mesh.points),
            (grid.cell_data["region"], mesh.regions),
            (copy.points, mesh.points),
            (copy.cells[0].data, mesh.simplices),
            (copy.cell_data["region"][0], mesh.regions),
        ):
            assert not np.shares_memory(theirs, ours)
            theirs[0] = 7
        assert ltbw.check(mesh.points, mesh.simplices).hash == digest
        found = mesh.find_simplex(mesh.points)
        found[0] = 7
    assert len(doubled.coplanar) == 3


def test_points_that_are_nearly_in_one_plane_are_told_of():
    flat = cloud() * [1, 1, 1e-9]
    (note,) = ltbw.delaunay(flat).notes
    assert note.startswith("the points are nearly in one plane: thickness ")
    assert ltbw.delaunay(cloud()).notes == []


def test_progress_is_told_and_may_end_the_work():
    told = []
    ltbw.delaunay(cloud(400_000), progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (400_000, 400_000)
    assert told and all(total in (None, 400_000) for _, total in told)
    mesh = ltbw.delaunay(cloud(400_000), progress=lambda done, total: done == 0)
    assert mesh.outcome == "cancelled" and mesh.check().passed

    def raises(done, total):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        ltbw.delaunay(cloud(400_000), progress=raises)


def test_a_panic_is_an_ordinary_exception():
    with pytest.raises(ltbw.InternalError, match="asked for") as caught:
        ltbw._native._panics()
    assert caught.value.code == "internal.panic" and isinstance(caught.value, Exception)


def test_arrays_are_made_once_and_without_a_copy():
    mesh = ltbw.delaunay(cloud())
    assert mesh.simplices is mesh.simplices and mesh.simplices.base is not None
    assert mesh.node is mesh.points and mesh.elem is mesh.simplices
