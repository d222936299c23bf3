//! The troubles that keep a surface from being meshed, in words for people: is it open, doubled,
//! does it cross itself, or do its bodies touch or cross each other?
//!
//! A *body* is a set of facets that edges connect; vertices at the same place count as one. Every
//! finding is about one body or about two. Cost: O(n), and only if there are errors.

use super::complex::same_place;
use crate::{DefectKind, Domain, DomainDefect, Element, Severity};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;

/// Facets that a [`Trouble`] lists.
const LISTED: usize = 100_000;

/// The kinds of what keeps a surface from being meshed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum TroubleKind {
    /// Edges with a facet on one side only: there is a hole.
    Open,
    /// Facets are there twice: the surface is double-sided, or was written twice.
    Doubled,
    /// Facets of different bodies meet where they have no common edges and vertices.
    BodiesTouch,
    /// Facets of different bodies cross.
    BodiesCross,
    /// Facets of one body cross or overlap.
    SelfCrossing,
    /// A vertex of a body lies inside an edge or a facet of the same body.
    Seam,
    /// Facets that have no area or cross themselves.
    Degenerate,
}

impl TroubleKind {
    /// Every kind.
    pub const ALL: [TroubleKind; 7] = [
        TroubleKind::Open,
        TroubleKind::Doubled,
        TroubleKind::BodiesTouch,
        TroubleKind::BodiesCross,
        TroubleKind::SelfCrossing,
        TroubleKind::Seam,
        TroubleKind::Degenerate,
    ];

    /// A short code that stays the same between versions, for programs to match on.
    #[must_use]
    pub fn code(self) -> &'static str {
        match self {
            TroubleKind::Open => "open",
            TroubleKind::Doubled => "doubled",
            TroubleKind::BodiesTouch => "bodies-touch",
            TroubleKind::BodiesCross => "bodies-cross",
            TroubleKind::SelfCrossing => "self-crossing",
            TroubleKind::Seam => "seam",
            TroubleKind::Degenerate => "degenerate",
        }
    }

    /// Its kind in a few words.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            TroubleKind::Open => "open",
            TroubleKind::Doubled => "doubled (double-sided)",
            TroubleKind::BodiesTouch => "bodies that touch",
            TroubleKind::BodiesCross => "bodies that cross",
            TroubleKind::SelfCrossing => "self-crossing",
            TroubleKind::Seam => "T-junctions",
            TroubleKind::Degenerate => "facets without area",
        }
    }
}

impl fmt::Display for TroubleKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.code())
    }
}

/// All findings of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Trouble {
    /// Its kind.
    pub kind: TroubleKind,
    /// The number of findings.
    pub places: u64,
    /// In how many bodies.
    pub bodies: usize,
    /// The first finding.
    pub first: Option<DomainDefect>,
    /// The facets concerned, ascending, at most 100,000 of them.
    pub facets: Vec<u32>,
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, places, bodies, first, .. } = self;
        let (s, y) = (if *places == 1 { "" } else { "s" }, if *bodies == 1 { "y" } else { "ies" });
        write!(f, "{}: {places} place{s} in {bodies} bod{y}", kind.about())?;
        if let Some([x, y, z]) = first.as_ref().and_then(|d| d.at.first()) {
            write!(f, ", the first at ({x:?} {y:?} {z:?})")?;
        }
        Ok(())
    }
}

/// A finding as it is counted: its kind, and the elements that it is about.
pub(super) type Counted = (DefectKind, [Element; 2]);

/// The bodies of a domain.
struct Bodies<'a> {
    domain: &'a Domain,
    /// For each vertex the least one at its place.
    same: Option<Vec<u32>>,
    /// For each facet another of its body with a smaller number, or itself.
    root: Vec<u32>,
    /// For each vertex a facet that names it.
    facet_at: Vec<u32>,
}

impl<'a> Bodies<'a> {
    fn new(domain: &'a Domain) -> Self {
        let count = domain.facets.len() as u32;
        let mut bodies = Self {
            domain,
            same: same_place(&domain.vertices),
            root: (0..count).collect(),
            facet_at: vec![u32::MAX; domain.vertices.len()],
        };
        let mut first: HashMap<[u32; 2], u32> = HashMap::new();
        for (f, facet) in (0..).zip(&domain.facets) {
            for polygon in &facet.polygons {
                for (i, &v) in polygon.iter().enumerate() {
                    let (v, w) = (bodies.kept(v), bodies.kept(polygon[(i + 1) % polygon.len()]));
                    let other = *first.entry([v.min(w), v.max(w)]).or_insert(f);
                    bodies.unite(f, other);
                    let place = &mut bodies.facet_at[v as usize];
                    *place = (*place).min(f);
                }
            }
        }
        bodies
    }

    fn kept(&self, v: u32) -> u32 {
        self.same.as_ref().map_or(v, |same| same[v as usize])
    }

