//! Levels *orientation*, *Delaunay* and *canonical* inside the mesh: one exact test per
//! tetrahedron and one per interior face. The hull's part is in `hull.rs`.

use crate::chunks::{Levels, Partial, pieces};
use crate::defect::{Findings, Kind};
use crate::determinant::{det3, differences};
use crate::faces::Faces;
use crate::mesh::{Mesh, Point, Side, VertexOrder, face};
use crate::perturb;
use crate::predicates::{Sphere, Tally, insphere, orient3d};

/// The mesh with every tetrahedron's exact sign.
pub(crate) struct Oriented<'a> {
    pub(crate) mesh: &'a Mesh<'a>,
    /// 1, -1, or 0 for flat; 0 for unsound ones too.
    signs: Vec<i8>,
    /// Sum of the absolute volumes, rounded.
    pub(crate) volume: f64,
    pub(crate) positive: u64,
    pub(crate) negative: u64,
}

impl<'a> Oriented<'a> {
    /// A mesh of positive tetrahedra alone.
    pub(crate) fn positive(mesh: &'a Mesh<'a>, volume: f64) -> Self {
        let count = mesh.tets.len();
        Self { mesh, signs: vec![1; count], volume, positive: count as u64, negative: 0 }
    }

    /// Whether all of the mesh is negative.
    pub(crate) fn is_mirrored(&self) -> bool {
        self.negative > 0 && self.positive == 0
    }

    /// The sign of a tetrahedron.
    pub(crate) fn sign(&self, t: usize) -> i8 {
        self.signs[t]
    }

    /// The vertices of tetrahedron `t` turned to positive.
    pub(crate) fn positive_tet(&self, t: usize) -> [u32; 4] {
        let [a, b, c, d] = self.mesh.tets[t];
        if self.signs[t] < 0 { [a, b, d, c] } else { [a, b, c, d] }
    }

    /// The face of `t` opposite its vertex in place `i` of the given order, turned outward.
    pub(crate) fn outward(&self, t: usize, i: usize) -> [u32; 3] {
        let [a, b, c] = face(&self.mesh.tets[t], i);
        if self.signs[t] < 0 { [a, c, b] } else { [a, b, c] }
    }

    pub(crate) fn at(&self, v: u32) -> &Point {
        &self.mesh.points[v as usize]
    }

    /// The exact in-sphere sign of `v` in the tetrahedron `t`, which must not be flat.
    pub(crate) fn in_sphere(&self, t: usize, v: u32, tally: &mut Tally) -> i8 {
        let [a, b, c, d] = self.positive_tet(t).map(|v| self.at(v));
        insphere([a, b, c, d, self.at(v)], tally)
    }
}

/// The signs of all sound tetrahedra.
pub(crate) fn signs<'a>(mesh: &'a Mesh, sound: &[bool]) -> (Oriented<'a>, Tally) {
    let parts = pieces(mesh.tets.len(), |range| {
        let mut tally = Tally::default();
        let mut volume = 0.0;
        let signs: Vec<i8> = range
            .map(|t| match sound[t] {
                true => {
                    let corners = mesh.tets[t].map(|v| &mesh.points[v as usize]);
                    volume += rounded_volume6(corners);
                    orient3d(corners, &mut tally)
                }
                false => 0,
            })
            .collect();
        (signs, tally, volume)
    });
    let mut tally = Tally::default();
    let mut signs = Vec::with_capacity(mesh.tets.len());
    let mut volume = 0.0;
    for (part, t, v) in parts {
        signs.extend(part);
        tally.merge(t);
        volume += v;
    }
    let count = |sign| signs.iter().filter(|&&s| s == sign).count() as u64;
    let (positive, negative) = (count(1), count(-1));
    (Oriented { mesh, signs, volume: volume / 6.0, positive, negative }, tally)
}

/// Six times the absolute volume, rounded.
fn rounded_volume6([a, b, c, d]: [&Point; 4]) -> f64 {
    det3(&differences([b, c, d], a)).abs()
}

