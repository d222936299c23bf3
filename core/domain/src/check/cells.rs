//! The cells into which the facets divide space.
//!
//! Every triangle has two sides, `2t` (to which its normal points, seen from where its corners run
//! counterclockwise) and `2t + 1`. Sides that see each other across an edge belong to one cell:
//!
//! ```text
//!      front|back         around an edge with more triangles than two, sorted by angle, each
//!     -------+-------     one's side ahead belongs to the next one's side behind; an edge of one
//!      back |front        triangle joins its own two sides
//! ```
//!
//! That finds cells up to shells inside shells, which meet in no edge. From a point outside
//! everything a segment is cast to each shell: between two crossings in a row lies one cell. The
//! last crossing before a shell belongs to what it lies in, so that all shells are joined.

use super::Findings;
use super::complex::{Complex, Piece};
use super::contact::sides_of;
use super::rays::{Hit, cast};
use crate::{DefectKind, Element};
use ltbw_core::Random;
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, orient3d};
use rayon::prelude::*;
use rstar::RTree;
use std::cmp::Ordering;
use std::collections::HashMap;

/// The number of the cell that reaches to infinity.
pub(crate) const OUTSIDE: u32 = 0;

/// The most times that a segment is cast anew when it meets an edge.
const TRIES: usize = 64;

/// An edge of a triangle: the edge as one number, and the triangle with the place of the edge.
pub(super) type Side = (u64, u32, u8);

/// The cells of a complex.
#[derive(Debug, Clone)]
pub(crate) struct Cells {
    /// The cell of each side of each triangle.
    pub(super) of_side: Vec<u32>,
    /// Their number, the outside included.
    pub(super) count: u32,
    /// Edges of one triangle only, with that triangle.
    pub(super) open: Vec<([u32; 2], u32)>,
}

/// Sets that are united.
pub(super) struct Sets(Vec<u32>);

impl Sets {
    pub(super) fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    pub(super) fn find(&mut self, mut x: u32) -> u32 {
        // Halves the path: every turn goes to an element nearer to the root.
        while self.0[x as usize] != x {
            self.0[x as usize] = self.0[self.0[x as usize] as usize];
            x = self.0[x as usize];
        }
        x
    }

    pub(super) fn unite(&mut self, x: u32, y: u32) {
        let (x, y) = (self.find(x), self.find(y));
        // The smaller number is the root.
        self.0[x.max(y) as usize] = x.min(y);
    }
}

/// The edges of all triangles, equal ones beside each other.
pub(super) fn edges(complex: &Complex<'_>) -> Vec<Side> {
    let mut sides: Vec<Side> = (0..complex.triangles.len() as u32)
        .into_par_iter()
        .flat_map_iter(|t| {
            let edges = sides_of(complex.triangles[t as usize]);
            (0..3_u8)
                .zip(edges)
                .map(move |(k, [a, b])| (u64::from(a.min(b)) << 32 | u64::from(a.max(b)), t, k))
        })
        .collect();
    sides.par_sort_unstable();
    sides
}

fn ends(edge: u64) -> [u32; 2] {
    [(edge >> 32) as u32, edge as u32]
}

/// Reports every edge of one facet only, without asking where the outside is. Facets without
/// triangles count: their neighbours are not at fault.
pub(super) fn open_edges(complex: &Complex<'_>, findings: &mut Findings) {
    let key = |[a, b]: [u32; 2]| u64::from(a.min(b)) << 32 | u64::from(a.max(b));
    let broken: std::collections::HashSet<u64> = complex.broken.iter().map(|&e| key(e)).collect();
    let sides = edges(complex);
    for group in sides.chunk_by(|a, b| a.0 == b.0) {
        if let [(edge, t, _)] = group
            && !broken.contains(edge)
        {
            leak(complex, ends(*edge), *t, DefectKind::Leak, findings);
        }
    }
}

/// Reports an open edge.
pub(super) fn leak(
    complex: &Complex<'_>,
    edge: [u32; 2],
    triangle: u32,
    kind: DefectKind,
    findings: &mut Findings,
) {
    let elements = vec![Element::Edge(edge), Element::Facet(complex.facet_of[triangle as usize])];
    findings.add(kind, elements, edge.map(|v| complex.points[v as usize]).to_vec());
}

