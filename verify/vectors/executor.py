#!/usr/bin/env python3
# CC0-1.0: no rights reserved.
"""A conformance executor in plain Python: one JSON question a line in, one JSON answer a line out.

It shares nothing with the Rust code and answers the whole kit. Numbers are exact rationals
(``fractions``), meshes are built by Bowyer and Watson's method on plain sets, slowly. The protocol,
home and owner, is written from docs/protocol.md and docs/protocol-variants.md; R1 to R16 are the
page's rules, where they are obeyed.
"""

import hashlib
import json
import struct
import sys
from fractions import Fraction
from itertools import groupby

INFINITE = -1  # the vertex at infinity, last in a ghost (a, b, c, INFINITE)


def read(point): return tuple(Fraction(float.fromhex(c)) for c in point)
def sign(value): return (value > 0) - (value < 0)


# Predicates ------------------------------------------------------------------------------------


def minus(p, q): return tuple(a - b for a, b in zip(p, q))


def cross(u, v):
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


def dot(u, v): return sum(a * b for a, b in zip(u, v))
def det(u, v, w): return dot(cross(u, v), w)


def orient3d(a, b, c, d):
    return sign(det(minus(b, a), minus(c, a), minus(d, a)))


def insphere(a, b, c, d, e):
    q = [minus(p, e) for p in (a, b, c, d)]
    return sign(sum((-1) ** k * dot(q[k], q[k]) * det(*q[:k], *q[k + 1 :]) for k in range(4)))


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


def side_of_hull_facet(cell, p): return orient3d(*cell, p) or side_of_circle(cell, p)


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


def grouped(points, keyed, depth):
    """Runs of more than eight equal keys are ordered again in their own box."""
    order = []
    for _, group in groupby(keyed, key=lambda pair: pair[0]):
        run = [i for _, i in group]
        found = keys(points, run) if len(run) > 8 and depth < 212 else None
        order += grouped(points, sorted((found[i], i) for i in run), depth + 1) if found else run
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


def brio_rounds(points):
    count, rounds = len(points), 0
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


def walls(tet): return [tuple(tet[k] for k in others) for others in OTHERS]


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
    a, b = distinct[:2]
    off_line = lambda p: any(cross(minus(points[b], points[a]), minus(p, points[a])))
    c = next(i for i in distinct if off_line(points[i]))
    side = lambda i: orient3d(*(points[k] for k in (a, b, c, i)))
    d = next(i for i in distinct if side(i))
    return (a, b, c, d) if side(d) > 0 else (b, a, c, d)


def delaunay(points):
    distinct = sorted({p: i for i, p in reversed([*enumerate(points)])}.values())
    t = first_tet(points, distinct)
    # Beyond a face opposite slot i lies a ghost: the face seen from there.
    tets = {t} | {(t[j], t[k], t[i], INFINITE) for i, j, k in OTHERS}
    for i in distinct:
        if i not in t:
            tets = inserted(points, tets, i)
    return tets


def turned(a, b, c): return list(min((a, b, c), (b, c, a), (c, a, b)))
def finite(tets): return sorted(sorted(t) for t in tets if t[3] != INFINITE)
def hull(tets): return sorted(turned(*t[:3]) for t in tets if t[3] == INFINITE)


def mesh_hash(points, floats, tets):
    used = sorted({v for t in tets for v in t}, key=lambda v: points[v])
    rank = {v: k for k, v in enumerate(used)}
    rows = sorted(sorted(rank[v] for v in t) for t in tets)
    data = b"ltbw.mesh/1\n" + struct.pack("<Q", len(used))
    data += b"".join(struct.pack("<3d", *(c + 0.0 for c in floats[v])) for v in used)
    data += struct.pack("<Q", len(rows)) + b"".join(struct.pack("<4I", *row) for row in rows)
    return hashlib.sha256(data).hexdigest()


# Small meshes: the line, and the hull of points in the plane (README.md) ------------------------

START = 4294967295  # the creator of the line's cells at the start


class Cell:
    """An interval or an edge. Its links, left and right, are handles (creator, number, block)."""

    def __init__(self, name, ends, left=None, right=None):
        self.name, self.ends, self.links = name, ends, [left, right]

    def copy(self): return Cell(self.name, self.ends, *self.links)

    def written(self):
        return {"name": self.name, "ends": self.ends, "left": self.links[0], "right": self.links[1]}


