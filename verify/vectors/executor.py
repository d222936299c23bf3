#!/usr/bin/env python3
# CC0-1.0: no rights reserved.
"""A conformance executor in plain Python: one JSON question a line in, one JSON answer a line out.

It shares nothing with the Rust code. Numbers are exact rationals (``fractions``), meshes are built
by Bowyer and Watson's method on plain sets, slowly. It answers predicates/, order/, cavity/,
insert/ and delaunay/; of protocol/ and interleavings/ it says that it does not.
"""

import hashlib
import json
import struct
import sys
from fractions import Fraction

INFINITE = -1  # the vertex at infinity, last in a ghost (a, b, c, INFINITE)


def read(point):
    return tuple(Fraction(float.fromhex(c)) for c in point)


def sign(value):
    return (value > 0) - (value < 0)


# Predicates ------------------------------------------------------------------------------------


def minus(p, q):
    return tuple(a - b for a, b in zip(p, q))


def cross(u, v):
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


def dot(u, v):
    return sum(a * b for a, b in zip(u, v))


def det(u, v, w):
    return dot(cross(u, v), w)


def orient3d(a, b, c, d):
    return sign(det(minus(b, a), minus(c, a), minus(d, a)))


def insphere(a, b, c, d, e):
    a, b, c, d = (minus(p, e) for p in (a, b, c, d))
    return sign(
        dot(a, a) * det(b, c, d)
        - dot(b, b) * det(a, c, d)
        + dot(c, c) * det(a, b, d)
        - dot(d, d) * det(a, b, c)
    )


def side_of_sphere(cell, p):
    """Perturbed: never zero for five different points of which the first four are positive."""
    side = insphere(*cell, p)
    if side:
        return side
    for q in sorted([*cell, p], reverse=True):
        if q == p:
            return -1
        side = orient3d(*(p if r == q else r for r in cell))
        if side:
            return side
    raise ValueError("equal points")


def turn(a, b, c):
    """Turn of three points in the first of the planes xy, yz, xz in which it is not zero."""
    u, v = minus(b, a), minus(c, a)
    for i, j in ((0, 1), (1, 2), (0, 2)):
        found = sign(u[i] * v[j] - u[j] * v[i])
        if found:
            return found
    return 0


def side_of_circle(cell, p):
    a, b, c = cell
    apex = tuple(x + n for x, n in zip(a, cross(minus(b, a), minus(c, a))))
    side = insphere(a, b, c, apex, p)
    if side:
        return side
    local = turn(a, b, c)
    for q in sorted([*cell, p], reverse=True)[:3]:
        if q == p:
            return -1
        side = turn(*(p if r == q else r for r in cell))
        if side:
            return side * local
    return -local


def side_of_hull_facet(cell, p):
    return orient3d(*cell, p) or side_of_circle(cell, p)


# Order -----------------------------------------------------------------------------------------

BITS = 20


def hilbert_number(cell):
    """Hamilton's compact Hilbert index, one level at a time; axis 0 is the lowest bit."""
    number, e, d = 0, 0, 0
    rotl = lambda v, by: (v << by | v >> (3 - by)) & 7
    ones = lambda v: len(bin(v)) - len(bin(v).rstrip("1"))
    for level in reversed(range(BITS)):
        octant = sum((cell[k] >> level & 1) << k for k in range(3))
        t = rotl(octant ^ e, 3 - (d + 1))
        w = t ^ t >> 1 ^ t >> 2
        number = number << 3 | w
        entry = 0 if w == 0 else ((w - 1) & ~1) ^ ((w - 1) & ~1) >> 1
        direction = 0 if w == 0 else ones(w) % 3 if w & 1 else ones(w - 1) % 3
        e ^= rotl(entry, d + 1)
        d = (d + direction + 1) % 3
    return number


def keys(points, chosen):
    """Keys in the cube around the chosen points: f64 arithmetic, as it stands. None: one point."""
    half = {i: [c * 0.5 for c in points[i]] for i in chosen}
    low = [min(h[k] for h in half.values()) for k in range(3)]
    side = max(max(h[k] for h in half.values()) - low[k] for k in range(3))
    if side == 0.0:
        return None
    most = (1 << BITS) - 1
    cell = lambda h: [min(int((h[k] - low[k]) / side * float(1 << BITS)), most) for k in range(3)]
    return {i: hilbert_number(cell(h)) for i, h in half.items()}


