//! Counted steps of large facets.

use super::*;

/// A comb with a square hole in each of its teeth, and the edges.
fn comb(teeth: u32) -> (Vec<Point>, Vec<[u32; 2]>) {
    let mut points: Vec<Point> = Vec::new();
    for k in 0..teeth {
        let x = f64::from(4 * k);
        points.extend([[x, 0.0, 0.0], [x, 3.0, 0.0], [x + 3.0, 3.0, 0.0], [x + 3.0, 0.0, 0.0]]);
    }
    let end = f64::from(4 * teeth);
    points.extend([[end, 0.0, 0.0], [end, -1.0, 0.0], [0.0, -1.0, 0.0]]);
    let ring =
        |first: u32, count: u32| (0..count).map(move |k| [first + k, first + (k + 1) % count]);
    let mut edges: Vec<[u32; 2]> = ring(0, points.len() as u32).collect();
    for k in 0..teeth {
        let x = f64::from(4 * k);
        edges.extend(ring(points.len() as u32, 4));
        let hole = [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]];
        points.extend(hole.map(|[a, b]| [x + a, b, 0.0]));
    }
    (points, edges)
}

#[test]
fn each_corner_and_hole_of_many_takes_few_steps() {
    let each = [1 << 7, 1 << 9, 1 << 11].map(|teeth| {
        let (points, edges) = comb(teeth);
        let count = points.len();
        let mut plane = Plane::new(points, [0, 1]).expect("a triangulation");
        edges.iter().for_each(|&edge| plane.force(edge).expect("no crossings"));
        plane.remove_outside();
        let index = plane.index();
        for k in 0..teeth {
            let x = f64::from(4 * k);
            assert!(matches!(plane.locate(&index, &[x + 1.5, 1.25, 0.0]), Place::Inside(_)));
            assert_eq!(plane.locate(&index, &[x + 1.5, 1.0, 0.0]), Place::OnEdge);
            assert_eq!(plane.locate(&index, &[x + 3.5, 1.25, 0.0]), Place::Outside);
        }
        plane.steps.get() as f64 / count as f64
    });
    assert!(each[1] < 1.3 * each[0] && each[2] < 1.3 * each[1], "{each:?}");
}
