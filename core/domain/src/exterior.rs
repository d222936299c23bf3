//! Facets, segments and vertices with nothing but exterior around them are no part of a domain.
//! The check finds them ([`Exterior`]); preparation leaves them out.
//!
//! A facet that is exterior on both sides in some pieces only (a wall that goes on beyond the body)
//! is cut into its triangles first, which the mesh cannot tell from the facet: triangles of one
//! plane and one marker are one facet there.

use crate::check::Exterior;
use crate::repair::{Repairs, Surface};
use crate::triangulate::{edges, sorted};
use crate::{CheckOptions, Domain, DomainError, DomainReport, Facet};
use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};

/// The number of a vertex that is no part of the domain: see [`crate::Prepared::vertex_map`].
pub const LEFT_OUT: u32 = u32::MAX;

/// A list without the items of these numbers, which are ascending.
fn without<T>(list: &mut Vec<T>, numbers: &[u32]) {
    let (mut number, mut next) = (0, numbers.iter().copied().peekable());
    list.retain(|_| {
        let is_out = next.next_if_eq(&number).is_some();
        number += 1;
        !is_out
    });
}

impl Domain {
    /// The domain without these vertices, which nothing names, ascending; and for each vertex its
    /// new number or [`LEFT_OUT`].
    pub(crate) fn without_vertices(mut self, vertices: &[u32]) -> (Self, Vec<u32>) {
        let mut map: Vec<u32> = Vec::with_capacity(self.vertices.len());
        let (mut kept, mut next) = (0, vertices.iter().copied().peekable());
        for v in 0..self.vertices.len() as u32 {
            let is_out = next.next_if_eq(&v).is_some();
            map.push(if is_out { LEFT_OUT } else { kept });
            kept += u32::from(!is_out);
        }
        without(&mut self.vertices, vertices);
        let corners = self.facets.iter_mut().flat_map(|f| f.polygons.iter_mut().flatten());
        let ends = self.segments.iter_mut().flat_map(|(ends, _)| ends);
        corners.chain(ends).for_each(|v| *v = map[*v as usize]);
        (self, map)
    }

    /// The vertices that facets and segments name, each as often as they do.
    pub(crate) fn named(&self) -> impl Iterator<Item = u32> + '_ {
        let corners = self.facets.iter().flat_map(|f| f.polygons.iter().flatten());
        corners.chain(self.segments.iter().flat_map(|(ends, _)| ends)).copied()
    }

    /// The domain without the vertices that nothing names and that lie beyond the box of all that
    /// is named: they are outside, and the lattice must not reach out for them. Its vertices'
    /// numbers here, if there are such. The structure has to be sound.
    pub(crate) fn near(&self) -> (Cow<'_, Self>, Option<Vec<u32>>) {
        let mut is_named = vec![false; self.vertices.len()];
        self.named().for_each(|v| is_named[v as usize] = true);
        if !(is_named.contains(&false) && is_named.contains(&true)) {
            return (Cow::Borrowed(self), None);
        }
        let named = self.vertices.iter().zip(&is_named).filter(|(_, named)| **named);
        let (low, high) = named.fold(([f64::MAX; 3], [f64::MIN; 3]), |(low, high), (p, _)| {
            ([0, 1, 2].map(|k| low[k].min(p[k])), [0, 1, 2].map(|k| high[k].max(p[k])))
        });
        let is_beyond = |v: &u32| {
            let p = &self.vertices[*v as usize];
            !is_named[*v as usize] && (0..3).any(|k| p[k] < low[k] || p[k] > high[k])
        };
        let beyond: Vec<u32> = (0..self.vertices.len() as u32).filter(is_beyond).collect();
        if beyond.is_empty() {
            return (Cow::Borrowed(self), None);
        }
        let mut numbers: Vec<u32> = (0..self.vertices.len() as u32).collect();
        without(&mut numbers, &beyond);
        (Cow::Owned(self.clone().without_vertices(&beyond).0), Some(numbers))
    }
}

/// A surface from which what is exterior was left out.
pub(crate) struct Settled {
    /// The findings on what is left.
    pub(crate) report: DomainReport,
    /// The domain with all but flaps, and a hole point in each void, if anything was left out.
    pub(crate) whole: Option<Domain>,
    /// For each vertex its new number or [`LEFT_OUT`], if anything was left out.
    pub(crate) left: Option<Vec<u32>>,
}

