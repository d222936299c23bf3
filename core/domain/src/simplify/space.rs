//! The space around a fan: does anything cross the new triangles, or lie in what they sweep?

use super::surface::{Star, Surface};
use crate::check::contact::Contacts;
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, orient3d};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// A piece and the box around it.
type Boxed = GeomWithData<Rectangle<Point>, u32>;

/// A piece that stays.
#[derive(Debug, Clone, Copy)]
enum Fixed {
    Triangle([u32; 3]),
    Edge([u32; 2]),
    Vertex(u32),
}

/// All pieces by their boxes: first the triangles of the surface, then those that stay.
pub(super) struct Space {
    tree: RTree<Boxed>,
    fixed: Vec<Fixed>,
    triangles: usize,
    /// Points of holes and regions.
    seeds: Vec<Point>,
}

/// A box around points.
fn around<'a>(mut points: impl Iterator<Item = &'a Point>) -> Option<[Point; 2]> {
    let first = *points.next()?;
    Some(points.fold([first; 2], |[low, high], p| {
        [[0, 1, 2].map(|k| low[k].min(p[k])), [0, 1, 2].map(|k| high[k].max(p[k]))]
    }))
}

fn boxed<'a>(number: u32, points: impl Iterator<Item = &'a Point>) -> Option<Boxed> {
    let [low, high] = around(points)?;
    Some(GeomWithData::new(Rectangle::from_corners(low, high), number))
}

impl Space {
    /// The space around a surface, other triangles, edges and points.
    pub(super) fn new(
        surface: &Surface,
        kept: &[[u32; 3]],
        edges: &[[u32; 2]],
        seeds: Vec<Point>,
    ) -> Self {
        let mut used: Vec<bool> = surface
            .stars
            .iter()
            .zip(&surface.beside)
            .map(|(s, b)| !s.is_empty() || !b.is_empty())
            .collect();
        kept.iter().flatten().for_each(|&v| used[v as usize] = true);
        let unused = (0..).zip(used).filter(|(_, used)| !used).map(|(v, _)| Fixed::Vertex(v));
        let triangles = kept.iter().map(|&t| Fixed::Triangle(t));
        let fixed: Vec<Fixed> =
            triangles.chain(edges.iter().map(|&e| Fixed::Edge(e))).chain(unused).collect();
        let count = surface.triangles.len();
        let own = (0..count as u32).filter_map(|t| boxed(t, surface.corners(t).into_iter()));
        let others = (count as u32..)
            .zip(&fixed)
            .filter_map(|(n, piece)| boxed(n, corners(piece).iter().map(|&v| surface.at(v))));
        Self { tree: RTree::bulk_load(own.chain(others).collect()), fixed, triangles: count, seeds }
    }

    /// Forgets triangles of the surface.
    pub(super) fn take(&mut self, surface: &Surface, triangles: impl Iterator<Item = u32>) {
        for t in triangles {
            if let Some(piece) = boxed(t, surface.corners(t).into_iter()) {
                self.tree.remove(&piece);
            }
        }
    }

    /// Adds triangles of the surface.
    pub(super) fn put(&mut self, surface: &Surface, triangles: impl Iterator<Item = u32>) {
        for t in triangles {
            if let Some(piece) = boxed(t, surface.corners(t).into_iter()) {
                self.tree.insert(piece);
            }
        }
    }

    /// May the vertex of a star be put onto `onto`, which its rings start with?
    ///
    /// The star sweeps tetrahedra with the edge and an edge of a ring each. Nothing else touches
    /// the triangles before, nor after if this is true; so what has no corner in a tetrahedron, and
    /// other corners than those of the rings, is not in it at all.
    pub(super) fn is_free(&self, surface: &Surface, star: &Star, from: u32, onto: u32) -> bool {
        let sides: Vec<[u32; 2]> = star
            .sectors
            .iter()
            .flat_map(|s| {
                let closing = s.closed.then(|| [s.ring[s.ring.len() - 1], s.ring[0]]);
                s.ring.windows(2).map(|w| [w[0], w[1]]).chain(closing).collect::<Vec<_>>()
            })
            .filter(|side| !side.contains(&onto))
            .collect();
        let ring: Vec<u32> = star.sectors.iter().flat_map(|s| s.ring.iter().copied()).collect();
        let is_own = |v: &u32| *v == from || ring.contains(v);
        let Some([low, high]) = around(ring.iter().chain([&from]).map(|&v| surface.at(v))) else {
            return false;
        };
        let swept = Swept { surface, from, onto, sides: &sides };
        let contacts = Contacts { points: &surface.points };
        let mut is_free = true;
        let mut near = self.tree.locate_in_envelope_intersecting(AABB::from_corners(low, high));
        while let (true, Some(piece)) = (is_free, near.next()) {
            let number = piece.data as usize;
            let piece = match number.checked_sub(self.triangles) {
                None => Fixed::Triangle(surface.triangles[number]),
                Some(k) => self.fixed[k],
            };
            let all = corners(&piece);
            if all.contains(&from) {
                continue;
            }
            let touches = |&[a, b]: &[u32; 2]| {
                let new = [onto, a, b];
                match piece {
                    Fixed::Triangle(t) => contacts.triangles(new, t),
                    Fixed::Edge(e) if e.iter().all(|v| new.contains(v)) => None,
                    Fixed::Edge(e) => contacts.edge_on_triangle(e, new),
                    Fixed::Vertex(v) => contacts.vertex_on_triangle(v, new),
                }
                .is_some()
            };
            is_free = !all.iter().all(is_own)
                && !all.iter().any(|v| !is_own(v) && swept.has(surface.at(*v)))
                && !sides.iter().any(touches);
        }
        let within = |p: &&Point| (0..3).all(|k| low[k] <= p[k] && p[k] <= high[k]);
        let on =
            |p: &Point| sides.iter().any(|&[a, b]| contacts.point_on_triangle(p, [onto, a, b]));
        let folds = || {
            (1..sides.len()).any(|k| {
                sides[..k].iter().any(|&[a, b]| {
                    let [c, d] = sides[k];
                    contacts.triangles([onto, a, b], [onto, c, d]).is_some()
                })
            })
        };
        is_free && !self.seeds.iter().filter(within).any(|p| swept.has(p) || on(p)) && !folds()
    }
}

/// The corners of a piece.
fn corners(piece: &Fixed) -> &[u32] {
    match piece {
        Fixed::Triangle(t) => t,
        Fixed::Edge(e) => e,
        Fixed::Vertex(v) => std::slice::from_ref(v),
    }
}

/// The tetrahedra between the triangles before and after.
struct Swept<'a> {
    surface: &'a Surface,
    from: u32,
    onto: u32,
    sides: &'a [[u32; 2]],
}

impl Swept<'_> {
    /// Is a point in one of the tetrahedra, or on its border? Flat ones have no inside.
    fn has(&self, p: &Point) -> bool {
        let [from, onto] = [self.from, self.onto].map(|v| self.surface.at(v));
        self.sides.iter().any(|side| {
            let [a, b] = side.map(|v| self.surface.at(v));
            let way = orient3d(from, onto, a, b);
            let sees = |sign: Sign| sign.is_zero() || sign == way;
            !way.is_zero()
                && sees(orient3d(p, onto, a, b))
                && sees(orient3d(from, p, a, b))
                && sees(orient3d(from, onto, p, b))
                && sees(orient3d(from, onto, a, p))
        })
    }
}
