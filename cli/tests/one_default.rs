//! One tolerance for surfaces where nobody asks for one: library, program and bindings make one
//! mesh of a file.

use crate::common::ltbw;
use ltbw::io;
use ltbw::refine::{Refined, Refiner};
use ltbw_bindings::{Reins, Source, Wishes};
use std::path::Path;

fn hash_of(refined: &Refined) -> String {
    let inside = refined.inside();
    ltbw::canonical_hash(&inside.points, &inside.tets).unwrap().to_string()
}

/// The mesh of the half of the bindings that all languages share.
fn bound(source: Source) -> String {
    let wishes = Wishes { radius_edge: Some(2.0), ..Wishes::default() };
    let (ready, reins) = (ltbw_bindings::Ready::new(source, &wishes).unwrap(), Reins::default());
    let refined = ready.refine(&wishes, None, false, &reins.progress, &reins.cancel).unwrap();
    let meshed = ready.finish(&wishes, refined).unwrap();
    assert!(meshed.certificate.is_some());
    meshed.hash().unwrap()
}

fn program(dir: &Path, name: &str) -> String {
    let run = ltbw(dir, &["mesh", name, "--excused-share", "0.05"]);
    assert!(run.code < 2, "{}", run.stderr);
    run.stdout.trim_end().strip_prefix("ltbw.mesh/1 ").unwrap().to_owned()
}

#[test]
fn library_program_and_bindings_mesh_a_surface_alike() {
    let dir = tempfile::tempdir().unwrap();
    // Quadrilaterals that are flat up to the rounding to single precision, as an STL file has them.
    let globe = ltbw_generate::surfaces::single(ltbw_generate::surfaces::globe(10, 12, 0.0, 1));
    let path = dir.path().join("globe.stl");
    io::write_domain(&path, &globe).unwrap();
    let file = io::read_domain(&path).unwrap();
    let whole = Refiner::new().mesh(&file).unwrap();
    assert!(whole.stats.patches > 0 && whole.stats.flat_tolerance > 0.0);
    let hash = hash_of(&whole);
    assert_eq!(hash, program(dir.path(), "globe.stl"));
    assert_eq!(hash, bound(Source::File(path)));
    let arrays = Source::Arrays {
        vertices: file.domain.vertices.clone(),
        corners: file
            .domain
            .facets
            .iter()
            .flat_map(|f| &f.polygons[0])
            .map(|&v| v.into())
            .collect(),
        starts: (0..file.domain.facets.len()).map(|k| 3 * k).collect(),
        markers: Vec::new(),
    };
    assert_eq!(hash, bound(arrays));
    // The tolerance that is asked for is the one.
    let exact = Refiner::new().flat_tolerance(0.0).mesh(&file).unwrap();
    assert_eq!(exact.stats.patches, 0);
    assert_ne!(hash, hash_of(&exact));
}

#[test]
fn what_is_no_surface_is_taken_as_it_is() {
    let dir = tempfile::tempdir().unwrap();
    let globe = ltbw_generate::surfaces::single(ltbw_generate::surfaces::globe(6, 8, 0.0, 1));
    let path = dir.path().join("globe.poly");
    io::write_domain(&path, &globe).unwrap();
    let file = io::read_domain(&path).unwrap();
    let whole = Refiner::new().mesh(&file).unwrap();
    assert_eq!((whole.stats.patches, whole.stats.flat_tolerance), (0, 0.0));
    let hash = hash_of(&whole);
    assert_eq!(hash, hash_of(&Refiner::new().mesh(&file.domain).unwrap()));
    assert_eq!(hash, program(dir.path(), "globe.poly"));
    assert_eq!(hash, bound(Source::File(path)));
}