def refined(points, run, depth):
    """Runs of more than eight equal keys are ordered again in their own box."""
    found = keys(points, run) if depth < 212 else None
    if found is None:
        return run
    return grouped(points, sorted((found[i], i) for i in run), depth + 1)


def grouped(points, keyed, depth):
    order, start = [], 0
    while start < len(keyed):
        end = start
        while end < len(keyed) and keyed[end][0] == keyed[start][0]:
            end += 1
        run = [i for _, i in keyed[start:end]]
        order += refined(points, run, depth) if len(run) > 8 else run
        start = end
    return order


def in_rounds(points, rounds):
    every = list(range(len(points)))
    found = keys(points, every) or {i: 0 for i in every}
    keyed = sorted(((round_of(i, rounds), found[i]), i) for i in every)
    return grouped(points, keyed, 1)


def round_of(index, rounds):
    mask = (1 << 64) - 1
    z = (index + 0x9E3779B97F4A7C15) & mask
    z = ((z ^ z >> 30) * 0xBF58476D1CE4E5B9) & mask
    z = ((z ^ z >> 27) * 0x94D049BB133111EB) & mask
    z ^= z >> 31
    zeros = (z & -z).bit_length() - 1 if z else 64
    return rounds - min(zeros // 3, rounds)


def brio_rounds(count):
    rounds = 0
    while count > 512 and rounds < 15:
        count, rounds = count // 8, rounds + 1
    return rounds


def block_of(tet, vertices, blocks):
    """Block b has the vertices 1 + b n / k up to 1 + (b + 1) n / k, exclusive."""
    votes = [0] * blocks
    for v in tet:
        if v:
            votes[max(b for b in range(blocks) if 1 + b * vertices // blocks <= v)] += 1
    return votes.index(max(votes))


# Meshes ----------------------------------------------------------------------------------------

# The slots other than i, in the order in which (p, others) is positive.
OTHERS = ((1, 2, 3), (2, 0, 3), (0, 1, 3), (1, 0, 2))


def in_conflict(points, tet, p):
    if tet[3] == INFINITE:
        return side_of_hull_facet([points[v] for v in tet[:3]], p) > 0
    return side_of_sphere([points[v] for v in tet], p) > 0


def walls(tet):
    for others in OTHERS:
        yield tuple(tet[k] for k in others)


def closure(points, tets, p):
    """Cavity and ring by definition: every tetrahedron and ghost is tested."""
    cavity = {t for t in tets if in_conflict(points, t, p)}
    faces = {frozenset(face) for t in cavity for face in walls(t)}
    ring = {t for t in tets - cavity if any(frozenset(face) in faces for face in walls(t))}
    return cavity, ring


def star(cavity, vertex):
    count = {}
    for t in cavity:
        for face in walls(t):
            count.setdefault(frozenset(face), []).append(face)
    return {(vertex, *found[0]) for found in count.values() if len(found) == 1}


def ghosts_last(tet):
    """The vertex at infinity comes last; an even permutation keeps the orientation."""
    at = tet.index(INFINITE) if INFINITE in tet else 3
    if at == 3:
        return tet
    a, b, c = [v for k, v in enumerate(tet) if k != at]
    return (a, b, c, INFINITE) if (3 - at) % 2 == 0 else (b, a, c, INFINITE)


def inserted(points, tets, vertex):
    cavity, _ = closure(points, tets, points[vertex])
    return (tets - cavity) | {ghosts_last(t) for t in star(cavity, vertex)}


def first_tet(points, distinct):
    a = distinct[0]
    b = distinct[1]
    c = next(i for i in distinct if any(cross(minus(points[b], points[a]), minus(points[i], points[a]))))
    d = next(i for i in distinct if orient3d(*(points[k] for k in (a, b, c, i))))
    return (a, b, c, d) if orient3d(*(points[k] for k in (a, b, c, d))) > 0 else (b, a, c, d)


def delaunay(points):
    first = {}
    for i, p in enumerate(points):
        first.setdefault(p, i)
    distinct = list(first.values())
    t = first_tet(points, distinct)
    # Beyond a face opposite slot i lies a ghost: the face seen from there.
    tets = {t} | {(c, b, a, INFINITE) for a, b, c in (beyond(t, i) for i in range(4))}
    for i in distinct:
        if i not in t:
            tets = inserted(points, tets, i)
    return tets


def beyond(tet, slot):
    """The face opposite a slot, so that the vertex there is on its positive side."""
    a, b, c = (tet[k] for k in OTHERS[slot])
    return a, c, b  # orient3d(v, a, b, c) > 0 is orient3d(a, c, b, v) > 0


def turned(a, b, c):
    return list(min((a, b, c), (b, c, a), (c, a, b)))


def finite(tets):
    return sorted(sorted(t) for t in tets if t[3] != INFINITE)


def hull(tets):
    return sorted(turned(*t[:3]) for t in tets if t[3] == INFINITE)


def mesh_hash(points, floats, tets):
    used = sorted({v for t in tets for v in t}, key=lambda v: points[v])
    rank = {v: k for k, v in enumerate(used)}
    rows = sorted(sorted(rank[v] for v in t) for t in tets)
    data = b"ltbw.mesh/1\n" + struct.pack("<Q", len(used))
    data += b"".join(struct.pack("<3d", *(c + 0.0 for c in floats[v])) for v in used)
    data += struct.pack("<Q", len(rows)) + b"".join(struct.pack("<4I", *row) for row in rows)
    return hashlib.sha256(data).hexdigest()


# Questions -------------------------------------------------------------------------------------


def ask_mesh(ask):
    points = [read(p) for p in ask["points"]] + [read(ask["at"])]
    tets = [tuple(t) for t in ask["tets"]]
    ghosts = [(*f, INFINITE) for f in ask["hull"]]
    return points, tets, ghosts


def answer_cavity(ask):
    points, tets, ghosts = ask_mesh(ask)
    cavity, ring = closure(points, set(tets + ghosts), points[-1])
    where = lambda some, chosen: [k for k, t in enumerate(some) if t in chosen]
    return {
        "cavity": where(tets, cavity),
        "cavity_hull": where(ghosts, cavity),
        "ring": where(tets, ring),
        "ring_hull": where(ghosts, ring),
    }


def answer_insert(ask):
    points, tets, ghosts = ask_mesh(ask)
    old = set(tets + ghosts)
    new = inserted(points, old, len(points) - 1) - old
    return {"created": finite(new), "created_hull": hull(new)}


def answer_delaunay(ask):
    points = [read(p) for p in ask["points"]]
    floats = [[float.fromhex(c) for c in p] for p in ask["points"]]
    tets = delaunay(points)
    rows = finite(tets)
    return {
        "tets": len(rows),
        "hull": len(hull(tets)),
        "hash": mesh_hash(points, floats, rows),
        "list": rows if len(rows) <= 40 else None,
    }


def floats_of(ask):
    return [[float.fromhex(c) for c in p] for p in ask["points"]]


def points_of(ask):
    return [read(p) for p in ask["points"]]


ANSWERS = {
    "orient3d": lambda ask: {"sign": orient3d(*points_of(ask))},
    "insphere": lambda ask: {"sign": insphere(*points_of(ask))},
    "side_of_sphere": lambda ask: {"sign": side_of_sphere(points_of(ask)[:4], points_of(ask)[4])},
    "side_of_hull_facet": lambda ask: {
        "sign": side_of_hull_facet(points_of(ask)[:3], points_of(ask)[3])
    },
    "compare_xyz": lambda ask: {
        "sign": (points_of(ask)[0] > points_of(ask)[1]) - (points_of(ask)[0] < points_of(ask)[1])
    },
    "hilbert": lambda ask: {"order": in_rounds(floats_of(ask), 0)},
    "brio_hilbert": lambda ask: {
        "order": in_rounds(floats_of(ask), brio_rounds(len(ask["points"])))
    },
    "round_of": lambda ask: {"round": round_of(ask["index"], ask["rounds"])},
    "blocks": lambda ask: {
        "blocks": [block_of(t, ask["vertices"], ask["blocks"]) for t in ask["tets"]]
    },
    "cavity": answer_cavity,
    "insert": answer_insert,
    "delaunay": answer_delaunay,
}


def main():
    for line in sys.stdin:
        ask = json.loads(line)
        known = ANSWERS.get(ask["op"])
        reply = known(ask) if known else {"unsupported": True}
        print(json.dumps(reply), flush=True)


if __name__ == "__main__":
    main()