impl Surface {
    /// Checks the surface and leaves out what has nothing but exterior around it.
    ///
    /// # Errors
    /// Those of [`Domain::check`].
    pub(crate) fn settle(
        &mut self,
        checks: &CheckOptions,
        repairs: &mut Repairs,
    ) -> Result<Settled, DomainError> {
        let mut report = self.check(checks)?;
        if report.is_meshable() && !report.exterior.partly.is_empty() {
            self.cut(&report.exterior.partly);
            report = self.check(checks)?;
        }
        if !report.is_meshable() || report.exterior.is_empty() {
            return Ok(Settled { report, whole: None, left: None });
        }
        let mut whole = self.without_flaps(&report.exterior);
        whole.holes.append(&mut report.voids);
        let left = self.leave_out(&report.exterior, repairs);
        Ok(Settled { report: self.check(checks)?, whole: Some(whole), left: Some(left) })
    }

    /// The domain without facets that are given from either side with nothing between, and without
    /// vertices that these alone name. Inside a body nobody could tell them from a sheet.
    fn without_flaps(&self, exterior: &Exterior) -> Domain {
        let mut domain = self.domain.clone();
        let is_flap = |f: &&u32| self.inner[**f as usize].is_some();
        let flaps: Vec<u32> = exterior.facets.iter().filter(is_flap).copied().collect();
        let corners = flaps.iter().flat_map(|&f| domain.facets[f as usize].polygons.concat());
        let mut gone: BTreeSet<u32> = corners.collect();
        gone.retain(|v| exterior.vertices.binary_search(v).is_ok());
        without(&mut domain.facets, &flaps);
        domain.named().for_each(|v| _ = gone.remove(&v));
        domain.without_vertices(&gone.into_iter().collect::<Vec<_>>()).0
    }

    /// Cuts facets into their triangles. Edges that such a facet draws inside itself, and its
    /// segments, become segments of the domain.
    fn cut(&mut self, facets: &[u32]) {
        let old = std::mem::take(&mut self.domain.facets);
        let (origin, inner) = (std::mem::take(&mut self.origin), std::mem::take(&mut self.inner));
        let mut next = facets.iter().copied().peekable();
        for (number, facet) in (0..).zip(old) {
            let place = number as usize;
            let mut add = |facet: Facet| {
                self.domain.facets.push(facet);
                self.origin.push(origin[place]);
                self.inner.push(inner[place]);
            };
            if next.next_if_eq(&number).is_none() {
                add(facet);
                continue;
            }
            let found = crate::triangulate::facet(&self.domain.vertices, &facet);
            let mut uses: HashMap<[u32; 2], u32> = HashMap::new();
            let sides = found.triangles.iter().flat_map(|t| edges(t));
            sides.for_each(|side| *uses.entry(sorted(side)).or_default() += 1);
            let mut drawn: Vec<[u32; 2]> =
                facet.polygons.iter().flat_map(|p| edges(p)).map(sorted).collect();
            drawn.sort_unstable();
            drawn.dedup();
            drawn.retain(|edge| uses.get(edge) == Some(&2));
            drawn.extend(found.loose.iter().copied());
            found.triangles.iter().for_each(|t| add(Facet::polygon(t, facet.marker)));
            self.domain.segments.extend(drawn.into_iter().map(|edge| (edge, facet.marker)));
        }
    }

    /// Leaves out what is exterior; for each vertex its new number or [`LEFT_OUT`].
    fn leave_out(&mut self, exterior: &Exterior, repairs: &mut Repairs) -> Vec<u32> {
        for &f in &exterior.facets {
            let (own, partner) = (self.origin[f as usize], self.inner[f as usize]);
            if let Some(other) = partner {
                repairs.flaps.extend([own, other]);
                repairs.inner.retain(|&f| f != other);
            } else if exterior.ends.binary_search(&f).is_ok() {
                repairs.ends.push(own);
            } else {
                repairs.exterior.push(own);
            }
        }
        for list in [&mut repairs.flaps, &mut repairs.ends, &mut repairs.exterior] {
            list.sort_unstable();
            list.dedup();
        }
        repairs.exterior_segments += exterior.segments.len();
        repairs.exterior_vertices += exterior.vertices.len();
        repairs.exterior_holes += exterior.holes.len();
        without(&mut self.origin, &exterior.facets);
        without(&mut self.inner, &exterior.facets);
        let mut domain = std::mem::take(&mut self.domain);
        without(&mut domain.facets, &exterior.facets);
        without(&mut domain.segments, &exterior.segments);
        without(&mut domain.holes, &exterior.holes);
        let (domain, map) = domain.without_vertices(&exterior.vertices);
        self.domain = domain;
        map
    }
}
