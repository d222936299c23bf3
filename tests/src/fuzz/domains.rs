//! `domains`: bytes to a small domain, checked and prepared.
//!
//! The bytes: 4 of style and 4 of plan, then cells of 4 bytes. The plan says how many of them are
//! vertices ([`snap`]), which solid there is to begin with, layers by the style's seed or one that
//! is made awkward (`spoil`); the others are polygons, segments, holes and regions.
//!
//! A domain that can be meshed is, and the counter of excuses judges the mesh.

use crate::excuses::{judge_refined, limits};
use crate::families::snap;
use crate::layered::{Stack, random_honeycomb, random_laminate};
use arbitrary::Unstructured;
use ltbw::Point;
use ltbw::domain::{
    CheckOptions, DefectKind, Domain, DomainReport, Facet, PrepareOptions, Prepared, Region,
};
use ltbw::refine::{RefineError, RefineOutcome, Refiner};

/// The most points of a mesh: many domains have details that would take more than there is time
/// for.
const POINTS: u64 = 2_000;

/// Corners of a tetrahedron and of a cube, in numbers of vertices, outward for the points of
/// [`corners`].
const TETRAHEDRON: &[&[u32]] = &[&[0, 2, 4], &[0, 4, 1], &[0, 1, 2], &[4, 2, 1]];
const CUBE: &[&[u32]] =
    &[&[0, 1, 3, 2], &[4, 6, 7, 5], &[0, 4, 5, 1], &[2, 3, 7, 6], &[0, 2, 6, 4], &[1, 5, 7, 3]];

/// The corners of a box from 0 to `size`, by bits.
fn corners(size: f64) -> impl Iterator<Item = Point> {
    (0..8u32).map(move |i| [i >> 2, i >> 1 & 1, i & 1].map(|b| f64::from(b & 1) * size))
}

/// The domain of some bytes.
#[must_use]
pub fn domain(bytes: &[u8]) -> Domain {
    let mut u = Unstructured::new(bytes);
    // Zeros follow the last byte.
    let style: u32 = u.arbitrary().unwrap_or_default();
    let [count, solid, size, void]: [u8; 4] = u.arbitrary().unwrap_or_default();
    let (cells, _) = u.take_rest().as_chunks::<4>();
    let (points, parts) = cells.split_at(cells.len().min(usize::from(count % 12)));
    let mut domain = match solid / 32 {
        1 => Stack::random(style.into(), f64::from(size) * 10.0).domain(),
        2 => random_honeycomb(style.into()).1,
        3 => random_laminate(style.into()).1,
        _ => Domain::default(),
    };
    if solid % 4 != 0 {
        let first = domain.vertices.len() as u32;
        domain.vertices.extend(corners(f64::from(size % 9 + 1)));
        let faces = if solid % 4 == 1 { TETRAHEDRON } else { CUBE };
        domain.facets.extend(faces.iter().map(|face| {
            let corners: Vec<u32> = face.iter().map(|v| first + v).collect();
            Facet::polygon(&corners, 1)
        }));
    }
    if solid % 4 == 3 {
        // A smaller box inside, turned round.
        let first = domain.vertices.len() as u32;
        let place = f64::from(void % 16) / 4.0;
        domain.vertices.extend(corners(f64::from(void / 16)).map(|p| p.map(|c| c + place)));
        domain.facets.extend(CUBE.iter().map(|face| {
            let corners: Vec<u32> = face.iter().rev().map(|v| first + v).collect();
            Facet::polygon(&corners, 2)
        }));
    }
    spoil(&mut domain, solid / 4 % 8, f64::from(size % 9 + 1), void);
    domain.vertices.extend(snap(style, points));
    let n = domain.vertices.len().max(1) as u32;
    for &[kind, a, b, c] in &parts[..parts.len().min(24)] {
        let [i, j, k] = [a, b, c].map(|x| u32::from(x) % n);
        let place = [a, b, c].map(|x| f64::from(x) / 16.0);
        match kind % 8 {
            0..=2 => domain.facets.push(Facet::polygon(&[i, j, k], i32::from(kind))),
            3 => domain.facets.push(Facet::polygon(&[i, j, k, (i + 1) % n], 0)),
            4 => domain.segments.push(([i, j], i32::from(c))),
            5 => domain.holes.push(place),
            6 => {
                domain.regions.push(Region { seed: place, attribute: 1.0, max_volume: Some(0.5) });
            }
            // Another polygon, or a hole, in a facet that there is.
            _ => {
                let count = domain.facets.len().max(1);
                if let Some(facet) = domain.facets.get_mut(usize::from(kind / 8) % count) {
                    if a % 2 == 0 {
                        facet.polygons.push(vec![i, j, k]);
                    } else {
                        facet.holes.push(place);
                    }
                }
            }
        }
    }
    domain
}

