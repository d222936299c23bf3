//! Checkpoints of a team's rounds: each member's part between two rounds, as bytes, and the state
//! that parts of any number make.
//!
//! A mesh is the Delaunay mesh of its vertices, so a part is written as its vertices with where
//! they live. Of their own Delaunay mesh, whose tetrahedra have one order, a bit tells of each
//! whether it is the part's: all that are, are there, since their spheres are empty of all
//! vertices. Nothing is put together until a team goes on from it.

use super::figures::RoundFigures;
use super::source::Rounds;
use super::{Resumed, RoundNode};
use crate::protocol::{Correct, WorkerId};
use crate::refining::RefineError;
use crate::refining::domain::DomainMesh;
use crate::refining::parcel::of_team;
use crate::wire::{WireError, bytes_of, value_of};
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_core::{Builder, Mesh, Vertex};
use ltbw_exact::{Point, PointSet};
use ltbw_refine::{
    Asked, Block, Carrier, ItemPlace, RefineStats, Refusal, Remaining, Start, TetPlace,
};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// The vertices of a tetrahedron, ascending.
type Row = [u32; 4];

/// The things that all members know, and the figures of all.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct Head {
    figures: RoundFigures,
    stats: RefineStats,
    refused: Vec<(ItemPlace, Refusal)>,
    candidates: usize,
    spent: usize,
    blocks: Vec<Block>,
}

/// Tetrahedra one after the other that are in one region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
struct Run {
    region: u32,
    count: u32,
}

/// One member's part, and the work that it has.
#[derive(Default, serde::Serialize, serde::Deserialize)]
struct Slice {
    points: Vec<Point>,
    carriers: Vec<Carrier>,
    /// A bit for each tetrahedron of the Delaunay mesh of `points`, in order: is it the part's?
    own: Vec<u8>,
    /// The regions of those that are.
    regions: Vec<Run>,
    asked: Vec<Asked>,
    refused: Vec<(TetPlace, Refusal)>,
}

/// The state that a checkpoint is of.
pub(super) struct Kept {
    pub(super) start: Start,
    pub(super) resumed: Resumed,
    pub(super) stats: RefineStats,
}

/// The Delaunay tetrahedra of some points, in order.
fn rows_of(mesh: &Mesh) -> Vec<Row> {
    let ascending = |mut v: Row| {
        v.sort_unstable();
        v
    };
    let mut rows: Vec<Row> = mesh.tets().map(ascending).collect();
    rows.par_sort_unstable();
    rows
}

/// The Delaunay mesh of some points, none of which is there twice.
fn delaunay(points: Vec<Point>) -> Option<Mesh> {
    let set = PointSet::new(points).ok()?;
    Builder::new().build(&set).ok().map(|built| built.mesh)
}

/// An own part that is of no Delaunay mesh.
fn unfit() -> RefineError {
    ltbw_refine::RefineError::Invariant { what: "a part is of a Delaunay mesh" }.into()
}

fn damaged(reason: &str) -> RefineError {
    let (from, reason) = (WorkerId::default(), format!("a checkpoint {reason}"));
    of_team(WireError { from, at: 0, length: 0, reason })
}

impl Head {
    /// That of the first member; `told` are the figures of all, which began with `begin`, and
    /// `before` the refinement's then.
    pub(super) fn of(
        node: &RoundNode<'_, Correct>,
        told: &[RoundFigures],
        begin: RoundFigures,
        before: RefineStats,
    ) -> Self {
        let figures = RoundFigures::summed(told, begin);
        let stats = figures.after(&begin, before);
        node.source().head(figures, stats)
    }

    pub(super) fn into_bytes(self) -> Result<Vec<u8>, RefineError> {
        bytes_of(&self, WorkerId::default()).map_err(of_team)
    }
}

/// A member's part between two rounds.
///
/// # Errors
/// [`RefineError`] if it is not of the Delaunay mesh of its vertices.
pub(super) fn slice_of(node: &RoundNode<'_, Correct>) -> Result<Vec<u8>, RefineError> {
    let (mesh, source) = (node.mesh(), node.source());
    let slice = Slice { asked: source.asked(), refused: source.refused(mesh), ..Slice::of(mesh)? };
    bytes_of(&slice, source.me).map_err(of_team)
}

impl Slice {
    /// The tetrahedra of a part.
    fn of(mesh: &DomainMesh<'_>) -> Result<Self, RefineError> {
        let tets = mesh.inner.tets();
        let finite = || tets.tets().filter(|(_, v)| v[3] != INFINITE);
        let mut place = vec![u32::MAX; mesh.inner.num_vertices() + 1];
        let (mut points, mut carriers) = (Vec::new(), Vec::new());
        for v in finite().flat_map(|(_, v)| v) {
            let own = &mut place[v.index()];
            if *own == u32::MAX {
                *own = points.len() as u32;
                points.push(mesh.point(v));
                carriers.push(mesh.carrier(v));
            }
        }
        if points.is_empty() {
            return Ok(Self::default());
        }
        let row = |(t, v): (TetId, [VertexId; 4])| {
            let mut row = v.map(|v| place[v.index()]);
            row.sort_unstable();
            (row, mesh.region(t))
        };
        let mut all: Vec<(Row, u32)> = finite().map(row).collect();
        all.par_sort_unstable();
        let rows = rows_of(&delaunay(points.clone()).ok_or_else(unfit)?);
        let mut own = vec![0; rows.len().div_ceil(8)];
        let mut regions: Vec<Run> = Vec::new();
        let mut left = all.iter().peekable();
        for (k, row) in rows.iter().enumerate() {
            let Some(&(_, region)) = left.next_if(|own| own.0 == *row) else { continue };
            own[k / 8] |= 1 << (k % 8);
            match regions.last_mut().filter(|run| run.region == region) {
                Some(run) => run.count += 1,
                None => regions.push(Run { region, count: 1 }),
            }
        }
        match left.next() {
            None => Ok(Self { points, carriers, own, regions, ..Self::default() }),
            Some(_) => Err(unfit()),
        }
    }