def chained(pieces):
    """The cells of a cavity, from the left to the right."""
    known = {p.name: p for p in pieces}
    inside = lambda link: link and link[:2] in known
    chain = [p for p in pieces if not inside(p.links[0])]
    while inside(chain[-1].links[1]):
        chain.append(known[chain[-1].links[1][:2]])
    return chain


class Mesh:
    """The cells of one worker: what it knows of the mesh, and who has locked which of them."""

    def __init__(self, setup, me):
        self.setup, self.me, self.cells, self.holder, self.named = setup, me, {}, {}, 0

    def block(self, cell): return self.block_of(cell.ends)
    def handle(self, cell): return (*cell.name, self.block(cell))
    def rim(self, chain): return chain[0].ends[0], chain[-1].ends[1]

    def fresh_name(self):
        self.named += 1
        return (self.me, self.named)  # R13

    def neighbours(self, name):
        """Handles of the neighbours, left before right."""
        return [link for link in self.cells[name].links if link]

    def cavity(self, name, point):
        """The cavity from a cell on, none if it leaves this worker; or else a lock in the way."""
        cavity, whole, stack = {}, True, [name]
        while stack:
            cell = self.cells[stack.pop()]
            if cell.name in self.holder:
                return None, cell.name
            if self.in_conflict(cell, point) and cell.name not in cavity:
                cavity[cell.name] = cell
                near = [h[:2] for h in self.neighbours(cell.name) if h[:2] in self.cells]
                whole = whole and len(near) == len(self.neighbours(cell.name))
                stack += reversed(near)
        return (chained(cavity.values()) if whole else None), None

    def star(self, chain, point):
        """The star of a point in its cavity: two new cells, linked with what is around."""
        (a, b), names = self.rim(chain), (self.fresh_name(), self.fresh_name())
        left = Cell(names[0], (a, point), left=chain[0].links[0])
        right = Cell(names[1], (point, b), right=chain[-1].links[1])
        left.links[1], right.links[0] = self.handle(right), self.handle(left)
        return left, right

    def walk(self, point, at):
        """Where a point is: known, empty, locked (t), leaves (by a handle), in (t)."""
        cell = self.first(point, self.cells.get(at and at[:2])) if self.cells else None
        for _ in self.cells:
            if point in cell.ends:
                break
            if cell.name in self.holder:
                return "locked", cell.name
            if self.in_conflict(cell, point):
                return "in", cell.name
            link = cell.links[self.is_ahead(cell, point)]
            if link[:2] not in self.cells:
                return "leaves", link
            cell = self.cells[link[:2]]
        return "known" if cell else "empty", None

    def take(self, block):
        """A block's cells, taken out in ascending order of their names."""
        gone = [c for c in self.cells.values() if self.block(c) == block]
        for cell in gone:
            del self.cells[cell.name]
        return sorted(gone, key=lambda c: c.name)


class Line(Mesh):
    """Intervals between neighbouring integers."""

    def start(self):
        ends = [-1, *self.setup["start"], self.setup["range"]]
        return [Cell((START, k), pair) for k, pair in enumerate(zip(ends, ends[1:]))]

    def block_of_point(self, v):
        return min(max(v, 0), self.setup["range"] - 1) * self.setup["blocks"] // self.setup["range"]

    def block_of(self, ends): return self.block_of_point(ends[0])
    def in_conflict(self, cell, point): return cell.ends[0] < point < cell.ends[1]

    def is_locked(self, block):
        return any(self.block(self.cells[name]) == block for name in self.holder)

    def first(self, point, named):
        if named and named.ends[0] <= point <= named.ends[1]:
            return named
        ordered = sorted(self.cells.values(), key=lambda c: c.ends)
        return ([c for c in ordered if c.ends[0] <= point] or ordered[:1])[-1]

    def is_ahead(self, cell, point): return point > cell.ends[1]


