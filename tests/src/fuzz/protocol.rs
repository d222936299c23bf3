//! `protocol`: bytes to points, workers and an order of events; the real mesh on the real protocol.
//!
//! The bytes: 4 of style, 12 of plan, then 4 for each of at most 150 points ([`snap`]), as many
//! as the plan says; every other byte chooses one event of [`interleave`](crate::interleave).
//! Where they end, a seed goes on.

use super::reference;
use crate::compare::{compare_mesh, refusal};
use crate::families::snap;
use crate::interleave::{Case, Chooser, Refusal, Tempo};
use arbitrary::Unstructured;
use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Closure, Rule};
use ltbw::{Point, PointSet};
use std::sync::PoisonError;

/// The points, the case and the choices of some bytes.
fn read(bytes: &[u8]) -> (Vec<Point>, Case, Chooser<'_>) {
    let mut u = Unstructured::new(bytes);
    // Zeros follow the last byte.
    let style: u32 = u.arbitrary().unwrap_or_default();
    let [count, workers, rule, tempo, slow, moves, cancel, sample, blocks, cursors, mix, seed]: [u8;
        12] = u.arbitrary().unwrap_or_default();
    let rest = u.take_rest();
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
    (points, case, Chooser::new(&rest[4 * cells.len()..], u64::from(seed)))
}

/// Runs the bytes' points on the bytes' workers.
///
/// # Panics
/// If the run does not end at rest, or its mesh fails the checker, is not the sequential kernel's
/// or not CGAL's (where CGAL is there).
pub fn protocol(bytes: &[u8]) {
    let (points, case, mut chooser) = read(bytes);
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
