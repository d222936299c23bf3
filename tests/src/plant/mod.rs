//! Defects planted into sound meshes: does the checker find every one, and call it by its name?
//!
//! A [`Subject`] is a sound mesh as plain lists. [`Plant::ALL`] lists the ways to spoil it; each
//! says at which level the first defect must be found and what it is called. What makes a plant a
//! defect is decided without the checker: by counting, by the exact oracle ([`crate::oracle`]), or
//! by the theorem that the canonical mesh of a point set is unique, so that any other set of
//! tetrahedra over all of its points is wrong.

mod flips;

use crate::oracle;
use ltbw::{Mesh, Point, Sign};
use ltbw_verify::{Depth, Kind, Level, NO_NEIGHBOUR, Options, Report, check};
use std::collections::HashMap;

/// A mesh as plain lists, with the claims that the checker verifies.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Subject {
    /// Points; each is a vertex.
    pub points: Vec<Point>,
    /// Positive tetrahedra.
    pub tets: Vec<[u32; 4]>,
    /// Claimed neighbours, opposite each vertex.
    pub neighbours: Vec<[u32; 4]>,
    /// Claimed hull facets.
    pub hull: Vec<[u32; 3]>,
}

impl Subject {
    /// The lists of a mesh; its vertices, renumbered.
    #[must_use]
    pub fn of(mesh: &Mesh) -> Self {
        let vertices: Vec<(u32, Point)> = mesh.vertices().collect();
        let number: HashMap<u32, u32> = vertices.iter().map(|v| v.0).zip(0..).collect();
        let ids: HashMap<u32, u32> = mesh.tet_ids().zip(0..).collect();
        let neighbour =
            |t: u32, slot: usize| mesh.neighbour(t, slot).map_or(NO_NEIGHBOUR, |u| ids[&u]);
        Self {
            points: vertices.iter().map(|v| v.1).collect(),
            tets: mesh.tets().map(|t| t.map(|v| number[&v])).collect(),
            neighbours: mesh.tet_ids().map(|t| [0, 1, 2, 3].map(|s| neighbour(t, s))).collect(),
            hull: mesh.hull_facets().map(|f| f.map(|v| number[&v])).collect(),
        }
    }

    fn at(&self, v: u32) -> &Point {
        &self.points[v as usize]
    }

    /// Exact orientation of four vertices.
    fn orient(&self, [a, b, c, d]: [u32; 4]) -> Sign {
        oracle::orient3d(self.at(a), self.at(b), self.at(c), self.at(d))
    }

    /// Makes the claims those of the tetrahedra as they are: a face has the neighbour that shares
    /// it (of several, the first), and is a hull facet if none does.
    fn claim(&mut self) {
        let mut faces: HashMap<[u32; 3], Vec<u32>> = HashMap::new();
        for (tet, t) in self.tets.iter().zip(0..) {
            (0..4).for_each(|i| faces.entry(sorted(opposite(tet, i))).or_default().push(t));
        }
        let other = |tet: &[u32; 4], t: u32, i: usize| {
            let owners = &faces[&sorted(opposite(tet, i))];
            owners.iter().find(|&&u| u != t).copied().unwrap_or(NO_NEIGHBOUR)
        };
        let tets = self.tets.iter().zip(0..);
        self.neighbours = tets.map(|(tet, t)| [0, 1, 2, 3].map(|i| other(tet, t, i))).collect();
        let all = self.tets.iter().zip(&self.neighbours);
        let hull = all.flat_map(|(tet, n)| {
            (0..4).filter(|&i| n[i] == NO_NEIGHBOUR).map(|i| opposite(tet, i))
        });
        self.hull = hull.collect();
    }

    /// The checker's report, with or without the claims.
    fn report(&self, depth: Depth, claims: bool) -> Report {
        let options = Options { depth, all_points: true, ..Options::default() };
        let view = ltbw_verify::Mesh::new(&self.points, &self.tets);
        if claims {
            check(&view.with_neighbours(&self.neighbours).with_hull(&self.hull), &options)
        } else {
            check(&view, &options)
        }
    }

