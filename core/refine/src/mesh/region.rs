//! Inside, outside and regions: exact floods over marked faces.
//!
//! With all subfaces present, the components of the mesh between marked faces are the cells of the
//! domain: what is connected to the outside or to the point of a hole is exterior (region 0), what
//! is connected to the seed of a region is that region, and what is left gets numbers of its own.

use super::journal::Journal;
use super::marks::{DUST, MAX_REGION, face_bit, region_of};
use super::state::State;
use super::tiles::Found;
use crate::RefineError;
use crate::table::{Map, Set};
use ltbw_core::query::Location;
use ltbw_core::topology::{INFINITE, TetId, VertexId, tet_of};
use ltbw_domain::Element;
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, orient3d};

/// No region yet.
const UNKNOWN: u32 = MAX_REGION;

/// A region as the domain describes it.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RegionInfo {
    /// The region of the domain whose seed lies in it; `None` for one without a seed.
    pub seed: Option<u32>,
    /// Its attribute.
    pub attribute: f64,
    /// Its own bound on volumes.
    pub max_volume: Option<f64>,
}

impl State {
    /// Labels all tetrahedra; returns the regions, the exterior first, or `None` if the labels do
    /// not say what the sides of a patch are. `layers`: those of all patches.
    ///
    /// # Errors
    /// A seed that lies on the boundary; no region inside.
    pub(crate) fn flood(
        &mut self,
        holes: &[Point],
        seeds: &[ltbw_domain::Region],
        layers: Option<&Found>,
    ) -> Result<Option<Vec<RegionInfo>>, RefineError> {
        let slots = TetId::below(self.mesh.topology().slots() as u32);
        let mut places = Vec::new();
        {
            let queries = self.mesh.queries();
            let mut cursor = queries.cursor();
            let holes = (0..).zip(holes).map(|(k, &p)| (Element::Hole(k), p, None));
            let seeds = (0..).zip(seeds).map(|(k, r)| (Element::Region(k), r.seed, Some(k)));
            for (element, p, region) in holes.chain(seeds) {
                let place = match cursor.locate(p) {
                    Ok(Location::Tet(t)) => Some(t),
                    Ok(Location::Edge { tet, .. } | Location::Facet { tet, .. }) => Some(tet),
                    Ok(Location::OutsideHull { .. }) => None,
                    _ => return Err(RefineError::Seed { element, at: p }),
                };
                places.push((place, region));
            }
        }
        slots.clone().for_each(|t| self.marks.set_region(t, UNKNOWN));
        if layers.is_some_and(|layers| !self.bar(layers)) {
            return Ok(None);
        }
        let mut stack: Vec<TetId> = self
            .mesh
            .topology()
            .iter()
            .filter_map(|(t, tet)| tet.is_ghost().then_some(t))
            .collect();
        stack.iter().for_each(|&t| self.marks.set_region(t, 0));
        self.spread(&mut stack, 0);
        let mut regions = vec![RegionInfo::default()];
        for (place, region) in places {
            let Some(t) = place.filter(|&t| self.marks.region(t) == UNKNOWN) else { continue };
            let label = if region.is_none() { 0 } else { regions.len() as u32 };
            if let Some(k) = region {
                let own = &seeds[k as usize];
                let (attribute, max_volume) = (own.attribute, own.max_volume);
                regions.push(RegionInfo { seed: region, attribute, max_volume });
            }
            self.start(t, label, &mut stack);
        }
        for t in slots {
            let used = !self.mesh.topology().at(t).is_free();
            if used && self.marks.region(t) == UNKNOWN {
                let label = (regions.len() as u32).min(DUST - 1);
                regions.push(RegionInfo::default());
                self.start(t, label, &mut stack);
            }
        }
        if regions.len() == 1 {
            return Err(RefineError::NoInterior);
        }
        let chosen = layers.is_none_or(|layers| self.choose_layers(layers));
        Ok(chosen.then_some(regions))
    }

    fn start(&mut self, t: TetId, label: u32, stack: &mut Vec<TetId>) {
        self.marks.set_region(t, label);
        stack.push(t);
        self.spread(stack, label);
    }

