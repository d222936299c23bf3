//! The hull of a mesh in parts: its facets meet at their edges, where it is convex; it is one
//! sphere, and once around. The tests are those of `crate::hull`, which says why.

use super::exchange::{Exchange, Record, deal, member_of, sums, tell_all};
use super::faces::Facet;
use super::found::Found;
use crate::chunks::{Levels, Partial};
use crate::defect::Kind;
use crate::hull::{Ray, Turned};
use crate::mesh::Point;
use crate::perturb;
use crate::predicates::{insphere, orient3d};

/// A facet at one of its edges: that opposite its vertex `k`.
#[derive(Clone, Copy)]
struct AtEdge {
    facet: Facet,
    k: u32,
}

impl Record for AtEdge {
    const BYTES: usize = Facet::BYTES + 4;

    fn put(&self, to: &mut Vec<u8>) {
        self.facet.put(to);
        self.k.put(to);
    }

    fn get(bytes: &[u8]) -> Self {
        Self { facet: Facet::get(bytes), k: u32::get(&bytes[Facet::BYTES..]) }
    }

    fn is_sound(&self) -> bool {
        self.facet.is_sound() && self.k < 3
    }
}

impl AtEdge {
    /// The numbers of the edge's ends, ascending.
    fn edge(&self) -> [u32; 2] {
        let [a, b] = self.ends().map(|k| self.facet.v[k].by_place);
        [a.min(b), a.max(b)]
    }

    /// The places of the ends in the facet.
    fn ends(&self) -> [usize; 2] {
        [(self.k as usize + 1) % 3, (self.k as usize + 2) % 3]
    }

    /// The far vertex of the facet.
    fn far(&self) -> &super::faces::Vertex {
        &self.facet.v[self.k as usize]
    }
}

/// The numbers of the whole hull.
pub(super) struct Counts {
    pub(super) facets: u64,
    pub(super) vertices: u64,
}

/// Tests every edge of the hull, whose facets have met at members, and its Euler characteristic if
/// that is asked for.
pub(super) fn edges<E: Exchange>(
    team: &mut E,
    facets: &[Facet],
    is_full: bool,
    levels: &mut Levels,
    found: &mut Found,
) -> Result<Counts, E::Error> {
    let members = team.members();
    let sides = facets.iter().flat_map(|&facet| (0..3).map(move |k| AtEdge { facet, k }));
    let all = deal(team, sides, |side| member_of(&side.edge(), members))?;
    let mut all: Vec<AtEdge> = all.into_iter().flatten().collect();
    all.sort_unstable_by_key(|side| (side.edge(), side.facet.tet, side.facet.key()));
    let mut proper = 0;
    for group in all.chunk_by(|a, b| a.edge() == b.edge()) {
        match group {
            [one, other] => {
                proper += 1;
                edge([one, other], is_full, levels, found);
            }
            _ => {
                let tets: Vec<u32> = group.iter().map(|side| side.facet.tet).collect();
                let ends = group[0].ends().map(|k| group[0].facet.v[k].corner);
                found.add(Kind::HullEdge, &tets, &ends);
            }
        }
    }
    drop(all);
    let corners = facets.iter().flat_map(|facet| facet.key());
    let all = deal(team, corners, |&v| member_of(&[v], members))?;
    let mut vertices: Vec<u32> = all.into_iter().flatten().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let own = [vertices.len() as u64, proper, facets.len() as u64];
    let [vertices, edges, facets] = sums(team, own)?;
    // Of a hull in several pieces, that it is not once around is told.
    let is_sphere = i128::from(vertices) - i128::from(edges) + i128::from(facets) == 2;
    if is_full && !is_sphere && facets > 0 && team.me() == 0 {
        found.add(Kind::HullEuler, &[], &[]);
    }
    Ok(Counts { facets, vertices })
}

/// Tests the edge of two facets.
fn edge([one, other]: [&AtEdge; 2], canonical: bool, levels: &mut Levels, found: &mut Found) {
    let Levels { delaunay: part, canonical: ties } = levels;
    if one.facet.sign == 0 || other.facet.sign == 0 {
        part.untested += 1;
        ties.untested += 1;
        return;
    }
    let (p, q) = (one.far(), &other.far().corner.at);
    let mut report = |kind: Kind| {
        let [x, y] = one.ends().map(|k| one.facet.v[k].corner);
        let vertices = [x, y, p.corner, other.far().corner];
        found.add(kind, &[one.facet.tet, other.facet.tet], &vertices);
    };
    let [a, b, c] = one.facet.outward();
    let sign = orient3d([a, b, c, q], &mut part.tally);
    if sign > 0 {
        report(Kind::ConcaveHull);
    }
    if sign != 0 {
        return;
    }
    // Coplanar: the circle of the facet lies on the sphere of its tetrahedron.
    let [s, t, u, v] = one.facet.positive();
    match insphere([s, t, u, v, q], &mut part.tally) {
        1 => report(Kind::NotDelaunay),
        0 if canonical => {
            let off = &one.facet.apex().corner.at;
            if perturb::side_in_plane([a, b, c], q, off, &mut ties.tally) > 0 {
                report(Kind::HullNotCanonical);
            }
        }
        _ => {}
    }
}

/// The global test. Presumes that all that came before it holds. `inner` is a tetrahedron of this
/// member that is not flat, if it has one.
pub(super) fn once_around<E: Exchange>(
    team: &mut E,
    inner: Option<[Point; 4]>,
    facets: &[Facet],
    found: &mut Found,
) -> Result<Partial, E::Error> {
    let mut part = Partial::new(0);
    // The same at all members: the first one's tetrahedron, and the first facet by its vertices.
    let inner = tell_all(team, inner.as_slice())?;
    let firsts: Vec<Facet> =
        facets.iter().min_by_key(|facet| facet.key()).copied().into_iter().collect();
    let firsts = tell_all(team, &firsts)?;
    let inner = inner.into_iter().flatten().next();
    let first = firsts.into_iter().flatten().min_by_key(Facet::key);
    let (Some(inner), Some(first)) = (inner, first) else { return Ok(part) };
    if !inner.iter().flatten().all(|c| c.is_finite()) {
        return Err(team.nonsense(0, "a tetrahedron that is not finite"));
    }
    let corners = inner.each_ref();
    let ray = Ray::new(corners, first.outward());
    for facet in facets {
        let vertices = [0, 1, 2].map(|k| facet.v[k].corner);
        match ray.turned(corners, facet.outward(), facet.key() == first.key(), &mut part) {
            None => {}
            Some(Turned::Away) => found.add(Kind::HullTurnedAway, &[facet.tet], &vertices),
            Some(Turned::Twice) => {
                found.add(Kind::HullWoundTwice, &[first.tet, facet.tet], &vertices);
            }
        }
    }
    Ok(part)
}