    /// The checker passes this mesh, in every way of asking; else its defects.
    pub fn passes(&self) -> Result<(), String> {
        for depth in [Depth::Fast, Depth::Full] {
            for claims in [false, true] {
                let report = self.report(depth, claims);
                if !report.passed() || report.mirrored {
                    return Err(format!("{depth:?}, claims {claims}: {:?}", report.defects));
                }
            }
        }
        Ok(())
    }
}

/// The face opposite vertex `i`, outward.
fn opposite([a, b, c, d]: &[u32; 4], i: usize) -> [u32; 3] {
    match i {
        0 => [*b, *c, *d],
        1 => [*a, *d, *c],
        2 => [*a, *b, *d],
        _ => [*a, *c, *b],
    }
}

fn sorted<const N: usize>(mut row: [u32; N]) -> [u32; N] {
    row.sort_unstable();
    row
}

/// What the checker must say of a planted defect.
#[derive(Debug, Clone, Copy)]
struct Expected {
    /// The first level that fails is one of these.
    levels: &'static [Level],
    /// One of these is reported.
    kinds: &'static [Kind],
    /// Only the claims are wrong: without them the mesh is sound.
    in_claims: bool,
}

impl Expected {
    const fn new(levels: &'static [Level], kinds: &'static [Kind]) -> Self {
        Self { levels, kinds, in_claims: false }
    }
}

/// A way to spoil a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names say it; `spoil` says it precisely")]
pub enum Plant {
    FlippedTet,
    SwappedNeighbours,
    WrongNeighbour,
    MissingHullFacet,
    ForeignHullFacet,
    VertexMovedBeyond,
    VertexMovedOntoAnother,
    VertexNotFinite,
    MissingTet,
    DuplicatedTet,
    ForeignTet,
    SecondBody,
    RepeatedVertex,
    IndexOutOfRange,
    RenamedVertex,
    ForgottenPoint,
    Flip23,
    Flip32,
    Flip44,
    Flip22,
}

const STRUCTURE: &[Level] = &[Level::Structure];
const TOPOLOGY: &[Level] = &[Level::Topology];
const TIES: &[Kind] = &[Kind::NotCanonical, Kind::HullNotCanonical];
/// What other tetrahedra over the same points may break first.
const TILING: Expected = Expected::new(
    &[Level::Structure, Level::Topology, Level::Orientation, Level::Delaunay],
    &[
        Kind::PointLeftOut,
        Kind::DuplicateTet,
        Kind::FaceOverused,
        Kind::SameSide,
        Kind::HullEdge,
        Kind::Disconnected,
        Kind::HullDisconnected,
        Kind::HullEuler,
        Kind::Euler,
        Kind::VertexLink,
        Kind::FlatTet,
        Kind::InvertedTet,
        Kind::FoldedFace,
        Kind::ConcaveHull,
        Kind::HullTurnedAway,
        Kind::HullWoundTwice,
        Kind::NotDelaunay,
    ],
);

impl Plant {
    /// Every way.
    pub const ALL: [Self; 20] = [
        Self::FlippedTet,
        Self::SwappedNeighbours,
        Self::WrongNeighbour,
        Self::MissingHullFacet,
        Self::ForeignHullFacet,
        Self::VertexMovedBeyond,
        Self::VertexMovedOntoAnother,
        Self::VertexNotFinite,
        Self::MissingTet,
        Self::DuplicatedTet,
        Self::ForeignTet,
        Self::SecondBody,
        Self::RepeatedVertex,
        Self::IndexOutOfRange,
        Self::RenamedVertex,
        Self::ForgottenPoint,
        Self::Flip23,
        Self::Flip32,
        Self::Flip44,
        Self::Flip22,
    ];

