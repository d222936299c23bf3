"""Exactly Delaunay tetrahedral meshes of points and of polyhedral domains.

======================================  =====================================================
``ltbw.delaunay(points)``               the Delaunay mesh of points
``ltbw.tetrahedralize(surface, ...)``   the mesh of a domain: a file, arrays, pyvista, meshio
``ltbw.check(points, tets, ...)``       anybody's mesh, checked exactly
``mesh.points``, ``mesh.simplices``     its arrays; ``mesh.grid``, ``mesh.plot()``: pyvista's
``ltbw.errors``                         the exceptions, each of them a name of ``ltbw``, too
======================================  =====================================================

The same input has the same mesh, whatever the number of threads: :attr:`Mesh.hash` tells.

>>> import ltbw, numpy as np
>>> cube = np.array([[x, y, z] for x in (0., 1.) for y in (0., 1.) for z in (0., 1.)])
>>> mesh = ltbw.delaunay(cube)
>>> mesh.simplices.shape
(6, 4)
>>> bool(mesh.check().passed)
True
"""

from . import _input, _markers, _native, errors
from .errors import (  # noqa: F401
    Cancelled,
    DomainError,
    Error,
    FileError,
    InputError,
    InternalError,
    MachineError,
    MissingFileError,
    RecoveryError,
)
from ._mesh import Certificate, Mesh, check
from ._synonyms import helpful

__version__ = _native.__version__

# Exceptions are in `errors`: what users call comes first in `help(ltbw)`.
__all__ = ["Certificate", "Mesh", "check", "delaunay", "errors", "tetrahedralize"]


def _threads(threads):
    return _input.whole(threads, "threads", "threads.count", 1, 4096)


@helpful
def delaunay(points, threads=1, *, without=(), progress=None):
    """The Delaunay mesh of points, exact for any input.

    Parameters
    ----------
    points : array_like of shape (n, 3), path, or anything with ``points``
        Finite coordinates: an array, a file (``.npy .xyz .txt .csv .ply`` ...), a pyvista data set
        or a meshio mesh. Duplicates are allowed: the first of them is the vertex.
    threads : int
        Threads to work with; the mesh is the same for any number.
    without : array_like of int, optional
        Numbers of points to remove from the mesh, which is that of the others then. ``points`` and
        numbers stay: those removed are in no tetrahedron. Duplicates go with their vertex.
    progress : callable, optional
        ``progress(done, total)`` is called some twenty times a second; ``total`` is None where it is
        not known. An exception ends the work and comes back; ``False`` ends it and keeps the
        mesh so far, with the outcome ``"cancelled"``; :class:`Cancelled` if there is none yet.

    Returns
    -------
    Mesh
        Its ``notes`` tell of points that are nearly in one plane, whose tetrahedra are as flat.

    Raises
    ------
    InputError
        Points that are not finite (``ids`` has the first), or do not span space; numbers that are
        no point's, or without which there is no mesh.

    >>> import ltbw
    >>> ltbw.delaunay([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]).simplices.shape
    (1, 4)
    """
    array = _input.places(points)
    without = _input.numbers(without, "without", "without.type")
    progress = _input.function(progress, "progress")
    kernel, notes = _native.delaunay(array, without, _threads(threads), progress)
    return Mesh(kernel, notes=notes)


