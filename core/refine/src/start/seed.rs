//! Seeds: the first points inside a domain with large empty balls.
//!
//! Where nearly all vertices lie on one sphere, or on a few, the cavity of every point is nearly
//! the whole mesh, and each point of the boundary costs as much. The centres of the largest balls,
//! inserted first, part the mesh: each such cavity is a fraction of the one before it.

use crate::complex::measure::Shape;
use crate::heed::Heed;
use crate::mesh::item::{Item, Queues};
use crate::mesh::state::Place;
use crate::queue::split::{Proposal, Refinement};
use crate::rules::aim::Aim;
use crate::rules::verdict::Verdict;
use crate::rules::walk::Way;
use ltbw_core::topology::{TetId, VertexId};
use std::collections::BinaryHeap;

/// The least number of tetrahedra in the cavity of a seed.
const LARGE: usize = 256;

/// Proposals with smaller cavities, one after the other, after which no more are made.
const TRIES: u32 = 64;

/// Refused cavities may have this many times the tetrahedra of the mesh, all together.
const REFUSED: usize = 4;

/// A tetrahedron, the largest circumradius first.
type Candidate = (u64, [VertexId; 4], TetId);

impl Refinement<'_> {
    /// Inserts the circumcentres of the tetrahedra over their bounds that have large cavities and
    /// that no boundary item bars, the largest balls first; `most`: how many there may be.
    pub(crate) fn seed(&mut self, most: u64, heed: Heed<'_>, work: &mut Queues) {
        let all: Vec<TetId> = self.state.mesh.tet_ids().collect();
        let mut heap: BinaryHeap<Candidate> = BinaryHeap::new();
        heap.extend(all.iter().filter_map(|&t| self.candidate(t)));
        let (mut small, mut refused) = (0, REFUSED * all.len());
        let mut inserted = 0;
        // Each round takes a candidate; new ones come with points only, whose number is limited.
        while let Some((_, v, t)) = heap.pop() {
            // One cavity may be nearly the whole mesh: the token is asked before each.
            if small == TRIES || inserted == most || heed.is_cancelled() {
                return;
            }
            if !self.state.is_live(t, v) {
                continue;
            }
            let Some(place) = self.centre_of(t, v) else { continue };
            let mut size = 0;
            let verdict = self.propose(&place, work, |judge| {
                size = judge.closure.state.mesh.cavity().tets().count();
                match size < LARGE {
                    true => Verdict::Useless,
                    false => judge.on_tet(t, &place),
                }
            });
            match verdict {
                Proposal::Inserted => {
                    (small, inserted) = (0, inserted + 1);
                    let created = std::mem::take(&mut self.inserted.created);
                    heap.extend(created.iter().filter_map(|&t| self.candidate(t)));
                    self.inserted.created = created;
                }
                Proposal::SetBack(_) => return,
                _ if size < LARGE => small += 1,
                _ => match refused.checked_sub(size) {
                    Some(left) => refused = left,
                    None => return,
                },
            }
        }
    }

    /// A tetrahedron over its bounds, by its circumradius.
    fn candidate(&self, t: TetId) -> Option<Candidate> {
        let v = self.state.vertices(t);
        self.bounds.as_ref()?.is_over(&self.state, t).then_some(())?;
        let [a, b, c, d] = v.map(|v| self.state.at(v));
        // The bits of positive numbers are in the order of the numbers.
        Some((Shape::of([&a, &b, &c, &d]).radius().to_bits(), v, t))
    }

    /// The circumcentre of a tetrahedron, if there is a way to it inside the domain.
    fn centre_of(&self, t: TetId, v: [VertexId; 4]) -> Option<Place> {
        let [a, b, c, d] = v.map(|v| self.state.at(v));
        let shape = Shape::of([&a, &b, &c, &d]);
        if self.record.refused.contains_key(&Item::Tet(t, v)) {
            return None;
        }
        let aim = self.aims().tet(shape.radius(), shape.circumcentre(&d), 0);
        let Aim::At { point: p, carrier, may: true } = aim else { return None };
        match self.state.way(t, &p) {
            Way::Arrived(from) => Some(Place { p, carrier, from }),
            Way::Blocked(_) | Way::Outside => None,
        }
    }
}