    /// Spoils the mesh at a place that `choice` names: what the checker must say. `None` where this
    /// plant does not grow.
    fn spoil(self, mesh: &mut Subject, choice: usize) -> Option<Expected> {
        let (tet, slot) = (choice / 4 % mesh.tets.len(), choice % 4);
        let (tets, points) = (mesh.tets.len() as u32, mesh.points.len() as u32);
        let vertex = choice as u32 % points;
        let claims = |kinds| Some(Expected { in_claims: true, ..Expected::new(TOPOLOGY, kinds) });
        match self {
            Self::FlippedTet => {
                // A mesh of one is mirrored then, which is no defect.
                (tets > 1).then_some(())?;
                mesh.tets[tet].swap(slot, (slot + 1) % 4);
                mesh.neighbours[tet].swap(slot, (slot + 1) % 4);
                Some(Expected::new(TOPOLOGY, &[Kind::InvertedTet]))
            }
            Self::SwappedNeighbours => {
                let n = &mut mesh.neighbours[tet];
                let other = (0..4).find(|&i| n[i] != n[slot])?;
                n.swap(slot, other);
                claims(&[Kind::WrongNeighbour])
            }
            Self::WrongNeighbour => {
                let n = &mut mesh.neighbours[tet][slot];
                let wrong = [tet as u32, tets, NO_NEIGHBOUR, choice as u32 % tets];
                *n = wrong.into_iter().cycle().skip(choice / 16 % 4).find(|w| *w != *n)?;
                claims(&[Kind::WrongNeighbour])
            }
            Self::MissingHullFacet => {
                mesh.hull.swap_remove(choice % mesh.hull.len());
                claims(&[Kind::HullFacetMissing])
            }
            Self::ForeignHullFacet => {
                let inner = (0..4).find(|&i| mesh.neighbours[tet][i] != NO_NEIGHBOUR);
                let facet = inner.map_or(mesh.hull[0], |i| opposite(&mesh.tets[tet], i));
                mesh.hull.push(facet);
                claims(&[Kind::HullFacetExtra])
            }
            Self::VertexMovedBeyond => beyond(mesh, tet, slot),
            Self::VertexMovedOntoAnother => {
                let other = (vertex + 1 + choice as u32 / points % (points - 1)) % points;
                mesh.points[vertex as usize] = mesh.points[other as usize];
                Some(Expected::new(STRUCTURE, &[Kind::EqualVertices]))
            }
            Self::VertexNotFinite => {
                let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][choice % 3];
                mesh.points[vertex as usize][slot % 3] = bad;
                Some(Expected::new(STRUCTURE, &[Kind::NotFinite]))
            }
            Self::MissingTet => {
                mesh.tets.swap_remove(tet);
                mesh.claim();
                let only = Expected::new(STRUCTURE, &[Kind::Empty]);
                Some(if tets == 1 { only } else { TILING })
            }
            Self::DuplicatedTet => {
                let mut copy = mesh.tets[tet];
                copy.rotate_left(slot);
                mesh.tets.push(copy);
                mesh.claim();
                Some(Expected::new(STRUCTURE, &[Kind::DuplicateTet]))
            }
            Self::ForeignTet => foreign(mesh, choice),
            Self::SecondBody => second_body(mesh, tet),
            Self::RepeatedVertex => {
                mesh.tets[tet][slot] = mesh.tets[tet][(slot + 1) % 4];
                Some(Expected::new(STRUCTURE, &[Kind::RepeatedVertex]))
            }
            Self::IndexOutOfRange => {
                mesh.tets[tet][slot] = if choice.is_multiple_of(3) { u32::MAX } else { points };
                Some(Expected::new(STRUCTURE, &[Kind::IndexOutOfRange]))
            }
            Self::RenamedVertex => {
                (!mesh.tets[tet].contains(&vertex)).then_some(())?;
                mesh.tets[tet][slot] = vertex;
                mesh.claim();
                Some(TILING)
            }
            Self::ForgottenPoint => {
                let [a, b] = [0, 1].map(|k| mesh.points[mesh.tets[tet][k] as usize]);
                let middle = std::array::from_fn(|k| a[k] / 2.0 + b[k] / 2.0);
                (!mesh.points.contains(&middle)).then_some(())?;
                mesh.points.push(middle);
                Some(Expected::new(STRUCTURE, &[Kind::PointLeftOut]))
            }
            Self::Flip23 => flips::flip23(mesh, tet, slot),
            Self::Flip32 => flips::flip32(mesh, tet, choice),
            Self::Flip44 => flips::flip44(mesh, tet, choice),
            Self::Flip22 => flips::flip22(mesh, tet, choice),
        }
    }
}

