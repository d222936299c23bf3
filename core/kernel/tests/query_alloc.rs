//! No query allocates once its cursor is warm, nor does a removal once the mesh is: counted by a
//! global allocator of our own.

use ltbw_core::query::{Conflicts, Cursor};
use ltbw_core::{Builder, Inserted, Vertex};
use ltbw_exact::{Point, PointSet};
use ltbw_generate::{PointKind, generate};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator, counting the calls of each thread.
struct Counting;

thread_local! {
    static CALLS: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    // A thread that is ending has no counter any more.
    let _ = CALLS.try_with(|calls| calls.set(calls.get() + 1));
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract.
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract.
        unsafe { System.realloc(at, layout, size) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Asks everything once for each point and vertex; a figure that depends on all answers.
fn ask_all(cursor: &mut Cursor<'_>, points: &[Point], vertices: Vertex) -> u64 {
    let mut sum = 0;
    for &p in points {
        sum += u64::from(matches!(cursor.locate(p), Ok(ltbw_core::query::Location::Tet(_))));
        sum += u64::from(cursor.nearest(p).expect("a finite point"));
        if let Conflicts::Region(region) = cursor.conflicts(p).expect("a finite point") {
            sum += (region.tets.len() + region.hull.len() + region.boundary.len()) as u64;
        }
    }
    for v in 0..vertices {
        sum += cursor.star(v).map_or(0, <[_]>::len) as u64;
        sum += cursor.neighbours(v).map_or(0, <[_]>::len) as u64;
        sum += u64::from(cursor.is_on_hull(v) == Some(true));
        sum += cursor.cell(v).map_or(0, |cell| cell.faces().map(|f| f.corners.len()).sum()) as u64;
    }
    sum + cursor.edges().count() as u64
}

#[test]
fn no_query_allocates_once_warm() {
    let kinds = [PointKind::Uniform, PointKind::Grid, PointKind::Cospherical, PointKind::Ulps];
    let mut sets = kinds.map(|kind| generate(kind, 1500, 4)).to_vec();
    // Exponents far apart: no filter and no fixed width decides.
    let spread = |k: usize| 2f64.powi((k * 7919 % 1800) as i32 - 900);
    let far = |(k, p): (usize, &Point)| [p[0] * spread(3 * k), p[1] * spread(k), p[2]];
    sets.push(sets[0][..300].iter().enumerate().map(far).collect());
    for points in sets {
        let set = PointSet::new(points).expect("finite points");
        let mesh = Builder::new().build(&set).expect("points of dimension 3").mesh;
        let mut asked = generate(PointKind::Uniform, 500, 5);
        asked.extend_from_slice(&set.points()[..100]);
        // Outside the exactness window.
        asked.extend([[1e80, 0.5, -1e80], [0.1, -2f64.powi(70), 1e-300], [5e-324; 3]]);
        let queries = mesh.queries();
        let mut cursor = queries.cursor();
        let warm = ask_all(&mut cursor, &asked, set.len() as Vertex);
        let before = CALLS.get();
        let again = ask_all(&mut cursor, &asked, set.len() as Vertex);
        let calls = CALLS.get() - before;
        assert_eq!((again, calls), (warm, 0), "{:?}", mesh.mode());
        // The counter does count.
        let fresh = ask_all(&mut queries.cursor(), &asked, set.len() as Vertex);
        assert_eq!(fresh, warm);
        assert!(CALLS.get() - before > 5);
    }
}

/// Removals take no memory once stars of their size were met.
#[test]
fn a_removal_that_is_warm_allocates_nothing() {
    for kind in [PointKind::Uniform, PointKind::Grid, PointKind::Shell] {
        let set = PointSet::new(generate(kind, 2000, 1)).expect("finite points");
        let mut mesh = Builder::new().build(&set).expect("a mesh").mesh;
        let mut some: Vec<(Vertex, Point)> = mesh.vertices().step_by(3).collect();
        let mut calls = [0; 3];
        for calls in &mut calls {
            let before = CALLS.with(Cell::get);
            for &(v, _) in &some {
                mesh.remove(v).expect("a vertex");
            }
            *calls = CALLS.with(Cell::get) - before;
            for (v, p) in &mut some {
                if let Ok(Inserted::Vertex(number)) = mesh.insert(*p) {
                    *v = number;
                }
            }
        }
        assert!(calls[0] > 0, "{kind:?}: the first ones need memory");
        assert_eq!(calls[2], 0, "{kind:?}: {calls:?}");
    }
}
