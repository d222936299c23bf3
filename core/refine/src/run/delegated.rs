//! Rounds that others carry out, on many processors: they get the mesh at the start, and hand over
//! what they have when they are done, or at a step that takes the whole mesh; or they keep it.

mod parts;

use super::{Refiner, Run, START, START_WITH_PATCHES};
use crate::complex::carrier::Carrier;
use crate::fill::Points;
use crate::mesh::item::Item;
use crate::mesh::limit::Limit;
use crate::mesh::region::RegionInfo;
use crate::mesh::state::State;
use crate::outcome::RefineStats;
use crate::queue::split::Refinement;
use crate::rounds::{InsertOrder, Resumed, Waiting};
use crate::rules::block::Block;
use crate::rules::choice::{BoundaryItem, ItemPlace, TetPlace};
use crate::rules::complex::{Complex, ComplexError, Start};
use crate::rules::record::{Record, Refusal};
use crate::table::Set;
use crate::{RefineError, Refined};
use ltbw_core::mesh::{Mesh, Vertex};
use ltbw_core::topology::{TetId, VertexId};
use ltbw_domain::{Domain, Lattice};
use std::time::Instant;

/// The part of a mesh that is made before others without rounds begin.
const SHARE: usize = 4;
/// Slivers that others are not given back the mesh for, if there are fewer.
const FEW: usize = 16;
/// Tetrahedra of a mesh for each vertex, about.
const TETS_PER_VERTEX: usize = 5;

/// A refinement whose rounds others carry out.
#[doc(hidden)]
pub struct Delegated<'a> {
    run: Run<'a>,
    regions: Vec<RegionInfo>,
    lattice: Lattice,
    clock: Instant,
    start_seconds: f64,
    /// Refused tetrahedra for which no point was found that relieves them, by their places.
    in_vain: Set<TetPlace>,
}

impl std::fmt::Debug for Delegated<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Delegated").field("regions", &self.regions.len()).finish_non_exhaustive()
    }
}

/// A boundary item that was still to be split.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Asked {
    /// The item.
    pub item: BoundaryItem,
    /// The one before which it is not to be tried.
    pub first: Option<ItemPlace>,
    /// The edges that splitting it may make.
    pub limit: Option<Limit>,
}

/// The state in which others hand over.
#[doc(hidden)]
#[derive(Debug)]
pub struct Handed {
    /// The mesh.
    pub mesh: Mesh,
    /// Where its vertices live, by kernel vertex from 1.
    pub carriers: Vec<Carrier>,
    /// The regions of its finite tetrahedra, by slot.
    pub regions: Vec<u32>,
    /// Boundary items to be split.
    pub asked: Vec<Asked>,
    /// Boundary items that were refused.
    pub refused: Vec<(ItemPlace, Refusal)>,
    /// Tetrahedra that were refused.
    pub refused_tets: Vec<(TetId, Refusal)>,
    /// Candidates among the tetrahedra in the last round that split some.
    pub candidates: usize,
    /// The transactions of joint steps in rounds so far.
    pub spent: usize,
    /// If none is over its bounds, the tetrahedra that may have tiny dihedral angles.
    pub thin: Option<Vec<TetId>>,
    /// If rounds of slivers have begun, those that are still to be looked at.
    pub slivers: Option<Vec<TetId>>,
    /// Subfaces that bar many.
    pub blocks: Vec<Block>,
    /// The figures of the rounds.
    pub stats: RefineStats,
}

/// The work with which rounds go on.
#[doc(hidden)]
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Remaining {
    /// Boundary items to be split.
    pub asked: Vec<Asked>,
    /// Boundary items that were refused.
    pub refused: Vec<(ItemPlace, Refusal)>,
    /// Tetrahedra that were refused, by their places.
    pub refused_tets: Vec<(TetPlace, Refusal)>,
    /// The candidates among the tetrahedra when last counted.
    pub candidates: usize,
    /// The transactions of joint steps in rounds so far.
    pub spent: usize,
    /// If slivers are what is left, all to be looked at, by their places.
    pub slivers: Option<Vec<TetPlace>>,
    /// Subfaces that bar many.
    pub blocks: Vec<Block>,
}

