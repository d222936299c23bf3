"""Ctrl-C ends every call, and Python goes on."""

import os
import signal
import subprocess
import sys
import textwrap

import pytest

CALLS = {
    "delaunay": "ltbw.delaunay(np.random.default_rng(1).random((3_000_000, 3)))",
    "threads": "ltbw.delaunay(np.random.default_rng(1).random((3_000_000, 3)), threads=2)",
    "domain": "ltbw.tetrahedralize((corners, faces), max_volume=1e-8)",
    "function": "ltbw.tetrahedralize((corners, faces), size=lambda p: 0.005)",
}


@pytest.mark.skipif(os.name != "posix", reason="signals are sent as on Unix")
@pytest.mark.parametrize("call", CALLS)
def test_an_interrupt_ends_the_call(call):
    script = f"""
    import signal, numpy as np, ltbw
    # A background job of a shell begins without it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    corners = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    print("ready", flush=True)
    try:
        {CALLS[call]}
    except KeyboardInterrupt:
        print("interrupted", ltbw.delaunay([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]).outcome)
    """
    command = [sys.executable, "-c", textwrap.dedent(script)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        try:
            assert child.stdout.readline() == "ready\n"
            # The call is somewhere in its work.
            with pytest.raises(subprocess.TimeoutExpired):
                child.wait(1.0)
            child.send_signal(signal.SIGINT)
            out, _ = child.communicate(timeout=60)
        finally:
            child.kill()
    assert out == "interrupted complete\n"
    assert child.returncode == 0