class Hull(Mesh):
    """Directed edges of a convex polygon. A point (x, y, block) conflicts with those it sees."""

    def start(self):
        polygon = [tuple(v) for v in self.setup["polygon"]]
        cells, given = [], {}
        for ends in zip(polygon, [*polygon[1:], polygon[0]]):
            owner = self.setup["owners"][self.block_of(ends)]
            cells.append(Cell((owner, given.setdefault(owner, 0)), ends))
            given[owner] += 1
        self.named = given.get(self.me, 0) - 1
        return [*cells, cells[0]]

    def block_of_point(self, v): return v[2]
    def block_of(self, ends): return min(ends[0][2], ends[1][2])

    def in_conflict(self, cell, p):
        a, b = cell.ends
        return (b[0] - a[0]) * (p[1] - a[1]) < (b[1] - a[1]) * (p[0] - a[0])

    def is_locked(self, block):
        locked = [self.cells[name] for name in self.holder]
        return any(block in (self.block(c), *(h[2] for h in c.links)) for c in locked)

    def first(self, _, named):
        return named or self.cells[min(self.cells)]

    def is_ahead(self, *_): return True


# The protocol ----------------------------------------------------------------------------------


class Operation:
    """What a home knows of a point on its way. It has no ticket before it needs one."""

    def __init__(self, point, ticket=None, attempt=0, at=None):
        self.point, self.ticket, self.attempt, self.at = point, ticket, attempt, at
        self.phase, self.releasing = "Ready", 0
        self.forget()

    def forget(self):
        self.asked, self.whereabouts, self.parts = {}, {}, {}


class Request:
    """What an owner knows of an operation. Wants are a stack of ('tet' or 'handle', which)."""

    def __init__(self, home, ticket, attempt, point):
        self.home, self.ticket, self.attempt, self.point = home, ticket, attempt, point
        self.wants, self.held, self.owed, self.stalled, self.wounded = [], [], 0, False, False
        self.found, self.foreign, self.bounced = [], [], []


def must(holds, invariant):
    if not holds:
        raise RuntimeError(f"{invariant} is broken")


def above(w): return (w - 1) // 16  # in the tree, of which 0 is the root


def below(w, workers): return [*range(16 * w + 1, min(16 * w + 17, workers))]


