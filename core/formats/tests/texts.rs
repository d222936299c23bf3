//! Codes and texts: for programs, each once; for people, one line each.

use ltbw_domain::{
    CheckOptions, DefectKind, Domain, DomainDefect, Element, Facet, PrepareError, PrepareOptions,
    Severity,
};
use ltbw_formats as io;
use ltbw_formats::{npy, off};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use std::collections::HashSet;

fn one_line(text: &str) {
    assert!(!text.is_empty() && !text.contains('\n'), "{text:?}");
}

#[test]
fn every_kind_of_defect_has_a_code_and_a_text_of_its_own() {
    let mut codes = HashSet::new();
    let mut texts = HashSet::new();
    for kind in DefectKind::ALL {
        assert!(kind.code().starts_with("domain.") && codes.insert(kind.code()), "{kind:?}");
        one_line(kind.about());
        assert!(texts.insert(kind.about()), "{kind:?}");
    }
    let names = [Severity::Info, Severity::Warning, Severity::Error].map(Severity::name);
    assert_eq!(names, ["info", "warning", "error"]);
}

#[test]
fn elements_are_named_by_what_they_are() {
    for (element, text) in [
        (Element::Vertex(3), "vertex 3"),
        (Element::Facet(1), "facet 1"),
        (Element::Polygon { facet: 1, polygon: 0 }, "facet 1"),
        (Element::Polygon { facet: 1, polygon: 2 }, "facet 1 polygon 2"),
        (Element::Edge([4, 2]), "edge 4-2"),
        (Element::Segment(0), "segment 0"),
        (Element::FacetHole { facet: 5, hole: 1 }, "facet 5 hole 1"),
        (Element::Hole(7), "hole 7"),
        (Element::Region(8), "region 8"),
    ] {
        assert_eq!(element.to_string(), text);
    }
    let defect = DomainDefect {
        kind: DefectKind::TJunction,
        elements: vec![Element::Vertex(1), Element::Facet(2)],
        at: vec![[0.5, 0.0, -1.0]],
    };
    let text = "domain.t-junction: a vertex inside an edge or facet that does not name it: \
                vertex 1, facet 2 at (0.5 0.0 -1.0)";
    assert_eq!(defect.to_string(), text);
}

#[test]
fn model_domains_are_described() {
    let texts: HashSet<&str> = DomainKind::ALL.into_iter().map(DomainKind::about).collect();
    assert_eq!(texts.len(), DomainKind::ALL.len());
    for kind in DomainKind::ALL {
        assert!(kind.about().starts_with("domain: "), "{kind}");
        let domain = generate_domain(kind, &Shape::default()).expect("defaults");
        let polygons: usize = domain.facets.iter().map(|facet| facet.polygons.len()).sum();
        assert_eq!(domain.polygon_count(), polygons);
        assert!(domain.polygon_count() >= domain.facets.len());
    }
}

#[test]
fn domains_that_cannot_be_prepared_say_why() {
    let kind = DomainKind::CubeInCube;
    let cube = generate_domain(kind, &Shape::default()).expect("defaults");
    let refused =
        |domain: &Domain| domain.prepare(&PrepareOptions::default()).expect_err("refused");
    let said = |domain: &Domain, code: &str| {
        let error = refused(domain);
        assert_eq!(error.code(), code, "{error}");
        one_line(&error.to_string());
    };
    said(&Domain::default(), "domain.empty");
    let mut holes = cube.clone();
    holes.holes.push([0.1, 0.1, 0.1]);
    assert_eq!(refused(&holes), PrepareError::NothingInside);
    said(&holes, "domain.nothing-inside");
    let mut open = cube.clone();
    open.facets.truncate(5);
    said(&open, "domain.defects");
    // A plate so near the floor that it falls on it.
    let mut plate = cube;
    let first = plate.vertices.len() as u32;
    plate.vertices.extend([[0.2, 0.2], [0.4, 0.2], [0.2, 0.4]].map(|[x, y]| [x, y, 1e-9]));
    plate.facets.push(Facet::polygon(&[first, first + 1, first + 2], 0));
    assert!(plate.check(&CheckOptions::default()).expect("a report").is_meshable());
    said(&plate, "domain.below-lattice");
}

#[test]
fn files_that_are_nearly_right_are_refused_in_one_line() {
    let surplus = off::read_domain(b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 2 0\n3 0 1 2\n3 0 1 2\n");
    let error = surplus.expect_err("one face more").to_string();
    assert!(error.contains("face"), "{error}");
    one_line(&error);
    let error = npy::read(b"\x93NUMPY\x04\x00\x00\x00").expect_err("version 4").to_string();
    assert!(error.contains("version 4"), "{error}");
}

#[test]
fn a_domain_is_read_from_two_files_where_its_points_are_in_the_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    for (name, text, beside) in [
        ("a.poly", "# points elsewhere\n0 3 0 0\n", Some("a.node")),
        ("b.smesh", "0 3 0 0\n", Some("b.node")),
        ("c.poly", "1 3 0 0\n0 0 0 0\n", None),
        ("d.off", "OFF\n0 0 0\n", None),
    ] {
        std::fs::write(path(name), text).expect("a file");
        let wanted: Vec<_> = [Some(name), beside].into_iter().flatten().map(path).collect();
        assert_eq!(io::domain_files(path(name)), wanted);
    }
    assert_eq!(io::domain_files(path("missing.poly")).len(), 1);
}
