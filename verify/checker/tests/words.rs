//! The words of a report and of its certificate, beside the numbers.

use ltbw_verify::{Depth, Hash, Kind, Level, Mesh, Options, check};

const POINTS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

#[test]
fn levels_have_names() {
    let names = [
        (Level::Structure, "structure"),
        (Level::Topology, "topology"),
        (Level::Orientation, "orientation"),
        (Level::Delaunay, "delaunay"),
        (Level::Canonical, "canonical"),
    ];
    for (level, name) in names {
        assert_eq!((level.to_string().as_str(), level.name()), (name, name));
    }
}

#[test]
fn a_defect_names_tetrahedra_points_and_coordinates() {
    let report = check(&Mesh::new(&POINTS, &[[0, 1, 2, 3], [0, 1, 2, 9]]), &Options::default());
    let missing = report.defects.iter().find(|d| d.kind == Kind::IndexOutOfRange).expect("named");
    // There is no point 9: no coordinates.
    let text = missing.to_string();
    let corners = "0 at (0.0, 0.0, 0.0), 1 at (1.0, 0.0, 0.0), 2 at (0.0, 1.0, 0.0), 9, ";
    let kind = Kind::IndexOutOfRange;
    assert_eq!(text, format!("{kind}: tets [1], {corners}{}", kind.text()));

    // A facet claimed twice belongs to no tetrahedron.
    let hull = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3], [1, 2, 3]];
    let mesh = Mesh::new(&POINTS, &[[0, 1, 2, 3]]);
    let report = check(&mesh.with_hull(&hull), &Options::default());
    let kind = Kind::HullFacetExtra;
    let extra = report.defects.iter().find(|d| d.kind == kind).expect("named");
    assert!(extra.to_string().starts_with(&format!("{kind}: 1 at (1.0, 0.0, 0.0), 2 at ")));

    let mut flat = POINTS;
    flat[3] = [1.0, 1.0, 0.0];
    let report = check(&Mesh::new(&flat, &[[0, 1, 2, 3]]), &Options::default());
    let defect = report.defects.iter().find(|d| d.kind == Kind::FlatTet).expect("named");
    let text = defect.to_string();
    assert!(text.contains("3 at (1.0, 1.0, 0.0), "), "{text}");
}

#[test]
fn a_hash_that_was_not_asked_for_is_not_there() {
    let mesh = Mesh::new(&POINTS, &[[0, 1, 2, 3]]);
    let options = Options { depth: Depth::Fast, ..Options::default() };
    for neighbours in [None, Some([[ltbw_verify::NO_NEIGHBOUR; 4]])] {
        let mesh = match &neighbours {
            Some(claimed) => mesh.with_neighbours(claimed),
            None => mesh,
        };
        let report = check(&mesh, &options);
        assert!(report.passed());
        assert_eq!(report.hash, Hash::Skipped);
        let json = report.certificate().to_json().expect("a certificate");
        assert!(json.contains("\"hash\": null,\n    \"no_hash\": \"not asked for\""), "{json}");
        assert!(matches!(check(&mesh, &Options::default()).hash, Hash::Value(_)));
    }
}
