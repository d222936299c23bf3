//! `triangulate`: bytes to points, an order and a life of a mesh, checked in every way there is.
//!
//! The bytes: 4 of style, 4 of plan, then 4 for each of at most 48 points. Style and cells are
//! those of [`snap`]; the plan adds a second style, duplicates and a second scale, and says where
//! the interleaved life begins, which admission is refused and how points are shuffled.

use super::reference;
use crate::compare::{canonical, compare_with};
use crate::families::{Rng, snap, two_to};
use crate::oracle::{self, brute_force, exact};
use arbitrary::Unstructured;
use ltbw::invariants::check_all;
use ltbw::query::{Conflicts, Location};
use ltbw::topology::Topology;
use ltbw::{Builder, InsertError, Inserted, Mesh, Order, Point, PointSet, RemoveError};
use ltbw_verify::Options;
use std::sync::PoisonError;

/// Sets of at most this many points are also triangulated by definition.
const FEW: usize = 8;

/// The largest number of points inserted one by one: each is asked about in many ways.
const LIVE: usize = 12;

/// The case that the bytes describe.
struct Plan {
    points: Vec<Point>,
    /// Points that the first build of [`live`] has, if they have volume.
    first: usize,
    /// The ask at which an admission refuses; 0: none does.
    refuse: usize,
    /// Seed of the shuffles.
    seed: u64,
}

impl Plan {
    fn of(bytes: &[u8]) -> Self {
        let mut u = Unstructured::new(bytes);
        // Zeros follow the last byte.
        let style: u32 = u.arbitrary().unwrap_or_default();
        let [mix, first, refuse, seed]: [u8; 4] = u.arbitrary().unwrap_or_default();
        let (cells, _) = u.take_rest().as_chunks::<4>();
        let cells = &cells[..cells.len().min(48)];
        let mut points = snap(style, cells);
        let half = points.len() / 2;
        if mix & 1 != 0 {
            let other = snap(style.rotate_left(13) ^ u32::from(seed), &cells[half..]);
            points.splice(half.., other);
        }
        if mix & 2 != 0 {
            // Every third point is its predecessor once more, with zeros of the other sign.
            for i in (2..points.len()).step_by(3) {
                points[i] = points[i - 1].map(|c| if c == 0.0 { -c } else { c });
            }
        }
        if mix & 4 != 0 {
            let factor = two_to([-600, 400, -52, 3][usize::from(mix >> 4 & 3)]);
            points.iter_mut().step_by(2).for_each(|p| *p = p.map(|c| c * factor));
        }
        let first =
            (usize::from(first) % (points.len() + 1)).max(points.len().saturating_sub(LIVE));
        Self { points, first, refuse: usize::from(refuse), seed: u64::from(seed) }
    }
}

/// Builds the points of `bytes` in three orders, lets a mesh grow and shrink; compares everything.
///
/// # Panics
/// If the mesh depends on the order of insertion, on refusals or on queries, if it fails the
/// independent check, differs from brute force (few points) or from CGAL (where it is there), if
/// a query is wrong, or if the kernel panics.
pub fn triangulate(bytes: &[u8]) {
    let plan = Plan::of(bytes);
    let points = &plan.points;
    let set = PointSet::new(points.clone()).expect("snapped points are finite");
    let build = |order| Builder::new().order(order).build(&set);
    match (build(Order::Brio), build(Order::Input)) {
        (Ok(brio), Ok(input)) => {
            assert_eq!(brio.mesh.hash(), input.mesh.hash(), "the order matters: {points:?}");
            shuffled(&plan, &brio.mesh);
            certify(&set, &brio.mesh);
            live(&plan, &brio.mesh);
            removed(&plan, input.mesh);
            if points.len() <= FEW {
                let tets: Vec<[u32; 4]> = brio.mesh.tets().collect();
                assert_eq!(canonical(&tets), brute_force(points), "{points:?}");
            }
        }
        (Err(_), Err(_)) if points.len() > FEW => {}
        (Err(error), Err(_)) => assert_eq!(brute_force(points).len(), 0, "{error}: {points:?}"),
        (one, other) => {
            panic!("one order is refused: {:?}, {:?}: {points:?}", one.err(), other.err())
        }
    }
    if let Some(cgal) = reference() {
        let mut cgal = cgal.lock().unwrap_or_else(PoisonError::into_inner);
        let reply = cgal.triangulate(points).unwrap_or_else(|failure| panic!("{failure}"));
        if let Err(difference) = compare_with(&reply, points, Order::Brio) {
            panic!("{difference}: {points:?}");
        }
    }
}

