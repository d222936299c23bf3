//! The coarse mesh of a start, of a sample of the points; its tetrahedra, distributed to their
//! owners.

use super::name::NO_PLACE;
use super::{Blocks, LocalMesh, Place, WireVertex};
use crate::protocol::{BlockId, Handle, Name, WorkerId};
use ltbw_core::topology::{FaceId, INFINITE, Tet, TetId, VertexId, slot_of, tet_of};
use ltbw_core::{BuildError, Builder, Duplicate, PredicateStats};
use ltbw_exact::{Point, PointSet};
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;

/// The creator in the names of the coarse mesh: no worker has this number.
const COARSE: WorkerId = WorkerId::new(u32::MAX);

/// A given point, in kernel coordinates, by its place along the curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sampled {
    pub(crate) place: Place,
    pub(crate) at: Point,
}

/// Some given points, by their places along the curve.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sample {
    /// Ascending.
    places: Vec<Place>,
    points: Vec<Point>,
}

impl Sample {
    /// These points, each once.
    pub(crate) fn of(mut chosen: Vec<Sampled>) -> Self {
        chosen.sort_unstable_by_key(|own| own.place);
        chosen.dedup_by_key(|own| own.place);
        let (places, points) = chosen.into_iter().map(|own| (own.place, own.at)).unzip();
        Self { places, points }
    }

    /// Number of points.
    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }
}

/// The coarse mesh.
#[derive(Debug)]
pub(super) struct Coarse<'a> {
    /// By slot.
    tets: Cow<'a, [Tet]>,
    /// By vertex: its number in the sample. The first one is the vertex at infinity.
    numbers: Vec<u32>,
    sample: Sample,
    /// Points of the sample that equal another one: vertex numbers of both.
    pub(super) duplicates: Vec<(VertexId, VertexId)>,
    /// Predicate calls that it took.
    pub(super) predicates: PredicateStats,
}

/// A tetrahedron of the coarse mesh, where it has gone.
#[derive(Clone, Copy, Default)]
struct Gone {
    block: BlockId,
    owner: WorkerId,
    /// Its handle there.
    local: TetId,
}

impl<'a> Coarse<'a> {
    /// The mesh of a sample.
    pub(super) fn of(sample: Sample) -> Result<Self, BuildError> {
        // Kernel coordinates are finite, and no more than the input's.
        let distinct = sample.len();
        let set = PointSet::new(sample.points.clone());
        let set = set.map_err(|_| BuildError::TooFewPoints { distinct })?;
        let mesh = Builder::new().build(&set)?.mesh;
        let slots = TetId::below(mesh.topology().slots() as u32);
        let vertex = |k: u32| VertexId::new(sample.places[k as usize]);
        let pair = |&Duplicate { number, kept }: &Duplicate| (vertex(number), vertex(kept));
        Ok(Self {
            tets: slots.map(|t| *mesh.topology().at(t)).collect(),
            numbers: mesh.numbers().to_vec(),
            duplicates: mesh.duplicates().iter().map(pair).collect(),
            predicates: mesh.predicate_stats(),
            sample,
        })
    }

    /// A mesh that is there, of all points; `order` says which they are, along the curve.
    pub(super) fn given(tets: &'a [Tet], order: &[u32], points: &[Point]) -> Self {
        let mut numbers = vec![0; order.len() + 1];
        (0..).zip(order).for_each(|(number, &k)| numbers[k as usize + 1] = number);
        let sample =
            Sample { places: (1..=order.len() as Place).collect(), points: points.to_vec() };
        let (duplicates, predicates) = (Vec::new(), PredicateStats::default());
        Self { tets: Cow::Borrowed(tets), numbers, sample, duplicates, predicates }
    }

    /// Number of points, duplicates included.
    pub(super) fn points(&self) -> usize {
        self.sample.len()
    }

    /// The number of a vertex in the sample; none of the one at infinity.
    fn number(&self, v: VertexId) -> Option<usize> {
        (v != INFINITE).then(|| self.numbers[v.index()] as usize)
    }

