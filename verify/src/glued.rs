//! The short proof: a claimed adjacency that holds makes the checker's own one needless.
//!
//! One sweep over the tetrahedra tests that every claim is mutual and joins one face with two
//! opposite sides, and, with the same data in hand, the exact orientation of the tetrahedron and
//! the exact in-sphere test of each face; then come the tests of the hull. These are the premises
//! of the theorem in the crate documentation, which concludes what is *not* tested here: that no
//! face has a third tetrahedron, that the mesh hangs together, that it is a ball at every vertex
//! and as a whole. Where one test fails there is no proof, and the levels are gone through one by
//! one, on the checker's own adjacency, to say what is wrong.
//!
//! *Claims.* A face of `t` with the claim `u > t` is tested: `u` claims `t` across a face of its
//! own, with the same three vertices turned the other way. Faces of one tetrahedron differ, so
//! this maps the faces with a claim `u > t` one to one into those with a claim `u < t`; if the
//! numbers of both are equal, onto them: the claims are pairs.

use crate::defect::Findings;
use crate::geometry::Oriented;
use crate::hull;
use crate::mesh::{Mesh, NO_NEIGHBOUR, Options, face};
use crate::perturb;
use crate::predicates::{Sphere, Tally};
use crate::sweep::{Partial, pieces};
use crate::topology::{self, Hull};

/// What the report says of a mesh that was proved.
pub(crate) struct Proof {
    pub(crate) orientation: Tally,
    pub(crate) delaunay: Tally,
    pub(crate) canonical: Tally,
    /// Sum of the volumes, rounded.
    pub(crate) volume: f64,
    /// Number of hull facets.
    pub(crate) hull_facets: u64,
    pub(crate) hull: Hull,
    /// Number of different faces.
    pub(crate) faces: u64,
}

/// Proves the mesh Delaunay, and canonical if `canonical`, from its claimed adjacency. All its
/// tetrahedra must be sound and there must be one.
pub(crate) fn prove(mesh: &Mesh, options: &Options, canonical: bool) -> Option<Proof> {
    let claims = mesh.neighbours.filter(|n| n.len() == mesh.tets.len())?;
    let swept = Swept::all(mesh, claims, canonical)?;
    let facets = &swept.hull;
    let mut findings = Findings::new(options.max_defects);
    topology::claimed_hull(mesh, facets, &mut findings);
    let surface = topology::hull(mesh, facets, &mut findings);
    findings.merge(topology::hull_euler(mesh, facets, &surface));

    let oriented = Oriented::positive(mesh, swept.volume / 6.0);
    let limit = options.max_defects;
    let (mut part, ties) = hull::edges(&oriented, facets, &surface.pairs, canonical, limit);
    part.merge(hull::once_around(&oriented, facets, 0, limit));
    let holds = |part: &Partial| part.findings.counts.is_empty() && part.untested == 0;
    if !findings.counts.is_empty() || !holds(&part) || !holds(&ties) {
        return None;
    }
    let (mut delaunay, mut perturbed) = (swept.delaunay, swept.canonical);
    delaunay.merge(part.tally);
    perturbed.merge(ties.tally);
    Some(Proof {
        orientation: swept.orientation,
        delaunay,
        canonical: perturbed,
        volume: oriented.volume,
        hull_facets: facets.len() as u64,
        faces: swept.above + facets.len() as u64,
        hull: surface,
    })
}

/// What a sweep over tetrahedra brings back if all of its tests hold.
#[derive(Default)]
struct Swept {
    orientation: Tally,
    delaunay: Tally,
    canonical: Tally,
    /// Six times the sum of the volumes, rounded.
    volume: f64,
    /// Codes of the hull facets, ascending.
    hull: Vec<u32>,
    /// Numbers of faces towards larger and towards smaller tetrahedra.
    above: u64,
    below: u64,
}

impl Swept {
    fn all(mesh: &Mesh, claims: &[[u32; 4]], canonical: bool) -> Option<Self> {
        let parts = pieces(mesh.tets.len(), |range| {
            let mut part = Self::default();
            for t in range {
                part.tet(mesh, claims, t, canonical)?;
            }
            Some(part)
        });
        let mut all = Self::default();
        for part in parts {
            let part = part?;
            all.orientation.merge(part.orientation);
            all.delaunay.merge(part.delaunay);
            all.canonical.merge(part.canonical);
            all.volume += part.volume;
            all.hull.extend(part.hull);
            all.above += part.above;
            all.below += part.below;
        }
        (all.above == all.below).then_some(all)
    }

    /// Tests the tetrahedron `t` and its faces towards larger ones; `None` if a test fails.
    #[inline]
    fn tet(&mut self, mesh: &Mesh, claims: &[[u32; 4]], t: usize, canonical: bool) -> Option<()> {
        let tet = &mesh.tets[t];
        let corners = tet.map(|v| &mesh.points[v as usize]);
        let sphere = Sphere::new(corners);
        if sphere.orientation(&mut self.orientation) <= 0 {
            return None;
        }
        self.volume += sphere.volume6();
        for (i, &claim) in claims[t].iter().enumerate() {
            let u = claim as usize;
            if claim == NO_NEIGHBOUR {
                self.hull.push((4 * t + i) as u32);
            } else if u < t {
                self.below += 1;
            } else {
                self.above += 1;
                let other = mesh.tets.get(u)?;
                let j = side_of(t as u32, claims.get(u)?)?;
                if !are_opposite(face(tet, i), face(other, j)) {
                    return None;
                }
                let apex = &mesh.points[other[j] as usize];
                let sign = sphere.side(apex, &mut self.delaunay);
                let tie = sign == 0 && canonical;
                if sign > 0 || tie && perturb::side(corners, apex, &mut self.canonical) > 0 {
                    return None;
                }
            }
        }
        Some(())
    }
}

/// The place of `t` among the claims of a neighbour.
#[inline]
fn side_of(t: u32, claims: &[u32; 4]) -> Option<usize> {
    // Without a branch; should two claims be equal, the sum is 3 or the last line refuses it.
    let is = |i: usize| usize::from(claims[i] == t);
    let j = (is(1) + 2 * is(2) + 3 * is(3)) & 3;
    (claims[j] == t).then_some(j)
}

/// Whether two faces have the same vertices and turn opposite ways.
#[inline]
fn are_opposite([a, b, c]: [u32; 3], [x, y, z]: [u32; 3]) -> bool {
    let is = |p, q, r| (a == p) & (b == q) & (c == r);
    is(x, z, y) | is(y, x, z) | is(z, y, x)
}
