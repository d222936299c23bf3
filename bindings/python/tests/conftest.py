"""What the tests share: the program `ltbw`, and surfaces."""

import os
import pathlib
import subprocess

import pytest


def required(name):
    """Is a skipped check an error? `LTBW_REQUIRE` names those that are, or says `all`."""
    wanted = os.environ.get("LTBW_REQUIRE", "").split(",")
    return "all" in wanted or name in wanted


@pytest.fixture(scope="session")
def program():
    """Runs the program: the environment's LTBW_PROGRAM."""
    path = os.environ.get("LTBW_PROGRAM")
    if not path:
        if required("python"):
            pytest.fail("LTBW_PROGRAM does not name the program ltbw")
        pytest.skip("LTBW_PROGRAM does not name the program ltbw")

    def run(*words):
        done = subprocess.run(
            [path, *map(str, words)], capture_output=True, text=True, timeout=600, check=False
        )
        assert done.returncode == 0, (words, done.stderr)
        return done.stdout

    assert pathlib.Path(path).exists(), path
    return run


@pytest.fixture
def cube():
    """Corners and faces of the unit cube, faces turned outward."""
    corners = [[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return corners, faces
