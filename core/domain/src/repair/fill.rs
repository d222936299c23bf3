//! Holes of a surface that are closed where that is asked for: loops of open edges, by triangles
//! between their corners, those of the least area in sum (Barequet and Sharir, Computer Aided
//! Geometric Design 12, 1995). Whether these cross the surface is for the check.

use super::{Repairs, Surface, edges};
use crate::triangulate::sorted;
use crate::vector::{cross, dot, minus};
use crate::{Domain, Facet};
use ltbw_exact::Point;
use ltbw_exact::predicates::collinear;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// The longest loop that is closed: its triangles are found in cubic time.
pub const LONGEST_LOOP: u32 = 256;

/// The use of an edge.
#[derive(Clone, Copy)]
struct Use {
    facets: u32,
    /// The first facet, and the edge as that turns.
    facet: u32,
    ends: [u32; 2],
}

/// The edges of a surface, and for each vertex the vertices at the other ends of its open ones.
struct Border {
    uses: HashMap<[u32; 2], Use>,
    open: BTreeMap<u32, Vec<u32>>,
}

impl Border {
    fn new(domain: &Domain) -> Self {
        let mut uses: HashMap<[u32; 2], Use> = HashMap::new();
        for (facet, own) in (0..).zip(&domain.facets) {
            for ends in own.polygons.iter().flat_map(|polygon| edges(polygon)) {
                let of = Use { facets: 0, facet, ends };
                uses.entry(sorted(ends)).or_insert(of).facets += 1;
            }
        }
        let mut open: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (&[a, b], _) in uses.iter().filter(|(_, own)| own.facets == 1) {
            open.entry(a).or_default().push(b);
            open.entry(b).or_default().push(a);
        }
        open.values_mut().for_each(|others| others.sort_unstable());
        Self { uses, open }
    }

    /// The facet at an open edge, if it turns against the edge as given.
    fn is_against(&self, edge: [u32; 2]) -> bool {
        self.uses.get(&sorted(edge)).is_some_and(|own| own.ends == [edge[1], edge[0]])
    }

    /// The loops of at most `longest` open edges each of whose corners is on no other, from the
    /// least corner on, turned as the facets that would close them. The outline of a facet that
    /// stands alone is none.
    fn loops(&self, longest: usize) -> Vec<Vec<u32>> {
        let mut seen = BTreeSet::new();
        let mut loops = Vec::new();
        for (&start, others) in &self.open {
            let &[low, high] = &others[..] else { continue };
            if seen.contains(&start) {
                continue;
            }
            let first = if self.is_against([start, low]) || !self.is_against([start, high]) {
                low
            } else {
                high
            };
            let mut corners = vec![start];
            let mut at = first;
            // Every turn but the last adds a corner.
            while at != start && corners.len() <= longest {
                let before = corners[corners.len() - 1];
                let Some(&[one, other]) = self.open.get(&at).map(Vec::as_slice).and_then(pair)
                else {
                    break;
                };
                corners.push(at);
                at = if one == before { other } else { one };
            }
            seen.extend(corners.iter().copied());
            if at == start && (3..=longest).contains(&corners.len()) && !self.is_a_facet(&corners) {
                loops.push(corners);
            }
        }
        loops
    }

    fn is_a_facet(&self, corners: &[u32]) -> bool {
        let mut facets = edges(corners).map(|edge| self.uses.get(&sorted(edge)).map(|u| u.facet));
        let first = facets.next();
        facets.all(|facet| Some(facet) == first)
    }
}

fn pair(others: &[u32]) -> Option<&[u32; 2]> {
    others.try_into().ok()
}

