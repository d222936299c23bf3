//! `protocol`: bytes to points, or a domain to refine in rounds, workers and an order of events;
//! the real mesh on the real protocol.
//!
//! The bytes: 4 of style, 12 of plan, then 4 for each of at most 150 points ([`snap`]), as many
//! as the plan says; every other byte chooses one event of [`interleave`](crate::interleave).
//! Where they end, a seed goes on. If bit 5 of `mix` is set there is a domain: its kind is from the
//! style, its bound from the count, and all bytes after the plan choose events.

use super::reference;
use crate::compare::{compare_mesh, refusal};
use crate::domains::prepared;
use crate::families::snap;
use crate::interleave::{Case, Chooser, Refusal, Tempo};
use arbitrary::Unstructured;
use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Closure, Rule};
use ltbw::refine::Refiner;
use ltbw::{Point, PointSet};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use std::sync::PoisonError;

/// Kinds of domains, and bounds of volumes that lead to 100 to 200 vertices.
const DOMAINS: [(DomainKind, f64); 6] = [
    (DomainKind::CubeOctahedron, 1e-2),
    (DomainKind::CubeInCube, 2e-2),
    (DomainKind::LBlock, 1e-2),
    (DomainKind::Stair, 2e-2),
    (DomainKind::TwoMaterial, 2e-2),
    (DomainKind::Schoenhardt, 5e-3),
];

/// The work of a run.
enum What {
    Points(Vec<Point>),
    Domain(DomainKind, f64),
}

/// The points or domain, the case and the choices of some bytes.
fn read(bytes: &[u8]) -> (What, Case, Chooser<'_>) {
    let mut u = Unstructured::new(bytes);
    // Zeros follow the last byte.
    let style: u32 = u.arbitrary().unwrap_or_default();
    let [count, workers, rule, tempo, slow, moves, cancel, sample, blocks, cursors, mix, seed]: [u8;
        12] = u.arbitrary().unwrap_or_default();
    let rest = u.take_rest();
    let has_domain = mix & 32 != 0;
    let domain = has_domain.then(|| {
        let (kind, volume) = DOMAINS[style as usize % DOMAINS.len()];
        What::Domain(kind, volume * (1.0 + f64::from(count)))
    });
    let count = if has_domain { 0 } else { count };
    let (cells, _) = rest.as_chunks::<4>();
    let cells = &cells[..cells.len().min(usize::from(count) % 151)];
    let mut points = snap(style, cells);
    if mix & 1 != 0 {
        // Every third point is its predecessor once more, with zeros of the other sign.
        for i in (2..points.len()).step_by(3) {
            points[i] = points[i - 1].map(|c| if c == 0.0 { -c } else { c });
        }
    }
    let workers = 2 + u32::from(workers) % 7;
    let (closure, ownership) = match rule / 3 % 4 {
        0 | 1 => (Closure::Face, Ownership::Block),
        2 => (Closure::Vertex, Ownership::Block),
        _ => (Closure::Vertex, Ownership::Creator),
    };
    let ownership = if mix & 24 == 24 { Ownership::Newest } else { ownership };
    // Blocks move only where they own the tetrahedra.
    let moves = if ownership == Ownership::Block { u32::from(moves) % 64 } else { 0 };
    let case = Case {
        layout: Layout {
            workers,
            blocks_per_worker: 1 + u32::from(blocks) % 4,
            cursors: 1 + usize::from(cursors) % 6,
            max_in_flight: usize::from(cursors) / 6 % 8,
            sample: 4 + usize::from(sample) % 24,
            ownership,
            ..Layout::new(0, 1)
        },
        rule: Rule::ALL[usize::from(rule) % 2],
        closure,
        tempo: Tempo::ALL[usize::from(tempo) % 4],
        // Half of the values: no slow worker.
        slow: (slow % 2 == 1).then_some(usize::from(slow / 2) % workers as usize),
        moves,
        cancel: cancel.checked_sub(192).map(|k| 8 * usize::from(k)),
        bytes: mix & 6 == 6,
    };
    (
        domain.unwrap_or(What::Points(points)),
        case,
        Chooser::new(&rest[4 * cells.len()..], u64::from(seed)),
    )
}

/// Runs the bytes' points, or domain, on the bytes' workers.
///
/// # Panics
/// If the run does not end at rest, or its mesh fails the checker, is not the sequential kernel's
/// or not CGAL's (where CGAL is there). If that of a domain is not the sequential engine's.
pub fn protocol(bytes: &[u8]) {
    let (what, case, mut chooser) = read(bytes);
    let points = match what {
        What::Points(points) => points,
        What::Domain(kind, volume) => {
            let domain = generate_domain(kind, &Shape::default());
            let ready = prepared(&domain.unwrap_or_else(|error| panic!("{error}")));
            let refiner = Refiner::new().max_volume(volume).start(0);
            drop(case.refine(&refiner, &ready, &mut chooser));
            return;
        }
    };
    let set = PointSet::new(points.clone()).expect("snapped points are finite");
    let played = case.play(&set, &mut chooser);
    if case.cancel.is_some() {
        return;
    }
    let Some(cgal) = reference() else { return };
    let mut cgal = cgal.lock().unwrap_or_else(PoisonError::into_inner);
    let reply = cgal.triangulate(&points).unwrap_or_else(|failure| panic!("{failure}"));
    let same = match played {
        Ok(played) => compare_mesh(&reply, &played.mesh),
        Err(Refusal::Build(error)) => refusal(&reply, &error),
        Err(error) => panic!("{error}"),
    };
    same.unwrap_or_else(|difference| panic!("{difference}: {case:?} {points:?}"));
}
