//! The owner of a point's star is asked for before the point is inserted at once.

use ltbw::PointSet;
use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Insert, Source, Submesh, Walk};
use ltbw_generate::{PointKind, generate};

/// A worker that finds the cavity of another worker's point whole and unlocked must not insert it,
/// where the star belongs to the owner of the point's block.
#[test]
fn another_workers_point_is_blocked() {
    let set = PointSet::new(generate(PointKind::Uniform, 4000, 3)).expect("finite points");
    for ownership in [Ownership::Newest, Ownership::Block] {
        let layout = Layout { ownership, sample: 400, ..Layout::new(set.len(), 2) };
        let mut workers = layout.distribute(&set).expect("a start").workers;
        let (_, theirs, mut points) = workers.pop().expect("the second worker");
        let (directory, mut mesh, mut own) = workers.pop().expect("the first worker");
        let (mut blocked, mut done) = (0, 0);
        while let Some(point) = points.next(&theirs) {
            points.inserted(&theirs, &point);
            let Walk::At(seed) = mesh.walk(&point, None) else { continue };
            match mesh.insert(&point, seed, &directory) {
                Insert::Blocked => blocked += 1,
                Insert::Done => done += 1,
                other => panic!("{other:?}"),
            }
        }
        assert!(done == 0 && blocked > 10, "{ownership:?}: {done} inserted, {blocked} blocked");
        // Its own points are another matter.
        let mut inserted = 0;
        while let Some(point) = own.next(&mesh) {
            own.inserted(&mesh, &point);
            let Walk::At(seed) = mesh.walk(&point, None) else { continue };
            inserted += usize::from(mesh.insert(&point, seed, &directory) == Insert::Done);
        }
        assert!(inserted > 1000, "{ownership:?}: {inserted} of its own");
    }
}
