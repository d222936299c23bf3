"""A mesh without its kernel: what is left of one that went through pickle."""

import functools

import numpy as np

from . import _native

# The parts of a kernel that are kept as they are: a method, or an attribute, each.
METHODS = (
    "points",
    "simplices",
    "neighbors",
    "convex_hull",
    "coplanar",
    "boundary",
    "regions",
    "attributes",
    "excuses",
    "offset",
    "hash",
    "quality",
)


def _kept(name):
    def method(self):
        return self._parts[name]

    method.__name__ = name
    return method


class Stored:
    """Arrays and figures of a kernel; it answers as that did."""

    def __init__(self, parts, outcome, certificate):
        self._parts, self.outcome, self._certificate = parts, outcome, certificate

    @classmethod
    def of(cls, kernel):
        """What a kernel has."""
        if isinstance(kernel, cls):
            return kernel
        parts = {name: getattr(kernel, name)() for name in METHODS} | {"names": kernel.names}
        return cls(parts, kernel.outcome, kernel.certify(False))

    @property
    def names(self):
        """Names of groups."""
        return self._parts["names"]

    @functools.cached_property
    def _delaunay(self):
        # Every mesh of ours has tetrahedra of the one Delaunay mesh of its vertices.
        points, tets = self._parts["points"], self._parts["simplices"]
        used = np.zeros(len(points), bool)
        used[tets.ravel()] = True
        numbers = np.flatnonzero(used)
        kernel, _ = _native.delaunay(np.ascontiguousarray(points[numbers]), [], 1, None)
        own = {tuple(row): t for t, row in enumerate(np.sort(tets, axis=1).tolist())}
        theirs = np.sort(numbers[kernel.simplices()], axis=1).tolist()
        return kernel, np.array([own.get(tuple(row), -1) for row in theirs], np.int32)

    def find_simplex(self, xi):
        """As the kernel's."""
        kernel, own = self._delaunay
        found = kernel.find_simplex(xi)
        return np.where(found >= 0, own[found], np.int32(-1))

    def certify(self, full):
        """The certificate that the kernel had."""
        return self._certificate

    def save(self, path):
        """Writes the arrays."""
        _native.save(path, self._parts)


for _name in METHODS:
    setattr(Stored, _name, _kept(_name))
