//! Snapping domains to their lattice.

use ltbw_domain::{Domain, DomainError, Facet, Lattice, Region};
use ltbw_exact::Point;
use proptest::prelude::*;

fn domain(vertices: Vec<Point>) -> Domain {
    Domain { vertices, facets: vec![Facet::polygon(&[0, 1, 2], 0)], ..Domain::default() }
}

const STEPS: f64 = (1_u64 << 26) as f64;

#[test]
fn the_step_is_the_least_power_of_two_that_suffices() {
    let step = |c: f64| {
        let d = domain(vec![[c, 0.0, 0.0], [0.0, c, 0.0], [0.0; 3]]);
        Lattice::of(&d).map(|l| l.step())
    };
    for (largest, unit) in [(1.0, 1.0), (0.75, 1.0), (0.5, 0.5), (1.0000001, 2.0), (-3.0, 4.0)] {
        assert_eq!(step(largest).unwrap(), unit / STEPS, "{largest}");
    }
    // The ends of the exactness window: a fine step of 2^-142, coordinates below 2^200.
    let power = |e: i32| 2.0_f64.powi(e);
    assert_eq!(step(power(-89)).unwrap() / 2.0_f64.powi(27), power(-142));
    assert!(matches!(step(power(-90)), Err(DomainError::Range { .. })));
    assert_eq!(step(power(199)).unwrap(), power(173));
    assert!(matches!(step(power(199) * 1.5), Err(DomainError::Range { .. })));
    assert!(matches!(step(0.0), Err(DomainError::Range { .. })));
    assert!(matches!(step(f64::NAN), Err(DomainError::NotFinite { .. })));
    assert_eq!(Lattice::of(&Domain::default()).unwrap_err(), DomainError::Empty);
}

#[test]
fn moves_are_counted_and_the_largest_is_told() {
    let g = 1.0 / STEPS;
    let mut d = domain(vec![[1.0, 0.0, 0.0], [0.5 + 0.25 * g, 0.0, 0.0], [0.0, 0.5, 0.375 * g]]);
    d.holes.push([0.1; 3]);
    let snapped = d.snap().unwrap();
    let largest = snapped.largest.unwrap();
    assert_eq!((snapped.moved, largest.vertex, largest.distance), (2, 2, 0.375 * g));
    assert_eq!((largest.from, largest.to), ([0.0, 0.5, 0.375 * g], [0.0, 0.5, 0.0]));
    assert_eq!(snapped.domain.vertices[1], [0.5, 0.0, 0.0]);
    assert_eq!(snapped.domain.holes, d.holes);
    let error = snapped.clone().exact().unwrap_err();
    assert_eq!(error.code(), "domain.off-lattice");
    assert!(error.to_string().starts_with("2 vertices are not on the lattice"), "{error}");
    // Coordinates on the lattice stay, to the bit, but for the sign of zero.
    let again = snapped.domain.snap().unwrap().exact().unwrap();
    assert_eq!(again.domain, snapped.domain);
    let minus = domain(vec![[-0.0, 1.0, 0.0], [1.0, -0.0, 0.0], [0.0; 3]]).snap().unwrap();
    assert_eq!(minus.moved, 0);
    assert!(minus.domain.vertices.iter().flatten().all(|c| c.is_sign_positive()));
}

#[test]
fn far_from_the_origin_bits_are_lost_unless_the_frame_is_local() {
    let far = |d: f64| {
        let at = |x: f64, y: f64| [d + x, d + y, d];
        let mut domain = domain(vec![at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0 / 1024.0)]);
        domain.regions.push(Region { seed: at(0.25, 0.25), attribute: 1.0, max_volume: None });
        domain
    };
    let snapped = far(1024.0).snap().unwrap();
    // A coordinate of 1025 for a domain of 1: half of that is 2^-1.
    assert_eq!(snapped.lattice.lost_bits(), 12);
    assert_eq!(snapped.lattice.offset(), [0.0; 3]);
    let local = far(1024.0).snap_local().unwrap();
    assert_eq!(local.lattice.lost_bits(), 0);
    assert_eq!(local.lattice.step(), 0.5 / STEPS);
    assert_eq!(local.moved, 0);
    assert_eq!(local.lattice.offset()[0], 1024.5);
    assert_eq!(local.domain.vertices[0][0], -0.5);
    assert_eq!(local.domain.regions[0].seed[0], -0.25);
}

proptest! {
    #[test]
    fn snapped_vertices_are_on_the_grid_and_near(
        points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 3..20),
        exponent in -80..190_i32,
        far in prop::option::of(prop::array::uniform3(-1000.0..1000.0_f64)),
    ) {
        let scale = 2.0_f64.powi(exponent);
        let shift = far.unwrap_or([0.0; 3]);
        let scaled = |p: &Point| [0, 1, 2].map(|k| (p[k] + shift[k]) * scale);
        let original = domain(points.iter().map(scaled).collect());
        let mirrored: Vec<Point> = original.vertices.iter().map(|p| p.map(|c| -c)).collect();
        for snapped in [original.snap().unwrap(), original.snap_local().unwrap()] {
            let lattice = snapped.lattice;
            let mut farthest = 0.0_f64;
            for (p, q) in original.vertices.iter().zip(&snapped.domain.vertices) {
                let steps = lattice.steps(q).unwrap();
                prop_assert!(steps.iter().all(|s| s.abs() <= 1 << 26));
                prop_assert_eq!(lattice.point(steps), *q);
                let fine = lattice.fine_steps(q).unwrap();
                prop_assert_eq!(fine, steps.map(|s| s << 27));
                let moved =
                    [0, 1, 2].map(|k| (q[k] - (p[k] - lattice.offset()[k])) / lattice.step());
                prop_assert!(moved.iter().all(|m| m.abs() <= 0.5));
                farthest = farthest.max(moved.iter().map(|m| m * m).sum::<f64>().sqrt());
            }
            let told = snapped.largest.map_or(0.0, |m| m.distance / lattice.step());
            prop_assert!((told - farthest).abs() <= 1e-9, "{} {}", told, farthest);
        }
        let turned = domain(mirrored).snap().unwrap().domain;
        let own = original.snap().unwrap().domain;
        for (p, q) in own.vertices.iter().zip(&turned.vertices) {
            prop_assert_eq!(*p, q.map(|c| 0.0 - c));
        }
    }
}
