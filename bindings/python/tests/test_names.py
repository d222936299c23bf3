"""Names that users of scipy, pyvista and TetGen look for; meshes that are copied and kept."""

import copy
import pickle

import numpy as np
import pytest
from scipy.spatial import Delaunay

import ltbw


def cloud(n=300, seed=4):
    return np.random.default_rng(seed).random((n, 3))


def by_corners(mesh, rows):
    """Values of tetrahedra by their corners."""
    return {tuple(sorted(t)): row for t, row in zip(mesh.simplices.tolist(), rows)}


def test_figures_are_scipys():
    points = cloud()
    ours, theirs = ltbw.delaunay(points), Delaunay(points)
    assert (ours.npoints, ours.nsimplex, ours.ndim) == (theirs.npoints, theirs.nsimplex, theirs.ndim)
    assert (ours.min_bound == theirs.min_bound).all()
    assert (ours.max_bound == theirs.max_bound).all()
    starts, neighbours = ours.vertex_neighbor_vertices
    for other, (k, begin) in zip(np.split(*reversed(theirs.vertex_neighbor_vertices)), enumerate(starts)):
        if k:
            own = neighbours[starts[k - 1] : begin]
            assert set(own) == set(other) and len(set(own)) == len(own)
    at = ours.vertex_to_simplex
    assert all(v in ours.simplices[t] for v, t in enumerate(at))


def test_transform_gives_barycentric_coordinates():
    mesh = ltbw.delaunay(cloud())
    places = np.random.default_rng(1).random((50, 3)) * 0.4 + 0.3
    for x, t in zip(places, mesh.find_simplex(places)):
        first = mesh.transform[t, :3] @ (x - mesh.transform[t, 3])
        weights = np.append(first, 1 - first.sum())
        assert (weights > -1e-9).all()
        assert np.allclose(weights @ mesh.points[mesh.simplices[t]], x)


def test_plane_distances_have_the_signs_of_scipys():
    points = cloud(100)
    ours, theirs = ltbw.delaunay(points), Delaunay(points)
    x = np.array([0.4, 0.5, 0.6])
    own = by_corners(ours, ours.plane_distance(x) > 0)
    other = by_corners(theirs, theirs.plane_distance(x)[: theirs.nsimplex] > 0)
    assert own == other and any(own.values()) and not all(own.values())
    assert np.allclose(np.linalg.norm(ours.equations[:, :4], axis=1), 1.0)
    assert ours.plane_distance(np.zeros((2, 5, 3))).shape == (2, 5, ours.nsimplex)


def test_flat_tetrahedra_have_no_transform():
    grid = np.stack(np.meshgrid(*[np.arange(3.0)] * 3), axis=-1).reshape(-1, 3)
    mesh = ltbw.delaunay(grid)
    volumes = np.linalg.det(np.diff(mesh.points[mesh.simplices], axis=1))
    assert (np.isnan(mesh.transform[:, 0, 0]) == (volumes == 0)).all()


def test_points_that_are_added_make_the_mesh_of_all():
    points = cloud(200)
    mesh = ltbw.delaunay(points[:150])
    kept = mesh.simplices
    mesh.add_points(points[150:])
    assert mesh.hash == ltbw.delaunay(points).hash and mesh.npoints == 200
    assert kept.max() < 150
    mesh.add_points(points[:20], restart=True)
    assert mesh.hash == ltbw.delaunay(points[:20]).hash


def same(one, other):
    assert one.hash == other.hash and one.outcome == other.outcome
    assert (one.points == other.points).all() and (one.simplices == other.simplices).all()
    assert (one.neighbors == other.neighbors).all() and (one.triangles == other.triangles).all()
    assert (one.regions == other.regions).all() and one.excuses == other.excuses
    assert (one.triface_markers == other.triface_markers).all() and one.notes == other.notes
    assert one.quality == other.quality


@pytest.mark.parametrize("through", [copy.copy, copy.deepcopy, "pickle"])
def test_meshes_are_copied(through, cube, tmp_path):
    if through == "pickle":
        through = lambda mesh: pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(mesh))))
    regions = [((0.5, 0.5, 0.5), 3.5)]
    points = np.concatenate([cloud(), cloud()[:3]])
    for mesh in (
        ltbw.delaunay(points, without=[5]),
        ltbw.tetrahedralize(cube, max_volume=0.02, regions=regions),
    ):
        again = through(mesh)
        same(mesh, again)
        places = np.random.default_rng(3).random((200, 3)) * 1.4 - 0.2
        assert (mesh.find_simplex(places) == again.find_simplex(places)).all()
        for end in ("vtu", "msh", "mesh"):
            one, other = tmp_path / f"one.{end}", tmp_path / f"other.{end}"
            mesh.save(one)
            again.save(other)
            assert one.read_bytes() == other.read_bytes(), end
        assert bool(again.check()) and again.check().report == mesh.check().report


def test_grids_carry_figures_and_surfaces_their_markers(cube):
    pytest.importorskip("pyvista")
    corners, faces = cube[0], cube[1]
    mesh = ltbw.tetrahedralize((corners, faces, list(range(1, 7))), max_volume=0.01)
    grid, surface = mesh.grid, mesh.surface
    angle, number = mesh.quality["dihedral"]["least"]
    assert np.isclose(grid.cell_data["dihedral"][number], angle)
    assert np.isclose(grid.cell_data["volume"].sum(), 1.0) and not grid.cell_data["excused"].any()
    assert (surface.cell_data["marker"] == mesh.triface_markers).all()
    assert np.isclose(surface.area, 6.0)
    assert ltbw.delaunay(corners).surface.n_cells == 12


def test_other_packages_names_are_told(cube):
    with pytest.raises(TypeError, match="no argument 'maxvolume': max_volume"):
        ltbw.tetrahedralize(cube, maxvolume=0.1)
    with pytest.raises(TypeError, match="'switches': each switch is an argument"):
        ltbw.tetrahedralize(cube, switches="pq1.2")
    with pytest.raises(TypeError, match="'max_volum': max_volume"):
        ltbw.tetrahedralize(cube, max_volum=0.1)
    with pytest.raises(TypeError, match="'qhull_options': not there"):
        ltbw.delaunay(cloud(10), qhull_options="QJ")


def test_defects_have_kinds_and_places(cube):
    corners, faces = cube[0], cube[1]
    with pytest.raises(ltbw.DomainError) as caught:
        ltbw.tetrahedralize((corners, faces[1:]))
    defects = caught.value.defects
    assert {d["kind"] for d in defects} == {"domain.leak"}, defects
    ends = sorted(sorted(edge) for d in defects for edge in d["edges"])
    assert ends == [[0, 1], [0, 2], [1, 3], [2, 3]]
    assert all(len(place) == 3 for d in defects for place in d["places"])
    pyvista = pytest.importorskip("pyvista")
    places = caught.value.to_pyvista()
    assert isinstance(places, pyvista.PolyData) and set(places.point_data["kind"]) == {"domain.leak"}


def test_what_users_call_comes_first():
    assert not any(name.endswith("Error") for name in ltbw.__all__)
    assert ltbw.errors.DomainError is ltbw.DomainError
    assert "delaunay" in ltbw.__doc__.splitlines()[3]