/// Names flat and inverted tetrahedra and folded faces.
pub(crate) fn orientation(
    mesh: &Oriented,
    faces: &Faces,
    sound: &[bool],
    order: VertexOrder,
    limit: usize,
) -> Partial {
    let names_inverted = order == VertexOrder::Oriented && !mesh.is_mirrored();
    let parts = pieces(sound.len(), |range| {
        let mut part = Partial::new(limit);
        for t in range.filter(|&t| sound[t]) {
            let tet = &mesh.mesh.tets[t];
            match mesh.sign(t) {
                0 => part.findings.add(Kind::FlatTet, &[t as u32], tet),
                -1 if names_inverted => part.findings.add(Kind::InvertedTet, &[t as u32], tet),
                _ => {}
            }
            for i in 0..4 {
                let own = Side { t, i };
                let Some(other) = faces.other(t, i).filter(|other| t < other.t) else { continue };
                match fold(mesh, own, other) {
                    None => part.untested += 1,
                    Some(false) => {}
                    Some(true) => {
                        report(&mut part.findings, Kind::FoldedFace, mesh, own, other);
                    }
                }
            }
        }
        part
    });
    let mut out = Partial::new(limit);
    parts.into_iter().for_each(|part| out.merge(part));
    out
}

/// Whether two neighbours lie in space on the same side of their face; `None` if one is flat.
/// Both are turned to positive, so they lie on opposite sides exactly if their outward faces
/// turn opposite ways.
pub(crate) fn fold(mesh: &Oriented, one: Side, other: Side) -> Option<bool> {
    if mesh.sign(one.t) == 0 || mesh.sign(other.t) == 0 {
        return None;
    }
    let [a, b, c] = mesh.outward(one.t, one.i);
    let other = mesh.outward(other.t, other.i);
    Some([[a, b, c], [b, c, a], [c, a, b]].contains(&other))
}

/// The vertices of a face, then both apexes.
fn face_and_apexes(mesh: &Oriented, one: Side, other: Side) -> [u32; 5] {
    let [a, b, c] = mesh.outward(one.t, one.i);
    let apex = |side: Side| mesh.mesh.tets[side.t][side.i];
    [a, b, c, apex(one), apex(other)]
}

/// Tests every interior face: exactly locally Delaunay, and, if `canonical`, with ties as the
/// perturbation has them.
pub(crate) fn delaunay(mesh: &Oriented, faces: &Faces, canonical: bool, limit: usize) -> Levels {
    let parts = pieces(mesh.mesh.tets.len(), |range| {
        let Levels { delaunay: mut part, canonical: mut ties } = Levels::new(limit);
        for t in range {
            let corners = mesh.positive_tet(t).map(|v| mesh.mesh.points.get(v as usize));
            let [Some(a), Some(b), Some(c), Some(d)] = corners else { continue };
            let sphere = Sphere::new([a, b, c, d]);
            for i in 0..4 {
                let own = Side { t, i };
                let Some(other) = faces.other(t, i).filter(|other| t < other.t) else { continue };
                if fold(mesh, own, other) != Some(false) {
                    part.untested += 1;
                    ties.untested += 1;
                    continue;
                }
                let apex = mesh.mesh.tets[other.t][other.i];
                let sign = sphere.side(mesh.at(apex), &mut part.tally);
                if sign > 0 {
                    report(&mut part.findings, Kind::NotDelaunay, mesh, own, other);
                }
                let tie = sign == 0 && canonical;
                if tie && perturb::side([a, b, c, d], mesh.at(apex), &mut ties.tally) > 0 {
                    report(&mut ties.findings, Kind::NotCanonical, mesh, own, other);
                }
            }
        }
        Levels { delaunay: part, canonical: ties }
    });
    Partial::both(parts, limit)
}

fn report(out: &mut Findings, kind: Kind, mesh: &Oriented, one: Side, other: Side) {
    out.add(kind, &[one.t as u32, other.t as u32], &face_and_apexes(mesh, one, other));
}
