//! The exact check of domains.
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use ltbw_core::domain::{CheckOptions, Domain, PrepareOptions};
use ltbw_core::io;
use std::path::Path;

fn fixture(name: &str) -> Domain {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/domains");
    io::read_domain(&folder.join(name)).unwrap().domain
}

#[test]
fn the_model_problems_are_sound_and_have_their_volumes() {
    for (name, cells, volume) in [
        ("model.poly", 2, "47/48"),
        ("cubeincube.poly", 2, "485/512"),
        ("tee.poly", 1, "47/16"),
    ] {
        let domain = fixture(name);
        let report = domain.check(&CheckOptions::default()).unwrap();
        assert!(report.passed(), "{name}: {:?}", report.defects);
        assert_eq!(report.cells.as_ref().unwrap().len(), cells, "{name}");
        assert_eq!(report.volume().unwrap().to_string(), volume, "{name}");
        let prepared = domain.prepare(&PrepareOptions::default()).unwrap();
        assert_eq!((prepared.moved, prepared.largest), (0, None), "{name}");
        assert_eq!(prepared.domain, domain, "{name}");
    }
    let gear = fixture("gear.poly");
    let report = gear.check(&CheckOptions::default()).unwrap();
    assert!(report.passed(), "{:?}", report.defects);
    let volume = report.volume().unwrap().to_f64();
    assert!((volume - 0.561246).abs() < 1e-6, "{volume}");
    let prepared = gear.prepare(&PrepareOptions::default()).unwrap();
    assert!(prepared.moved > 100);
    assert!(prepared.largest.unwrap().distance < 1e-8);
    assert!(prepared.report.passed(), "{:?}", prepared.report.defects);
}
