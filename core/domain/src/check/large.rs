//! Large facets: what meets the plane of one in a corner of it or in an edge that it draws, and
//! nowhere else, has no contact with any of its triangles, however many these are.

use super::cells::area;
use super::complex::{Complex, Shape};
use super::contact::sides_of;
use crate::Element;
use ltbw_exact::predicates::{Sign, orient3d};
use std::collections::HashMap;

/// Triangles from which on a facet is large.
const MANY: usize = 64;

/// A flat facet of many triangles.
struct Outline {
    /// The corners of one of its triangles.
    plane: [u32; 3],
    /// All corners of its triangles, ascending.
    corners: Vec<u32>,
    /// The edges that it draws and its triangles have, ascending, each from its lower end.
    drawn: Vec<[u32; 2]>,
}

/// The large facets of a complex.
pub(super) struct Large<'c> {
    complex: &'c Complex<'c>,
    outlines: HashMap<u32, Outline>,
}

impl<'c> Large<'c> {
    pub(super) fn new(complex: &'c Complex<'c>) -> Self {
        Self::of(complex, MANY)
    }

    /// The facets of this number of triangles and more.
    pub(super) fn of(complex: &'c Complex<'c>, many: usize) -> Self {
        let (mut outlines, mut end) = (HashMap::new(), 0);
        // The triangles of a facet follow each other.
        for group in complex.facet_of.chunk_by(|a, b| a == b) {
            let first = end;
            end += group.len();
            if group.len() >= many && !complex.is_bent(group[0]) {
                outlines.insert(group[0], Outline::new(complex, first as u32..end as u32));
            }
        }
        Self { complex, outlines }
    }

    /// The large facet that has the most pieces in a list, if these are many beside the others;
    /// and the places of its first piece and the one after its last.
    pub(super) fn foremost(&self, list: &[u32]) -> Option<(u32, [usize; 2])> {
        /// Parts of a list of which a facet's pieces are one at least.
        const PARTS: usize = 8;
        let facet = |n: u32| self.complex.facet_of.get(n as usize);
        let (mut best, mut end): (Option<(u32, [usize; 2])>, usize) = (None, 0);
        for group in list.chunk_by(|&a, &b| facet(a).is_some() && facet(a) == facet(b)) {
            let first = end;
            end += group.len();
            let largest = best.map_or(MANY.max(list.len() / PARTS), |(_, [i, j])| j - i + 1);
            if let Some(&f) = facet(group[0])
                && group.len() >= largest
                && self.outlines.contains_key(&f)
            {
                best = Some((f, [first, end]));
            }
        }
        best
    }

    /// Is it sure that a piece has no contact with this facet, as it meets its plane nowhere, or
    /// in something that both have?
    pub(super) fn is_apart(&self, facet: u32, piece: u32) -> bool {
        let Some(outline) = self.outlines.get(&facet) else { return false };
        if self.complex.element(piece) == Element::Facet(facet) {
            return true;
        }
        match self.complex.shape(piece) {
            Shape::Triangle(t) => {
                let draws = |side| self.complex.draws(piece, side);
                outline.is_apart(self.complex, &t, &draws)
            }
            Shape::Edge(e) => outline.is_apart(self.complex, &e, &|_| true),
        }
    }
}

impl Outline {
    fn new(complex: &Complex<'_>, triangles: std::ops::Range<u32>) -> Self {
        let at = |t: u32| complex.triangles[t as usize];
        // The largest one: signs are decided by it without exact arithmetic.
        let largest = triangles.clone().max_by(|&t, &u| {
            let (t, u) = (area(complex, t), area(complex, u));
            t.total_cmp(&u)
        });
        let plane = at(largest.unwrap_or(triangles.start));
        let mut corners: Vec<u32> = triangles.clone().flat_map(at).collect();
        let mut drawn: Vec<[u32; 2]> = triangles
            .flat_map(|t| sides_of(at(t)).map(|side| (t, side)))
            .filter(|&(t, side)| complex.draws(t, side))
            .map(|(_, [a, b])| [a.min(b), a.max(b)])
            .collect();
        corners.sort_unstable();
        corners.dedup();
        drawn.sort_unstable();
        drawn.dedup();
        Self { plane, corners, drawn }
    }

    /// Does a piece with these corners meet the plane nowhere, in a corner of the facet, or in an
    /// edge that both draw, and lies it on one side of the plane otherwise?
    fn is_apart(
        &self,
        complex: &Complex<'_>,
        corners: &[u32],
        draws: &dyn Fn([u32; 2]) -> bool,
    ) -> bool {
        let at = |v: u32| &complex.points[v as usize];
        let [a, b, c] = self.plane.map(at);
        let (mut side, mut on) = (Sign::Zero, Vec::new());
        for &v in corners {
            if self.corners.binary_search(&v).is_ok() {
                on.push(v);
                continue;
            }
            match orient3d(a, b, c, at(v)) {
                Sign::Zero => return false,
                sign if side * sign == Sign::Negative => return false,
                sign => side = sign,
            }
        }
        match on[..] {
            [] | [_] => true,
            [v, w] => self.drawn.binary_search(&[v.min(w), v.max(w)]).is_ok() && draws([v, w]),
            _ => false,
        }
    }
}