impl<'a> Refiner<'a> {
    /// Refines up to where rounds begin, for others to carry these out.
    ///
    /// # Errors
    /// Those of [`Refiner::refine`].
    #[doc(hidden)]
    pub fn delegate(
        &self,
        domain: &Domain,
        lattice: &Lattice,
    ) -> Result<Delegated<'a>, RefineError> {
        self.delegate_to(domain, lattice, 0)
    }

    /// Refines up to where others can begin that want this many vertices, or to a quarter of what
    /// there will be as far as that can be told, but at least to where rounds begin: a mesh of
    /// fewer vertices is the one that rounds have, and one of little more is near it.
    ///
    /// # Errors
    /// Those of [`Refiner::refine`].
    #[doc(hidden)]
    pub fn delegate_to(
        &self,
        domain: &Domain,
        lattice: &Lattice,
        wanted: usize,
    ) -> Result<Delegated<'a>, RefineError> {
        let (mut run, regions) = self.recovered(domain, lattice)?;
        let clock = Instant::now();
        let heed = run.heed();
        run.refinement.seed(run.most, heed, &mut run.work);
        // A tetrahedron that is over its bounds then is put off, not refused.
        if heed.is_cancelled() {
            run.look()?;
        }
        let patched = run.refinement.state.plc.has_patches();
        let usual = if patched { START_WITH_PATCHES } else { START };
        let vertices = run.refinement.state.expected / TETS_PER_VERTEX;
        let start = usual.max(wanted.min(vertices / SHARE));
        run.refine(self.start.unwrap_or(start))?;
        let start_seconds = clock.elapsed().as_secs_f64();
        let (lattice, in_vain) = (*lattice, Set::default());
        Ok(Delegated { run, regions, lattice, clock, start_seconds, in_vain })
    }
}

impl<'a> Delegated<'a> {
    /// The boundary and the bounds as values, and the mesh at the start.
    ///
    /// # Errors
    /// [`ComplexError`] if some of the boundary is missing, or there is nothing to do in rounds.
    pub fn complex(&self) -> Result<(Complex<'a>, Start), ComplexError> {
        self.check_fit()?;
        let complex = self.run.complex()?;
        let start = Start::of(&self.run.refinement.state, self.regions.clone(), self.run.most);
        Ok((complex, start))
    }

    fn check_fit(&self) -> Result<(), ComplexError> {
        match self.run.stop {
            Some(_) => Err(ComplexError::Unsupported("a run that has stopped before the rounds")),
            None => self.run.fit().map(|_| ()),
        }
    }

    /// Carries out the rounds after all.
    ///
    /// # Errors
    /// Those of [`Refiner::refine`].
    pub fn go_on(self) -> Result<Refined, RefineError> {
        self.finish_from(None)
    }

    /// Takes over, and does what is left to do.
    ///
    /// # Errors
    /// Those of [`Refiner::refine`]; items that are not in the mesh.
    pub fn finish(mut self, handed: Handed) -> Result<Refined, RefineError> {
        let resumed = self.take(handed)?;
        self.finish_from(Some(resumed))
    }

    /// Takes over where late steps come before slivers, and carries out these. Others go on then
    /// with slivers; `None` if there are few: then all is done, and [`Delegated::ended`] tells.
    ///
    /// # Errors
    /// Those of [`Delegated::finish`].
    pub fn go_to_slivers(&mut self, handed: Handed) -> Result<Option<Remaining>, RefineError> {
        let resumed = self.take(handed)?;
        let (order, start) = (self.run.refiner.order, self.start_seconds);
        let Some((slivers, blocks)) =
            self.run.rounds_from(order, start, Some(resumed), Some(FEW))?
        else {
            return Ok(None);
        };
        let Refinement { record, state, .. } = &self.run.refinement;
        let spent = record.joint_transactions;
        let place = |v: [VertexId; 4]| TetPlace::of(v.map(|v| state.at(v)));
        let in_vain = record.in_vain.iter().filter_map(|&item| match item {
            Item::Tet(t, v) if state.is_live(t, v) => Some(place(v)),
            _ => None,
        });
        self.in_vain = in_vain.collect();
        let slivers = slivers.into_iter().map(|(_, v)| place(v)).collect();
        let (refused, refused_tets) = state.refusals(record);
        Ok(Some(Remaining {
            asked: Vec::new(),
            refused,
            refused_tets,
            candidates: 0,
            spent,
            slivers: Some(slivers),
            blocks,
        }))
    }

    /// The refinement at its end.
    ///
    /// # Errors
    /// Those of [`Refiner::refine`].
    pub fn ended(self) -> Result<Refined, RefineError> {
        self.end()
    }

    /// The figures of all rounds so far.
    pub fn stats(&self) -> RefineStats {
        self.run.stats
    }

    /// Goes on from where others were between two rounds, with these figures.
    pub fn go_on_from(&mut self, stats: RefineStats) {
        self.run.stats = stats;
    }

