//! A worker's range of vertices, and cursors on it.

use crate::mesh::{LocalMesh, Place, VertexName, WireVertex, given};
use ltbw_core::order::round_of;
use std::collections::VecDeque;
use std::ops::Range;

/// No piece of the curve with fewer points is cut in two. At least 2: the halves are shorter.
pub(super) const SHORTEST: usize = 4;

/// The most vertices of a cursor at the interface. Its points wait one after the other: a
/// long one would be the last of all to end.
const LONGEST: Place = 64;

/// The worker's range of vertices: which of them are not to be given, for they are in the coarse
/// mesh or have moved away; and in which round each comes.
#[derive(Clone, Debug)]
pub(super) struct Own {
    pub(super) range: Range<Place>,
    /// A bit for each vertex.
    out: Vec<u64>,
    /// Pieces at the interface, ascending and disjoint.
    pub(super) interface: Vec<Range<Place>>,
    /// The last round; the first one is 0.
    pub(super) rounds: u32,
}

impl Own {
    /// Vertices `range`, none of which is out.
    pub(super) fn new(range: Range<Place>) -> Self {
        let rounds = match range.len() {
            0..4096 => 0,
            4096..65536 => 1,
            _ => 2,
        };
        let out = vec![0; range.len().div_ceil(64)];
        Self { range, out, interface: Vec::new(), rounds }
    }

    fn place(&self, v: Place) -> (usize, u64) {
        let bit = v - self.range.start;
        (bit as usize / 64, 1 << (bit % 64))
    }

    /// Is `v`, of this range, out? Then it stays so.
    pub(super) fn take_out(&mut self, v: Place) -> bool {
        let (word, bit) = self.place(v);
        let was = self.out[word] & bit != 0;
        self.out[word] |= bit;
        was
    }

    fn is_out(&self, v: Place) -> bool {
        let (word, bit) = self.place(v);
        self.out[word] & bit != 0
    }

    /// Is `v` to be given in `round`?
    fn gives(&self, v: Place, round: u32) -> bool {
        !self.is_out(v) && round_of(v, self.rounds) == round
    }

    /// The first vertex of a round in `from..end`, or `end`.
    pub(super) fn first(&self, from: Place, end: Place, round: u32) -> Place {
        (from..end).find(|&v| self.gives(v, round)).unwrap_or(end)
    }

    /// Vertices of `range` and of rounds from `first` on, which are not out.
    pub(super) fn since_round(
        &self,
        range: &Range<Place>,
        first: u32,
    ) -> impl Iterator<Item = Place> + '_ {
        let both = range.start.max(self.range.start)..range.end.min(self.range.end);
        both.filter(move |&v| !self.is_out(v) && round_of(v, self.rounds) >= first)
    }

    /// Cuts a piece of the range into those at the interface, none of which is long, and others.
    pub(super) fn stretches(&self, piece: Range<Place>) -> Vec<(Range<Place>, bool)> {
        let first = self.interface.partition_point(|r| r.end <= piece.start);
        let mut all = Vec::new();
        let mut from = piece.start;
        for r in self.interface[first..].iter().take_while(|r| r.start < piece.end) {
            let (start, end) = (r.start.max(from), r.end.min(piece.end));
            all.push((from..start, false));
            let short = |start| (start..end.min(start + LONGEST), true);
            all.extend((start..end).step_by(LONGEST as usize).map(short));
            from = from.max(end);
        }
        all.push((from..piece.end, false));
        all.retain(|(range, _)| !range.is_empty());
        all
    }
}

/// The points that a cursor is to give.
#[derive(Clone, Debug)]
pub(super) enum Track {
    /// Vertices of a round in a piece of the worker's range; `next` is one if it is not `end`.
    /// The submesh has their coordinates.
    Own { next: Place, end: Place, round: u32 },
    /// Points that have moved here.
    Moved(VecDeque<WireVertex>),
}

/// Is it a given vertex of `range`?
fn lies_in(vertex: &WireVertex, range: &Range<Place>) -> bool {
    given(vertex.name).is_some_and(|place| range.contains(&place))
}

/// A piece of a Hilbert curve.
#[derive(Clone, Debug)]
pub(super) struct Cursor {
    /// The points left.
    pub(super) track: Track,
    /// The point given last, if it is not inserted yet.
    pub(super) given: Option<VertexName>,
    /// It lies at the interface, as far as is known.
    pub(super) is_interface: bool,
}

impl Cursor {
    pub(super) fn new(track: Track) -> Self {
        Self { track, given: None, is_interface: false }
    }

    pub(super) fn is_empty(&self) -> bool {
        match &self.track {
            Track::Own { next, end, .. } => next == end,
            Track::Moved(points) => points.is_empty(),
        }
    }

    /// Is no point of it under way?
    pub(super) fn is_ready(&self) -> bool {
        self.given.is_none()
    }

    /// About how many points it has.
    pub(super) fn length(&self, own: &Own) -> usize {
        match &self.track {
            Track::Own { next, end, round } => (end - next) as usize >> (3 * (own.rounds - round)),
            Track::Moved(points) => points.len(),
        }
    }

    /// Cuts off the second half, if it is not short.
    pub(super) fn split(&mut self, own: &Own) -> Option<Self> {
        if self.length(own) < SHORTEST {
            return None;
        }
        let track = match &mut self.track {
            Track::Own { next, end, round } => {
                let middle = *next + (*end - *next) / 2;
                let half =
                    Track::Own { next: own.first(middle, *end, *round), end: *end, round: *round };
                *end = middle;
                half
            }
            Track::Moved(points) => Track::Moved(points.split_off(points.len() / 2)),
        };
        Some(Self { is_interface: self.is_interface, ..Self::new(track) })
    }

    /// Its points in `range`: their number.
    pub(super) fn count_in(&self, range: &Range<Place>, own: &Own) -> usize {
        match &self.track {
            Track::Own { next, end, round } => {
                let both = (*next).max(range.start)..(*end).min(range.end);
                both.filter(|&v| own.gives(v, *round)).count()
            }
            Track::Moved(points) => points.iter().filter(|vertex| lies_in(vertex, range)).count(),
        }
    }

    /// Takes its points of `range` out, to the end of `taken`.
    pub(super) fn take_in(
        &mut self,
        range: &Range<Place>,
        own: &mut Own,
        mesh: &LocalMesh,
        taken: &mut Vec<WireVertex>,
    ) {
        match &mut self.track {
            Track::Own { next, end, round } => {
                for v in (*next).max(range.start)..(*end).min(range.end) {
                    if round_of(v, own.rounds) == *round && !own.take_out(v) {
                        taken.push(mesh.vertex_at(v));
                    }
                }
                *next = own.first(*next, *end, *round);
            }
            Track::Moved(points) => points.retain(|vertex| {
                let goes = lies_in(vertex, range);
                if goes {
                    taken.push(*vertex);
                }
                !goes
            }),
        }
    }

    /// The next point.
    pub(super) fn next(&mut self, own: &Own, mesh: &LocalMesh) -> Option<WireVertex> {
        match &mut self.track {
            Track::Own { next, end, .. } if next == end => None,
            Track::Own { next, end, round } => {
                let v = *next;
                *next = own.first(v + 1, *end, *round);
                Some(mesh.vertex_at(v))
            }
            Track::Moved(points) => points.pop_front(),
        }
    }
}
