"""What small angles cost, for `cargo xtask bench iterations`.

    iterations.py LTBW FOLDER

LTBW is the program, FOLDER takes files. On meshes of the model problem, by bound of dihedral angles and
sweeps of smoothing: conjugate gradients for a Poisson problem (linear elements, right-hand side 1, zero
boundary) until the residual is 1e-8 of the first, plain and with Jacobi's preconditioner, and the largest
eigenvalue of the stiffness matrix.
"""

import pathlib
import subprocess
import sys

import numpy
from beside import PROBLEMS, ours, smallest

ROWS = [(0, 0)] + [(degrees, sweeps) for degrees in (8, 10) for sweeps in range(4)]
RESIDUAL = 1e-8
# Steps of Lanczos for the largest eigenvalue.
STEPS = 100


def problem(points, tets):
    """The stiffness matrix as a function, its diagonal, and the right-hand side; zero at the boundary."""
    corners = points[tets]
    edges = corners[:, 1:] - corners[:, :1]
    volumes = numpy.abs(numpy.linalg.det(edges)) / 6
    slopes = numpy.linalg.inv(edges).transpose(0, 2, 1)
    slopes = numpy.concatenate([-slopes.sum(axis=1, keepdims=True), slopes], axis=1)
    local = volumes[:, None, None] * (slopes @ slopes.transpose(0, 2, 1))
    faces = numpy.sort(numpy.concatenate([numpy.delete(tets, k, axis=1) for k in range(4)]), axis=1)
    faces, count = numpy.unique(faces, axis=0, return_counts=True)
    inside = numpy.ones(len(points))
    inside[faces[count == 1].ravel()] = 0
    collect = lambda values: inside * numpy.bincount(tets.ravel(), values.ravel(), len(points))
    apply = lambda x: collect((local @ x[tets][:, :, None])[:, :, 0])
    diagonal = collect(numpy.diagonal(local, axis1=1, axis2=2)) + (1 - inside)
    return apply, diagonal, collect(numpy.repeat(volumes / 4, 4))


def iterations(apply, right, diagonal):
    residual = right.copy()
    scaled = residual / diagonal
    direction, product = scaled, residual @ scaled
    for count in range(1, 10_000):
        image = apply(direction)
        residual = residual - product / (direction @ image) * image
        if numpy.linalg.norm(residual) <= RESIDUAL * numpy.linalg.norm(right):
            return count
        scaled = residual / diagonal
        product, before = residual @ scaled, product
        direction = scaled + product / before * direction
    raise SystemExit("no end")


def largest(apply, right):
    """The largest eigenvalue, by Lanczos from a vector that no mesh favours."""
    start = numpy.where(right > 0, numpy.random.default_rng(1).standard_normal(len(right)), 0)
    vector, before, size = start / numpy.linalg.norm(start), 0 * start, 0.0
    middle, beside = [], []
    for _ in range(STEPS):
        image = apply(vector) - size * before
        middle.append(image @ vector)
        image -= middle[-1] * vector
        size = numpy.linalg.norm(image)
        beside.append(size)
        before, vector = vector, image / size
    return numpy.linalg.eigvalsh(numpy.diag(middle) + numpy.diag(beside[:-1], 1) + numpy.diag(beside[:-1], -1))[-1]


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    kind, volume = PROBLEMS[0]
    domain = str(folder / f"{kind}.poly")
    subprocess.run([program, "generate", kind, "-o", domain, "--quiet"], check=True)
    print(f"{kind}, volumes up to {volume:g}\n")
    print("| `--min-dihedral` | `--smooth` | tetrahedra | least angle | 1 in 100 below | plain | Jacobi | λ |")
    print("|--:|--:|--:|--:|--:|--:|--:|--:|")
    for degrees, sweeps in ROWS:
        points, tets, _ = ours(program, folder, domain, volume, degrees, sweeps)
        apply, diagonal, right = problem(points, tets)
        plain, jacobi = iterations(apply, right, numpy.ones(len(right))), iterations(apply, right, diagonal)
        least = smallest(points, tets)
        print(
            f"| {degrees} | {sweeps} | {len(tets):,} | {least[0]:.1f}° | {least[len(least) // 100]:.1f}° "
            f"| {plain} | {jacobi} | {largest(apply, right):.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