impl Surface {
    /// Closes loops of at most `longest` open edges, [`LONGEST_LOOP`] at most; the triangles get
    /// the marker that most of the edges have.
    pub(crate) fn fill(&mut self, longest: u32, repairs: &mut Repairs) {
        let border = Border::new(&self.domain);
        for corners in border.loops(longest.min(LONGEST_LOOP) as usize) {
            let triangles = least_area(&self.domain.vertices, &corners, &border);
            let beside = self.beside(&corners, &border);
            let (Some(triangles), Some(beside)) = (triangles, beside) else { continue };
            repairs.filled.push(corners.len());
            repairs.filling += triangles.len();
            for triangle in triangles {
                let marker = self.domain.facets[beside as usize].marker;
                self.domain.facets.push(Facet::polygon(&triangle, marker));
                self.origin.push(self.origin[beside as usize]);
                self.inner.push(None);
            }
        }
    }
}

impl Surface {
    /// The first facet at a loop with the marker that most of its edges have, the least of those.
    fn beside(&self, corners: &[u32], border: &Border) -> Option<u32> {
        let mut counts: BTreeMap<i32, (usize, u32)> = BTreeMap::new();
        for edge in edges(corners) {
            let facet = border.uses.get(&sorted(edge))?.facet;
            let of = counts.entry(self.domain.facets[facet as usize].marker).or_insert((0, facet));
            *of = (of.0 + 1, of.1.min(facet));
        }
        let most = counts.into_values().rev().max_by_key(|of| of.0)?;
        Some(most.1)
    }
}