class Worker:
    """One worker: `step(event)` gives the list of its actions."""

    def __init__(self, mesh, setup, me):
        self.me, self.workers, self.window = me, len(setup["points"]), setup["window"]
        self.paper, self.line = setup["rule"] == "paper", mesh(setup, me)
        self.directory = {b: (owner, 0) for b, owner in enumerate(setup["owners"])}
        self.points = [tuple(p) if mesh is Hull else p for p in setup["points"][me]]
        self.operations, self.requests = {}, {}  # both by ticket
        self.waiting_tet, self.waiting_name = {}, {}  # name -> [('walk' or 'request', ticket)]
        self.clock, self.sequence = 0, 0
        self.children = below(me, self.workers)
        self.awaited, self.below = len(self.children), (0, False)  # awaited None: it has spoken
        self.count, self.black, self.stopped, self.cancelled = 0, me == 0, False, False
        self.actions, self.to_self = [], []
        line, cells = self.line, self.line.start()
        for left, right in zip(cells, cells[1:]):
            left.links[1], right.links[0] = line.handle(right), line.handle(left)
        line.cells = {c.name: c for c in cells if self.mine(line.block(c))}

    def owner(self, block): return self.directory[block][0]
    def mine(self, block): return self.owner(block) == self.me

    def learn(self, news):
        newer = [(b, (owner, epoch)) for b, owner, epoch in news if epoch > self.directory[b][1]]
        self.directory.update(newer)

    # Steps and messages

    def step(self, event):
        self.actions = []
        getattr(self, "event_" + event["event"])(event)
        while self.to_self:
            self.receive(self.me, self.to_self.pop(0))
        return self.actions

    def send(self, to, kind, **fields):
        message = {"kind": kind, **fields}
        if to == self.me:
            self.to_self.append(message)
            return
        self.count += kind not in ("token", "stop")
        self.actions.append({"to": to, "send": message})

    def event_deliver(self, event):
        if event["message"]["kind"] not in ("token", "stop"):
            self.count -= 1
            self.black = True  # R8
        self.receive(event["from"], event["message"])

    def receive(self, sender, message):
        if "ticket" in message:
            self.clock = max(self.clock, message["ticket"][0])
        getattr(self, "on_" + message["kind"])(sender, **message)

    def event_work(self, _):
        ready = [op for op in self.operations.values() if op.phase == "Ready"]
        if ready:
            self.start(min(ready, key=lambda op: op.ticket))
        elif self.points and len(self.operations) < self.window:
            self.start(Operation(self.points.pop(0)))
        elif self.awaited == 0 and self.passive():
            self.pass_token()

    def event_cancel(self, _): self.points, self.cancelled = [], True

    def event_retry(self, event):
        op = self.operations[tuple(event["ticket"])]
        must(op.phase == "Backoff", "P8")
        op.phase = "Ready"

    # The home

    def give_ticket(self, op):
        if op.ticket is None:
            self.clock, self.sequence = self.clock + 1, self.sequence + 1
            op.ticket = (self.clock, self.me, self.sequence)
        return op.ticket

    def start(self, op):
        self.operations.pop(op.ticket, None)
        kind, at = self.line.walk(op.point, op.at)
        if kind == "known":
            return
        if kind == "empty":
            self.walk_on(op, (self.me + 1) % self.workers, None)
        elif kind == "locked":
            self.walk_waits(op, self.waiting_tet, at)
        elif kind == "leaves" and self.mine(at[2]):
            self.walk_waits(op, self.waiting_name, at[:2])
        elif kind == "leaves":
            self.walk_on(op, self.owner(at[2]), at)
        else:
            self.insert(op, at)

    def walk_on(self, op, to, at):
        ticket = self.give_ticket(op)
        self.send(to, "walk", ticket=ticket, attempt=op.attempt, point=op.point, at=at)

    def walk_waits(self, op, table, name):
        op.phase = "Walking"
        self.operations[self.give_ticket(op)] = op
        table.setdefault(name, []).append(("walk", op.ticket))

    def insert(self, op, name):
        line = self.line
        chain, locked = line.cavity(name, op.point)
        if locked and not self.paper:
            return self.walk_waits(op, self.waiting_tet, locked)
        if not chain or not self.all_mine(line.rim(chain), op.point):
            op.phase, op.asked = "Expanding", {self.me: 1}
            self.operations[self.give_ticket(op)] = op
            return self.request(self.me, op.ticket, op.attempt, op.point, [("tet", name)])
        for cell in chain:
            del line.cells[cell.name]
        for side, new in enumerate(line.star(chain, op.point)):
            line.cells[new.name] = new
            if new.links[side]:
                line.cells[new.links[side][:2]].links[1 - side] = line.handle(new)

    def all_mine(self, rim, point):
        return all(self.mine(self.line.block_of(e)) for e in ((rim[0], point), (point, rim[1])))

    def on_walk(self, _, kind, ticket, attempt, point, at):
        op = Operation(point, ticket, attempt, at)
        if at is None or self.mine(at[2]):
            self.start(op)
        else:
            self.walk_on(op, self.owner(at[2]), at)  # R10

    def on_grant(self, sender, kind, ticket, attempt, answers, pieces, foreign, bounced, moved):
        op = self.operations.get(ticket)
        must(op and op.attempt == attempt and op.phase in ("Expanding", "Releasing"), "P8")
        if op.phase == "Releasing":
            return
        self.learn(moved)
        op.parts.setdefault(sender, []).extend(pieces)
        op.asked[sender] -= answers
        must(op.asked[sender] >= 0, "P8")
        seeds, new = {}, {f[:2]: f for f in reversed(foreign) if f[:2] not in op.whereabouts}
        for f in [f for f in foreign if new.pop(f[:2], None)] + bounced:
            op.whereabouts[f[:2]] = self.owner(f[2])
            seeds.setdefault(self.owner(f[2]), []).append(f)
        for w in sorted(seeds):
            op.asked[w] = op.asked.get(w, 0) + 1
            what = {"point": op.point, "seeds": seeds[w]}
            self.send(w, "expand", ticket=op.ticket, attempt=op.attempt, **what)
        if not any(op.asked.values()):
            self.fill(op)

    def fill(self, op):
        """The commit point: two new cells fill the cavity."""
        patches = {}
        patch = lambda w: patches.setdefault(w, {"remove": [], "add": [], "relink": []})
        owner = {piece.name: w for w, pieces in op.parts.items() for piece in pieces}
        chain = chained([piece for pieces in op.parts.values() for piece in pieces])
        for piece in chain:
            patch(owner[piece.name])["remove"].append(piece.name)
        for side, new in enumerate(self.line.star(chain, op.point)):
            beyond = new.links[side]
            if beyond:
                change = {"of": beyond[:2], "side": 1 - side, "to": self.line.handle(new)}
                near = owner[chain[-side].name]
                patch(op.whereabouts.get(beyond[:2], near))["relink"].append(change)  # R12
            block, piece = self.line.block(new), chain[-side]
            stays = isinstance(self.line, Line) and block == self.line.block(piece)
            patch(owner[piece.name] if stays else self.owner(block))["add"].append(new)
        del self.operations[op.ticket]
        for w in [*sorted(op.asked), *sorted(set(patches) - set(op.asked))]:
            self.send(w, "commit", ticket=op.ticket, patch=patches.get(w))

    def on_wound(self, _, kind, ticket, attempt):
        op = self.operations.get(ticket)
        if op and op.phase == "Expanding" and op.attempt == attempt:  # R7
            self.set_back(op)

    on_deny = on_wound  # of the paper's rule

    def set_back(self, op):
        op.phase, op.releasing = "Releasing", len(op.asked)
        for w in sorted(op.asked):
            self.send(w, "abort", ticket=op.ticket, attempt=op.attempt)
        op.forget()

    def on_aborted(self, _, kind, ticket, attempt):
        op = self.operations.get(ticket)
        must(op and op.phase == "Releasing" and op.attempt == attempt, "P8")
        op.releasing -= 1
        if op.releasing:  # R6
            return
        op.attempt += 1
        op.phase = "Backoff" if self.paper else "Ready"
        if self.paper:
            self.actions.append({"backoff": op.ticket, "attempt": op.attempt})

    # The owner

    def on_expand(self, sender, kind, ticket, attempt, point, seeds):
        self.request(sender, ticket, attempt, point, [("handle", seed) for seed in seeds])

    def request(self, home, ticket, attempt, point, seeds):
        r = self.requests.get(ticket)
        if r is None:
            r = self.requests[ticket] = Request(home, ticket, attempt, point)
        must(r.attempt == attempt and r.home == home, "P8")
        r.owed += 1
        if r.stalled:
            r.wants[-1:-1] = seeds  # R5
        else:
            r.wants += seeds
            self.advance(r)

    def advance(self, r):
        r.stalled = False
        while r.wants:
            kind, want = r.wants[-1]
            if kind == "handle" and not self.mine(want[2]):
                r.bounced.append(want)  # R10
                r.wants.pop()
                continue
            name = want[:2]
            if name not in self.line.cells:
                must(kind == "handle", "P6")
                return self.stall(r, self.waiting_name, name)  # R14
            holder = self.line.holder.get(name)
            if holder not in (None, r.ticket):
                return self.meet(r, name, self.requests[holder])
            r.wants.pop()
            if holder is None:
                self.lock(r, name)
        self.grant(r)

    def lock(self, r, name):
        self.line.holder[name] = r.ticket  # R1
        r.held.append(name)
        if not self.line.in_conflict(self.line.cells[name], r.point):
            return
        r.found.append(name)
        for handle in self.line.neighbours(name):
            if handle[:2] in self.line.cells:
                r.wants.append(("tet", handle[:2]))
            else:
                r.foreign.append(handle)

    def stall(self, r, table, name):
        r.stalled = True
        table.setdefault(name, []).append(("request", r.ticket))

    def meet(self, r, name, holder):
        """A request meets a lock: what the rule does. The paper's has no queue: `Abort` follows."""
        if self.paper:
            r.stalled = True
            self.send(r.home, "deny", ticket=r.ticket, attempt=r.attempt)
            return
        self.stall(r, self.waiting_tet, name)
        if r.ticket < holder.ticket and not holder.wounded:
            holder.wounded = True
            self.send(holder.home, "wound", ticket=holder.ticket, attempt=holder.attempt)

    def grant(self, r):
        pieces = [self.line.cells[name].copy() for name in r.found]
        moved = [(b, *self.directory[b]) for b in sorted({h[2] for h in r.bounced})]
        lists = {"pieces": pieces, "foreign": r.foreign, "bounced": r.bounced, "moved": moved}
        self.send(r.home, "grant", ticket=r.ticket, attempt=r.attempt, answers=r.owed, **lists)
        r.owed, r.found, r.foreign, r.bounced = 0, [], [], []

    def unlock(self, r):
        """Unlocks all that a request holds (R2); gives everybody in the queues of these (R4)."""
        woken = []
        for name in r.held:
            del self.line.holder[name]
            woken += self.waiting_tet.pop(name, [])
        return woken

    def wake(self, woken):
        for kind, ticket in sorted(woken, key=lambda who: who[1]):
            if kind == "walk":
                self.operations[ticket].phase = "Ready"
            else:
                self.advance(self.requests[ticket])

    def on_abort(self, sender, kind, ticket, attempt):
        r = self.requests.pop(ticket, None)
        must(r and r.attempt == attempt and r.home == sender, "P8")
        for table in (self.waiting_tet, self.waiting_name):
            for name, queue in list(table.items()):
                table[name] = [who for who in queue if who != ("request", r.ticket)]
        self.wake(self.unlock(r))  # R3
        self.send(sender, "aborted", ticket=r.ticket, attempt=attempt)

    def on_commit(self, _, kind, ticket, patch):
        r = self.requests.pop(ticket, None)
        must(r or (patch and not patch["remove"]), "P8")
        must(not r or not r.stalled, "P8")
        woken = self.unlock(r) if r else []
        patch = patch or {"remove": [], "add": [], "relink": []}
        for name in patch["remove"]:
            del self.line.cells[name]
        woken += self.install(patch["add"])
        for change in patch["relink"]:
            self.line.cells[change["of"]].links[change["side"]] = change["to"]
        self.send_strays(patch["add"])
        self.wake(woken)

    def install(self, cells):
        """Installs cells; gives the queues of their names."""
        woken = []
        for cell in cells:
            self.line.cells[cell.name] = cell
            woken += self.waiting_name.pop(cell.name, [])
        return woken

    def send_strays(self, cells):
        strayed = {self.line.block(c) for c in cells}
        for block in sorted(b for b in strayed if not self.mine(b)):
            self.send(self.owner(block), "stray", block=block, cargo=self.line.take(block))

    # Blocks that move

    def event_migrate(self, event):
        block, to, line = event["block"], event["to"], self.line
        locked = line.is_locked(block)
        if not self.mine(block) or to == self.me or locked or self.stopped or self.passive():  # R9
            return
        cargo = line.take(block)
        points = [p for p in self.points if line.block_of_point(p) == block]
        self.points = [p for p in self.points if p not in points]
        epoch = self.directory[block][1] + 1
        self.directory[block] = (to, epoch)
        self.send(to, "migrate", block=block, epoch=epoch, cargo=cargo, points=points)
        gone = {cell.name: line.handle(cell) for cell in cargo}
        for r in self.requests.values():
            r.foreign += [gone[w] for kind, w in r.wants if kind == "tet" and w in gone]
            r.wants = [(kind, w) for kind, w in r.wants if kind != "tet" or w not in gone]
        self.wake(self.waiters_of(block))  # R11

    def waiters_of(self, block):
        """Takes out all walks that wait for a name, and requests that wait for one of the block."""
        told = lambda who: who[0] == "walk" or self.requests[who[1]].wants[-1][1][2] == block
        woken = []
        for name, queue in self.waiting_name.items():
            woken += filter(told, queue)
            self.waiting_name[name] = [who for who in queue if not told(who)]
        return woken

    def on_migrate(self, _, kind, block, epoch, cargo, points):
        self.directory[block] = (self.me, epoch)
        if not self.cancelled:  # R15
            self.points += points
            if isinstance(self.line, Hull):
                self.points.sort()
        self.wake(self.install(cargo))

    def on_stray(self, _, kind, block, cargo):
        if self.mine(block):
            self.wake(self.install(cargo))
        else:
            self.send(self.owner(block), "stray", block=block, cargo=cargo)  # R10

    # Termination

    def passive(self): return not self.operations and not self.points
    def on_stop(self, _, kind): self.stopped = True

    def on_token(self, sender, kind, count, black):
        if sender < self.me:  # from above: the next wave
            self.start_wave()
        else:
            self.awaited, self.below = self.awaited - 1, self.add(count, black)

    def add(self, count, black): return self.below[0] + count, self.below[1] or black

    def start_wave(self):
        self.awaited = len(self.children)
        for w in self.children:
            self.send(w, "token", count=0, black=False)

    def pass_token(self):
        count, black = self.add(self.count, self.black)
        if self.me == 0 and (self.workers == 1 or not black and count == 0):
            for w in range(1, self.workers):
                self.send(w, "stop")
            self.stopped = True
            return
        self.awaited, self.below, self.black = None, (0, False), False
        if self.me == 0:
            self.start_wave()
        else:
            self.send(above(self.me), "token", count=count, black=black)


