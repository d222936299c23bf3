"""Dihedral angles of our meshes beside those of TetGen, Gmsh and CGAL, for `cargo xtask bench quality`.

    beside.py LTBW FOLDER [KIND MAX_VOLUME]...

LTBW is the program, FOLDER takes files. Each mesher meshes the domain of a kind as its users call it and
with its optimisers; Gmsh and CGAL, which take a size and no volume, are given one that makes as many
tetrahedra as ours within 5 %. CGAL's are those of a program of its own (`tests/cgal/mesh.cpp`), if it
compiles. A row: tetrahedra, seconds of the processor for the call alone (ours: the refinement, of
its report), the smallest dihedral angle, those that 1 in 1,000 and 1 in 100 of the tetrahedra are below, and
the faces that are not Delaunay, which our checker counts for all.
"""

import json
import os
import pathlib
import subprocess
import sys
import time

import gmsh
import numpy
import tetgen

sys.path.append(str(pathlib.Path(__file__).parent.parent / "tetgen"))
from run import read  # noqa: E402

# What is measured where nothing is named: as in the page.
PROBLEMS = [("cube-octahedron", 1.73783e-5), ("cube-in-cube", 1.78e-5)]


def smallest(points, tets):
    """The smallest dihedral angle of each tetrahedron, in degrees."""
    corners = points[tets]
    least = numpy.full(len(tets), 180.0)
    for i, j, k, l in [(0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2), (2, 3, 0, 1)]:
        edge = corners[:, j] - corners[:, i]
        one = numpy.cross(edge, corners[:, k] - corners[:, i])
        two = numpy.cross(edge, corners[:, l] - corners[:, i])
        sine = numpy.linalg.norm(numpy.cross(one, two), axis=1)
        angle = numpy.degrees(numpy.arctan2(sine, (one * two).sum(axis=1)))
        least = numpy.minimum(least, angle)
    return numpy.sort(least)


def not_delaunay(program, folder, points, tets):
    """Faces whose two tetrahedra have a vertex of each other in their spheres, by `ltbw check`."""
    path = folder / "beside.mesh"
    with open(path, "w") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(points)}\n")
        numpy.savetxt(file, numpy.c_[points, numpy.zeros(len(points))], fmt="%.17g %.17g %.17g %d")
        file.write(f"Tetrahedra\n{len(tets)}\n")
        numpy.savetxt(file, numpy.c_[tets + 1, numpy.zeros(len(tets))], fmt="%d")
        file.write("End\n")
    words = [program, "check", path, "--json", "-", "--quiet"]
    told = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
    return json.loads(told).get("information_counts", {}).get("not_delaunay", 0)


