#!/usr/bin/env python3
"""Time of `ltbw.delaunay` over that of the program's insertion and one copy of the points.

usage: bench.py LTBW [POINTS [ROUNDS]]

LTBW is the program. Every measurement is a process of its own, the two take turns in coming first;
the medians and the median of the ratios are printed, then the least of each and their ratio, which
other work on the machine disturbs least. The aim for a million points is 1.1 at most.
"""

import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

BUILD = """
import sys, time
import numpy as np
import ltbw
points = np.load(sys.argv[1])
start = time.perf_counter()
copied = points.copy()
middle = time.perf_counter()
mesh = ltbw.delaunay(points)
end = time.perf_counter()
print(middle - start, end - middle, mesh.hash)
"""


def by_program(program, folder):
    """Seconds of ordering and insertion, and the hash."""
    words = ["delaunay", "points.npy", "--quiet", "--check", "off", "--json", "report.json"]
    subprocess.run([program, *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    report = json.loads((folder / "report.json").read_text())
    seconds = report["seconds"]
    return seconds["order"] + seconds["insert"], report["mesh"]["hash"]


def by_python(folder):
    """Seconds of a copy, of the build, and the hash."""
    words = [sys.executable, "-c", BUILD, "points.npy"]
    done = subprocess.run(words, cwd=folder, check=True, stdout=subprocess.PIPE, text=True)
    copy, build, name = done.stdout.split()
    return float(copy), float(build), name


def main():
    program = Path(sys.argv[1]).resolve()
    points = int(sys.argv[2]) if len(sys.argv) > 2 else 1_000_000
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        generate = ["generate", "uniform", str(points), "--quiet", "-o", "points.npy"]
        subprocess.run([program, *generate], cwd=folder, check=True)
        for turn in range(rounds):
            ours = by_python(folder) if turn % 2 else None
            insertion, wanted = by_program(program, folder)
            copy, build, found = ours or by_python(folder)
            if found != wanted:
                sys.exit(f"the hash is {found}, the program's {wanted}")
            rows.append((insertion, copy, build, build / (insertion + copy)))
    insertion, copy, build, ratio = map(statistics.median, zip(*rows))
    print(f"{points} points, {rounds} rounds, medians in seconds")
    print(f"program: insertion {insertion:.3f}; copy of the points {copy:.3f}")
    print(f"python:  ltbw.delaunay {build:.3f}, {ratio:.2f} of both (aim: 1.1 at most)")
    insertion, copy, build, _ = map(min, zip(*rows))
    ratio = build / (insertion + copy)
    print(f"least:   {build:.3f} of {insertion:.3f} and {copy:.3f}, {ratio:.2f}")


if __name__ == "__main__":
    main()
