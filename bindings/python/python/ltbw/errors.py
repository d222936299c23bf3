"""Exceptions of ltbw: each has a code that stays the same between versions, and the numbers of the
elements that are at fault."""


class Error(Exception):
    """Base of all exceptions of ltbw.

    ``code`` is a short name that stays the same between versions; ``ids`` are the numbers of the
    points, vertices or faces at fault, counted from 0. ``defects`` are those of a surface: dicts with
    ``kind``, ``text``, ``vertices``, ``facets``, ``edges`` (by their ends) and ``places``.
    """

    def __init__(self, message, code="", ids=()):
        super().__init__(message)
        self.code = code
        self.ids = list(ids)
        self.defects = []

    def to_pyvista(self):
        """The places of the defects as a ``pyvista.PolyData`` of points, with the number of its
        defect (``defect``) and its kind (``kind``) for each."""
        import pyvista

        rows = [(k, d["kind"], place) for k, d in enumerate(self.defects) for place in d["places"]]
        places = pyvista.PolyData([place for _, _, place in rows] or None)
        places.point_data["defect"] = [k for k, _, _ in rows]
        places.point_data["kind"] = [kind for _, kind, _ in rows]
        return places


class InputError(Error, ValueError):
    """The arguments are no points, no surface, or no bounds that a mesh can meet."""


class DomainError(Error, ValueError):
    """The surface bounds nothing that can be meshed: open, doubled, touching or crossing parts."""


class RecoveryError(Error, RuntimeError):
    """The surface could not be brought into a Delaunay mesh; the message names the places."""


class Cancelled(Error, RuntimeError):
    """The progress function ended the work before there was a mesh."""


class FileError(Error, OSError):
    """A file could not be read or written: ``errno`` and ``filename`` as those of OSError."""

    def __str__(self):
        return self.args[0]


class MissingFileError(FileError, FileNotFoundError):
    """A file, or the folder of a file to be written, is not there."""


class MachineError(Error, MemoryError):
    """The machine lacks memory or threads."""


class InternalError(Error, RuntimeError):
    """A defect of ltbw itself: please report it."""