    fn find(&mut self, mut f: u32) -> u32 {
        // Halves the path: every turn goes to a smaller number.
        while self.root[f as usize] != f {
            self.root[f as usize] = self.root[self.root[f as usize] as usize];
            f = self.root[f as usize];
        }
        f
    }

    fn unite(&mut self, f: u32, g: u32) {
        let (f, g) = (self.find(f), self.find(g));
        self.root[f.max(g) as usize] = f.min(g);
    }

    /// A facet of an element, if it has one.
    fn facet(&self, element: Element) -> Option<u32> {
        let at = |v: u32| Some(self.facet_at[self.kept(v) as usize]).filter(|&f| f != u32::MAX);
        match element {
            Element::Facet(f) | Element::Polygon { facet: f, .. } => Some(f),
            Element::Vertex(v) => at(v),
            Element::Edge([v, w]) => at(v).or_else(|| at(w)),
            Element::Segment(s) => {
                let (ends, _) = self.domain.segments.get(s as usize)?;
                ends.iter().find_map(|&v| at(v))
            }
            _ => None,
        }
    }

    /// The places of a facet's corners, ascending.
    fn corners(&self, f: u32) -> Vec<u32> {
        let polygons = self.domain.facets.get(f as usize).map(|f| &f.polygons);
        let mut corners: Vec<u32> =
            polygons.into_iter().flatten().flatten().map(|&v| self.kept(v)).collect();
        corners.sort_unstable();
        corners
    }

    /// The meaning of a finding, and the facets that it is about.
    fn meaning(&mut self, kind: DefectKind, pair: [Element; 2]) -> Option<(TroubleKind, [u32; 2])> {
        let [one, other] = pair.map(|element| self.facet(element));
        let facets = [one.or(other)?, other.or(one)?];
        let same_body = self.find(facets[0]) == self.find(facets[1]);
        let kind = match kind {
            DefectKind::Leak => TroubleKind::Open,
            DefectKind::Degenerate => TroubleKind::Degenerate,
            DefectKind::Overlap
                if facets[0] != facets[1] && self.corners(facets[0]) == self.corners(facets[1]) =>
            {
                TroubleKind::Doubled
            }
            DefectKind::Overlap if !same_body => TroubleKind::BodiesTouch,
            DefectKind::Intersection if !same_body => TroubleKind::BodiesCross,
            DefectKind::Overlap | DefectKind::Intersection => TroubleKind::SelfCrossing,
            DefectKind::TJunction if !same_body => TroubleKind::BodiesTouch,
            DefectKind::TJunction => TroubleKind::Seam,
            _ => return None,
        };
        Some((kind, facets))
    }
}

/// For each facet the least one of its body.
pub(super) fn bodies_of(domain: &Domain) -> Vec<u32> {
    let mut bodies = Bodies::new(domain);
    (0..domain.facets.len() as u32).map(|f| bodies.find(f)).collect()
}

/// The two elements by which a finding is counted.
pub(super) fn counted(kind: DefectKind, elements: &[Element]) -> Option<Counted> {
    if kind.severity() < Severity::Error {
        return None;
    }
    // An open edge is where its facet is.
    let place = |i: usize| elements.get(i).copied();
    let pair = match kind {
        DefectKind::Leak => [place(1)?, place(1)?],
        _ => [place(0)?, place(1).or(place(0))?],
    };
    Some((kind, pair))
}

/// Sums the findings up by what they mean; also tells how many bodies there are.
pub(super) fn troubles(
    domain: &Domain,
    all: &[Counted],
    listed: &[DomainDefect],
) -> (Vec<Trouble>, usize) {
    if all.is_empty() {
        return (Vec::new(), 0);
    }
    let mut bodies = Bodies::new(domain);
    let mut sums: BTreeMap<TroubleKind, (u64, BTreeSet<u32>, BTreeSet<u32>)> = BTreeMap::new();
    for &(kind, pair) in all {
        let Some((kind, facets)) = bodies.meaning(kind, pair) else { continue };
        let (places, found, concerned) = sums.entry(kind).or_default();
        *places += 1;
        found.extend(facets.map(|f| bodies.find(f)));
        if concerned.len() < LISTED {
            concerned.extend(facets);
        }
    }
    let mut first: BTreeMap<TroubleKind, DomainDefect> = BTreeMap::new();
    for defect in listed {
        let meaning = counted(defect.kind, &defect.elements)
            .and_then(|(kind, pair)| bodies.meaning(kind, pair));
        if let Some((kind, _)) = meaning {
            first.entry(kind).or_insert_with(|| defect.clone());
        }
    }
    let count = (0..domain.facets.len() as u32).filter(|&f| bodies.find(f) == f).count();
    let trouble = |(kind, (places, found, facets)): (TroubleKind, (u64, BTreeSet<u32>, _))| {
        let facets: BTreeSet<u32> = facets;
        Trouble {
            kind,
            places,
            bodies: found.len(),
            first: first.get(&kind).cloned(),
            facets: facets.into_iter().collect(),
        }
    };
    (sums.into_iter().map(trouble).collect(), count)
}