def run_line(ask):
    """Runs workers over a given order of events: after each its actions, and the workers."""
    setup = ask["setup"]
    mesh = {"line": Line, "hull": Hull}[ask.get("mesh", ask["op"])]
    workers = [Worker(mesh, setup, w) for w in range(len(setup["points"]))]
    channels = {}
    for event in ask["events"]:
        me, message = event["worker"], None
        if event["event"] == "deliver":
            message = channels[event["from"], me].pop(0)
        actions = workers[me].step({**event, "message": message})
        for action in actions:
            if "send" in action:
                channels.setdefault((me, action["to"]), []).append(action["send"])
        yield json.loads(json.dumps(actions, default=Cell.written)), workers


def answer_line(ask):
    steps = []
    for actions, workers in run_line(ask):
        steps.append(actions)
    cells = [sorted(c.ends for c in w.line.cells.values()) for w in workers]
    return {"steps": steps, "state": {"cells": cells, "stopped": [w.stopped for w in workers]}}


def answer_judge(ask):
    runs = enumerate(run_line(ask))
    return {"wrong": next((k for k, (found, _) in runs if found != ask["steps"][k]), None)}


# Questions -------------------------------------------------------------------------------------


# Rounds of refinement ---------------------------------------------------------------------------


def distance2(p, q):
    x, y, z = minus(p, q)
    return x * x + y * y + z * z


