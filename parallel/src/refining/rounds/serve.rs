//! The owner's side of the choice: ways, searches, reservations, and what rivals there are.

use crate::protocol::Handle;
use crate::refining::domain::DomainMesh;
use crate::refining::news::{
    Bits, INFINITE_CORNER, PartEnd, ProbeId, Proposal, WireClosure, WireCorner, WireItem, point,
};
use ltbw_core::cavity::OTHERS;
use ltbw_core::topology::{INFINITE, TetId, VertexId, slot_of, tet_of};
use ltbw_domain::refine::{Carrier, Corner, Rank, Rival, way_out};
use rustc_hash::FxHashMap;

/// One probe's part of its closure here.
#[derive(Debug)]
pub(super) struct Part {
    rank: Rank,
    carrier: Carrier,
    /// It reserves nothing.
    is_void: bool,
    /// Its home wants to hear of rivals.
    is_wanted: bool,
    /// Is each tetrahedron looked at in conflict?
    seen: FxHashMap<TetId, bool>,
    /// They in the order in which the home was told.
    pub(super) order: Vec<TetId>,
}

impl Part {
    fn of(own: &Proposal) -> Self {
        Self {
            rank: own.rank,
            carrier: own.carrier,
            is_void: false,
            is_wanted: false,
            seen: FxHashMap::default(),
            order: Vec::new(),
        }
    }

    /// The tetrahedra in conflict.
    pub(super) fn cavity(&self) -> impl Iterator<Item = TetId> + '_ {
        self.order.iter().copied().filter(|t| self.seen[t])
    }

    /// Is a tetrahedron in conflict?
    pub(super) fn has(&self, t: TetId) -> bool {
        self.seen.get(&t).copied().unwrap_or_default()
    }
}

/// The end of a way.
pub(super) enum WayEnd {
    /// It ends in the tetrahedron that holds its point.
    At(TetId),
    /// It goes on elsewhere.
    Far(Handle),
    /// It is not to be searched.
    Not(PartEnd),
}

/// The parts that this worker has been asked for in a round.
#[derive(Debug, Default)]
pub(super) struct Served {
    parts: FxHashMap<ProbeId, Part>,
    /// The foremost candidate with a tetrahedron in its cavity, and where its point lives.
    reserved: FxHashMap<TetId, (Rank, Carrier)>,
}

impl Served {
    /// Starts a round.
    pub(super) fn clear(&mut self) {
        self.parts.clear();
        self.reserved.clear();
    }

    pub(super) fn part(&self, probe: ProbeId) -> Option<&Part> {
        self.parts.get(&probe)
    }

    /// Looks at tetrahedra, and from those in conflict on. Returns the new ones, and the far
    /// neighbours of those in conflict.
    pub(super) fn search(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        own: &Proposal,
        seeds: impl Iterator<Item = TetId>,
    ) -> (Vec<TetId>, Vec<Handle>) {
        let p = &point(&own.to);
        let part = self.parts.entry(own.probe).or_insert_with(|| Part::of(own));
        let before = part.order.len();
        let mut foreign = Vec::new();
        let mut stack: Vec<TetId> = seeds.collect();
        // Ends: each is looked at once.
        while let Some(t) = stack.pop() {
            if part.seen.contains_key(&t) {
                continue;
            }
            let is_in = mesh.conflicts(t, p);
            part.seen.insert(t, is_in);
            part.order.push(t);
            if is_in {
                let tets = mesh.inner.tets();
                for u in tets.neighbours(t).map(tet_of) {
                    match tets.far(u) {
                        Some(handle) => foreign.push(handle),
                        None => stack.push(u),
                    }
                }
            }
        }
        (part.order[before..].to_vec(), foreign)
    }

    /// A probe reserves nothing.
    pub(super) fn drop_part(&mut self, probe: ProbeId) {
        if let Some(part) = self.parts.get_mut(&probe) {
            part.is_void = true;
        }
    }

    /// The home of a probe wants to hear of rivals.
    pub(super) fn want_rivals(&mut self, probe: ProbeId) {
        if let Some(part) = self.parts.get_mut(&probe) {
            part.is_wanted = true;
        }
    }

    /// All probes have ended: reserves their cavities. Returns those whose homes want to hear of
    /// rivals.
    pub(super) fn reserve_all(&mut self) -> Vec<ProbeId> {
        let Self { parts, reserved } = self;
        for part in parts.values().filter(|part| !part.is_void) {
            let own = (part.rank, part.carrier);
            for t in part.cavity() {
                let entry = reserved.entry(t).or_insert(own);
                if own.0 < entry.0 {
                    *entry = own;
                }
            }
        }
        let wanted = parts.iter().filter(|(_, part)| part.is_wanted);
        let mut wanted: Vec<ProbeId> = wanted.map(|(&probe, _)| probe).collect();
        wanted.sort_unstable();
        wanted
    }