impl Cells {
    /// Finds the cells of a complex of one triangle at least, in which triangles meet in common
    /// edges and vertices only.
    ///
    /// # Errors
    /// A triangle of a shell through which no segment could be cast that meets no edge.
    pub(super) fn new(
        complex: &Complex<'_>,
        index: &RTree<Piece>,
        findings: &mut Findings,
    ) -> Result<Self, u32> {
        let count = complex.triangles.len();
        let mut sets = Sets::new(2 * count);
        let mut open = Vec::new();
        let sides = edges(complex);
        for group in sides.chunk_by(|a, b| a.0 == b.0) {
            match group {
                [(edge, t, _)] => {
                    sets.unite(2 * t, 2 * t + 1);
                    open.push((ends(*edge), *t));
                }
                [one, other] => {
                    let (ahead, behind) = (ahead(complex, one), ahead(complex, other));
                    sets.unite(ahead, behind ^ 1);
                    sets.unite(ahead ^ 1, behind);
                }
                _ => {
                    let around = sorted(complex, group);
                    for (i, side) in around.iter().enumerate() {
                        let next = &around[(i + 1) % around.len()];
                        sets.unite(ahead(complex, side), ahead(complex, next) ^ 1);
                    }
                    non_manifold(complex, group, findings);
                }
            }
        }
        let outside = join_shells(complex, index, &mut sets)?;
        let mut names = HashMap::from([(outside, OUTSIDE)]);
        let mut of_side = Vec::with_capacity(2 * count);
        for side in 0..2 * count as u32 {
            let next = names.len() as u32;
            of_side.push(*names.entry(sets.find(side)).or_insert(next));
        }
        Ok(Self { of_side, count: names.len() as u32, open })
    }

    /// The cells in front of and behind a triangle.
    pub(super) fn beside(&self, triangle: usize) -> [u32; 2] {
        [self.of_side[2 * triangle], self.of_side[2 * triangle + 1]]
    }
}

/// The side of a triangle that lies ahead, counterclockwise around an edge seen against its
/// direction from the smaller vertex to the larger.
fn ahead(complex: &Complex<'_>, &(_, t, place): &Side) -> u32 {
    let [a, b] = sides_of(complex.triangles[t as usize])[place as usize];
    2 * t + u32::from(a > b)
}

/// The corner of a triangle that is not on its edge.
fn apex(complex: &Complex<'_>, &(_, t, place): &Side) -> u32 {
    complex.triangles[t as usize][(place as usize + 2) % 3]
}

/// The triangles at an edge, counterclockwise around it from the first one.
fn sorted(complex: &Complex<'_>, group: &[Side]) -> Vec<Side> {
    let at = |v: u32| &complex.points[v as usize];
    let [a, b] = ends(group[0].0);
    let first = apex(complex, &group[0]);
    let turn = |c: u32, d: u32| orient3d(at(a), at(b), at(c), at(d));
    // Less than half a turn from the first one, exactly half, or more.
    let half = |v: u32| match turn(first, v) {
        _ if v == first => 0,
        Sign::Positive => 1,
        Sign::Zero => 2,
        Sign::Negative => 3,
    };
    let mut around = group.to_vec();
    around.sort_by(|p, q| {
        let (p, q) = (apex(complex, p), apex(complex, q));
        half(p).cmp(&half(q)).then_with(|| match turn(p, q) {
            _ if p == q => Ordering::Equal,
            Sign::Positive => Ordering::Less,
            Sign::Zero => Ordering::Equal,
            Sign::Negative => Ordering::Greater,
        })
    });
    around
}

fn non_manifold(complex: &Complex<'_>, group: &[Side], findings: &mut Findings) {
    let edge = ends(group[0].0);
    let mut facets: Vec<u32> =
        group.iter().map(|&(_, t, _)| complex.facet_of[t as usize]).collect();
    facets.sort_unstable();
    facets.dedup();
    let facets = facets.into_iter().map(Element::Facet);
    let elements = std::iter::once(Element::Edge(edge)).chain(facets).collect();
    let at = edge.map(|v| complex.points[v as usize]).to_vec();
    findings.add(DefectKind::NonManifold, elements, at);
}

/// Unites the cells of shells that are in one another; returns a side of the outside, or a triangle
/// of a shell that no segment hits.
fn join_shells(complex: &Complex<'_>, index: &RTree<Piece>, sets: &mut Sets) -> Result<u32, u32> {
    let mut outside = None;
    let shells = shells(complex, sets);
    let casts: Vec<Option<Vec<Hit>>> =
        shells.par_iter().map(|shell| to_shell(complex, index, shell)).collect();
    for (hits, shell) in casts.into_iter().zip(&shells) {
        let hits = hits.ok_or(shell[0])?;
        let first = hits[0].near();
        sets.unite(first, *outside.get_or_insert(first));
        for pair in hits.windows(2) {
            sets.unite(pair[0].far(), pair[1].near());
        }
    }
    Ok(sets.find(outside.unwrap_or_default()))
}

