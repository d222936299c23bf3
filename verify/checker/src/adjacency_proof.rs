//! The short proof: a claimed adjacency that holds makes the checker's own one needless.
//!
//! One sweep over the tetrahedra tests that every claim is mutual and joins one face with two
//! opposite sides, and, with the same data in hand, the exact orientation of the tetrahedron and
//! the exact in-sphere test of each face; then come the tests of the hull. These are the premises
//! of the theorem in the crate documentation, which concludes what is *not* tested here: that no
//! face has a third tetrahedron, that the mesh is connected, that it is a ball at every vertex
//! and as a whole. Where one test fails there is no proof, and the levels are gone through one by
//! one, on the checker's own adjacency, to say what is wrong.
//!
//! *Claims.* A face of `t` with the claim `u > t` is tested: `u` claims `t` across a face of its
//! own, with the same three vertices turned the other way. Faces of one tetrahedron differ, so
//! this maps the faces with a claim `u > t` one to one into those with a claim `u < t`; if the
//! numbers of both are equal, onto them: the claims are pairs.

use crate::chunks::{Levels, Partial, pieces};
use crate::defect::Findings;
use crate::geometry::Oriented;
use crate::hull;
use crate::mesh::{Mesh, NO_NEIGHBOUR, Options, Point, Side, face, split};
use crate::perturb;
use crate::predicates::{Sphere, Tally};
use crate::topology::{self, Hull};
use std::ops::Range;

/// The counts that the report gives of a mesh that was proved.
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
    let totals = Totals::all(mesh, claims, canonical)?;
    let facets = &totals.hull;
    let mut findings = Findings::new(options.max_defects);
    topology::claimed_hull(mesh, facets, &mut findings);
    let surface = topology::hull(mesh, facets, &mut findings);
    findings.merge(topology::hull_euler(mesh, facets, &surface));

    let oriented = Oriented::positive(mesh, totals.volume / 6.0);
    let limit = options.max_defects;
    let Levels { delaunay: mut part, canonical: ties } =
        hull::edges(&oriented, facets, &surface.pairs, canonical, limit);
    part.merge(hull::once_around(&oriented, facets, 0, limit));
    let holds = |part: &Partial| part.findings.counts.is_empty() && part.untested == 0;
    if !findings.counts.is_empty() || !holds(&part) || !holds(&ties) {
        return None;
    }
    let (mut delaunay, mut perturbed) = (totals.delaunay, totals.canonical);
    delaunay.merge(part.tally);
    perturbed.merge(ties.tally);
    Some(Proof {
        orientation: totals.orientation,
        delaunay,
        canonical: perturbed,
        volume: oriented.volume,
        hull_facets: facets.len() as u64,
        faces: totals.above + facets.len() as u64,
        hull: surface,
    })
}

/// The result of a sweep over tetrahedra if all of its tests hold.
#[derive(Default)]
struct Totals {
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

impl Totals {
    fn all(mesh: &Mesh, claims: &[[u32; 4]], canonical: bool) -> Option<Self> {
        let parts = pieces(mesh.tets.len(), |range| {
            let (mut part, mut block) = (Self::default(), Block::default());
            for first in range.clone().step_by(BLOCK) {
                let tets = first..range.end.min(first + BLOCK);
                block.fill(mesh, claims, tets.clone(), &mut part)?;
                part.geometry(mesh, tets, &block.joints, canonical)?;
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

    /// Tests the tetrahedra `tets` with their `joints`; `None` if a test fails.
    fn geometry(
        &mut self,
        mesh: &Mesh,
        tets: Range<usize>,
        joints: &[Joint],
        canonical: bool,
    ) -> Option<()> {
        let mut joints = joints.iter().peekable();
        for t in tets {
            let corners = mesh.tets[t].map(|v| &mesh.points[v as usize]);
            let sphere = Sphere::new(corners);
            if sphere.orientation(&mut self.orientation) <= 0 {
                return None;
            }
            self.volume += sphere.volume6();
            while let Some(Joint { apex, .. }) = joints.next_if(|joint| split(joint.code).t == t) {
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

/// Tetrahedra whose neighbours are looked up together.
const BLOCK: usize = 64;

/// The faces of a block of tetrahedra towards larger ones, and what lies behind them.
///
/// Neighbours are anywhere in memory. Looking up those of a whole block, one kind of thing after
/// the other, lets the processor wait for many of them at once.
#[derive(Default)]
struct Block {
    joints: Vec<Joint>,
}

/// A face towards a larger tetrahedron.
#[derive(Clone, Copy)]
struct Joint {
    /// `4 * tet + face`.
    code: u32,
    /// The claimed neighbour, its vertices and its own claims.
    claim: u32,
    other: [u32; 4],
    back: [u32; 4],
    /// The vertex of the neighbour opposite the face.
    apex: Point,
}

impl Block {
    /// Looks up the neighbours of `tets` and tests that the claims are mutual and the faces the
    /// same, with opposite sides; `None` if not. Counts faces and collects those of the hull.
    fn fill(
        &mut self,
        mesh: &Mesh,
        claims: &[[u32; 4]],
        tets: Range<usize>,
        totals: &mut Totals,
    ) -> Option<()> {
        let empty = Joint { code: 0, claim: 0, other: [0; 4], back: [0; 4], apex: [0.0; 3] };
        self.joints.resize(4 * tets.len(), empty);
        // Whether a face counts here is chance: written always, kept if it does, no branch.
        let (mut count, mut on_hull) = (0, 0);
        for t in tets.clone() {
            for (i, &claim) in claims[t].iter().enumerate() {
                let joint = &mut self.joints[count];
                (joint.code, joint.claim) = ((4 * t + i) as u32, claim);
                let is_hull = claim == NO_NEIGHBOUR;
                on_hull += usize::from(is_hull);
                count += usize::from(!is_hull & (claim as usize >= t));
            }
        }
        self.joints.truncate(count);
        totals.above += count as u64;
        totals.below += (4 * tets.len() - count - on_hull) as u64;
        if on_hull > 0 {
            let codes = (4 * tets.start as u32..).zip(claims[tets].as_flattened());
            totals.hull.extend(codes.filter(|&(_, &c)| c == NO_NEIGHBOUR).map(|(code, _)| code));
        }
        for joint in &mut self.joints {
            joint.other = *mesh.tets.get(joint.claim as usize)?;
            joint.back = *claims.get(joint.claim as usize)?;
        }
        for joint in &mut self.joints {
            let Side { t, i } = split(joint.code);
            let j = side_of(t as u32, &joint.back)?;
            if !are_opposite(face(&mesh.tets[t], i), face(&joint.other, j)) {
                return None;
            }
            joint.apex = *mesh.points.get(joint.other[j] as usize)?;
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