def ours(program, folder, domain, volume, degrees, sweeps=0):
    report, mesh = folder / "beside.json", folder / "beside.vtu"
    subprocess.run(
        [program, "mesh", domain, "--max-volume", str(volume), "--min-dihedral", str(degrees),
         "--smooth", str(sweeps), "--threads", "1", "-o", mesh, "--json", report, "--quiet"],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    converted = folder / "beside-ours.node"
    subprocess.run([program, "convert", mesh, converted, "--quiet"], check=True)
    points = numpy.loadtxt(converted, skiprows=1, comments="#")[:, 1:4]
    tets = numpy.loadtxt(converted.with_suffix(".ele"), skiprows=1, comments="#", dtype=int)[:, 1:5]
    first = int(numpy.loadtxt(converted, skiprows=1, comments="#", max_rows=1)[0])
    seconds = json.loads(report.read_text())["refinement"]["refine_seconds"]
    return points, tets - first, seconds


def by_tetgen(domain, volume, options):
    points, triangles, holes = read(domain)
    mesher = tetgen.TetGen(points, triangles)
    for hole in holes:
        mesher.add_hole(hole)
    start = time.process_time()
    mesher.tetrahedralize(switches=f"pq2/0a{volume}Q{options}")
    return mesher.node, mesher.elem, time.process_time() - start


def polygons(path):
    """Vertices, polygons and hole points of a .poly file."""
    with open(path) as file:
        rows = iter([row for row in (line.split("#")[0].split() for line in file) if row])
    count = int(next(rows)[0])
    points = [[float(c) for c in next(rows)[1:4]] for _ in range(count)]
    facets = []
    for _ in range(int(next(rows)[0])):
        number, *_ = (int(word) for word in next(rows))
        facets += [[int(word) for word in next(rows)][1:] for _ in range(number)]
    return points, facets, int(next(rows)[0])


def by_gmsh(domain, size, options):
    points, facets, holes = polygons(domain)
    gmsh.initialize(["", "-v", "0", "-nt", "1"])
    for name, value in options.items():
        gmsh.option.setNumber(name, value)
    gmsh.option.setNumber("Mesh.MeshSizeMin", size)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    geo = gmsh.model.geo
    corners = [geo.addPoint(*point) for point in points]
    lines, shells = {}, []
    for facet in facets:
        loop = []
        for a, b in zip(facet, facet[1:] + facet[:1]):
            key = (min(a, b), max(a, b))
            if key not in lines:
                lines[key] = geo.addLine(corners[key[0]], corners[key[1]])
            loop.append(lines[key] if a < b else -lines[key])
        surface = geo.addPlaneSurface([geo.addCurveLoop(loop)])
        # Facets that share a vertex are of one shell.
        beside = [shell for shell in shells if shell[0] & set(facet)]
        shells = [shell for shell in shells if not shell[0] & set(facet)]
        shells.append((set(facet).union(*(s[0] for s in beside)), sum((s[1] for s in beside), []) + [surface]))
    extent = lambda shell: numpy.ptp([points[v] for v in shell[0]], axis=0).max()
    shells.sort(key=extent, reverse=True)
    loops = [geo.addSurfaceLoop(surfaces) for _, surfaces in shells]
    geo.addVolume(loops)
    if holes == 0:
        for loop in loops[1:]:
            geo.addVolume([loop])
    geo.synchronize()
    start = time.process_time()
    gmsh.model.mesh.generate(3)
    seconds = time.process_time() - start
    tags, places, _ = gmsh.model.mesh.getNodes()
    number = numpy.zeros(int(tags.max()) + 1, dtype=int)
    number[tags.astype(int)] = numpy.arange(len(tags))
    _, of_tets = gmsh.model.mesh.getElementsByType(4)
    tets = number[of_tets.astype(int).reshape(-1, 4)]
    gmsh.finalize()
    return places.reshape(-1, 3), tets, seconds


def cgal(folder):
    """CGAL's program, or why there is none."""
    source, program = pathlib.Path("tests/cgal/mesh.cpp"), folder / "cgal-mesh"
    flags = ["-std=c++17", "-O3", "-DNDEBUG", "-frounding-math", "-lgmp", "-lmpfr"]
    try:
        words = [os.environ.get("CXX", "c++"), source, "-o", program, *flags]
        built = subprocess.run(words, stderr=subprocess.PIPE, text=True)
    except OSError as error:
        return None, str(error)
    reason = built.stderr.splitlines()[0] if built.returncode else None
    return (None if reason else program.resolve()), reason


def by_cgal(program, folder, domain, size, way):
    points, triangles, _ = read(domain)
    surface, mesh = folder / "cgal.off", folder / "cgal.txt"
    with open(surface, "w") as file:
        file.write(f"OFF\n{len(points)} {len(triangles)} 0\n")
        numpy.savetxt(file, points, fmt="%.17g")
        numpy.savetxt(file, numpy.c_[numpy.full(len(triangles), 3), triangles], fmt="%d")
    words = [program, surface, str(size), way, mesh]
    told = subprocess.run(words, stdout=subprocess.PIPE, check=True, text=True).stdout
    with open(mesh) as file:
        vertices, tets = (int(word) for word in file.readline().split())
        places = numpy.loadtxt(file, max_rows=vertices)
        return places, numpy.loadtxt(file, max_rows=tets, dtype=int), float(told)


def sized(make, wanted):
    """A mesh of as many tetrahedra as wanted, within 5 %, and its size."""
    size = 0.05
    for _ in range(8):
        made = make(size)
        share = len(made[1]) / wanted
        if 0.95 <= share <= 1.05:
            break
        size *= share ** (1 / 3)
    return made, size


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    rest = sys.argv[3:]
    problems = [(kind, float(volume)) for kind, volume in zip(rest[::2], rest[1::2])] or PROBLEMS
    for kind, volume in problems:
        domain = str(folder / f"{kind}.poly")
        subprocess.run([program, "generate", kind, "-o", domain, "--quiet"], check=True)
        print(f"\n{kind}, volumes up to {volume:g}\n")
        print("| | tetrahedra | s | smallest | 0.1 % | 1 % | faces not Delaunay |")
        print("|---|--:|--:|--:|--:|--:|--:|")
        wanted = None
        for degrees in (0, 5, 8, 10):
            row = ours(program, folder, domain, volume, degrees)
            wanted = wanted or len(row[1])
            tell(f"ltbw, `--min-dihedral {degrees}`", program, folder, row)
        for sweeps in (1, 2):
            row = ours(program, folder, domain, volume, 8, sweeps)
            tell(f"ltbw, `--smooth {sweeps}`", program, folder, row)
        tell("TetGen, not optimised", program, folder, by_tetgen(domain, volume, "O0/0/0"))
        tell("TetGen, as it comes", program, folder, by_tetgen(domain, volume, ""))
        tell("TetGen, optimised most", program, folder, by_tetgen(domain, volume, "o/140O9/7"))
        plain = {"Mesh.Algorithm3D": 1, "Mesh.Optimize": 0}
        ways = [
            ("Gmsh, not optimised", plain),
            ("Gmsh, as it comes", {"Mesh.Algorithm3D": 1}),
            ("Gmsh, Netgen's optimiser", {"Mesh.Algorithm3D": 1, "Mesh.OptimizeNetgen": 1}),
            ("Gmsh, HXT", {"Mesh.Algorithm3D": 10}),
        ]
        for name, options in ways:
            made, _ = sized(lambda size: by_gmsh(domain, size, options), wanted)
            tell(name, program, folder, made)
        other, reason = cgal(folder)
        if other is None:
            print(f"SKIPPED (cgal): {reason}")
            continue
        made, size = sized(lambda size: by_cgal(other, folder, domain, size, "plain"), wanted)
        tell("CGAL, not optimised", program, folder, made)
        ways = [("perturbed", "perturb"), ("exuded", "exude"), ("as it comes: both", "both")]
        for name, way in ways:
            tell(f"CGAL, {name}", program, folder, by_cgal(other, folder, domain, size, way))


def tell(name, program, folder, row):
    points, tets, seconds = row
    least = smallest(points, tets)
    at = lambda share: least[int(share * len(least))]
    faces = not_delaunay(program, folder, points, tets)
    print(
        f"| {name} | {len(tets):,} | {seconds:.2f} | {least[0]:.2f} | {at(0.001):.1f} | {at(0.01):.1f} | {faces:,} |",
        flush=True,
    )


if __name__ == "__main__":
    main()