    /// Takes the state that others hand over.
    fn take(&mut self, handed: Handed) -> Result<Resumed, RefineError> {
        let Handed { mesh, carriers, regions, asked, refused, candidates, thin, stats, .. } =
            handed;
        let (refused_tets, slivers, blocks) = (handed.refused_tets, handed.slivers, handed.blocks);
        let spent = handed.spent;
        let unfit = |_| RefineError::Invariant { what: "rounds of others are of a plain domain" };
        let complex = self.run.complex().map_err(unfit)?;
        let own = &mut self.run.refinement;
        own.state.mesh = mesh;
        own.state.carriers = std::iter::once(Carrier::Free).chain(carriers).collect();
        own.inserted.points = own.state.number_all();
        own.inserted.next_number = own.state.carriers.len() as Vertex - 1;
        let is_asked = !asked.is_empty() || !refused.is_empty();
        let found = own.state.enter_boundary(&complex, &regions, is_asked);
        let mut all = own.state.mesh.topology().iter().map(|(t, _)| t);
        if complex.has_patches() && !own.state.is_labelled(&mut all) {
            return Err(RefineError::Invariant { what: "regions change at the boundary alone" });
        }
        let waiting = |asked: &Asked| {
            let &(item, near) = found.get(&asked.item.place())?;
            let first = asked.first.and_then(|first| Some(found.get(&first)?.0));
            Some(Waiting { item, first, near, limit: asked.limit })
        };
        let here = |block: Block| {
            let &(item, near) = found.get(&block.place())?;
            let here = own.state.block_at(&block, item, near)?;
            Some((block, here))
        };
        let blocks = blocks.into_iter().filter_map(here).collect();
        let waiting: Option<Vec<Waiting>> = asked.iter().map(waiting).collect();
        let items: Option<Vec<_>> =
            refused.iter().map(|(place, why)| Some((found.get(place)?.0, *why))).collect();
        let place = |&t: &TetId| TetPlace::of(own.state.vertices(t).map(|v| own.state.at(v)));
        let in_vain = refused_tets.iter().map(|own| own.0);
        let in_vain =
            in_vain.filter(|t| !self.in_vain.is_empty() && self.in_vain.contains(&place(t)));
        let in_vain = in_vain.map(|t| Item::Tet(t, own.state.vertices(t))).collect();
        let tets = refused_tets.iter().map(|&(t, why)| (Item::Tet(t, own.state.vertices(t)), why));
        let refused = items.map(|items| items.into_iter().chain(tets).collect());
        let gone = || RefineError::Invariant { what: "items asked for are in the mesh" };
        self.run.stats = stats;
        // Tetrahedra that no point helps have to be refused with their reasons.
        let thin = thin.filter(|_| !complex.has_angles());
        let (waiting, refused) = (waiting.ok_or_else(gone)?, refused.ok_or_else(gone)?);
        Ok(Resumed { waiting, refused, candidates, thin, slivers, in_vain, spent, blocks })
    }

    fn finish_from(mut self, resumed: Option<Resumed>) -> Result<Refined, RefineError> {
        let order: InsertOrder = self.run.refiner.order;
        self.run.rounds_from(order, self.start_seconds, resumed, None)?;
        self.end()
    }

    fn end(mut self) -> Result<Refined, RefineError> {
        self.run.stats.refine_seconds = self.clock.elapsed().as_secs_f64();
        self.run.finish(self.regions, self.lattice)
    }
}

impl State {
    /// The boundary items and the tetrahedra that were refused, by their places.
    #[expect(clippy::type_complexity, reason = "two lists of one kind")]
    fn refusals(&self, record: &Record) -> (Vec<(ItemPlace, Refusal)>, Vec<(TetPlace, Refusal)>) {
        let (mut items, mut tets) = (Vec::new(), Vec::new());
        for (&item, &why) in &record.refused {
            match item {
                Item::Segment(s) => items.push((ItemPlace::of(&s.map(|v| self.at(v))), why)),
                Item::Subface(s) => items.push((ItemPlace::of(&s.map(|v| self.at(v))), why)),
                Item::Tet(t, v) if self.is_live(t, v) => {
                    tets.push((TetPlace::of(v.map(|v| self.at(v))), why));
                }
                Item::Tet(..) => {}
            }
        }
        items.sort_unstable_by_key(|own| own.0);
        tets.sort_unstable_by_key(|own| own.0);
        (items, tets)
    }

    /// Numbers all vertices: those that the domain says as there. Counts the others.
    fn number_all(&mut self) -> Points {
        let mut points = Points::default();
        let given = self.plc.given_numbers();
        let mut next = given.count;
        let at = |v: usize| self.at(VertexId::at(v));
        // The first is the vertex at infinity.
        let all = self.carriers.iter().enumerate().skip(1);
        let own: Vec<Option<Vertex>> = all.map(|(v, own)| given.of(*own, &at(v))).collect();
        let carriers = std::mem::take(&mut self.carriers);
        let numbers = self.mesh.numbers_mut();
        for ((v, carrier), own) in carriers.iter().enumerate().skip(1).zip(own) {
            numbers[v] = own.unwrap_or_else(|| {
                next += 1;
                points.count(*carrier);
                next - 1
            });
        }
        self.carriers = carriers;
        self.mesh.set_next_number(next);
        points
    }
}
