"""Arguments as users give them: taken where their meaning is clear, else told by name and code."""

import multiprocessing

import numpy as np
import pytest

import ltbw


@pytest.fixture
def far(cube):
    """The cube, a hundred times as large, and far from the origin."""
    corners, faces = cube
    return np.asarray(corners) * 100.0 + [500_000.0, 4_500_000.0, 0.0], faces


def test_a_domain_far_from_the_origin_says_what_its_points_are_relative_to(far):
    corners, _ = far
    with pytest.warns(UserWarning, match="mesh.offset"):
        mesh = ltbw.tetrahedralize(far, max_volume=1e5)
    assert mesh.offset.any() and any("relative" in note for note in mesh.notes)
    shifted = mesh.points + mesh.offset
    assert np.allclose(shifted.min(0), corners.min(0)) and np.allclose(shifted.max(0), corners.max(0))
    # Queries and certificates are in the coordinates of the points.
    assert mesh.find_simplex(mesh.points[mesh.simplices[3]].mean(0)) == 3
    assert ltbw.check(mesh.points, mesh.simplices, far)


def test_the_frame_can_be_chosen(far, recwarn):
    corners, _ = far
    own = ltbw.tetrahedralize(far, max_volume=1e5, frame="own")
    assert not own.offset.any() and not own.notes
    assert (own.points.min(0) == corners.min(0)).all()
    assert own.find_simplex(corners.mean(0)) >= 0
    assert ltbw.check(own.points, own.simplices, far, frame="own")
    assert not ltbw.check(own.points, own.simplices, far)
    local = ltbw.tetrahedralize(far, max_volume=1e5, frame="local")
    assert local.offset.any() and not recwarn.list
    for wrong in ("world", None, 1):
        with pytest.raises(ltbw.InputError) as caught:
            ltbw.tetrahedralize(far, frame=wrong)
        assert caught.value.code == "frame.name"


def test_sizes_are_asked_in_the_surfaces_coordinates(far):
    seen = []

    def size(p):
        seen.append(p)
        return 60.0

    with pytest.warns(UserWarning):
        ltbw.tetrahedralize(far, size=size)
    low, high = far[0].min(0), far[0].max(0)
    assert seen and all((low <= p).all() and (p <= high).all() for p in np.array(seen))


def _worked(job):
    kind, surface = job
    if kind == "function":
        try:
            return ltbw.tetrahedralize(surface, size=lambda p: 0.5).outcome
        except ltbw.InputError as error:
            return error.code
    mesh = ltbw.tetrahedralize(surface, max_volume=0.01)
    return mesh.outcome, mesh.find_simplex([0.5, 0.4, 0.3]) >= 0, mesh.hash, bool(mesh.check())


@pytest.mark.skipif(
    "fork" not in multiprocessing.get_all_start_methods(), reason="processes are not forked here"
)
def test_forked_processes_work_or_raise(cube):
    mesh = ltbw.tetrahedralize(cube, max_volume=0.01)
    expected = ("met", True, mesh.hash, bool(mesh.check()))
    mesh.find_simplex([0.5, 0.4, 0.3])
    ltbw.check(mesh.points, mesh.simplices, cube)
    ltbw.tetrahedralize(cube, size=lambda p: 0.5)
    with multiprocessing.get_context("fork").Pool(1) as pool:
        assert pool.map_async(_worked, [("mesh", cube)]).get(60) == [expected]
        assert pool.map_async(_worked, [("function", cube)]).get(60) == ["threads.forked"]


def test_attributes_of_regions_come_back(cube):
    mesh = ltbw.tetrahedralize(cube, regions=[((0.5, 0.5, 0.5), 70.5)])
    assert mesh.region_attributes.tolist() == [70.5]
    assert (mesh.region_attributes[mesh.regions - 1] == 70.5).all()
    assert np.isnan(ltbw.tetrahedralize(cube).region_attributes).all()


@pytest.mark.parametrize("names, kind", [("gmsh", "gmsh22"), ("medit", "medit")])
def test_meshios_writers_get_markers(cube, tmp_path, names, kind):
    import meshio

    tag = {"gmsh": "gmsh:physical", "medit": "medit:ref"}[names]
    given = meshio.Mesh(
        cube[0],
        [("quad", cube[1])],
        cell_data={tag: [[11, 12, 13, 14, 15, 16]]},
        field_data={"floor": np.array([11, 2])},
    )
    mesh = ltbw.tetrahedralize(given, max_volume=0.05)
    path = tmp_path / {"gmsh22": "a.msh", "medit": "a.mesh"}[kind]
    mesh.to_meshio(names).write(path, file_format=kind)
    read = meshio.read(path)
    markers = read.cell_data_dict[tag]["triangle"]
    as_rows = lambda rows, m: sorted((*sorted(r), int(k)) for r, k in zip(rows.tolist(), m))
    assert as_rows(read.cells_dict["triangle"], markers) == as_rows(mesh.triangles, mesh.triface_markers)
    assert set(read.cell_data_dict[tag]["tetra"]) == {1}
    if kind == "gmsh22":
        assert read.field_data["floor"].tolist() == [11, 2]
    with pytest.raises(ltbw.InputError):
        mesh.to_meshio("abaqus")