/// A few triangles of each shell (triangles that edges connect), the largest first.
fn shells(complex: &Complex<'_>, sets: &mut Sets) -> Vec<Vec<u32>> {
    const FEW: usize = 8;
    let mut joined = Sets(sets.0.clone());
    let count = complex.triangles.len() as u32;
    (0..count).for_each(|t| joined.unite(2 * t, 2 * t + 1));
    let mut place: HashMap<u32, usize> = HashMap::new();
    let mut shells: Vec<Vec<(f64, u32)>> = Vec::new();
    for t in 0..count {
        let shell = *place.entry(joined.find(2 * t)).or_insert_with(|| {
            shells.push(Vec::new());
            shells.len() - 1
        });
        let area = area(complex, t);
        let list = &mut shells[shell];
        if list.len() < FEW || list.last().is_some_and(|&(least, _)| area > least) {
            let at = list.partition_point(|&(a, _)| a >= area);
            list.insert(at, (area, t));
            list.truncate(FEW);
        }
    }
    shells.into_iter().map(|list| list.into_iter().map(|(_, t)| t).collect()).collect()
}

/// The square of twice the area of a triangle, rounded: larger is easier to hit.
pub(super) fn area(complex: &Complex<'_>, t: u32) -> f64 {
    let n = normal(complex, t);
    n[0] * n[0] + n[1] * n[1] + n[2] * n[2]
}

/// A normal of a triangle, rounded.
pub(super) fn normal(complex: &Complex<'_>, t: u32) -> Point {
    let [a, b, c] = complex.triangles[t as usize].map(|v| complex.points[v as usize]);
    let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
    [0, 1, 2].map(|k: usize| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        u[i] * v[j] - u[j] * v[i]
    })
}

/// A point near the middle of a triangle, not the same at every try.
pub(super) fn middle(complex: &Complex<'_>, t: u32, random: &mut Random) -> Point {
    let corners = complex.triangles[t as usize].map(|v| complex.points[v as usize]);
    let weights = [0, 1, 2].map(|_: usize| 1.0 + random.unit());
    let sum = weights[0] + weights[1] + weights[2];
    [0, 1, 2].map(|k: usize| (0..3).map(|i: usize| weights[i] / sum * corners[i][k]).sum())
}

/// A point far outside the box of all vertices, not the same at every try.
pub(super) fn beyond(points: &[Point], random: &mut Random) -> Point {
    let first = points.first().copied().unwrap_or([0.0; 3]);
    let (low, high) = points.iter().fold((first, first), |(low, high), p| {
        ([0, 1, 2].map(|k| low[k].min(p[k])), [0, 1, 2].map(|k| high[k].max(p[k])))
    });
    let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    // Beyond the box in one direction, anywhere in the others.
    let axis = random.below(3) as usize;
    [0, 1, 2].map(|k| {
        let within = low[k] + (2.0 * random.unit() - 0.5) * size;
        if k == axis { high[k] + (1.0 + random.unit()) * size } else { within }
    })
}

/// The crossings of a segment from the outside through a shell.
fn to_shell(complex: &Complex<'_>, index: &RTree<Piece>, shell: &[u32]) -> Option<Vec<Hit>> {
    let mut random = Random::new(1);
    for attempt in 0..TRIES {
        // The largest triangle at first, then the others in turn.
        let target = shell[attempt.saturating_sub(TRIES / 4) % shell.len()];
        let from = beyond(complex.points, &mut random);
        let through = middle(complex, target, &mut random);
        let to = [0, 1, 2].map(|k| through[k] + 0.5 * (through[k] - from[k]));
        match cast(complex, index, &from, &to) {
            Ok(hits) if hits.iter().any(|hit| hit.triangle == target) => return Some(hits),
            _ => {}
        }
    }
    None
}

/// The cell that a point which is on no facet lies in.
pub(super) fn locate(
    complex: &Complex<'_>,
    index: &RTree<Piece>,
    cells: &Cells,
    p: &Point,
) -> Option<u32> {
    let mut random = Random::new(2);
    (0..TRIES).find_map(|_| {
        let from = beyond(complex.points, &mut random);
        let hits = cast(complex, index, &from, p).ok()?;
        Some(hits.last().map_or(OUTSIDE, |hit| cells.of_side[hit.far() as usize]))
    })
}
