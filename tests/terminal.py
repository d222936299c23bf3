"""Longest silences of a program on a terminal: `terminal.py LIMIT COMMAND...`.

The command runs in a pseudo terminal, as for a person who waits. No LIMIT of seconds may pass
without output, from the start to the end; the exit code is 1 if one does.
"""

import os
import pty
import sys
import time


def run(command):
    """The exit code, and with the time of each output the end of what was written until then."""
    start = time.monotonic()
    child, terminal = pty.fork()
    if child == 0:
        os.execvp(command[0], command)
    told, written = [(0.0, b"")], b""
    while True:
        try:
            data = os.read(terminal, 65536)
        except OSError:
            # Linux tells so that the other side is closed.
            break
        if not data:
            break
        written = (written + data)[-60:]
        told.append((time.monotonic() - start, written))
    _, status = os.waitpid(child, 0)
    told.append((time.monotonic() - start, b""))
    return os.waitstatus_to_exitcode(status), told


def main():
    """Runs the command and tells."""
    limit, command = float(sys.argv[1]), sys.argv[2:]
    code, told = run(command)
    gaps = [(b[0] - a[0], a[0], a[1]) for a, b in zip(told, told[1:])]
    longest, at, after = max(gaps)
    text = after.decode(errors="replace").replace("\x1b", "^").replace("\r", " ").replace("\n", " ")
    words = " ".join(os.path.basename(word) for word in command)
    print(f"{words}: {told[-1][0]:.1f} s, longest silence {longest:.2f} s")
    print(f"    at {at:.2f} s, after `{text.strip()[-50:]}`")
    if code not in (0, 1):
        sys.exit(f"{words}: exit code {code}")
    if longest > limit:
        sys.exit(f"{words}: {longest:.2f} s of silence, more than {limit}")


if __name__ == "__main__":
    main()
