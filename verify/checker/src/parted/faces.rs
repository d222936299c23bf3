//! Faces that a part has once meet by the numbers of their vertices: two are a pair, one is a facet
//! of the hull.
//!
//! A face travels with its whole tetrahedron, so that the exact tests of the pair are made where
//! the two meet.

use super::exchange::{Exchange, Record, deal, member_of};
use super::found::{Corner, Found};
use crate::chunks::{Levels, Partial};
use crate::defect::Kind;
use crate::faces::{Faces, HULL};
use crate::geometry::Oriented;
use crate::mesh::{Point, split};
use crate::perturb;
use crate::predicates::Sphere;

/// A corner of a face that travels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vertex {
    /// Its number by coordinates.
    pub(crate) by_place: u32,
    pub(crate) corner: Corner,
}

/// A face of a tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Facet {
    /// Its vertices, outward if the tetrahedron is turned to positive, then the one opposite it.
    pub(crate) v: [Vertex; 4],
    /// The tetrahedron's number.
    pub(crate) tet: u32,
    /// Its sign.
    pub(crate) sign: i8,
    /// Its tag, if the mesh has some.
    pub(crate) tag: i64,
}

impl Record for Facet {
    const BYTES: usize = 4 * 32 + 16;

    fn put(&self, to: &mut Vec<u8>) {
        for Vertex { by_place, corner } in &self.v {
            by_place.put(to);
            corner.number.put(to);
            corner.at.put(to);
        }
        self.tet.put(to);
        (i32::from(self.sign) as u32).put(to);
        (self.tag as u64).put(to);
    }

    fn get(bytes: &[u8]) -> Self {
        let vertex = |k: usize| {
            let bytes = &bytes[32 * k..];
            let corner = Corner { number: u32::get(&bytes[4..]), at: Point::get(&bytes[8..]) };
            Vertex { by_place: u32::get(bytes), corner }
        };
        let sign = (u32::get(&bytes[132..]) as i32).signum() as i8;
        let (tet, tag) = (u32::get(&bytes[128..]), u64::get(&bytes[136..]) as i64);
        Self { v: std::array::from_fn(vertex), tet, sign, tag }
    }

    fn is_sound(&self) -> bool {
        self.v.iter().all(|v| v.corner.at.iter().all(|c| c.is_finite()))
    }
}

impl Facet {
    /// The numbers of its vertices, ascending: the same for both sides of a face.
    pub(crate) fn key(&self) -> [u32; 3] {
        let [a, b, c, _] = self.v.map(|v| v.by_place);
        let mut key = [a, b, c];
        key.sort_unstable();
        key
    }

    /// The coordinates of its vertices, outward.
    pub(crate) fn outward(&self) -> [&Point; 3] {
        let [a, b, c, _] = &self.v;
        [a, b, c].map(|v| &v.corner.at)
    }

    /// The vertex opposite it.
    pub(crate) fn apex(&self) -> &Vertex {
        &self.v[3]
    }

    /// Its tetrahedron, positive.
    pub(crate) fn positive(&self) -> [&Point; 4] {
        let [a, b, c, d] = &self.v;
        [a, c, b, d].map(|v| &v.corner.at)
    }

    /// Whether the outward faces of two tetrahedra that share a face turn the same way: then both
    /// lie on one side of it.
    fn is_folded(&self, other: &Self) -> bool {
        let [a, b, c, _] = self.v.map(|v| v.by_place);
        let [x, y, z, _] = other.v.map(|v| v.by_place);
        [[a, b, c], [b, c, a], [c, a, b]].contains(&[x, y, z])
    }
}