    /// The places of the sample in a range.
    pub(super) fn places_in(&self, range: &Range<Place>) -> impl Iterator<Item = Place> + '_ {
        let places = &self.sample.places;
        let [first, end] =
            [range.start, range.end].map(|v| places.partition_point(|&place| place < v));
        places[first..end.max(first)].iter().copied()
    }

    /// The pieces of the curve around those vertices of the sample that have a tetrahedron with
    /// vertices of several workers; `end` is one past the last vertex of all.
    pub(super) fn interface(
        &self,
        end: Place,
        owner_of: impl Fn(Place) -> WorkerId,
    ) -> Vec<Range<Place>> {
        let Self { tets, sample: Sample { places, .. }, .. } = self;
        let mut at_interface = vec![false; places.len()];
        for tet in tets.iter().filter(|tet| !tet.is_free()) {
            let numbers = tet.vertices().map(|v| self.number(v));
            let mut owners = numbers.iter().flatten().map(|&k| owner_of(places[k]));
            let first = owners.next();
            if owners.any(|other| Some(other) != first) {
                numbers.iter().flatten().for_each(|&k| at_interface[k] = true);
            }
        }
        // A vertex stands for those that are nearer to it on the curve than to others.
        let middle = |k: usize| match (k.checked_sub(1), places.get(k)) {
            (None, _) => 1,
            (_, None) => end,
            (Some(before), Some(&after)) => 1 + (places[before] - 1).midpoint(after - 1),
        };
        let mut pieces: Vec<Range<Place>> = Vec::new();
        for k in (0..places.len()).filter(|&k| at_interface[k]) {
            let (start, end) = (middle(k), middle(k + 1));
            match pieces.last_mut() {
                Some(last) if last.end == start => last.end = end,
                _ => pieces.push(start..end),
            }
        }
        pieces
    }

    /// Gives every tetrahedron to the owner of its block; `workers` are all of them, or one alone
    /// if nobody else is here. Returns the slots here of those that each has got, by slot there.
    pub(super) fn distribute(
        &self,
        blocks: &Blocks,
        owners: &[WorkerId],
        workers: &mut [LocalMesh],
    ) -> Vec<Vec<TetId>> {
        let Self { tets: whole, sample: Sample { places, points }, .. } = self;
        let corner = |v: VertexId| match self.number(v) {
            Some(k) => WireVertex::new(places[k], points[k]),
            None => WireVertex::new(NO_PLACE, Point::default()),
        };
        let place = |v: VertexId| self.number(v).map_or(NO_PLACE, |k| places[k]);
        let vertices = |t: TetId| whole[t.index()].vertices();
        let slots = TetId::below(whole.len() as u32);
        let tets: Vec<TetId> = slots.filter(|t| !whole[t.index()].is_free()).collect();
        // By coarse tetrahedron.
        let mut gone = vec![Gone::default(); whole.len()];
        let block_of = |&t: &TetId| blocks.of_tet(vertices(t).map(place));
        let block_of_each: Vec<BlockId> = tets.par_iter().map(block_of).collect();
        let first = workers.first().map_or(0, |mesh| mesh.me.index());
        let mut theirs: Vec<Vec<TetId>> = vec![Vec::new(); workers.len()];
        for (&t, block) in tets.iter().zip(block_of_each) {
            let owner = owners[block.index()];
            gone[t.index()] = Gone { block, owner, local: TetId::default() };
            if let Some(own) = owner.index().checked_sub(first).and_then(|k| theirs.get_mut(k)) {
                own.push(t);
            }
        }
        let create = |(mesh, tets): (&mut LocalMesh, &Vec<TetId>)| {
            let mut made = Vec::with_capacity(tets.len());
            for &t in tets {
                let v = vertices(t).map(|v| match v {
                    INFINITE => INFINITE,
                    v => mesh.take_vertex(&corner(v)),
                });
                // Without room the run fails before anything looks at the submesh.
                let Some(local) = mesh.tets.create(v) else {
                    mesh.fail_for_room();
                    break;
                };
                debug_assert_eq!(local.index(), made.len());
                made.push(local);
            }
            made.resize(tets.len(), TetId::default());
            made
        };
        let made: Vec<Vec<TetId>> = workers.par_iter_mut().zip(&theirs).map(create).collect();
        for (&t, local) in theirs.iter().flatten().zip(made.into_iter().flatten()) {
            gone[t.index()].local = local;
        }
        let sound = workers.par_iter_mut().zip(&theirs).filter(|(mesh, _)| mesh.error.is_none());
        sound.for_each(|(mesh, tets)| {
            for &t in tets {
                link(mesh, t, &whole[t.index()], &gone);
            }
            let (first, end) = (VertexId::new(1), mesh.vertices.after_run());
            mesh.tets.set_own_range(first..end);
        });
        theirs
    }
}

/// Links the faces of a coarse tetrahedron, which `mesh` has got.
fn link(mesh: &mut LocalMesh, t: TetId, tet: &Tet, gone: &[Gone]) {
    let Gone { block, owner, local } = gone[t.index()];
    debug_assert!(mesh.fixed.is_some() || block == mesh.block_of(local));
    for (slot, face) in tet.neighbours().into_iter().enumerate() {
        let (u, there) = (tet_of(face), slot_of(face));
        let other = gone[u.index()];
        if other.owner == owner {
            // Both ways at once.
            if t < u {
                mesh.tets.link(FaceId::new(local, slot), FaceId::new(other.local, there));
            }
            continue;
        }
        let name = Name { by: COARSE, number: u.number() };
        let far = Handle { name, block: other.block, face: there as u8 };
        if mesh.tets.link_far(FaceId::new(local, slot), far).is_none() {
            mesh.fail_for_room();
        }
        mesh.set_name(local, Name { by: COARSE, number: t.number() });
    }
}
