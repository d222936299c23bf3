"""What users of scipy.spatial.Delaunay look for, made of a mesh's arrays."""

import functools

import numpy as np

from . import _input


def _moved(mesh):
    """The tetrahedra's corners from the last on: that, the three edges, six times the volume."""
    corners = mesh.points[mesh.simplices]
    last = corners[:, 3]
    edges = corners[:, :3] - last[:, None]
    volume = np.einsum("ij,ij->i", edges[:, 0], np.cross(edges[:, 1], edges[:, 2]))
    return last, edges, volume


def _crossed(edges):
    """For each edge the cross product of the two others, in a turn."""
    a, b, c = edges[:, 0], edges[:, 1], edges[:, 2]
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)


class ScipyNames:
    """Names of ``scipy.spatial.Delaunay``. Rounded, where they are not whole numbers: no decision of
    ltbw depends on them."""

    # A point lies on a paraboloid of this scale and shift in four dimensions.
    paraboloid_scale, paraboloid_shift = 1.0, 0.0
    ndim = 3

    @property
    def npoints(self):
        """Number of points."""
        return len(self.points)

    @property
    def nsimplex(self):
        """Number of tetrahedra."""
        return len(self.simplices)

    @property
    def min_bound(self):
        """The least coordinates, (3,)."""
        return self.points.min(axis=0)

    @property
    def max_bound(self):
        """The largest coordinates, (3,)."""
        return self.points.max(axis=0)

    @functools.cached_property
    def vertex_to_simplex(self):
        """A tetrahedron at each point, or -1; int32, (n,)."""
        at = np.full(len(self.points), -1, np.int32)
        numbers = np.arange(len(self.simplices), dtype=np.int32)
        # The first tetrahedron of a vertex is written last.
        at[self.simplices[::-1].ravel()] = np.repeat(numbers[::-1], 4)
        return at

    @functools.cached_property
    def vertex_neighbor_vertices(self):
        """Neighbours of vertices as ``(indptr, indices)``: those of point k are
        ``indices[indptr[k]:indptr[k + 1]]``, in ascending order."""
        count = len(self.points)
        pairs = [self.simplices[:, [i, j]] for i in range(4) for j in range(4) if i != j]
        both = np.concatenate(pairs).astype(np.int64) if pairs else np.zeros((0, 2), np.int64)
        keys = np.unique(both[:, 0] * count + both[:, 1])
        starts = np.searchsorted(keys, np.arange(count + 1) * count)
        return starts.astype(np.int32), (keys % count).astype(np.int32)

    @functools.cached_property
    def transform(self):
        """Barycentric coordinates: ``transform[t, :3] @ (x - transform[t, 3])`` are the first three
        of ``x`` in tetrahedron ``t``, one less their sum the fourth; NaN where it is flat; (m, 4, 3)."""
        last, edges, volume = _moved(self)
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = _crossed(edges) / volume[:, None, None]
        inverse[volume == 0.0] = np.nan
        return np.concatenate([inverse, last[:, None]], axis=1)

    @functools.cached_property
    def equations(self):
        """The tetrahedra's hyperplanes through the points that are lifted onto a paraboloid: a normal
        of length 1 and an offset, ``normal @ lifted + offset`` is positive inside the sphere; (m, 5)."""
        last, edges, volume = _moved(self)
        squares = np.einsum("ijk,ijk->ij", edges, edges)
        with np.errstate(divide="ignore", invalid="ignore"):
            ball = np.einsum("ij,ijk->ik", squares, _crossed(edges)) / (2.0 * volume[:, None])
        centre = last + ball
        height = np.einsum("ij,ij->i", ball, ball) - np.einsum("ij,ij->i", centre, centre)
        rows = np.column_stack([2.0 * centre, np.full(len(centre), -1.0), height])
        return rows / np.linalg.norm(rows[:, :4], axis=1)[:, None]

    def lift_points(self, x):
        """Points of shape (..., 3) on the paraboloid, (..., 4)."""
        x = np.asarray(x, np.float64)
        return np.concatenate([x, (x * x).sum(axis=-1, keepdims=True)], axis=-1)

    def plane_distance(self, xi):
        """Distances of lifted points ``xi``, (..., 3), to all hyperplanes, (..., m)."""
        lifted = self.lift_points(xi)
        return lifted @ self.equations[:, :4].T + self.equations[:, 4]

    def add_points(self, points, restart=False):
        """Adds points to a mesh of points, behind those that are there; arrays made before stay as
        they are. The mesh is that of all points, as if they had been there at once: it is made anew.

        >>> import ltbw
        >>> mesh = ltbw.delaunay([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
        >>> mesh.add_points([[1, 1, 1]])
        >>> mesh.npoints, mesh.nsimplex
        (5, 2)
        """
        more = _input.coordinates(points)
        self._rebuild(more if restart else np.concatenate([self.points, more]))