    /// Is a candidate before this one in the way of its own tetrahedron?
    pub(super) fn has_rival(&self, t: TetId, rank: Rank) -> bool {
        self.reserved.get(&t).is_some_and(|own| own.0 < rank)
    }

    /// The rivals in a probe's part of its closure, in the order in which its home was told.
    pub(super) fn rivals(&self, probe: ProbeId) -> Vec<Rival> {
        let Some(part) = self.parts.get(&probe) else { return Vec::new() };
        let rival = |t: &TetId| match self.reserved.get(t) {
            Some((other, at)) if *other < part.rank => Rival {
                is_there: true,
                is_boundary: other.is_boundary(),
                is_apart: !is_same(*at, part.carrier),
            },
            _ => Rival::default(),
        };
        part.order.iter().map(rival).collect()
    }
}

/// Are two boundary points on one segment, or in one facet?
fn is_same(a: Carrier, b: Carrier) -> bool {
    match (a, b) {
        (Carrier::Segment(s, _), Carrier::Segment(r, _)) => s == r,
        (Carrier::Facet(f), Carrier::Facet(g)) => f == g,
        _ => false,
    }
}

/// A corner of a tetrahedron here.
pub(super) fn corner(mesh: &DomainMesh<'_>, v: VertexId) -> Corner {
    Corner { point: mesh.point(v), carrier: mesh.carrier(v) }
}

/// May something of a tetrahedron be boundary?
fn is_near(mesh: &DomainMesh<'_>, t: TetId) -> bool {
    let is_on = |v: &VertexId| *v != INFINITE && mesh.carrier(*v) != Carrier::Free;
    mesh.inner.tets().vertices(t).iter().filter(|v| is_on(v)).count() > 1
}

/// May something of a cavity's part be boundary?
pub(super) fn is_part_near(mesh: &DomainMesh<'_>, part: &Part) -> bool {
    part.cavity().any(|t| is_near(mesh, t))
}

/// Some tetrahedra of a part as their home gets to know them.
pub(super) fn describe(mesh: &DomainMesh<'_>, part: &Part, tets: &[TetId]) -> WireClosure {
    let mut found = WireClosure::default();
    let mut places: FxHashMap<VertexId, u32> = FxHashMap::default();
    for &t in tets {
        let v = mesh.inner.tets().vertices(t).map(|v| match v {
            INFINITE => INFINITE_CORNER,
            v => *places.entry(v).or_insert_with(|| {
                found.corners.push(WireCorner::new(&corner(mesh, v)));
                found.corners.len() as u32 - 1
            }),
        });
        found.tets.push((v, part.has(t)));
    }
    found
}

/// Walks straight from `start` to `to`, from face `entry` of tetrahedron `t` on.
pub(super) fn walk_way(
    mesh: &mut DomainMesh<'_>,
    (mut t, mut entry): (TetId, Option<usize>),
    start: &Bits,
    to: &Bits,
    may: bool,
) -> WayEnd {
    let (from, p) = (start.map(f64::from_bits), to.map(f64::from_bits));
    let slots = mesh.inner.tets().topology().slots();
    // In a Delaunay mesh such a walk visits no tetrahedron twice; the bound only guards it.
    for step in 0..=slots {
        let tets = mesh.inner.tets();
        let v = tets.vertices(t);
        if v[3] == INFINITE {
            mesh.count_steps(step as u64);
            return WayEnd::Not(PartEnd::Outside);
        }
        let corners = v.map(|v| mesh.point(v));
        let Some(slot) = way_out(corners, entry, &from, &p) else {
            mesh.count_steps(step as u64);
            return match corners.contains(&p) {
                _ if !may => WayEnd::Not(PartEnd::Outside),
                true => WayEnd::Not(PartEnd::Vertex),
                false => WayEnd::At(t),
            };
        };
        let face = OTHERS[slot].map(|k| corner(mesh, v[k]));
        if face.iter().all(|corner| corner.carrier != Carrier::Free)
            && let Some(item) = mesh.complex.item_at(face)
        {
            mesh.count_steps(step as u64);
            return WayEnd::Not(PartEnd::Blocked(WireItem::new(&item)));
        }
        let next = mesh.inner.tets().neighbours(t)[slot];
        if let Some(handle) = mesh.inner.tets().far(tet_of(next)) {
            mesh.count_steps(step as u64);
            return WayEnd::Far(handle);
        }
        (t, entry) = (tet_of(next), Some(slot_of(next)));
    }
    WayEnd::Not(PartEnd::Outside)
}