def square(v): return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]


def size2(corners):
    """The square of the length, or the circumradius: f64 arithmetic in the order of the page."""
    if len(corners) == 2:
        return distance2(*corners)
    if len(corners) == 3:
        u, v = minus(corners[1], corners[0]), minus(corners[2], corners[0])
        uu, vv = square(u), square(v)
        uv = u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
        g = 2.0 * square(cross(u, v))
        x, y = vv * (uu - uv) / g, uu * (vv - uv) / g
        return square([x * a + y * b for a, b in zip(u, v)])
    a, b, c = (minus(p, corners[3]) for p in corners[:3])
    bc, ca, ab = cross(b, c), cross(c, a), cross(a, b)
    aa, bb, cc = square(a), square(b), square(c)
    normal = [aa * bc[k] + bb * ca[k] + cc * ab[k] for k in range(3)]
    volume6 = a[0] * bc[0] + a[1] * bc[1] + a[2] * bc[2]
    return square(normal) / (4.0 * (volume6 * volume6))


def bits(number): return struct.unpack("<Q", struct.pack("<d", number))[0]


def key_of(corners):
    """16 leading bits of the size, 47 of a hash of the corners by x, y, z, and a 1."""
    corners = sorted(corners)
    hashed = 0
    for c in (c for p in corners for c in p):
        hashed = (hashed ^ bits(c)) * 0x9E3779B97F4A7C15 & (1 << 64) - 1
        hashed ^= hashed >> 32
    return bits(size2(corners)) >> 48 << 48 | hashed >> 16 | 1


