"""A walk through ltbw for Python. `python tutorial.py` runs it; each step asserts what it says.

The cells marked `# %%` open as a notebook in editors that know them.
"""

# %% Points: the Delaunay mesh, the same for any number of threads.
import tempfile
from pathlib import Path

import numpy as np

import ltbw

points = np.random.default_rng(7).random((20_000, 3))
mesh = ltbw.delaunay(points)
print(mesh, mesh.hash)
assert ltbw.delaunay(points, threads=4).hash == mesh.hash

# %% Where is a place, and what is beside it? Exactly answered.
where = mesh.find_simplex([[0.5, 0.5, 0.5], [9.0, 9.0, 9.0]])
print("in tetrahedron", where[0], "- outside:", where[1])
assert where[0] >= 0 and where[1] == -1
print("its neighbours:", mesh.neighbors[where[0]])

# %% A domain: a cube with a cubic hole, from arrays. Faces point outward, those of the hole into it.
corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
outside = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
vertices = np.vstack([corners, corners / 2 + 0.25])
faces = outside + [[v + 8 for v in reversed(face)] for face in outside]
domain = ltbw.tetrahedralize((vertices, faces), max_volume=0.002)
print(domain, domain.outcome, domain.certificate)
assert domain.outcome == "met" and domain.certificate.passed

# %% Quality: the bound on shape holds exactly.
ratio = domain.quality["radius_edge"]["largest"][0]
angle = domain.quality["dihedral"]["least"][0]
print(f"radius-edge at most {ratio:.3f}, dihedral angles from {angle:.1f} degrees")
assert ratio <= 2.0

# %% Sizes: fine near one corner. The function is asked from this thread only, and may raise.
graded = ltbw.tetrahedralize((vertices, faces), size=lambda p: 0.06 + 0.2 * max(p))
print(graded)
assert graded.outcome == "met"

# %% Progress; `return False` ends the work and keeps the mesh so far.
ltbw.delaunay(points, progress=lambda done, total: print(f"{done} of {total}"))

# %% What is wrong says where.
try:
    ltbw.tetrahedralize((vertices, faces[1:]))
except ltbw.DomainError as error:
    print(error.code, error)

# %% Files for others.
with tempfile.TemporaryDirectory() as folder:
    for name in ("mesh.vtu", "mesh.msh", "mesh.mesh"):
        domain.save(Path(folder) / name)
        print(name, (Path(folder) / name).stat().st_size, "bytes")
