//! Combs: segments whose balls hold nearly all corners.

use super::{check_conforming, ready, refine};
use crate::complex::plc::Plc;
use crate::heed::Heed;
use crate::{RefineOutcome, Refiner};
use ltbw_domain::{Domain, Facet, PrepareOptions, Prepared, vector};
use ltbw_exact::Point;
use ltbw_generate::{DomainKind, Shape};

/// The prism of depth 1 over a comb of teeth of width 1 on a back as high.
fn comb(teeth: u32, length: f64) -> Prepared {
    let mut ring = Vec::new();
    for k in 0..teeth {
        let x = f64::from(2 * k);
        ring.extend([[x, 0.0], [x, length], [x + 1.0, length], [x + 1.0, 0.0]]);
    }
    let end = f64::from(2 * teeth);
    ring.extend([[end, 0.0], [end, -1.0], [0.0, -1.0]]);
    let count = ring.len() as u32;
    let mut domain = Domain::default();
    for z in [0.0, 1.0] {
        domain.vertices.extend(ring.iter().map(|&[x, y]| [x, y, z]));
    }
    domain.facets = vec![
        Facet::polygon(&(0..count).collect::<Vec<u32>>(), 0),
        Facet::polygon(&(count..2 * count).collect::<Vec<u32>>(), 0),
    ];
    domain.facets.extend((0..count).map(|k| {
        let next = (k + 1) % count;
        Facet::polygon(&[k, next, next + count, k + count], 0)
    }));
    domain.prepare(&PrepareOptions::default()).expect("a sound domain")
}

#[test]
fn a_mesh_of_a_comb_takes_work_in_proportion_to_its_corners() {
    let work = [256, 512, 1024].map(|teeth| {
        let refined = refine(&Refiner::new(), &comb(teeth, 1.0));
        assert_eq!(refined.outcome, RefineOutcome::Met, "{teeth}");
        let stats = refined.mesh().predicate_stats();
        let tests = stats.insphere_calls + stats.orient3d_calls;
        [tests, refined.stats.searches + 1, refined.mesh().num_vertices() as u64]
    });
    for pair in work.windows(2) {
        for (&less, &more) in pair[0].iter().zip(&pair[1]) {
            assert!((more as f64) < 2.3 * less as f64, "{work:?}");
        }
    }
}

#[test]
fn crowded_segments_are_cut_until_their_parts_are_not() {
    let cuts_of = |ready: &Prepared, most: u64| {
        let plc = Plc::new(&ready.domain, &ready.lattice).expect("a complex");
        let cuts = plc.cuts(1.0, most, Heed::default()).expect("no token");
        (plc, cuts)
    };
    let comb = comb(400, 2.0);
    let (plc, cuts) = cuts_of(&comb, u64::MAX);
    let at = |ends: [u32; 2]| {
        ends.map(|c| crate::complex::carrier::corner_point(&plc.corners[c as usize]))
    };
    let held = |[a, b]: [Point; 2]| {
        let middle = [0, 1, 2].map(|k| (a[k] + b[k]) / 2.0);
        let radius = vector::distance2(&a, &b).sqrt() / 2.0 * (1.0 - 1e-9);
        let all = plc.corners.iter().map(crate::complex::carrier::corner_point);
        all.filter(|p| vector::distance2(p, &middle).sqrt() < radius).count()
    };
    let mut crowded = 0;
    for (s, segment) in (0..).zip(&plc.segments) {
        let ends = at(segment.ends);
        let own: Vec<Point> = cuts
            .iter()
            .filter(|cut| cut.segment == s)
            .map(|cut| segment.line.point(cut.parameter))
            .collect();
        if own.is_empty() {
            assert!(held(ends) <= 1024, "{segment:?}");
            continue;
        }
        crowded += 1;
        let chain: Vec<Point> = std::iter::once(ends[0]).chain(own).chain([ends[1]]).collect();
        assert!(chain.windows(2).all(|part| held([part[0], part[1]]) <= 4), "{chain:?}");
    }
    // The edges of the back, and nothing else; and no more than are asked for.
    assert_eq!(crowded, 2);
    assert_eq!(cuts_of(&comb, 10).1.len(), 10);
    for kind in DomainKind::ALL {
        assert!(cuts_of(&ready(kind, &Shape::default()), u64::MAX).1.is_empty(), "{kind:?}");
    }
    // All of the boundary is there, cut where it is.
    let (mut run, _) = Refiner::new().recovered(&comb.domain, &comb.lattice).expect("a mesh");
    assert!(run.refinement.inserted.points.segments >= cuts.len() as u64);
    check_conforming(&run.refinement.state);
    run.refine(usize::MAX).expect("a mesh");
    check_conforming(&run.refinement.state);
}
