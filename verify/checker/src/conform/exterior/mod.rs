//! The facets, segments and vertices of a domain that a mesh of its inside need not have: there is
//! nothing but exterior around them. Found from the domain alone, exactly.
//!
//! 1. Each facet is taken apart into pieces, as its polygons divide its plane (`pieces.rs`).
//! 2. Every piece has two sides. Around an edge, sides that see each other are in one cell; a piece
//!    that is alone at an edge has both of its sides in one (`cells.rs`).
//! 3. Shells (pieces that edges connect) are put into each other by segments from far outside,
//!    along which cells follow each other (`cast.rs`); so are points of holes, and vertices.
//! 4. The cell of the outside and those of holes are the exterior.
//!
//! That is right for a domain whose facets meet in common vertices and edges only. Where an open
//! edge has a vertex inside it, or a shell cannot be placed, nothing is taken for exterior.

mod cast;
mod cells;
mod hom;
mod pieces;

use super::whole::{Units, Whole};
use super::{Plc, edge};
use cells::Cells;
use hom::Hom;
use pieces::Piece;
use std::collections::HashMap;

/// The items that a mesh need not have: whether each facet, segment and vertex is such.
#[derive(Debug, Default)]
pub(super) struct Exterior {
    facets: Vec<bool>,
    segments: Vec<bool>,
    vertices: Vec<bool>,
}

impl Exterior {
    /// Is a facet, or a vertex, such?
    pub(super) fn has_facet(&self, f: usize) -> bool {
        self.facets.get(f).copied().unwrap_or(false)
    }

    pub(super) fn has_vertex(&self, v: usize) -> bool {
        self.vertices.get(v).copied().unwrap_or(false)
    }

    /// The domain without such facets and segments; the others keep their numbers.
    pub(super) fn left(&self, plc: &Plc) -> Plc {
        let mut left = plc.clone();
        for (f, facet) in left.facets.iter_mut().enumerate() {
            if self.has_facet(f) {
                facet.polygons.clear();
                facet.holes.clear();
            }
        }
        let mut segments = self.segments.iter();
        left.segments.retain(|_| !segments.next().copied().unwrap_or(false));
        left
    }

    /// Finds them in a domain whose indices are sound; `None` if there are none. `present` says of
    /// each vertex whether the mesh has it.
    pub(super) fn find(plc: &Plc, units: &Units, present: &[bool]) -> Option<Self> {
        let corners: Vec<Whole> = plc.vertices.iter().map(|p| units.whole(p)).collect();
        let missing = unnamed(plc, present);
        let pieces = Piece::all(plc, &corners, units)?;
        let mut cells = Cells::new(&pieces, &corners);
        let bare = plc.holes.is_empty() && plc.segments.is_empty() && missing.is_empty();
        if bare && cells.is_closed() {
            // Every facet parts two cells then, and what is bounded is inside.
            return None;
        }
        if cells.has_vertex_on_open_edge(&corners) || !cells.join(&pieces, &corners) {
            return None;
        }
        let holes: Vec<Hom> = plc.holes.iter().map(|p| Hom::of(p, units)).collect();
        cells.empty(&pieces, &corners, &holes);
        let outer: Vec<bool> = (0..pieces.len()).map(|k| cells.is_outer(k)).collect();
        let search = Search { plc, units, corners: &corners, pieces: &pieces, outer: &outer };
        let found = search.items(&cells, &missing);
        let is_body = found.facets.contains(&false);
        let any = |list: &[bool]| list.contains(&true);
        let is_any = any(&found.facets) || any(&found.segments) || any(&found.vertices);
        (is_body && is_any).then_some(found)
    }
}

/// The vertices that nothing names and that are not in the mesh.
fn unnamed(plc: &Plc, present: &[bool]) -> Vec<u32> {
    let mut is_named = vec![false; plc.vertices.len()];
    let all = plc.facets.iter().flat_map(|f| &f.polygons).flatten();
    all.chain(plc.segments.iter().flatten()).for_each(|&v| is_named[v as usize] = true);
    let missing = |v: &u32| !is_named[*v as usize] && !present[*v as usize];
    (0..plc.vertices.len() as u32).filter(missing).collect()
}

/// A domain, its pieces, and whether each is exterior on both sides.
struct Search<'a> {
    plc: &'a Plc,
    units: &'a Units,
    corners: &'a [Whole],
    pieces: &'a [Piece],
    outer: &'a [bool],
}

impl Search<'_> {
    fn items(&self, cells: &Cells, missing: &[u32]) -> Exterior {
        // Of each edge of pieces whether all of them are exterior.
        let mut edges: HashMap<[u32; 2], bool> = HashMap::new();
        let mut parts = vec![None; self.plc.facets.len()];
        for (piece, &outer) in self.pieces.iter().zip(self.outer) {
            *parts[piece.facet as usize].get_or_insert(true) &= outer;
            for &[a, b] in &piece.rim {
                *edges.entry(edge(a, b)).or_insert(true) &= outer;
            }
        }
        // A segment of a facet that borders none of its pieces has to be in the mesh.
        let is_whole = |ring: &Vec<u32>| {
            (0..ring.len()).all(|k| edges.contains_key(&edge(ring[k], ring[(k + 1) % ring.len()])))
        };
        let facets = self.plc.facets.iter().zip(parts);
        let facets: Vec<bool> = facets
            .map(|(f, outer)| outer == Some(true) && f.polygons.iter().all(is_whole))
            .collect();
        let holds = |p: &Hom| cells.holds_outside(self.pieces, self.corners, p);
        let is_outer = |&[a, b]: &[u32; 2]| {
            let [p, q] = [a, b].map(|v| self.corners[v as usize]);
            edges.get(&edge(a, b)).copied().unwrap_or_else(|| holds(&Hom::middle(p, q)))
        };
        let segments: Vec<bool> = self.plc.segments.iter().map(is_outer).collect();
        // Vertices that something names, but nothing that is kept.
        let mut vertices = vec![false; self.corners.len()];
        let mut name = |kept: bool| {
            let list = self.plc.facets.iter().zip(&facets).filter(|(_, outer)| **outer != kept);
            list.flat_map(|(f, _)| f.polygons.iter().flatten())
                .for_each(|&v| vertices[v as usize] = !kept);
            let list = self.plc.segments.iter().zip(&segments).filter(|(_, outer)| **outer != kept);
            list.flat_map(|(ends, _)| ends).for_each(|&v| vertices[v as usize] = !kept);
        };
        name(false);
        name(true);
        for &v in missing {
            let p = Hom::of(&self.plc.vertices[v as usize], self.units);
            vertices[v as usize] = holds(&p);
        }
        Exterior { facets, segments, vertices }
    }
}
