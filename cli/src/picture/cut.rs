//! A plane cut through a mesh, as a picture: each tetrahedron that the plane meets is a polygon,
//! coloured by its least dihedral angle.

use ltbw::Point;
use ltbw::quality::TetQuality;
use std::fmt::Write as _;

/// Colours for least dihedral angles below 10°, 20°, ... and from 60° on, from worst to best.
pub(crate) const COLOURS: [&str; 7] =
    ["#b2182b", "#ef8a62", "#fddbc7", "#e0f3f8", "#abd9e9", "#74add1", "#4575b4"];

/// The class of a tetrahedron: an index of [`COLOURS`].
fn class(tet: &TetQuality) -> usize {
    let least = tet.dihedral.into_iter().fold(f64::INFINITY, f64::min);
    // The conversion saturates.
    ((least / 10.0) as usize).min(COLOURS.len() - 1)
}

/// The section of a tetrahedron by the plane `x[axis] = at`: no corners, three, or four in turn,
/// with the coordinates of the two other axes.
fn section(corners: [&Point; 4], axis: usize, at: f64) -> Vec<[f64; 2]> {
    let above = corners.map(|p| p[axis] >= at);
    let axes = [(axis + 1) % 3, (axis + 2) % 3];
    let cross = |i: usize, j: usize| {
        let (p, q) = (corners[i], corners[j]);
        let t = (at - p[axis]) / (q[axis] - p[axis]);
        axes.map(|k| p[k] + t * (q[k] - p[k]))
    };
    let side = |want: bool| (0..4).filter(move |&k| above[k] == want);
    let (up, down): (Vec<usize>, Vec<usize>) = (side(true).collect(), side(false).collect());
    match (&up[..], &down[..]) {
        ([a], [x, y, z]) | ([x, y, z], [a]) => [x, y, z].map(|&k| cross(*a, k)).into(),
        // Neighbours in this order share a corner, so the four are in turn.
        ([a, b], [c, d]) => vec![cross(*a, *c), cross(*a, *d), cross(*b, *d), cross(*b, *c)],
        _ => Vec::new(),
    }
}

/// The cut by the plane `x[axis] = at` as an SVG picture of the given width, without anything from
/// outside it; the picture has no polygons if the plane misses the mesh. Every vertex has to be a
/// point, and `axis` below 3.
pub(crate) fn svg(points: &[Point], tets: &[[u32; 4]], axis: usize, at: f64, width: f64) -> String {
    let mut paths = [const { String::new() }; COLOURS.len()];
    let mut count = 0;
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut sections = Vec::new();
    for tet in tets {
        let corners = tet.map(|v| &points[v as usize]);
        let polygon = section(corners, axis, at);
        if !polygon.is_empty() {
            for p in &polygon {
                low = [low[0].min(p[0]), low[1].min(p[1])];
                high = [high[0].max(p[0]), high[1].max(p[1])];
            }
            sections.push((class(&TetQuality::of(corners)), polygon));
            count += 1;
        }
    }
    let scale = width / (high[0] - low[0]).max(high[1] - low[1]);
    for (class, polygon) in sections {
        for (k, p) in polygon.iter().enumerate() {
            let (x, y) = ((p[0] - low[0]) * scale, (high[1] - p[1]) * scale);
            // Writing to a string cannot fail.
            let _ = write!(paths[class], "{}{x:.1} {y:.1}", if k == 0 { "M" } else { "L" });
        }
        paths[class].push('Z');
    }
    let height = if count > 0 { (high[1] - low[1]) * scale } else { 0.0 };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-1 -1 {:.0} {:.0}\" \
         stroke=\"#333\" stroke-width=\"0.3\" stroke-linejoin=\"round\">\n",
        width + 2.0,
        height + 2.0
    );
    for (path, colour) in paths.iter().zip(COLOURS).filter(|(path, _)| !path.is_empty()) {
        let _ = writeln!(svg, "<path fill=\"{colour}\" d=\"{path}\"/>");
    }
    svg.push_str("</svg>\n");
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the area of a polygon whose corners are in turn.
    fn area(polygon: &[[f64; 2]]) -> f64 {
        let next = polygon.iter().cycle().skip(1);
        polygon.iter().zip(next).map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum::<f64>().abs()
    }

    #[test]
    fn sections_of_a_regular_tetrahedron() {
        let p = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let corners = [&p[0], &p[1], &p[2], &p[3]];
        for axis in 0..3 {
            // Halfway between two opposite edges: a square with the diagonal 2.
            let square = section(corners, axis, 0.0);
            assert_eq!(square.len(), 4);
            assert!((area(&square) - 4.0).abs() < 1e-12, "{square:?}");
            // A rectangle of edges √2/2 and 3√2/2.
            assert!((area(&section(corners, axis, 0.5)) - 3.0).abs() < 1e-12);
            assert!(section(corners, axis, 1.5).is_empty());
        }
        let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let triangle = section([&corner[0], &corner[1], &corner[2], &corner[3]], 2, 0.5);
        assert_eq!(triangle.len(), 3);
        assert!((area(&triangle) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn the_picture_has_a_polygon_for_every_tetrahedron_that_is_met() {
        let points = [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 1.0, 2.0],
            [0.0, 0.0, 9.0],
        ];
        let tets = [[0, 1, 2, 3], [1, 2, 3, 4], [1, 2, 4, 5]];
        let picture = svg(&points, &tets, 2, 0.5, 100.0);
        assert_eq!(picture.matches('Z').count(), 3);
        assert!(picture.starts_with("<svg") && picture.ends_with("</svg>\n"));
        assert!(!picture.contains("NaN") && !picture.contains("inf"));
        let nothing = svg(&points, &tets, 2, 10.0, 100.0);
        assert_eq!(nothing.matches("<path").count(), 0);
        assert!(!nothing.contains("NaN") && !nothing.contains("inf"));
    }
}
