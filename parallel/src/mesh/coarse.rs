//! The coarse mesh of a start, of a sample of the points; its tetrahedra, distributed to their
//! owners.

use super::name::NO_PLACE;
use super::{Blocks, LocalMesh, Place, WireVertex};
use crate::protocol::{BlockId, Handle, Name, WorkerId};
use ltbw_core::topology::{FaceId, INFINITE, Tet, TetId, VertexId, slot_of, tet_of};
use ltbw_core::{BuildError, Builder, Duplicate, Mesh, PredicateStats};
use ltbw_exact::{Point, PointSet};
use rayon::prelude::*;
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

/// The coarse mesh: vertices are numbered by the sample.
#[derive(Debug)]
pub(super) struct Coarse {
    mesh: Mesh,
    sample: Sample,
}

/// A tetrahedron of the coarse mesh, where it has gone.
#[derive(Clone, Copy, Default)]
struct Gone {
    block: BlockId,
    owner: WorkerId,
    /// Its handle there.
    local: TetId,
}

impl Coarse {
    /// The mesh of a sample.
    pub(super) fn of(sample: Sample) -> Result<Self, BuildError> {
        // Kernel coordinates are finite, and no more than the input's.
        let distinct = sample.len();
        let set = PointSet::new(sample.points.clone());
        let set = set.map_err(|_| BuildError::TooFewPoints { distinct })?;
        Ok(Self { mesh: Builder::new().build(&set)?.mesh, sample })
    }

    /// Predicate calls that it took.
    pub(super) fn predicates(&self) -> PredicateStats {
        self.mesh.predicate_stats()
    }

    /// Points of the sample that equal another one: vertex numbers of both.
    pub(super) fn duplicates(&self) -> impl Iterator<Item = (VertexId, VertexId)> + '_ {
        let vertex = |k: u32| VertexId::new(self.sample.places[k as usize]);
        let all = self.mesh.duplicates().iter();
        all.map(move |&Duplicate { number, kept }| (vertex(number), vertex(kept)))
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
        let Self { mesh, sample: Sample { places, .. } } = self;
        let owner = |k: u32| owner_of(places[k as usize]);
        let mut at_interface = vec![false; places.len()];
        for (_, tet) in mesh.topology().iter() {
            let numbers = tet.vertices().map(|v| mesh.number(v));
            let mut owners = numbers.iter().flatten().map(|&k| owner(k));
            let first = owners.next();
            if owners.any(|other| Some(other) != first) {
                numbers.iter().flatten().for_each(|&k| at_interface[k as usize] = true);
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
    /// if nobody else is here.
    pub(super) fn distribute(
        &self,
        blocks: &Blocks,
        owners: &[WorkerId],
        workers: &mut [LocalMesh],
    ) {
        let Self { mesh: whole, sample: Sample { places, points } } = self;
        let topology = whole.topology();
        let corner = |v: VertexId| match whole.number(v).map(|k| k as usize) {
            Some(k) => WireVertex::new(places[k], points[k]),
            None => WireVertex::new(NO_PLACE, Point::default()),
        };
        let place = |v: VertexId| whole.number(v).map_or(NO_PLACE, |k| places[k as usize]);
        let vertices = |t: TetId| topology.get(t).map(Tet::vertices);
        let tets: Vec<TetId> = topology.iter().map(|(t, _)| t).collect();
        // By coarse tetrahedron.
        let mut gone = vec![Gone::default(); topology.slots()];
        let block_of =
            |&t: &TetId| vertices(t).map_or(BlockId::default(), |v| blocks.of_tet(v.map(place)));
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
            for v in tets.iter().filter_map(|&t| vertices(t)) {
                let v = v.map(|v| match v {
                    INFINITE => INFINITE,
                    v => mesh.take_vertex(&corner(v)),
                });
                // Without room the run fails before anything looks at the submesh.
                let Some(local) = mesh.tets.create(v) else {
                    mesh.fail_for_room();
                    break;
                };
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
                link(mesh, whole, t, &gone);
            }
            let (first, end) = (VertexId::new(1), mesh.vertices.after_run());
            mesh.tets.set_own_range(first..end);
        });
    }
}

/// Links the faces of coarse tetrahedron `t`, which `mesh` has got.
fn link(mesh: &mut LocalMesh, coarse: &Mesh, t: TetId, gone: &[Gone]) {
    let Gone { block, owner, local } = gone[t.index()];
    debug_assert!(mesh.fixed.is_some() || block == mesh.block_of(local));
    let faces = coarse.topology().get(t).map(Tet::neighbours).unwrap_or_default();
    for (slot, face) in faces.into_iter().enumerate() {
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
