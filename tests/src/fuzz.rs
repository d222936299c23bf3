//! The body of the fuzz target `triangulate`, here so that `cargo test` replays its corpus.

use crate::cgal::{Cgal, Failure};
use crate::compare::{canonical, compare_with};
use crate::families::snap;
use crate::oracle::brute_force;
use ltbw::{Builder, Mesh, Order, Point, PointSet};
use ltbw_verify::Options;
use std::sync::{Mutex, OnceLock, PoisonError};

/// Sets of at most this many points are also triangulated by definition.
const FEW: usize = 8;

/// The points that `bytes` describe: 4 bytes of style, then 4 bytes for each of at most 60 points.
#[must_use]
pub fn points(bytes: &[u8]) -> Vec<Point> {
    let (words, _) = bytes.as_chunks::<4>();
    let Some((style, cells)) = words.split_first() else { return Vec::new() };
    snap(u32::from_le_bytes(*style), &cells[..cells.len().min(60)])
}

/// Builds the points of `bytes` in two ways and checks the mesh.
///
/// # Panics
/// If the mesh depends on the order of insertion, fails the independent check, differs from brute
/// force (few points) or from CGAL (where it is there), or if the kernel panics: that is the
/// fuzzer's finding.
pub fn triangulate(bytes: &[u8]) {
    let points = points(bytes);
    let set = PointSet::new(points.clone()).expect("snapped points are finite");
    let build = |order| Builder::new().order(order).build(&set);
    match (build(Order::Brio), build(Order::Input)) {
        (Ok(brio), Ok(input)) => {
            assert_eq!(brio.mesh.hash(), input.mesh.hash(), "the order matters: {points:?}");
            certify(&set, &brio.mesh);
            insert_later(&set, &brio.mesh);
            if points.len() <= FEW {
                let tets: Vec<[u32; 4]> = brio.mesh.tets().collect();
                assert_eq!(canonical(&tets), brute_force(&points), "{points:?}");
            }
        }
        (Err(_), Err(_)) if points.len() > FEW => {}
        (Err(error), Err(_)) => assert_eq!(brute_force(&points).len(), 0, "{error}: {points:?}"),
        (one, other) => {
            panic!("one order is refused: {:?}, {:?}: {points:?}", one.err(), other.err())
        }
    }
    if let Some(cgal) = reference() {
        let mut cgal = cgal.lock().unwrap_or_else(PoisonError::into_inner);
        let reply = cgal.triangulate(&points).unwrap_or_else(|failure| panic!("{failure}"));
        if let Err(difference) = compare_with(&reply, &points, Order::Brio) {
            panic!("{difference}: {points:?}");
        }
    }
}

/// The independent checker passes the mesh, at every level.
fn certify(set: &PointSet, mesh: &Mesh) {
    let plain = mesh.to_tet_mesh();
    let hull: Vec<[u32; 3]> = mesh.hull_facets().collect();
    let options = Options { all_points: true, ..Options::default() };
    let view = ltbw_verify::Mesh::new(set.points(), &plain.tets).with_hull(&hull);
    let report = ltbw_verify::check(&view, &options);
    assert!(report.passed(), "{:?}: {:?}", report.defects, set.points());
}

/// Inserting the second half of the points one by one gives the same mesh: also where they lie
/// outside the hull, or outside the window of the first half.
fn insert_later(set: &PointSet, whole: &Mesh) {
    let (first, later) = set.points().split_at(set.len() / 2);
    let half = PointSet::new(first.to_vec()).expect("points of a point set");
    let Ok(mut built) = Builder::new().build(&half) else { return };
    for &p in later {
        built.mesh.insert(p).unwrap_or_else(|error| panic!("{error}: {:?}", set.points()));
    }
    assert_eq!(built.mesh.hash(), whole.hash(), "inserted later: {:?}", set.points());
}

/// The one CGAL server of this process; none where CGAL is missing.
fn reference() -> Option<&'static Mutex<Cgal>> {
    static SERVER: OnceLock<Option<Mutex<Cgal>>> = OnceLock::new();
    let start = || match Cgal::start() {
        Ok(cgal) => Some(Mutex::new(cgal)),
        Err(Failure::Missing(_)) => None,
        Err(failure) => panic!("{failure}"),
    };
    SERVER.get_or_init(start).as_ref()
}