/// Makes a domain awkward: nearly coplanar corners, a needle, a sharp edge, bodies that touch.
fn spoil(domain: &mut Domain, how: u8, size: f64, amount: u8) {
    let tiny = 2.0_f64.powi(-i32::from(amount % 40));
    let first = domain.vertices.len() as u32;
    let mut body = |faces: &[&[u32]], place: &dyn Fn(Point) -> Point| {
        domain.vertices.extend(corners(size).map(place));
        let turned = |face: &&[u32]| face.iter().map(|v| first + v).collect::<Vec<u32>>();
        domain.facets.extend(faces.iter().map(|face| Facet::polygon(&turned(face), 3)));
    };
    match how {
        1 => {
            for (i, p) in (1..).zip(&mut domain.vertices) {
                p[2] += f64::from(i % 5) * tiny * 2.0_f64.powi(-20);
            }
        }
        2 => body(TETRAHEDRON, &|[x, y, z]| [x + 2.0 * size, y * tiny, z * tiny]),
        // A sheet that leaves the floor at an edge, at a small angle.
        3 if first > 1 => {
            domain.vertices.push([size / 2.0, size / 2.0, size * tiny]);
            domain.facets.push(Facet::polygon(&[0, 1, first], 4));
        }
        4 => body(CUBE, &|[x, y, z]| [x + size, y, z]),
        5 => body(CUBE, &|[x, y, z]| [x + size, y + size, z]),
        6 => body(CUBE, &|[x, y, z]| [x + size, y + size / 2.0, z + size * tiny]),
        7 => body(CUBE, &|[x, y, z]| [x + size + tiny * 2.0_f64.powi(-20), y, z]),
        _ => {}
    }
}

/// This domain, with its facets in the opposite order and their corners turned on by one.
fn told_otherwise(domain: &Domain) -> Domain {
    let mut other = domain.clone();
    other.facets.reverse();
    for polygon in other.facets.iter_mut().flat_map(|f| &mut f.polygons) {
        polygon.rotate_left(1);
    }
    other
}

/// Checks and prepares the domain of `bytes`, in both meanings of its facets.
///
/// # Panics
/// If the check panics or its verdict depends on the order of things, if a prepared domain is not
/// one or has a mesh that leaves too much over its bound, or if the reason for a refusal is not one
/// line.
pub fn domains(bytes: &[u8]) {
    let domain = domain(bytes);
    for oriented in [false, true] {
        let options = CheckOptions { oriented, ..CheckOptions::default() };
        let verdict = |domain: &Domain| domain.check(&options).map(|report| verdict_of(&report));
        match (verdict(&domain), verdict(&told_otherwise(&domain))) {
            (Ok(Some(one)), Ok(Some(other))) => {
                assert_eq!(one, other, "oriented {oriented}: {domain:?}");
            }
            (Ok(_), Ok(_)) => {}
            (Err(error), Err(_)) => one_line(&error.to_string()),
            (one, other) => panic!("{one:?}, told otherwise {other:?}: {domain:?}"),
        }
        let plain = PrepareOptions { oriented, ..PrepareOptions::default() };
        prepare(&domain, &plain);
        prepare(&domain, &PrepareOptions { repair: tolerance(&domain), ..plain });
    }
}