def test_points_come_from_files_and_data_sets(tmp_path):
    meshio, pyvista = pytest.importorskip("meshio"), pytest.importorskip("pyvista")
    points = np.random.default_rng(1).random((60, 3))
    expected = ltbw.delaunay(points).hash
    np.save(tmp_path / "p.npy", points)
    assert ltbw.delaunay(tmp_path / "p.npy").hash == expected
    assert ltbw.delaunay(str(tmp_path / "p.npy")).hash == expected
    assert ltbw.delaunay(meshio.Mesh(points, [])).hash == expected
    assert ltbw.delaunay(pyvista.PolyData(points)).hash == expected
    with pytest.raises(ltbw.MissingFileError) as caught:
        ltbw.delaunay(tmp_path / "none.npy")
    error = caught.value
    assert isinstance(error, FileNotFoundError) and error.errno == 2
    assert str(error.filename) == str(tmp_path / "none.npy") and "none.npy" in str(error)


def test_masked_points_are_refused():
    points = np.random.default_rng(1).random((20, 3))
    with pytest.raises(ltbw.InputError) as caught:
        ltbw.delaunay(np.ma.masked_array(points, mask=points > 0.9))
    assert caught.value.code == "points.masked"
    plain = np.ma.masked_array(points, mask=False)
    assert ltbw.delaunay(plain).hash == ltbw.delaunay(points).hash


def test_grids_and_strips_of_pyvista(cube):
    pyvista = pytest.importorskip("pyvista")
    with pytest.raises(ltbw.InputError, match="extract_surface") as caught:
        ltbw.tetrahedralize(ltbw.tetrahedralize(cube).grid)
    assert caught.value.code == "surface.type"
    strips = pyvista.Cube().triangulate().strip()
    assert strips.n_strips > 0
    mesh = ltbw.tetrahedralize(strips)
    assert np.isclose(mesh.grid.volume, 1.0)


@pytest.mark.parametrize(
    "change, code",
    [
        (lambda c, f: ((c, [[0.5, 1.5, 2.0]]), {}), "faces.type"),
        (lambda c, f: ((c, [0, 1, 2]), {}), "faces.type"),
        (lambda c, f: ((c, f, [1.5] * 6), {}), "faces.markers"),
        (lambda c, f: ((c, f, [2**40] * 6), {}), "faces.markers"),
        (lambda c, f: ((c, f), {"check": "off"}), "check.type"),
        (lambda c, f: ((c, f), {"progress": 3}), "progress.type"),
        (lambda c, f: ((c, f), {"max_points": -1}), "max_points.count"),
        (lambda c, f: ((c, f), {"max_points": 1.5}), "max_points.count"),
        (lambda c, f: ((c, f), {"max_volume": "a"}), "max_volume.type"),
        (lambda c, f: ((c, f), {"regions": None}), "regions.layout"),
        (lambda c, f: ((c, f), {"regions": [((0.5,) * 3, 7, -1)]}), "regions.max_volume"),
        (lambda c, f: ((c, f), {"threads": None}), "threads.count"),
        (lambda c, f: ((c, f), {"threads": float("nan")}), "threads.count"),
        (lambda c, f: ((c, f), {"threads": float("inf")}), "threads.count"),
        (lambda c, f: ((c, f), {"size": [[1.0], [2.0, 3.0]]}), "size.type"),
    ],
)
def test_what_makes_no_sense_is_told_with_a_code(cube, change, code):
    surface, wishes = change(*cube)
    with pytest.raises(ltbw.InputError) as caught:
        ltbw.tetrahedralize(surface, **wishes)
    assert caught.value.code == code, caught.value


def test_a_vertex_that_is_no_place_is_named(cube):
    corners, faces = cube
    corners[3] = [0.0, np.nan, 0.0]
    with pytest.raises(ltbw.DomainError) as caught:
        ltbw.tetrahedralize((corners, faces))
    assert caught.value.ids == [3]


def test_whole_floats_and_infinite_bounds_are_taken(cube):
    few = ltbw.tetrahedralize(cube, max_volume=1e-5, max_points=1e2)
    assert few.outcome == "budget"
    bare = ltbw.tetrahedralize(cube, max_volume=np.inf)
    assert bare.hash == ltbw.tetrahedralize(cube).hash


def test_numpys_false_ends_the_work(cube):
    stopped = ltbw.tetrahedralize(cube, max_volume=3e-6, progress=lambda *_: np.bool_(False))
    assert stopped.outcome == "cancelled"


def test_certificates_are_true_or_false(cube):
    mesh = ltbw.tetrahedralize(cube, max_volume=0.05)
    assert ltbw.check(mesh.points, tets=mesh.simplices)
    assert not ltbw.check(mesh.points, tets=mesh.simplices[1:], plc=cube)
    with pytest.raises(ltbw.InputError) as caught:
        ltbw.check(mesh.points, [[0, 1, 2, 3], [0, -1, 2, 3]])
    assert (caught.value.code, caught.value.ids) == ("tets.index", [1])
    with pytest.raises(ltbw.InputError):
        ltbw.check(mesh.points, [[0, 1, 2, 3], [0, 1]])
    assert not ltbw.check(mesh.points, [[0, 1, 2, 10**6]])