@helpful
def tetrahedralize(
    surface,
    *,
    max_volume=None,
    radius_edge=2.0,
    min_dihedral=8.0,
    smooth=0,
    size=None,
    max_edge=None,
    near=(),
    size_at=None,
    curvature=None,
    growth=1.3,
    background=None,
    points=None,
    regions=(),
    holes=None,
    max_points=None,
    repair=0.0,
    fill=0,
    simplify=0.0,
    flat_tolerance=None,
    feature_angle=None,
    exact_input=False,
    strict=False,
    frame="auto",
    progress=None,
    threads=1,
    check=True,
    excused_share=0.01,
):
    """A conforming Delaunay mesh of a polyhedral domain, with bounds that are met exactly.

    Parameters
    ----------
    surface : path, tuple, pyvista.PolyData, meshio.Mesh, or anything with vertices and faces
        The domain: a file (``.poly .smesh .off .obj .stl .ply .vtk``); ``(vertices, faces)`` or
        ``(vertices, faces, markers)``, faces as an array of shape (f, 3) or lists of corners. Of a
        pyvista or meshio surface, ``cell_data`` with a usual name (``marker``, ``gmsh:physical``,
        ``medit:ref``, ...) are the markers; where it is not clear which, a warning tells.
    max_volume : float, optional
        The largest volume of a tetrahedron.
    radius_edge : float or None
        The largest ratio of circumradius to shortest edge, at least 1; None: any shape.
    min_dihedral : float
        Tetrahedra with a dihedral angle of less than so many degrees are split where a point serves,
        at most 12; 0: none is. Nothing is done without ``radius_edge``.
    smooth : int
        Sweeps, at most 16, in which vertices inside are moved when all bounds are met, each where
        the smallest dihedral angle around rises; the mesh stays Delaunay, and within its bounds.
    size : float, array or callable, optional
        Usual edge length: one for all, one for each vertex of the surface, or ``size(p)`` for a
        place ``p = (x, y, z)``, or ``size(x, y, z)``. The mean edge is within 10 % of it where the
        surface is no finer. A function is called from the calling thread only, has to give the same
        answer for the same place, and may raise: its exception comes back as it is.
    max_edge : float, optional
        No edge is longer, exactly.
    near : sequence of (place, length) or (place, length, radius)
        Edges of a length within a radius of a place, in the surface's coordinates.
    size_at : dict, optional
        Edges of a length at parts of the boundary, by name (:attr:`Mesh.parts`) or marker.
    curvature : float, optional
        Edges in a full turn of a curved surface: 2πr / ``curvature`` at a radius of r.
    growth : float
        The factor by which edges grow from one to the next, away from where these are shorter.
    background : Mesh, tuple, meshio.Mesh, optional
        The mesh that ``size`` has a number for each point of, instead of the surface: that of a
        solution, say. ``(points, tetrahedra)``, or what has ``points`` and ``simplices``.
    points : array_like of shape (p, 3), path, or anything with ``points``, optional
        Points that are vertices of the mesh, too. Within three steps of the lattice of the boundary
        they are put on it; those outside are left out: :attr:`Mesh.notes` tell. Those that are left
        follow the surface's vertices in :attr:`Mesh.points`, but for duplicates.
    regions : sequence of (point, attribute) or (point, attribute, max_volume)
        A point in each region with properties of its own.
    holes : "none", "auto", or array_like of shape (h, 3), optional
        What is void. Without it the file's hole points and the surface's orientation say that: a
        body inside another is a void if its faces point the other way, else a region of its own.
        "none": nothing. "auto": bodies inside others, however turned. Points: what has one (and
        of a file what has one of its own); orientation means nothing then, even if there are none.
    max_points : int, optional
        The most points to insert; a mesh that needs more has the outcome ``"budget"``.
    repair : float
        Weld vertices within this distance and close seams as far apart.
    fill : int
        Close holes of up to so many edges by triangles, at most 256; 0: none. A note tells.
    simplify : float
        Collapse triangles within this distance before meshing, at most 5 % of the diagonal; 0: none.
        Vertices that are left are vertices of the surface; topology, markers and sharp edges stay.
        A note of :attr:`Mesh.notes` bounds how far the surfaces are apart.
    flat_tolerance : float, optional
        Facets that are coplanar within this distance are taken for one: triangles of a smooth
        surface that are flat up to rounding. At most 2**-10 of the diagonal; 0: exactly coplanar.
        By default, for surfaces, the larger of 2**-22 of the diagonal and what the numbers tell:
        two steps of the largest where all are float32, two units of the last decimal where they
        have 5 to 15 digits.
    feature_angle : float, optional
        A surface without markers has parts, smooth within so many degrees, with the markers 1, 2,
        ... by area and place: :attr:`Mesh.parts`. By default 40 for surfaces, at most 90; 0: none.
        The mesh does not depend on it.
    exact_input : bool
        Refuse a domain that is not exactly on its lattice.
    strict : bool
        Refuse input that would be repaired, of which something would be left out or guessed, points
        outside among them: :class:`DomainError`.
    frame : {"auto", "own", "local"}
        The coordinates of the mesh: the surface's own, or those from the middle of the domain, which
        are finer where it lies far from the origin. ``"auto"``: local ones where the distance takes
        two bits or more of the coordinates; a warning says so, and :attr:`Mesh.offset` is what
        ``points`` are relative to.
    progress : callable, optional
        As for :func:`delaunay`.
    threads : int
        Threads for refining, sorting and checking; with a size function one thread refines.
    check : bool
        Check the mesh against the domain, by independent code: :attr:`Mesh.certificate`.
    excused_share : float
        The certificate is true if at most this share of the tetrahedra, and of their volume, is
        excused from a bound; at most 0.05.

    Returns
    -------
    Mesh
        Its ``outcome`` is ``"met"``, or ``"excused"`` where input angles are too small for the
        bounds: ``excuses`` lists these tetrahedra, and the certificate says ``excused``, or
        ``failed`` where they are more than ``excused_share``.

    Raises
    ------
    DomainError
        The surface is open, or crosses itself, ...: the message names the places.
    RecoveryError
        The boundary could not be brought into the mesh.
    InputError
        Bounds or arguments that make no sense.

    >>> import ltbw
    >>> cube = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    >>> faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    >>> mesh = ltbw.tetrahedralize((cube, faces), max_volume=0.01)
    >>> mesh.outcome, mesh.certificate.passed
    ('met', True)
    """
    wishes = _input.wishes(
        **_input.bounds(max_volume, radius_edge, flat_tolerance),
        min_dihedral=_input.number(min_dihedral, "min_dihedral", "min_dihedral.type"),
        max_edge=None if max_edge is None else _input.number(max_edge, "max_edge", "max_edge.type"),
        near=_input.near(near),
        size_at=_input.size_at(size_at or {}),
        curvature=None
        if curvature is None
        else _input.number(curvature, "curvature", "curvature.type"),
        growth=_input.number(growth, "growth", "growth.type"),
        smooth=_input.whole(smooth, "smooth", "smooth.count", 0, 16),
        size=_input.size(size) if background is None else _input.size_on(background, size),
        max_points=None
        if max_points is None
        else _input.whole(max_points, "max_points", "max_points.count", 0, 2**63),
        holes=_input.holes(holes),
        regions=_regions(regions),
        repair=_input.number(repair, "repair", "repair.type"),
        fill=_input.whole(fill, "fill", "fill.count", 0, 256),
        simplify=_input.number(simplify, "simplify", "simplify.type"),
        feature_angle=None
        if feature_angle is None
        else _input.number(feature_angle, "feature_angle", "feature_angle.type"),
        exact_input=_input.truth(exact_input, "exact_input"),
        strict=_input.truth(strict, "strict"),
        own_frame=_input.frame(frame),
        check=_input.truth(check, "check"),
        excused_share=_input.number(excused_share, "excused_share", "excused_share.type"),
        threads=_threads(threads),
    )
    source, progress = _input.surface(surface), _input.function(progress, "progress")
    more = None if points is None else _input.places(points)
    kernel, certificate, notes = _native.tetrahedralize(source, wishes, more, progress)
    mesh = Mesh(kernel, certificate, notes, getattr(surface, "field_data", None))
    if frame == "auto" and mesh.offset.any():
        _markers.warn(
            "the domain lies far from the origin: points of the mesh are relative to "
            f"mesh.offset, {mesh.offset.tolist()}; frame='own' keeps the surface's coordinates, "
            "frame='local' asks for this"
        )
    return mesh


def _regions(given):
    try:
        return [_region(region) for region in given]
    except TypeError as error:
        raise InputError(f"regions: a sequence, not {given!r}", "regions.layout") from error


def _region(given):
    try:
        point, attribute, *volume = given
        x, y, z = point
        volume = None if not volume or volume[0] is None else float(volume[0])
        if volume is not None and not volume > 0.0:
            text = f"regions: {given!r}: the largest volume is positive"
            raise InputError(text, "regions.max_volume")
        return (float(x), float(y), float(z)), float(attribute), volume
    except InputError:
        raise
    except (TypeError, ValueError) as error:
        text = f"regions: (point, attribute) or (point, attribute, max_volume), not {given!r}"
        raise InputError(text, "regions.layout") from error