    /// Spreads a label over faces that are not marked; every tetrahedron is labelled once.
    fn spread(&mut self, stack: &mut Vec<TetId>, label: u32) {
        while let Some(t) = stack.pop() {
            let word = self.marks.of(t);
            let neighbours = self.mesh.topology().at(t).neighbours();
            for (slot, face) in neighbours.into_iter().enumerate() {
                let other = tet_of(face);
                if word & face_bit(slot) == 0 && self.marks.region(other) == UNKNOWN {
                    self.marks.set_region(other, label);
                    stack.push(other);
                }
            }
        }
    }

    /// Finds the regions of tetrahedra again that a joint step made while a subface was missing,
    /// from their neighbours that it did not make, or from where they were before. `false` if that
    /// does not tell.
    pub(crate) fn relabel(&mut self, journal: &Journal) -> bool {
        let live: Vec<TetId> =
            journal.created.iter().filter(|&&(t, v)| self.is_live(t, v)).map(|d| d.0).collect();
        let set: Set<TetId> = live.iter().copied().collect();
        let mut known: Map<TetId, u32> = Map::default();
        let mut stack = Vec::new();
        for &t in &live {
            if let Some(region) = self.neighbouring_region(t, &set)
                && known.insert(t, region).is_none()
            {
                stack.push(t);
            }
        }
        self.spread_known(&mut stack, &mut known, &set);
        // A part bounded by subfaces alone: the middle of one of its tetrahedra tells.
        for &t in &live {
            if !known.contains_key(&t)
                && let Some(region) = self.former_region(t, journal)
            {
                known.insert(t, region);
                stack.push(t);
                self.spread_known(&mut stack, &mut known, &set);
            }
        }
        for &t in &live {
            if let Some(&region) = known.get(&t) {
                self.marks.set_region(t, region);
            }
        }
        known.len() == set.len()
    }

    /// Spreads regions over the faces in `set` that are not marked.
    fn spread_known(&self, stack: &mut Vec<TetId>, known: &mut Map<TetId, u32>, set: &Set<TetId>) {
        while let Some(t) = stack.pop() {
            let (word, region) = (self.marks.of(t), known[&t]);
            let neighbours = self.mesh.topology().at(t).neighbours();
            for (slot, face) in neighbours.into_iter().enumerate() {
                let other = tet_of(face);
                let reaches = word & face_bit(slot) == 0 && set.contains(&other);
                if reaches && !known.contains_key(&other) {
                    known.insert(other, region);
                    stack.push(other);
                }
            }
        }
    }

    /// The region in which the middle of a tetrahedron was before a joint step; `None` if that is
    /// not certain.
    fn former_region(&self, t: TetId, journal: &Journal) -> Option<u32> {
        let v = self.vertices(t);
        let corners = |v: [VertexId; 4]| v.map(|v| self.at(v));
        let own = corners(v);
        let middle = [0, 1, 2].map(|k| own.iter().map(|c| c[k] * 0.25).sum::<f64>().round());
        let inside = |corners: &[Point; 4], least: Sign| {
            (0..4).all(|k| {
                let mut with = corners.each_ref();
                with[k] = &middle;
                let [a, b, c, d] = with;
                let side = orient3d(a, b, c, d);
                side == Sign::Positive || side == least
            })
        };
        if v[3] == INFINITE || !inside(&own, Sign::Positive) {
            return None;
        }
        // Tetrahedra made by the step itself have the point of an insertion of it.
        let first = self.carriers.len() - journal.insertions.len();
        let mut regions = journal.insertions.iter().flat_map(|(undo, words)| {
            undo.cavity_vertices().zip(words).filter_map(|(v, &word)| {
                let old = v[3] != INFINITE && v.iter().all(|&v| v.index() < first);
                (old && inside(&corners(v), Sign::Zero)).then(|| region_of(word))
            })
        });
        let region = regions.next()?;
        regions.all(|other| other == region).then_some(region)
    }

    /// The region of a neighbour outside `set`, across a face that is not marked.
    fn neighbouring_region(&self, t: TetId, set: &Set<TetId>) -> Option<u32> {
        let word = self.marks.of(t);
        let neighbours = self.mesh.topology().at(t).neighbours();
        let mut outside = neighbours.into_iter().enumerate().filter_map(|(slot, face)| {
            let other = tet_of(face);
            let clean = word & face_bit(slot) == 0 && !set.contains(&other);
            clean.then(|| self.marks.region(other))
        });
        outside.next()
    }
}
