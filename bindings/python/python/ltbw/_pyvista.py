"""The accessor ``surface.ltbw`` of pyvista's PolyData, where pyvista has accessors."""

import ltbw


class Accessor:
    """``surface.ltbw.tetrahedralize(...)`` and ``surface.ltbw.delaunay()``."""

    def __init__(self, surface):
        self._surface = surface

    def tetrahedralize(self, **wishes):
        """:func:`ltbw.tetrahedralize` of the surface, as a ``pyvista.UnstructuredGrid``."""
        return ltbw.tetrahedralize(self._surface, **wishes).grid

    def delaunay(self, threads=1):
        """:func:`ltbw.delaunay` of the surface's points, as a ``pyvista.UnstructuredGrid``."""
        return ltbw.delaunay(self._surface.points, threads).grid


def _register():
    try:
        from pyvista import PolyData, register_dataset_accessor
    except ImportError:
        return
    register_dataset_accessor("ltbw", PolyData)(Accessor)


_register()