def rank_of(corners):
    """The smaller one comes first: the larger key, then the smaller corners."""
    corners = [[float.fromhex(c) for c in p] for p in corners]
    return -key_of(corners), sorted(corners)


def answer_foremost(ask):
    ranks, around = [rank_of(t) for t in ask["tets"]], ask["neighbours"]
    over = [t for t, is_over in enumerate(ask["over"]) if is_over]

    def near(t): return {n for beside in around[t] for n in [beside, *around[beside]]} - {t}

    return {"foremost": [t for t in over if not any(ranks[n] < ranks[t] for n in near(t) & {*over})]}


def answer_kill(ask):
    ranks = [rank_of(c["tet"]) for c in ask["candidates"]]
    both = list(zip(ranks, ask["candidates"]))
    dies = lambda rank, own: any(r < rank and own in c["cavity"] for r, c in both)
    return {"chosen": [k for k, (rank, c) in enumerate(both) if not dies(rank, c["own"])]}


def answer_wave(ask):
    """A worker speaks when it itself and those below it have."""
    workers, known, up, total = ask["workers"], {}, [], None
    for word in ask["words"]:
        sent, who = [], word["worker"]
        known[who, who] = word["sums"]
        while True:
            own = [who, *below(who, workers)]
            if any((who, w) not in known for w in own):
                break
            sums = [sum(column) for column in zip(*(known[who, w] for w in own))]
            if who == 0:
                total = sums
                break
            sent.append({"from": who, "to": above(who), "sums": sums})
            known[above(who), who] = sums
            who = above(who)
        up.append(sent)
    return {"up": up, "all": total}