/// Moves a vertex of a tetrahedron through its opposite face, to its mirror image in the face's
/// centre. Some tetrahedra stay positive: else it may be the mirror image of a mesh.
fn beyond(mesh: &mut Subject, tet: usize, slot: usize) -> Option<Expected> {
    let v = mesh.tets[tet][slot];
    let face = opposite(&mesh.tets[tet], slot).map(|w| *mesh.at(w));
    let old = *mesh.at(v);
    let new = std::array::from_fn(|k| {
        2.0 * (face[0][k] / 3.0 + face[1][k] / 3.0 + face[2][k] / 3.0) - old[k]
    });
    let distinct = !mesh.points.contains(&new) && new.iter().all(|c| c.is_finite());
    if !distinct {
        return None;
    }
    mesh.points[v as usize] = new;
    let signs: Vec<Sign> = mesh.tets.iter().map(|&t| mesh.orient(t)).collect();
    if signs[tet] == Sign::Negative && signs.contains(&Sign::Positive) {
        return Some(Expected::new(&[Level::Orientation], &[Kind::InvertedTet]));
    }
    mesh.points[v as usize] = old;
    None
}

/// Adds a copy of a tetrahedron elsewhere.
fn second_body(mesh: &mut Subject, tet: usize) -> Option<Expected> {
    let n = mesh.points.len() as u32;
    let copy = mesh.tets[tet].map(|v| mesh.at(v).map(|c| c + 4.0 * c.abs() + 4.0));
    if !copy.iter().all(|p| p.iter().all(|c| c.is_finite()) && !mesh.points.contains(p)) {
        return None;
    }
    mesh.points.extend(copy);
    let body = [n, n + 1, n + 2, n + 3];
    mesh.tets.push(match mesh.orient(body) {
        Sign::Positive => body,
        Sign::Negative => [n + 1, n, n + 2, n + 3],
        Sign::Zero => return None,
    });
    mesh.claim();
    Some(Expected::new(TOPOLOGY, &[Kind::Disconnected]))
}

/// Adds a tetrahedron of the mesh's own vertices that it does not have.
fn foreign(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let n = mesh.points.len();
    let corner = |k: u32| (choice / n.pow(k) % n) as u32;
    let new = [corner(0), corner(1), corner(2), (choice * 7 % n) as u32];
    let four = (0..4).all(|i| !new[..i].contains(&new[i]));
    if !four || mesh.tets.iter().any(|t| sorted(*t) == sorted(new)) {
        return None;
    }
    mesh.tets.push(new);
    mesh.claim();
    Some(TILING)
}

/// Plants a defect and asks the checker, in every way of asking. `Ok(false)` where the plant does
/// not grow.
///
/// # Errors
/// Which defect was overlooked, or called by a wrong name.
pub fn try_plant(mesh: &Subject, plant: Plant, choice: usize) -> Result<bool, String> {
    let mut spoilt = mesh.clone();
    let Some(expected) = plant.spoil(&mut spoilt, choice) else {
        return Ok(false);
    };
    for claims in [false, true] {
        for depth in [Depth::Full, Depth::Fast] {
            let report = spoilt.report(depth, claims);
            let ask =
                || format!("{plant:?} {choice}, {depth:?}, claims {claims}: {:?}", report.defects);
            // Without its claims, the mesh is sound; ties are the business of the full depth.
            let ties = expected.kinds == TIES;
            if (expected.in_claims && !claims) || (ties && depth == Depth::Fast) {
                if !report.passed() {
                    return Err(format!("accused in vain: {}", ask()));
                }
                continue;
            }
            if report.passed() {
                return Err(format!("overlooked: {}", ask()));
            }
            let first = report.levels.iter().find(|l| l.defects > 0).map(|l| l.level);
            let at_level = first.is_some_and(|level| expected.levels.contains(&level));
            if !at_level || !expected.kinds.iter().any(|&kind| report.count(kind) > 0) {
                return Err(format!("not {expected:?}: {}", ask()));
            }
        }
    }
    Ok(true)
}
