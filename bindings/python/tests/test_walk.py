"""The walk docs/first-mesh.md, line by line."""

import doctest
import pathlib

import numpy as np
import pytest

import ltbw

from conftest import required

PAGE = pathlib.Path(__file__).parents[3] / "docs" / "first-mesh.md"


def cylinder(path, sides=48):
    """A cylinder as a text STL: its wall, and its ends as fans."""
    around = np.arange(sides + 1) % sides * (2 * np.pi / sides)
    ring = np.column_stack([np.cos(around) / 2, np.sin(around) / 2, np.zeros(sides + 1)])
    low, high, up = np.zeros(3), np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0])
    rows = []
    for a, b in zip(ring, ring[1:]):
        c, d = b + up, a + up
        rows += [(a, b, c), (a, c, d), (low, b, a), (high, d, c)]
    with open(path, "w") as file:
        print("solid", file=file)
        for row in rows:
            print("facet normal 0 0 0\nouter loop", file=file)
            for x, y, z in row:
                print("vertex", repr(float(x)), repr(float(y)), repr(float(z)), file=file)
            print("endloop\nendfacet", file=file)
        print("endsolid", file=file)


def test_the_walk(tmp_path, monkeypatch):
    if not required("python"):
        pytest.importorskip("skfem")
    monkeypatch.chdir(tmp_path)
    cylinder("cylinder.stl")
    text = PAGE.read_text()
    walk = doctest.DocTestParser().get_doctest(text, {}, "first-mesh", str(PAGE), 0)
    assert len(walk.examples) > 8
    told = []
    doctest.DocTestRunner().run(walk, out=told.append)
    assert not told, "".join(told)


def test_a_cylinder_has_three_parts(tmp_path):
    cylinder(tmp_path / "cylinder.stl")
    mesh = ltbw.tetrahedralize(tmp_path / "cylinder.stl", size=0.2)
    assert sorted(mesh.parts) == ["part 1", "part 2", "part 3"]
    heights = [np.ptp(mesh.points[mesh.triangles[mesh.parts[name]]][..., 2]) for name in mesh.parts]
    assert heights == [1.0, 0.0, 0.0]