def answer_quiet(ask):
    sent, taken = ask["sums"]
    return {"quiet": sent == taken and ask["before"] == ask["sums"]}


def ask_mesh(ask):
    points = [read(p) for p in ask["points"]] + [read(ask["at"])]
    tets = [tuple(t) for t in ask["tets"]]
    ghosts = [(*f, INFINITE) for f in ask["hull"]]
    return points, tets, ghosts


def answer_cavity(ask):
    points, tets, ghosts = ask_mesh(ask)
    cavity, ring = closure(points, set(tets + ghosts), points[-1])
    where = lambda some, chosen: [k for k, t in enumerate(some) if t in chosen]
    inside = {"cavity": where(tets, cavity), "cavity_hull": where(ghosts, cavity)}
    return {**inside, "ring": where(tets, ring), "ring_hull": where(ghosts, ring)}


def answer_insert(ask):
    points, tets, ghosts = ask_mesh(ask)
    old = set(tets + ghosts)
    new = inserted(points, old, len(points) - 1) - old
    return {"created": finite(new), "created_hull": hull(new)}


def answer_delaunay(ask):
    points = points_of(ask)
    tets = delaunay(points)
    rows = finite(tets)
    counts = {"tets": len(rows), "hull": len(hull(tets))}
    listed = rows if len(rows) <= 40 else None
    return {**counts, "hash": mesh_hash(points, floats_of(ask), rows), "list": listed}


def floats_of(ask): return [[float.fromhex(c) for c in p] for p in ask["points"]]
def points_of(ask): return [read(p) for p in ask["points"]]
def signed(predicate): return lambda ask: {"sign": predicate(*points_of(ask))}


ANSWERS = {
    "orient3d": signed(orient3d),
    "insphere": signed(insphere),
    "side_of_sphere": signed(lambda *points: side_of_sphere(points[:4], points[4])),
    "side_of_hull_facet": signed(lambda *points: side_of_hull_facet(points[:3], points[3])),
    "compare_xyz": signed(lambda p, q: (p > q) - (p < q)),
    "hilbert": lambda ask: {"order": in_rounds(floats_of(ask), 0)},
    "brio_hilbert": lambda ask: {"order": in_rounds(floats_of(ask), brio_rounds(ask["points"]))},
    "round_of": lambda ask: {"round": round_of(ask["index"], ask["rounds"])},
    "blocks": lambda ask: {
        "blocks": [block_of(t, ask["vertices"], ask["blocks"]) for t in ask["tets"]]
    },
    "cavity": answer_cavity,
    "insert": answer_insert,
    "delaunay": answer_delaunay,
    "line": answer_line,
    "hull": answer_line,
    "judge": answer_judge,
    "key": lambda ask: {"key": f"{key_of(floats_of(ask)):016x}"},
    "foremost": answer_foremost,
    "kill": answer_kill,
    "wave": answer_wave,
    "quiet": answer_quiet,
}


def main():
    for line in sys.stdin:
        ask = json.loads(line)
        known = ANSWERS.get(ask["op"])
        reply = known(ask) if known else {"unsupported": True}
        print(json.dumps(reply), flush=True)


if __name__ == "__main__":
    main()
