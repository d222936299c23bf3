import os
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

class Error(Exception):
    code: str
    ids: list[int]
    defects: list[dict[str, Any]]
    def to_pyvista(self) -> Any: ...

class InputError(Error, ValueError): ...
class DomainError(Error, ValueError): ...
class RecoveryError(Error, RuntimeError): ...
class FileError(Error, OSError): ...
class MissingFileError(FileError, FileNotFoundError): ...
class Cancelled(Error, RuntimeError): ...
class MachineError(Error, MemoryError): ...
class InternalError(Error, RuntimeError): ...

class Certificate:
    report: dict[str, Any]
    passed: bool
    verdict: Literal["passed", "excused", "failed"]
    defects: list[Any]
    quality: dict[str, Any] | None
    def __bool__(self) -> bool: ...
    @property
    def hash(self) -> str | None: ...

class Mesh:
    certificate: Certificate | None
    notes: list[str]
    points: NDArray[np.float64]
    node: NDArray[np.float64]
    simplices: NDArray[np.int32]
    elem: NDArray[np.int32]
    neighbors: NDArray[np.int32]
    convex_hull: NDArray[np.int32]
    coplanar: NDArray[np.int32]
    triangles: NDArray[np.int32]
    triface: NDArray[np.int32]
    triface_markers: NDArray[np.int64]
    parts: dict[str, NDArray[np.intp]]
    regions: NDArray[np.int32]
    region_attributes: NDArray[np.float64]
    excuses: list[tuple[int, str]]
    hash: str
    quality: dict[str, Any] | None
    grid: Any
    surface: Any
    npoints: int
    nsimplex: int
    ndim: int
    min_bound: NDArray[np.float64]
    max_bound: NDArray[np.float64]
    vertex_to_simplex: NDArray[np.int32]
    vertex_neighbor_vertices: tuple[NDArray[np.int32], NDArray[np.int32]]
    transform: NDArray[np.float64]
    equations: NDArray[np.float64]
    paraboloid_scale: float
    paraboloid_shift: float
    def lift_points(self, x: ArrayLike) -> NDArray[np.float64]: ...
    def plane_distance(self, xi: ArrayLike) -> NDArray[np.float64]: ...
    def add_points(self, points: ArrayLike, restart: bool = ...) -> None: ...
    def plot(self, *, cut: bool = ..., scalars: str = ..., **options: Any) -> Any: ...
    @property
    def outcome(self) -> str: ...
    @property
    def offset(self) -> NDArray[np.float64]: ...
    def find_simplex(self, xi: ArrayLike) -> NDArray[np.int32]: ...
    def check(self, *, full: bool = ...) -> Certificate | None: ...
    def save(self, path: str | os.PathLike[str]) -> None: ...
    def to_meshio(self, names: Literal["ltbw", "gmsh", "medit"] = ...) -> Any: ...

Frame = Literal["auto", "own", "local"]
Progress = Callable[[int, int | None], Any]
Region = tuple[Sequence[float], float] | tuple[Sequence[float], float, float | None]

def delaunay(
    points: Any,
    threads: int = ...,
    *,
    without: ArrayLike = ...,
    progress: Progress | None = ...,
) -> Mesh: ...
def tetrahedralize(
    surface: Any,
    *,
    max_volume: float | None = ...,
    radius_edge: float | None = ...,
    min_dihedral: float = ...,
    smooth: int = ...,
    max_edge: float | None = ...,
    near: Sequence[Any] = ...,
    size_at: dict[Any, float] | None = ...,
    curvature: float | None = ...,
    growth: float = ...,
    size: float
    | ArrayLike
    | Callable[[tuple[float, float, float]], float]
    | Callable[[float, float, float], float]
    | None = ...,
    background: Any = ...,
    points: Any = ...,
    regions: Iterable[Region] = ...,
    holes: Literal["none", "auto"] | ArrayLike | None = ...,
    max_points: int | None = ...,
    repair: float = ...,
    fill: int = ...,
    simplify: float = ...,
    flat_tolerance: float | None = ...,
    feature_angle: float | None = ...,
    exact_input: bool = ...,
    strict: bool = ...,
    frame: Frame = ...,
    progress: Progress | None = ...,
    threads: int = ...,
    check: bool = ...,
    excused_share: float = ...,
) -> Mesh: ...
def check(
    points: ArrayLike,
    tets: ArrayLike,
    plc: Any = ...,
    *,
    max_volume: float | None = ...,
    radius_edge: float | None = ...,
    flat_tolerance: float | None = ...,
    frame: Frame = ...,
    any_order: bool = ...,
    all_points: bool = ...,
    delaunay: bool = ...,
) -> Certificate: ...
