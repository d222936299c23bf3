use super::Parts;
use crate::{Domain, Facet, PrepareOptions, Prepared};

fn ready(domain: &Domain) -> Prepared {
    let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
    domain.prepare(&options).expect("a sound domain")
}

/// A closed prism over a regular polygon, of triangles.
fn prism(sides: u32, radius: f64, height: f64) -> Domain {
    let rim = |k: u32, z: f64| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(sides);
        [radius * angle.cos(), radius * angle.sin(), z]
    };
    let mut vertices: Vec<_> =
        (0..2 * sides).map(|v| rim(v % sides, if v < sides { 0.0 } else { height })).collect();
    vertices.extend([[0.0; 3], [0.0, 0.0, height]]);
    let (low, high) = (2 * sides, 2 * sides + 1);
    let corners = (0..sides).flat_map(|k| {
        let next = (k + 1) % sides;
        let (a, b, c, d) = (k, next, k + sides, next + sides);
        [[b, a, low], [c, d, high], [a, b, d], [a, d, c]]
    });
    let facets = corners.map(|t| Facet::polygon(&t, 0)).collect();
    Domain { vertices, facets, ..Domain::default() }
}

#[test]
fn a_cylinder_has_three_parts_by_area_and_place() {
    let ready = ready(&prism(24, 1.0, 3.0));
    let parts = Parts::smooth(&ready, 40.0, 0.0);
    let told: Vec<_> = parts.list.iter().map(|part| (part.marker, part.facets)).collect();
    assert_eq!(told, [(1, 48), (2, 24), (3, 24)]);
    let [side, low, high] = &parts.list[..] else { panic!("three parts") };
    assert!(side.normal.is_none() && side.area > 18.7 && side.area < 18.85, "{side:?}");
    assert_eq!((low.normal, high.normal), (Some([0.0, 0.0, -1.0]), Some([0.0, 0.0, 1.0])));
    assert_eq!((low.high[2], high.low[2]), (0.0, 3.0));
    for (facet, marker) in ready.domain.facets.iter().zip(&parts.markers) {
        let heights = facet.polygons[0].iter().map(|&v| ready.domain.vertices[v as usize][2]);
        let sum: f64 = heights.sum();
        assert_eq!(
            *marker,
            if sum == 0.0 {
                2
            } else if sum == 9.0 {
                3
            } else {
                1
            }
        );
    }
}

#[test]
fn the_angle_itself_is_a_feature() {
    // Sides of an octagon meet at 45 degrees, within the rounding of its corners.
    let ready = ready(&prism(8, 1.0, 1.0));
    let count = |degrees| Parts::smooth(&ready, degrees, 0.0).list.len();
    assert_eq!([count(44.0), count(46.0), count(90.0)], [10, 3, 3]);
    // The sides of a cube meet at 90 degrees, and the number for these is not below any.
    let cube = super::tests::ready(&Domain::cuboid([0.0; 3], [1.0; 3]));
    assert_eq!(Parts::smooth(&cube, 90.0, 0.0).list.len(), 6);
}

#[test]
fn the_order_of_the_file_does_not_matter() {
    let domain = prism(12, 1.0, 2.0);
    let mut turned = domain.clone();
    turned.facets.reverse();
    let [one, other] = [&domain, &turned].map(|domain| Parts::smooth(&ready(domain), 40.0, 0.0));
    assert_eq!(one.list, other.list);
    assert!(one.markers.iter().eq(other.markers.iter().rev()));
}

#[test]
fn needles_go_with_the_neighbour_at_their_longest_side() {
    // A side of a cube with a vertex beside an edge of two triangles, a little above the plane:
    // the needle's normal is far from all others.
    let mut cube = Domain::cuboid([0.0; 3], [1.0; 3]);
    let v = cube.vertices.len() as u32;
    cube.vertices.push([0.5 + 1e-7, 0.5, 1.0 + 1e-7]);
    let top = cube.facets.pop().expect("a side").polygons.remove(0);
    let [a, b, c, d] = top[..] else { panic!("four corners") };
    for triangle in [[a, b, v], [b, c, v], [c, a, v], [a, c, d]] {
        cube.facets.push(Facet::polygon(&triangle, 0));
    }
    let ready = ready(&cube);
    assert_eq!(Parts::smooth(&ready, 40.0, 1e-5).list.len(), 6);
    // Else it parts what is above the edge from what is below.
    assert_eq!(Parts::smooth(&ready, 40.0, 0.0).list.len(), 8);
}

#[test]
fn markers_are_parts_where_there_are_some() {
    let parts = Parts::marked(&ready(&Domain::cuboid([0.0; 3], [1.0, 2.0, 3.0])));
    let told: Vec<_> = parts.list.iter().map(|part| (part.marker, part.area)).collect();
    assert_eq!(told, [(1, 6.0), (2, 6.0), (3, 3.0), (4, 3.0), (5, 2.0), (6, 2.0)]);
}