/// The triangles of a loop with the least area in sum; `None` where each choice has one without
/// area, or an edge that the surface has.
fn least_area(points: &[Point], corners: &[u32], border: &Border) -> Option<Vec<[u32; 3]>> {
    let count = corners.len();
    let at = |i: usize| &points[corners[i] as usize];
    let is_free = |i: usize, j: usize| {
        let is_side = j == i + 1 || (i == 0 && j == count - 1);
        is_side || !border.uses.contains_key(&sorted([corners[i], corners[j]]))
    };
    let area = |i: usize, k: usize, j: usize| {
        if collinear(at(i), at(k), at(j)) {
            return f64::INFINITY;
        }
        let normal = cross(&minus(at(k), at(i)), &minus(at(j), at(i)));
        dot(&normal, &normal).sqrt()
    };
    // The least area between the corners from the first to the second, and the third corner.
    let mut best = vec![(0.0, 0); count * count];
    for length in 2..count {
        for i in 0..count - length {
            let j = i + length;
            let third = i + 1..j;
            let sum = |k: usize| best[i * count + k].0 + best[k * count + j].0 + area(i, k, j);
            let least = third.map(|k| (sum(k), k)).min_by(|a, b| a.0.total_cmp(&b.0))?;
            best[i * count + j] = if is_free(i, j) { least } else { (f64::INFINITY, least.1) };
        }
    }
    if best[count - 1].0 == f64::INFINITY {
        return None;
    }
    let mut triangles = Vec::with_capacity(count - 2);
    let mut parts = vec![[0, count - 1]];
    // Each part is cut into smaller ones.
    while let Some([i, j]) = parts.pop() {
        if j > i + 1 {
            let k = best[i * count + j].1;
            triangles.push([corners[i], corners[k], corners[j]]);
            parts.extend([[k, j], [i, k]]);
        }
    }
    Some(triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PrepareOptions;

    /// A box with a row of vertices along its top, whose facets are triangles.
    fn grid(n: u32) -> Domain {
        let mut domain = Domain::cuboid([0.0; 3], [1.0; 3]);
        // The top is a grid of its own.
        domain.facets.retain(|facet| facet.marker != 6);
        let (mut numbers, mut all) = (BTreeMap::new(), domain.vertices.clone());
        let mut number = |x: u32, y: u32| {
            *numbers.entry((x, y)).or_insert_with(|| {
                let place = [f64::from(x) / f64::from(n), f64::from(y) / f64::from(n), 1.0];
                let known = all.iter().position(|p| *p == place);
                known.map_or_else(
                    || {
                        all.push(place);
                        all.len() as u32 - 1
                    },
                    |v| v as u32,
                )
            })
        };
        let mut top: Vec<[u32; 3]> = Vec::new();
        for (x, y) in (0..n).flat_map(|x| (0..n).map(move |y| (x, y))) {
            let [a, b, c, d] = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
            let [a, b, c, d] = [a, b, c, d].map(|(x, y)| number(x, y));
            top.extend([[a, b, c], [a, c, d]]);
        }
        domain.vertices = all;
        domain.facets.extend(top.iter().map(|triangle| Facet::polygon(triangle, 6)));
        domain
    }

    /// The grid without the triangles at some vertices, with a seam put into the sides.
    fn with_holes(n: u32, of: &[Point]) -> Domain {
        let mut domain = grid(n);
        let gone: Vec<u32> =
            (0..).zip(&domain.vertices).filter(|(_, p)| of.contains(p)).map(|(v, _)| v).collect();
        domain.facets.retain(|facet| {
            facet.polygons[0].len() != 3 || !facet.polygons[0].iter().any(|v| gone.contains(v))
        });
        domain
    }

    fn options(fill: u32) -> PrepareOptions {
        PrepareOptions { fill, oriented: true, repair: 1e-6, ..PrepareOptions::default() }
    }

    #[test]
    fn a_missing_triangle_is_put_back_and_told() {
        let mut domain = grid(4);
        let lost = domain.facets.remove(15);
        assert!(domain.prepare(&options(0)).is_err());
        assert!(domain.prepare(&options(2)).is_err());
        let prepared = domain.prepare(&options(3)).unwrap();
        assert_eq!((prepared.repairs.filled.as_slice(), prepared.repairs.filling), (&[3][..], 1));
        let last = prepared.domain.facets.last().unwrap();
        let turned = |corners: &[u32]| {
            let least = (0..3).min_by_key(|&i| corners[i]).unwrap();
            [0, 1, 2].map(|i| corners[(least + i) % 3])
        };
        assert_eq!(turned(&last.polygons[0]), turned(&lost.polygons[0]));
        assert_eq!(last.marker, 6);
        let note = prepared.notes().into_iter().find(|note| note.contains("hole"));
        assert_eq!(note.as_deref(), Some("1 hole of 3 edges closed by 1 triangle"));
        let strict = PrepareOptions { strict: true, ..options(3) };
        assert!(domain.prepare(&strict).is_err());
    }

    #[test]
    fn holes_up_to_the_length_are_closed_flat() {
        // Six triangles are at a vertex inside.
        let domain = with_holes(8, &[[0.25, 0.25, 1.0], [0.75, 0.5, 1.0]]);
        assert!(domain.prepare(&options(5)).is_err());
        let prepared = domain.prepare(&options(6)).unwrap();
        assert_eq!(
            (prepared.repairs.filled.as_slice(), prepared.repairs.filling),
            (&[6, 6][..], 8)
        );
        let at = |v: u32| prepared.domain.vertices[v as usize];
        let fans = prepared.domain.facets.iter().flat_map(|facet| {
            let corners = &facet.polygons[0];
            corners.windows(2).map(|w| [corners[0], w[0], w[1]].map(at)).collect::<Vec<_>>()
        });
        let sum: f64 = fans.map(|[a, b, c]| dot(&a, &cross(&b, &c)) / 6.0).sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    }

    #[test]
    fn loops_that_meet_in_a_corner_are_left() {
        let mut domain = grid(4);
        // Two triangles that have one corner in common.
        let [one, other] = [15, 25].map(|f: usize| domain.facets[f].polygons[0].clone());
        assert_eq!(one.iter().filter(|v| other.contains(v)).count(), 1);
        domain.facets.remove(25);
        assert!(domain.prepare(&options(6)).is_ok());
        domain.facets.remove(15);
        assert!(domain.prepare(&options(6)).is_err());
    }
}
