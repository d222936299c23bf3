"""The mesh and its certificate, with the names that users of scipy and pyvista know."""

import functools
import json
import os

import numpy as np

from . import _input, _native
from .errors import InputError
from ._scipy import ScipyNames
from ._stored import Stored


class Certificate:
    """The findings of the independent checker.

    ``verdict`` is ``"passed"``: nothing is wrong; ``"excused"``: it is over its bounds only where
    that has a reason, on no more than ``excused_share`` of :func:`tetrahedralize`; or ``"failed"``.
    A certificate is true for the first two. ``passed`` tells whether nothing is wrong; ``defects``
    are the first defects or breaches, as dicts; ``report`` is all of it (schemas ``ltbw.cert/1``
    and ``ltbw.conformity/1``). ``quality``, of anybody's mesh without a domain, is like that of
    :class:`Mesh`, else None.
    """

    def __init__(self, text, quality=None):
        self.report = json.loads(text)
        self.quality = quality
        self.passed = self.report["passed"]
        self.verdict = self.report.get("verdict", "passed" if self.passed else "failed")
        self.defects = self.report.get("defects", []) + self.report.get("breaches", [])

    @property
    def hash(self):
        """The canonical hash ``ltbw.mesh/1``, if the checker made one."""
        return self.report.get("mesh", {}).get("hash")

    def __bool__(self):
        return self.verdict != "failed"

    def __repr__(self):
        return f"<ltbw.Certificate {self.verdict}>"


def check(
    points,
    tets,
    plc=None,
    *,
    max_volume=None,
    radius_edge=None,
    flat_tolerance=None,
    frame="auto",
    any_order=False,
    all_points=False,
    delaunay=False,
):
    """Checks anybody's mesh, as one of finite elements: points that are not there, degenerate,
    inverted and overlapping tetrahedra, hanging nodes, faces of three tetrahedra are defects.

    Pieces, pinched edges and vertices, the Delaunay property and convexity are information in
    ``report``. With a domain a mesh is judged as :func:`tetrahedralize` makes it: it is Delaunay,
    and every facet is a union of triangles of the mesh, which fills the domain, has no exterior,
    and keeps the bounds.

    Parameters
    ----------
    points : array_like of shape (n, 3)
    tets : array_like of int, of shape (m, 4)
    plc : optional
        A domain, as :func:`tetrahedralize` takes it.
    max_volume, radius_edge : float, optional
        Bounds that every tetrahedron has to keep; with a domain only.
    flat_tolerance : float, optional
        As for :func:`tetrahedralize`; with a domain only.
    frame : {"auto", "own", "local"}
        The coordinates of ``points``, as for :func:`tetrahedralize`; with a domain only. Meshes of
        others are in the domain's own.
    any_order : bool
        The order of a tetrahedron's corners means nothing (scipy and Qhull write such meshes).
    all_points : bool
        Every point has to be a vertex; without a domain only.
    delaunay : bool
        The mesh has to be Delaunay and convex; without a domain only.

    >>> import ltbw
    >>> points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> ltbw.check(points, [[0, 1, 2, 3]], any_order=True)
    <ltbw.Certificate passed>
    """
    array = _input.coordinates(points)
    rows = _input.corners(tets, 4, "tets")
    any_order = _input.truth(any_order, "any_order")
    all_points = _input.truth(all_points, "all_points")
    delaunay = _input.truth(delaunay, "delaunay")
    wishes = _input.bounds(max_volume, radius_edge, flat_tolerance)
    if plc is None:
        given = [name for name, value in wishes.items() if value is not None]
        if given:
            raise InputError(f"{', '.join(given)}: with a domain only", "check.bounds")
        return Certificate(*_native.check(array, rows, any_order, all_points, delaunay))
    for name, asked in (("all_points", all_points), ("delaunay", delaunay)):
        if asked:
            raise InputError(f"{name}: without a domain only", f"check.{name}")
    surface = _input.surface(plc)
    wishes = _input.wishes(**wishes, own_frame=_input.frame(frame))
    text = _native.check_domain(array, rows, any_order, surface, wishes)
    return Certificate(text)