/// The faces of a part that are not of two of its tetrahedra.
pub(crate) fn surface<'a>(
    mesh: &'a Oriented<'a>,
    faces: &'a Faces,
    names: impl Fn(u32) -> Vertex + 'a,
    first: u32,
    tags: Option<&'a [i64]>,
) -> impl Iterator<Item = Facet> + 'a {
    debug_assert!(faces.hull.iter().all(|&code| faces.across[code as usize] == HULL));
    faces.hull.iter().map(move |&code| {
        let side = split(code);
        let [a, b, c] = mesh.outward(side.t, side.i);
        let v = [a, b, c, mesh.mesh.tets[side.t][side.i]].map(&names);
        let tag = tags.and_then(|tags| tags.get(side.t)).copied().unwrap_or_default();
        Facet { v, tet: first.saturating_add(side.t as u32), sign: mesh.sign(side.t), tag }
    })
}

/// The faces that have met at this member.
pub(crate) struct Met {
    /// Facets of the hull, in the order of their vertices.
    pub(crate) hull: Vec<Facet>,
    /// Pairs of faces, in the same order, if they are kept.
    pub(crate) pairs: Vec<[Facet; 2]>,
    /// Different faces.
    pub(crate) count: u64,
    /// The tests of orientation: none but folds.
    pub(crate) orientation: Partial,
    /// The tests of pairs.
    pub(crate) levels: Levels,
}

/// Demands on the faces that meet.
#[derive(Clone, Copy)]
pub(crate) struct Asked {
    /// Ties are tested.
    pub(crate) canonical: bool,
    /// Pairs are kept.
    pub(crate) pairs: bool,
}

/// Lets the surfaces of all parts meet.
pub(crate) fn meet<E: Exchange>(
    team: &mut E,
    surface: impl Iterator<Item = Facet>,
    asked: Asked,
    found: &mut Found,
) -> Result<Met, E::Error> {
    let members = team.members();
    let all = deal(team, surface, |facet| member_of(&facet.key(), members))?;
    let mut all: Vec<Facet> = all.into_iter().flatten().collect();
    all.sort_unstable_by_key(|facet| (facet.key(), facet.tet));
    let (orientation, levels) = (Partial::new(0), Levels::new(0));
    let (hull, pairs) = Default::default();
    let mut met = Met { hull, pairs, count: 0, orientation, levels };
    for group in all.chunk_by(|a, b| a.key() == b.key()) {
        met.count += 1;
        match group {
            [facet] => met.hull.push(*facet),
            [one, other] => {
                met.pair([one, other], asked.canonical, found);
                if asked.pairs {
                    met.pairs.push([*one, *other]);
                }
            }
            _ => {
                let tets: Vec<u32> = group.iter().map(|facet| facet.tet).collect();
                let [a, b, c, _] = group[0].v.map(|v| v.corner);
                found.add(Kind::FaceOverused, &tets, &[a, b, c]);
            }
        }
    }
    Ok(met)
}

impl Met {
    /// Tests the two tetrahedra of a face.
    fn pair(&mut self, [one, other]: [&Facet; 2], canonical: bool, found: &mut Found) {
        let Levels { delaunay, canonical: ties } = &mut self.levels;
        let is_flat = one.sign == 0 || other.sign == 0;
        if is_flat {
            self.orientation.untested += 1;
        }
        let mut report = |kind: Kind| {
            let [a, b, c, d] = one.v.map(|v| v.corner);
            found.add(kind, &[one.tet, other.tet], &[a, b, c, d, other.apex().corner]);
        };
        let is_folded = !is_flat && one.is_folded(other);
        if is_folded {
            report(Kind::FoldedFace);
        }
        if is_flat || is_folded {
            delaunay.untested += 1;
            ties.untested += 1;
            return;
        }
        let (corners, apex) = (one.positive(), &other.apex().corner.at);
        let sign = Sphere::new(corners).side(apex, &mut delaunay.tally);
        if sign > 0 {
            report(Kind::NotDelaunay);
        }
        let tie = sign == 0 && canonical;
        if tie && perturb::side(corners, apex, &mut ties.tally) > 0 {
            report(Kind::NotCanonical);
        }
    }
}