    /// Its tetrahedra with their regions, by the numbers that `number` gives to its points.
    fn tets(&self, number: &[u32]) -> Result<Vec<(Row, u32)>, RefineError> {
        if self.points.is_empty() {
            return Ok(Vec::new());
        }
        let others = || damaged("with other tetrahedra than its vertices have");
        let rows = rows_of(&delaunay(self.points.clone()).ok_or_else(others)?);
        if self.own.len() != rows.len().div_ceil(8) {
            return Err(others());
        }
        let is_own = |k: &usize| self.own[k / 8] >> (k % 8) & 1 == 1;
        let own = (0..rows.len()).filter(is_own).map(|k| rows[k]);
        let regions = self.regions.iter().flat_map(|run| (0..run.count).map(|_| run.region));
        let numbered = own.zip(regions).map(|(row, region)| {
            let mut row = row.map(|v| number[v as usize]);
            row.sort_unstable();
            (row, region)
        });
        Ok(numbered.collect())
    }
}

/// The vertices of some parts, each once.
#[derive(Default)]
struct Vertices {
    points: Vec<Point>,
    carriers: Vec<Carrier>,
    by_place: FxHashMap<[u64; 3], u32>,
}

impl Vertices {
    /// The number of a vertex.
    fn number(&mut self, point: Point, carrier: Carrier) -> Result<u32, RefineError> {
        let next = self.points.len() as u32;
        let number = *self.by_place.entry(point.map(f64::to_bits)).or_insert(next);
        if number == next {
            self.points.push(point);
            self.carriers.push(carrier);
        }
        match self.carriers[number as usize] == carrier {
            true => Ok(number),
            false => Err(damaged("with a vertex at two places of the boundary")),
        }
    }
}

/// The state that the pieces of a checkpoint make: `base` is the start of a refinement with the
/// same boundary and bounds.
///
/// # Errors
/// [`RefineError`] if they make no sense, or not together.
pub(super) fn read(pieces: &[Vec<u8>], base: Start) -> Result<Kept, RefineError> {
    let nobody = WorkerId::default();
    let Some((head, slices)) = pieces.split_first() else { return Err(damaged("without a head")) };
    let head: Head = value_of(nobody, head).map_err(of_team)?;
    let Head { figures, stats, refused, candidates, spent, blocks } = head;
    let (mut vertices, mut tets) = (Vertices::default(), Vec::new());
    let (mut asked, mut refused_tets) = (Vec::new(), Vec::new());
    for slice in slices {
        let slice: Slice = value_of(nobody, slice).map_err(of_team)?;
        let Slice { points, carriers, .. } = &slice;
        if points.len() != carriers.len() {
            return Err(damaged("with vertices that live nowhere"));
        }
        let own = points.iter().zip(carriers);
        let numbers: Vec<u32> =
            own.map(|(&p, &carrier)| vertices.number(p, carrier)).collect::<Result<_, _>>()?;
        tets.extend(slice.tets(&numbers)?);
        asked.extend(slice.asked);
        refused_tets.extend(slice.refused);
    }
    let Vertices { points, carriers, .. } = vertices;
    let apart = || damaged("whose parts are not one mesh");
    let mesh = delaunay(points).ok_or_else(apart)?;
    tets.par_sort_unstable();
    let all: Vec<Row> = rows_of(&mesh);
    if !all.iter().eq(tets.iter().map(|own| &own.0)) {
        return Err(apart());
    }
    let region = |t: TetId| {
        let mut row = mesh.tet(t)?;
        row.sort_unstable();
        tets.binary_search_by_key(&row, |own| own.0).ok().map(|k| tets[k].1)
    };
    let carrier = |v: Vertex| carriers[v as usize];
    let start = base.with_mesh(&mesh, carrier, |t| region(t).unwrap_or_default());
    let slivers = None;
    let left = Remaining { asked, refused, refused_tets, candidates, spent, slivers, blocks };
    Ok(Kept { start, resumed: Resumed { left, figures, border: None }, stats })
}

impl Rounds<Correct> {
    /// The things that all workers know, with figures of all.
    fn head(&self, figures: RoundFigures, stats: RefineStats) -> Head {
        Head {
            figures,
            stats,
            refused: self.demands.refused.all.iter().map(|(&item, &why)| (item, why)).collect(),
            candidates: self.candidates(),
            spent: self.spent,
            blocks: self.blocks_left(),
        }
    }

    /// Its tetrahedra that were refused, by their places.
    fn refused(&self, mesh: &DomainMesh<'_>) -> Vec<(TetPlace, Refusal)> {
        let place = |t: TetId| TetPlace::of(mesh.inner.tets().vertices(t).map(|v| mesh.point(v)));
        self.keys.refused(mesh).into_iter().map(|(t, why)| (place(t), why)).collect()
    }
}