def _shapes(points, tets):
    """The least dihedral angle, in degrees, and the volume of each tetrahedron, rounded."""
    corners = points[tets]
    faces = [(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)]
    normals = [
        np.cross(corners[:, b] - corners[:, a], corners[:, c] - corners[:, a]) for a, b, c in faces
    ]
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = [n / np.linalg.norm(n, axis=1)[:, None] for n in normals]
    cosines = [-(unit[i] * unit[j]).sum(axis=1) for i in range(4) for j in range(i)]
    largest = np.clip(np.max(cosines, axis=0), -1.0, 1.0) if len(tets) else np.zeros(0)
    volumes = np.abs(((corners[:, 1] - corners[:, 0]) * normals[1]).sum(axis=1)) / 6.0
    return np.degrees(np.arccos(largest)), volumes


class Mesh(ScipyNames):
    """A tetrahedral mesh. Arrays are made when they are first asked for, and kept: they are
    read-only, as they are for all who ask. ``mesh.points.copy()`` may be changed. Meshes go through
    ``pickle`` and ``copy``; the rest of scipy's names is there, too.

    ============================  =====================  ==========================================
    here                          elsewhere              meaning
    ============================  =====================  ==========================================
    ``points``                    ``node`` (tetgen)      coordinates, float64, (n, 3)
    ``simplices``                 ``elem`` (tetgen)      corners of tetrahedra, int32, (m, 4)
    ``neighbors``                 scipy                  across the face opposite each corner, or -1
    ``convex_hull``               scipy                  facets of the convex hull, (h, 3)
    ``coplanar``                  scipy                  duplicates: point, tetrahedron, vertex, (d, 3)
    ``triangles``                 ``triface``            boundary triangles of a domain, (b, 3)
    ``triface_markers``           tetgen                 their facets' markers, (b,)
    ``parts``                                            parts of the boundary: name -> triangles
    ``regions``                                          region of each tetrahedron, from 1, (m,)
    ``region_attributes``                                attribute of each region, (r,)
    ``grid``, ``surface``         pyvista                the mesh, its boundary, with data of cells
    ============================  =====================  ==========================================
    """

    def __init__(self, kernel, certificate=None, notes=(), field_data=None):
        self._kernel = kernel
        # Names of groups that a meshio surface came with: (marker, dimension) each.
        self._names = dict(field_data or {})
        for dimension, number, name in kernel.names:
            self._names.setdefault(name, np.array([number, dimension]))
        self.certificate = None if certificate is None else Certificate(certificate)
        self.notes = list(notes)

    def __reduce__(self):
        kept = Stored.of(self._kernel)
        certificate = None if self.certificate is None else json.dumps(self.certificate.report)
        return Mesh, (kept, certificate, self.notes, self._names)

    def __deepcopy__(self, memo):
        # All of it is read-only, or made anew.
        return self.__copy__()

    def __copy__(self):
        certificate = None if self.certificate is None else json.dumps(self.certificate.report)
        return Mesh(self._kernel, certificate, self.notes, self._names)

    def _rebuild(self, points):
        if len(self.triangles) or self.outcome != "complete":
            raise InputError("add_points: of a mesh of points only", "add_points.domain")
        kernel, notes = _native.delaunay(np.ascontiguousarray(points), [], 1, None)
        self.__dict__.clear()
        self.__init__(kernel, notes=notes)

    @property
    def outcome(self):
        """``complete``, ``met``, ``excused``, ``budget`` or ``cancelled``."""
        return self._kernel.outcome

    @functools.cached_property
    def points(self):
        """Coordinates, float64, (n, 3)."""
        return self._kernel.points()

    @functools.cached_property
    def simplices(self):
        """Corners of the tetrahedra, int32, (m, 4)."""
        return self._kernel.simplices()

    @functools.cached_property
    def neighbors(self):
        """Across the face opposite each corner the tetrahedron there, or -1; int32, (m, 4)."""
        return self._kernel.neighbors()

    @functools.cached_property
    def convex_hull(self):
        """Facets of the convex hull, seen counterclockwise from outside; int32, (h, 3)."""
        return self._kernel.convex_hull()

    @functools.cached_property
    def coplanar(self):
        """Duplicates: point, a tetrahedron at the vertex in its place, that vertex; int32, (d, 3)."""
        return self._kernel.coplanar()

    @functools.cached_property
    def _boundary(self):
        return self._kernel.boundary()

    @property
    def triangles(self):
        """Boundary triangles of a domain, inner facets too; int32, (b, 3)."""
        return self._boundary[0]

    @property
    def triface_markers(self):
        """The markers of the boundary triangles' facets; int64, (b,)."""
        return self._boundary[1]

    @functools.cached_property
    def parts(self):
        """The parts of the boundary by name: numbers of ``triangles``, as a dict.

        Names are those of the solids of an ``.stl`` file, the groups and materials of an ``.obj`` file,
        the colours of a ``.ply`` or ``.off`` file, or the groups of a meshio surface; else ``"part 1"``
        and so on, the smooth parts of a surface without markers, the largest first; other markers
        are named by their numbers, ``"marker 5"``.

        >>> import ltbw
        >>> cube = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
        >>> faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        >>> mesh = ltbw.tetrahedralize((cube, faces))
        >>> sorted(mesh.parts)
        ['part 1', 'part 2', 'part 3', 'part 4', 'part 5', 'part 6']
        >>> mesh.points[mesh.triangles[mesh.parts["part 1"]]][..., 0].max().item()
        0.0
        """
        names = {int(group[0]): name for name, group in self._names.items() if int(group[1]) == 2}
        markers = self.triface_markers
        name = lambda marker: names.get(marker, f"marker {marker}")
        return {name(int(m)): np.flatnonzero(markers == m) for m in np.unique(markers)}

    @functools.cached_property
    def regions(self):
        """The region of each tetrahedron, from 1; int32, (m,)."""
        return self._kernel.regions()

    @functools.cached_property
    def region_attributes(self):
        """The attribute of each region, that of region 1 first; NaN where ``regions`` of
        :func:`tetrahedralize` gave none. ``region_attributes[regions - 1]`` is one for each
        tetrahedron."""
        return self._kernel.attributes()

    node = property(lambda self: self.points, doc="The same as ``points``.")
    elem = property(lambda self: self.simplices, doc="The same as ``simplices``.")
    triface = property(lambda self: self.triangles, doc="The same as ``triangles``.")

    @functools.cached_property
    def excuses(self):
        """The tetrahedra over a bound: (number, reason)."""
        return self._kernel.excuses()

    @property
    def offset(self):
        """The place that ``points`` are relative to, of a domain far from the origin: ``points +
        offset`` are, rounded, in the surface's coordinates. Else zeros."""
        return np.array(self._kernel.offset())

    @functools.cached_property
    def hash(self):
        """The canonical hash ``ltbw.mesh/1``: a function of the mesh alone."""
        return self._kernel.hash()

    @functools.cached_property
    def quality(self):
        """Histograms of ``dihedral`` (degrees), ``radius_edge``, ``volume``, ``edge``: each a dict with
        ``low, high, counts`` and ``least, largest`` as (value, tetrahedron); ``least_scaled_jacobian``,
        a pair, too; ``small_dihedral``: the tetrahedra below 1 and 5 degrees, as (angle, count).
        ``least_dihedral``: the tetrahedra by their smallest dihedral angle, a dict with ``low, high,
        counts`` (by whole degrees) and ``least``; ``least_dihedral_before`` is the same before
        slivers were split, of a domain, or None.

        >>> import ltbw
        >>> cube = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
        >>> faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        >>> quality = ltbw.tetrahedralize((cube, faces), max_volume=1e-3).quality
        >>> sum(quality["least_dihedral"]["counts"][:8])
        0
        >>> sum(quality["least_dihedral_before"]["counts"][:8]) > 0
        True
        """
        return self._kernel.quality()

    def find_simplex(self, xi):
        """For each point of ``xi``, of shape (..., 3), a tetrahedron that holds it, or -1. Exact.

        Coordinates are those of ``points``.

        >>> import ltbw
        >>> mesh = ltbw.delaunay([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
        >>> mesh.find_simplex([[0.1, 0.1, 0.1], [1, 1, 1]]).tolist()
        [0, -1]
        """
        array = np.asarray(xi)
        flat = _input.coordinates(array.reshape(-1, array.shape[-1]) if array.ndim else array, "xi")
        return self._kernel.find_simplex(flat).reshape(array.shape[:-1])

    def check(self, *, full=False):
        """Checks the mesh: of points that it is their canonical Delaunay mesh, adjacency and hull
        included; of a domain it is the certificate that came with it."""
        text = self._kernel.certify(bool(full))
        return self.certificate if text is None else Certificate(text)

    def save(self, path):
        """Writes the mesh: ``.vtu .vtk .msh .mesh .ele``. ``.msh`` and ``.vtu`` have the names of
        parts; names that a meshio surface came with are in :meth:`to_meshio` alone."""
        self._kernel.save(os.fspath(path))

    def to_meshio(self, names="ltbw"):
        """The mesh as a ``meshio.Mesh`` of its own arrays: tetrahedra with regions, boundary with
        markers.

        ``names`` are those of the data of cells: ``"ltbw"``: ``region`` and ``marker``; those that
        meshio's writers of other programs look for: ``"gmsh"`` (``gmsh:physical``, for
        ``file_format="gmsh22"``; :meth:`save` writes 4.1) or ``"medit"`` (``medit:ref``, for
        ``.mesh``). Names of groups of a meshio surface are in ``field_data``.
        """
        import meshio

        regions, cells = self.regions.copy(), [("tetra", self.simplices.copy())]
        markers = self.triface_markers.astype(np.int32)
        if len(self.triangles):
            cells.append(("triangle", self.triangles.copy()))
        both = [regions, markers][: len(cells)]
        if names == "ltbw":
            none = [regions, np.zeros(len(markers), np.int32)], [0 * regions, markers]
            data = {name: all[: len(cells)] for name, all in zip(("region", "marker"), none)}
        elif names == "gmsh":
            data = {"gmsh:physical": both, "gmsh:geometrical": both}
        elif names == "medit":
            data = {"medit:ref": both}
        else:
            text = f"names: 'ltbw', 'gmsh' or 'medit', not {names!r}"
            raise InputError(text, "meshio.names")
        return meshio.Mesh(self.points.copy(), cells, cell_data=data, field_data=self._names)

    @functools.cached_property
    def grid(self):
        """The mesh as a ``pyvista.UnstructuredGrid`` of its own arrays. Data of cells: ``region``,
        ``dihedral`` (the least angle, degrees), ``volume``; of a domain ``excused`` (0 or 1), too."""
        import pyvista

        count = len(self.simplices)
        cells = np.column_stack([np.full(count, 4, np.int64), self.simplices]).ravel()
        kinds = np.full(count, pyvista.CellType.TETRA, np.uint8)
        grid = pyvista.UnstructuredGrid(cells, kinds, self.points.copy())
        grid.cell_data["region"] = self.regions.copy()
        grid.cell_data["dihedral"], grid.cell_data["volume"] = _shapes(self.points, self.simplices)
        if len(self.triangles):
            excused = np.zeros(count, np.uint8)
            excused[[number for number, _ in self.excuses]] = 1
            grid.cell_data["excused"] = excused
        return grid

    @functools.cached_property
    def surface(self):
        """The boundary as a ``pyvista.PolyData``: of a domain its triangles with the data ``marker``,
        of points their convex hull."""
        import pyvista

        rows = self.triangles if len(self.triangles) else self.convex_hull
        faces = np.column_stack([np.full(len(rows), 3, np.int64), rows]).ravel()
        surface = pyvista.PolyData(self.points.copy(), faces)
        if len(self.triangles):
            surface.cell_data["marker"] = self.triface_markers.copy()
        return surface

    def plot(self, *, cut=True, scalars="dihedral", **options):
        """Shows the mesh by pyvista: cut open at the middle of its box across (1, 1, 0), whole
        tetrahedra, coloured by a name of the data of :attr:`grid`. ``options`` are those of
        ``pyvista.DataSet.plot``."""
        grid = self.grid
        if cut:
            middles = grid.cell_centers().points
            side = (middles - np.asarray(grid.center)) @ (1.0, 1.0, 0.0)
            grid = grid.extract_cells(np.flatnonzero(side <= 0.0))
        return grid.plot(**{"scalars": scalars, "show_edges": True, **options})

    def __repr__(self):
        return f"<ltbw.Mesh of {len(self.simplices)} tetrahedra, {self.outcome}>"