/// The points in another order have the same mesh.
fn shuffled(plan: &Plan, whole: &Mesh) {
    let mut points = plan.points.clone();
    Rng::new(plan.seed).shuffle(&mut points);
    let set = PointSet::new(points).expect("finite points");
    let built = Builder::new().order(Order::Input).build(&set);
    let mesh = built.unwrap_or_else(|error| panic!("{error}: {:?}", set.points())).mesh;
    assert_eq!(mesh.hash(), whole.hash(), "shuffled: {:?}", set.points());
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

/// A mesh of the first points (at least as many as have volume) grows by the others, also where
/// they lie outside its hull or its window. Between insertions it is asked, and insertions are
/// refused. It ends as the whole mesh.
fn live(plan: &Plan, whole: &Mesh) {
    let points = &plan.points;
    let of_first = |n: usize| Builder::new().build(&PointSet::new(points[..n].to_vec()).ok()?).ok();
    let started = (plan.first..=points.len()).find_map(|n| Some((n, of_first(n)?)));
    let (n, built) = started.unwrap_or_else(|| panic!("all points have a mesh: {points:?}"));
    let mut mesh = built.mesh;
    for (i, &p) in points.iter().enumerate().skip(n) {
        refuse(&mut mesh, p, plan.refuse);
        if i % 4 == plan.refuse % 4 {
            ask(&mesh, p);
        }
        let doomed = doomed(&mesh, p);
        let before = quadruples(&mesh);
        mesh.insert(p).unwrap_or_else(|error| panic!("{error}: {points:?}"));
        let after = quadruples(&mesh);
        let gone: Vec<_> = before.iter().filter(|t| after.binary_search(t).is_err()).collect();
        assert!(gone.into_iter().eq(&doomed), "the region of {p:?} foretells: {points:?}");
    }
    assert_eq!(mesh.hash(), whole.hash(), "inserted one by one: {points:?}");
}

/// Vertices are removed and put back, in an order of chance. The mesh is always that of the points
/// that are there, and what would have no mesh is refused without a trace.
fn removed(plan: &Plan, mut mesh: Mesh) {
    let mut rng = Rng::new(plan.seed ^ plan.refuse as u64);
    let mut there: Vec<(u32, Point)> = mesh.vertices().collect();
    let mut gone: Vec<Point> = Vec::new();
    for step in 0..2 * LIVE {
        // Rather removed than put back, so that few are left now and then.
        let back = !gone.is_empty() && rng.below(3) == 0;
        if back {
            let p = gone.swap_remove(rng.below(gone.len() as u64) as usize);
            match mesh.insert(p) {
                Ok(Inserted::Vertex(v)) => there.push((v, p)),
                other => panic!("put back, {other:?}: {p:?}"),
            }
        } else {
            let k = rng.below(there.len() as u64) as usize;
            let (v, p) = there.swap_remove(k);
            let before = fingerprint(&mesh);
            match mesh.remove(v) {
                Ok(()) => gone.push(p),
                Err(RemoveError::Flat { .. }) => {
                    assert!(fingerprint(&mesh) == before, "the removal of {p:?} left a trace");
                    let left = there.iter().map(|v| v.1).collect();
                    let set = PointSet::new(left).expect("finite points");
                    assert!(Builder::new().build(&set).is_err(), "{p:?} may go: {there:?}");
                    there.push((v, p));
                }
                Err(error) => panic!("{error}: {p:?}: {there:?}"),
            }
        }
        let set = PointSet::new(there.iter().map(|v| v.1).collect()).expect("finite points");
        let built = Builder::new().build(&set).unwrap_or_else(|error| panic!("{error}: {there:?}"));
        assert_eq!(mesh.hash(), built.mesh.hash(), "step {step}: {there:?}");
        if step % 8 == 7 {
            check_all(&mesh).unwrap_or_else(|defect| panic!("{defect}: {there:?}"));
        }
    }
}

/// Everything of a mesh that an insertion could change.
type Fingerprint = (Topology, Vec<(u32, [u64; 3])>, Vec<[u32; 4]>);

fn fingerprint(mesh: &Mesh) -> Fingerprint {
    let vertices = mesh.vertices().map(|(v, p)| (v, p.map(f64::to_bits))).collect();
    (mesh.topology().clone(), vertices, mesh.spheres_fingerprint())
}

/// An insertion that is refused at the `ask`-th tetrahedron leaves no trace. One with a smaller
/// closure goes through.
fn refuse(mesh: &mut Mesh, p: Point, ask: usize) {
    if ask == 0 {
        return;
    }
    let (before, mut asked) = (fingerprint(mesh), 0);
    let result = mesh.insert_with(p, &mut |_, _| {
        asked += 1;
        asked < ask
    });
    match result {
        Ok(_) => {}
        Err(InsertError::Refused { .. }) => {
            assert_eq!(asked, ask, "asked again after the refusal of {p:?}");
            assert!(fingerprint(mesh) == before, "the refusal of {p:?} left a trace");
        }
        Err(error) => panic!("{error}: {p:?}"),
    }
}

/// The tetrahedra that inserting `p` deletes, as the query foretells; sorted.
fn doomed(mesh: &Mesh, p: Point) -> Vec<[u32; 4]> {
    let queries = mesh.queries();
    let mut cursor = queries.cursor();
    match cursor.conflicts(p).expect("a finite point") {
        Conflicts::AtVertex(_) => Vec::new(),
        Conflicts::Region(region) => {
            let tets: Vec<[u32; 4]> = region.tets.iter().filter_map(|&t| mesh.tet(t)).collect();
            assert_eq!(tets.len(), region.tets.len(), "a region of finite tetrahedra: {p:?}");
            canonical(&tets)
        }
    }
}

fn quadruples(mesh: &Mesh) -> Vec<[u32; 4]> {
    canonical(&mesh.tets().collect::<Vec<_>>())
}

/// The queries at `p` against slow answers.
fn ask(mesh: &Mesh, p: Point) {
    let queries = mesh.queries();
    let mut cursor = queries.cursor();
    let found = cursor.locate(p).expect("a finite point");
    let slow = cursor.locate_by_search(p).expect("a finite point");
    let same = match (found, slow) {
        // Which of several tetrahedra, or of several facets in sight, is free.
        (Location::Edge { ends, .. }, Location::Edge { ends: other, .. }) => ends == other,
        (Location::Facet { corners, .. }, Location::Facet { corners: other, .. }) => {
            corners == other
        }
        (Location::OutsideHull { .. }, Location::OutsideHull { .. }) => true,
        _ => found == slow,
    };
    assert!(same, "located at {found:?} and {slow:?}: {p:?}");
    let vertices: Vec<(u32, Point)> = mesh.vertices().collect();
    let all: Vec<Point> = vertices.iter().map(|v| v.1).chain([p]).collect();
    let scaled = oracle::scale(&all);
    let (goal, scaled) = scaled.split_last().expect("the point is the last");
    let nearest = (0..scaled.len()).min_by(|&i, &j| {
        let nearer = exact::cmp_distance(goal, &scaled[i], &scaled[j]);
        nearer.then_with(|| scaled[i].cmp(&scaled[j]))
    });
    let nearest = nearest.map(|i| vertices[i].0);
    assert_eq!(cursor.nearest(p).ok(), nearest, "nearest to {p:?}");
    let v = nearest.expect("a mesh has vertices");
    let on_hull = mesh.hull_facets().any(|f| f.contains(&v));
    assert_eq!(cursor.is_on_hull(v), Some(on_hull), "{v} of the mesh around {p:?}");
    let bounded = cursor.cell(v).map(|cell| cell.is_bounded());
    assert_eq!(bounded, Some(!on_hull), "the cell of {v} around {p:?}");
}