/// A tolerance as large as they may be, nearly.
fn tolerance(domain: &Domain) -> f64 {
    let (low, high) = domain.bounds().unwrap_or_default();
    (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max) / 2048.0
}

/// Refines a prepared domain with a budget.
///
/// # Panics
/// If the mesh is not sound, or more of it is over the bound than the angles of the domain excuse.
fn refine(domain: &Domain, ready: &Prepared) {
    let refiner = Refiner::new().one_thread().max_points(POINTS);
    let refined = match refiner.refine(&ready.domain, &ready.lattice) {
        Ok(refined) => refined,
        Err(error @ RefineError::Invariant { .. }) => panic!("{error}: {domain:?}"),
        Err(error) => return one_line(&error.to_string()),
    };
    if matches!(refined.outcome, RefineOutcome::Met | RefineOutcome::Excused) {
        let bounds = limits(&ready.domain, Some(2.0), None);
        let judged = judge_refined(ready, &refined, &bounds);
        let (_, count) = judged.unwrap_or_else(|defect| panic!("{defect}: {domain:?}"));
        assert!(!count.is_broken(), "{count}: {domain:?}");
    }
}

/// Prepares a domain; what is prepared stays as it is if that is done again, and can be meshed.
fn prepare(domain: &Domain, options: &PrepareOptions) {
    match domain.prepare(options) {
        Err(error) => one_line(&error.to_string()),
        Ok(prepared) => {
            assert!(prepared.report.is_meshable(), "{domain:?}");
            prepared.repairs.notes().iter().for_each(|note| one_line(note));
            let again = prepared.domain.prepare(&PrepareOptions::default());
            let again = again.unwrap_or_else(|error| panic!("{error} once prepared: {domain:?}"));
            assert_eq!(again.moved, 0, "{domain:?}");
            let volumes = [&prepared.report, &again.report].map(DomainReport::volume);
            assert_eq!(volumes[0], volumes[1], "{domain:?}");
            refine(domain, &prepared);
        }
    }
}

/// The findings that must not depend on the order of facets. (In a domain with errors the order
/// does decide whether cells are told at all.) `None` if the check has given up on facets of nearly
/// no size, which is a matter of luck.
fn verdict_of(report: &DomainReport) -> Option<(bool, bool, Option<ltbw::domain::Volume>)> {
    let volume = if report.is_meshable() { report.volume() } else { None };
    let known = report.count(DefectKind::Unresolved) == 0;
    assert!(known || !report.is_meshable());
    known.then(|| (report.is_meshable(), report.passed(), volume))
}

fn one_line(text: &str) {
    assert!(!text.is_empty() && !text.contains('\n'), "{text:?}");
}

#[cfg(test)]
mod tests {
    use super::{domain, domains};

    #[test]
    fn the_solids_are_sound() {
        let touching = [[0, 2 + 4 * 4, 3, 0], [0, 2 + 4 * 5, 3, 0]];
        let needle = [[0, 2 + 4 * 2, 3, 12], [0, 2 + 4 * 3, 3, 12], [0, 2 + 4, 3, 4]];
        let plain = [[0, 1, 0, 0], [0, 2, 3, 0], [0, 3, 7, 0x24]];
        let layers = [[0, 32, 12, 0], [0, 64, 0, 0], [0, 96, 0, 0]];
        for solid in plain.into_iter().chain(touching).chain(needle).chain(layers) {
            let bytes = [[0; 4], solid].concat();
            let prepared = domain(&bytes).prepare(&Default::default());
            assert!(prepared.is_ok(), "{solid:?}: {:?}", prepared.err());
            domains(&bytes);
        }
    }
}
