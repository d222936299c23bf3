//! Surfaces as CAD programs and scanners write them: triangles that are flat, round or noisy only
//! up to the last bits of their coordinates.
//!
//! The families are those on which boundary recovery fails first: fans of needles in planes that
//! rounding has bent, quadrilaterals cut along a fold of 10^-7 degrees, sheets that meet at small
//! angles, and thin plates. Coordinates are made with + − × ÷ √ only, so that a surface is the same
//! on every machine. All facets point outwards.

use super::Random;
use super::domains::sine_cosine;
use ltbw_domain::{Domain, Facet};
use ltbw_exact::Point;

/// A point on the unit circle, `part` of `parts` around it.
pub(super) fn around(part: u32, parts: u32) -> [f64; 2] {
    let degrees = 360.0 * f64::from(part % parts) / f64::from(parts);
    // The series is for angles up to 180 degrees.
    let [sine, cosine] = sine_cosine(if degrees > 180.0 { degrees - 360.0 } else { degrees });
    [cosine, sine]
}

/// A number of mean 0 and variance 1, nearly normal: the sum of twelve uniform ones.
fn normal(random: &mut Random) -> f64 {
    (0..12).map(|_| random.unit()).sum::<f64>() - 6.0
}

/// Multiplies every vertex by 1 + `noise` times a normal number.
fn shake(domain: &mut Domain, noise: f64, seed: u64) {
    let mut random = Random::new(seed);
    for p in &mut domain.vertices {
        let factor = 1.0 + noise * normal(&mut random);
        *p = p.map(|c| c * factor);
    }
}

fn surface(vertices: Vec<Point>, triangles: &[[u32; 3]]) -> Domain {
    let facets = triangles.iter().map(|t| Facet::polygon(t, 0)).collect();
    Domain { vertices, facets, ..Domain::default() }
}

/// A prism over a regular polygon of `corners` (at least 3) with radius 0.5 between z = ±0.5: its
/// sides are two triangles each, its caps fans from the first corner.
///
/// Every vertex is multiplied by 1 + `noise` times a normal number.
#[must_use]
pub fn prism(corners: u32, noise: f64, seed: u64) -> Domain {
    let n = corners.max(3);
    let ring = |z: f64| (0..n).map(move |i| around(i, n)).map(move |[x, y]| [x / 2.0, y / 2.0, z]);
    let mut triangles = Vec::new();
    for i in 0..n {
        let next = (i + 1) % n;
        triangles.extend([[i, next, n + next], [i, n + next, n + i]]);
    }
    for i in 1..n - 1 {
        triangles.extend([[0, i + 1, i], [n, n + i, n + i + 1]]);
    }
    let mut domain = surface(ring(-0.5).chain(ring(0.5)).collect(), &triangles);
    shake(&mut domain, noise, seed);
    domain
}

/// A sphere of radius 0.5 by latitude and longitude: `rows` (at least 3) from pole to pole, both of
/// them fans, and `columns` (at least 3) around.
///
/// Every vertex is multiplied by 1 + `noise` times a normal number.
#[must_use]
pub fn globe(rows: u32, columns: u32, noise: f64, seed: u64) -> Domain {
    let (rings, columns) = (rows.max(3) - 2, columns.max(3));
    let mut vertices = vec![[0.0, 0.0, 0.5]];
    for row in 1..=rings {
        let [sine, cosine] = sine_cosine(180.0 * f64::from(row) / f64::from(rings + 1));
        let column = |i| around(i, columns).map(|c| c * sine / 2.0);
        vertices.extend((0..columns).map(column).map(|[x, y]| [x, y, cosine / 2.0]));
    }
    vertices.push([0.0, 0.0, -0.5]);
    let at = |row: u32, column: u32| 1 + row * columns + column % columns;
    let south = 1 + rings * columns;
    let mut triangles = Vec::new();
    for i in 0..columns {
        triangles
            .extend([[0, at(0, i), at(0, i + 1)], [south, at(rings - 1, i + 1), at(rings - 1, i)]]);
        for row in 1..rings {
            let [a, b] = [at(row - 1, i), at(row - 1, i + 1)];
            let [c, d] = [at(row, i), at(row, i + 1)];
            triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    let mut domain = surface(vertices, &triangles);
    shake(&mut domain, noise, seed);
    domain
}

/// A plate over a star with `points` (at least 3) tips of some 15 degrees: its sides are two
/// triangles each, and above and below are fans around the middle. By chance, from `seed`, no two
/// tips are alike.
///
/// Every vertex is multiplied by 1 + `noise` times a normal number.
#[must_use]
pub fn star(points: u32, noise: f64, seed: u64) -> Domain {
    let n = 2 * points.max(3);
    let mut random = Random::new(seed);
    let mut radius = |i: u32| match i % 2 {
        0 => 0.5 + 0.2 * random.unit(),
        _ => 0.05 + 0.05 * random.unit(),
    };
    let outline: Vec<_> = (0..n).map(|i| (around(i, n), radius(i))).collect();
    let ring = |z: f64| outline.iter().map(move |([x, y], r)| [x * r, y * r, z]);
    let middles = [[0.0, 0.0, -0.1], [0.0, 0.0, 0.1]];
    let mut triangles = Vec::new();
    for i in 0..n {
        let next = (i + 1) % n;
        triangles.extend([[i, next, n + next], [i, n + next, n + i]]);
        triangles.extend([[2 * n, next, i], [2 * n + 1, n + i, n + next]]);
    }
    let vertices = ring(-0.1).chain(ring(0.1)).chain(middles).collect();
    let mut domain = surface(vertices, &triangles);
    shake(&mut domain, noise, seed);
    domain
}

/// A ramp of side 1 that rises to `height`: two sheets of `cells` (at least 1) squares each way,
/// cut in two triangles each, which meet at an edge.
///
/// Every vertex is multiplied by 1 + `noise` times a normal number.
#[must_use]
pub fn ramp(cells: u32, height: f64, noise: f64, seed: u64) -> Domain {
    let n = cells.max(1);
    let (side, mut vertices, mut triangles) = (n + 1, Vec::new(), Vec::new());
    let part = |k: u32| f64::from(k) / f64::from(n);
    for (first, slope) in [(0, 0.0), (1, height)] {
        let rows = (first..side).flat_map(|i| (0..side).map(move |j| [part(i), part(j)]));
        vertices.extend(rows.map(|[x, y]| [x, y, slope * x]));
    }
    let low = |i: u32, j: u32| i * side + j;
    // The first row is one for both.
    let high = |i: u32, j: u32| if i == 0 { j } else { (n + i) * side + j };
    for i in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [low(i, j), low(i + 1, j), low(i + 1, j + 1), low(i, j + 1)];
            triangles.extend([[a, c, b], [a, d, c]]);
            let [a, b, c, d] = [high(i, j), high(i + 1, j), high(i + 1, j + 1), high(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        for (j, is_first) in [(0, true), (n, false)] {
            let [a, b, c, d] = [low(i, j), low(i + 1, j), high(i + 1, j), high(i, j)];
            let all = [[a, b, c], [a, c, d]].into_iter().take(if i == 0 { 1 } else { 2 });
            triangles.extend(all.map(|[a, b, c]| if is_first { [a, b, c] } else { [a, c, b] }));
        }
        let [a, b, c, d] = [low(n, i), low(n, i + 1), high(n, i + 1), high(n, i)];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    let mut domain = surface(vertices, &triangles);
    shake(&mut domain, noise, seed);
    domain
}

/// A torus of radii 0.5 and 0.2: `parts` (at least 3) around the axis and as many around the tube,
/// two triangles each.
#[must_use]
pub fn torus(parts: u32) -> Domain {
    let n = parts.max(3);
    let place = |i: u32, j: u32| {
        let ([x, y], [out, up]) = (around(i, n), around(j, n));
        let radius = 0.5 + 0.2 * out;
        [radius * x, radius * y, 0.2 * up]
    };
    let vertices = (0..n).flat_map(|i| (0..n).map(move |j| place(i, j))).collect();
    let at = |i: u32, j: u32| i % n * n + j % n;
    let quads = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let triangles: Vec<[u32; 3]> = quads
        .flat_map(|(i, j)| {
            let [a, b] = [at(i, j), at(i + 1, j)];
            let [c, d] = [at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    surface(vertices, &triangles)
}

/// A box with `sheets` that are hinged on one line inside it, `degrees` apart from each other.
///
/// The sheets are no wider than the box for up to 180 degrees in all.
#[must_use]
pub fn book(sheets: u32, degrees: f64) -> Domain {
    let mut vertices = Vec::new();
    for i in 0..8_u32 {
        vertices.push([0, 1, 2].map(|k| if i >> k & 1 == 0 { -1.0 } else { 1.0 }));
    }
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut facets: Vec<Facet> = faces.iter().map(|face| Facet::polygon(face, 0)).collect();
    // The hinge.
    vertices.extend([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]);
    for i in 0..sheets {
        let [sine, cosine] = sine_cosine((f64::from(i) * degrees).min(180.0));
        let first = vertices.len() as u32;
        vertices.extend([-0.5, 0.5].map(|z| [0.75 * cosine, 0.75 * sine, z]));
        facets.push(Facet::polygon(&[8, first, first + 1, 9], 1));
    }
    Domain { vertices, facets, ..Domain::default() }
}

/// A plate of `cells` (at least 1) squares of side 1 each way, cut in two triangles each, and as
/// thick as `thickness`.
#[must_use]
pub fn plate(cells: u32, thickness: f64) -> Domain {
    let n = cells.max(1);
    let side = n + 1;
    let level = |z: f64| {
        (0..side).flat_map(move |i| (0..side).map(move |j| [f64::from(i), f64::from(j), z]))
    };
    let at = |i: u32, j: u32| i * side + j;
    let above = side * side;
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let [a, b] = [at(i, j), at(i + 1, j)];
            let [c, d] = [at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[a, c, b], [a, d, c]]);
            triangles.extend([[a, b, c], [a, c, d]].map(|t| t.map(|v| v + above)));
        }
        let border = [
            [at(i, 0), at(i + 1, 0)],
            [at(n, i), at(n, i + 1)],
            [at(i + 1, n), at(i, n)],
            [at(0, i + 1), at(0, i)],
        ];
        for [a, b] in border {
            triangles.extend([[a, b, b + above], [a, b + above, a + above]]);
        }
    }
    surface(level(0.0).chain(level(thickness)).collect(), &triangles)
}

/// A cube of side 1 with a void that leaves a wall of this thickness (below 0.5): all faces are cut
/// into two triangles.
#[must_use]
pub fn shell(thickness: f64) -> Domain {
    let corners = |low: f64, high: f64| {
        (0..8_u32).map(move |i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { low } else { high }))
    };
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut triangles = Vec::new();
    for [a, b, c, d] in faces {
        triangles.extend([[a, b, c], [a, c, d]]);
        triangles.extend([[a, c, b], [a, d, c]].map(|t| t.map(|v| v + 8)));
    }
    let inner = corners(thickness, 1.0 - thickness);
    surface(corners(0.0, 1.0).chain(inner).collect(), &triangles)
}

/// The domain with every coordinate rounded to the nearest 32-bit float, as binary `.stl` files
/// keep it.
#[must_use]
pub fn single(mut domain: Domain) -> Domain {
    domain.vertices.iter_mut().flatten().for_each(|c| *c = f64::from(*c as f32));
    domain
}

/// The domain turned by 30 degrees about the axis (1, 2, 3) through the origin.
#[must_use]
pub fn turned(domain: &Domain) -> Domain {
    // Rodrigues' formula: the cosine is √3/2, the sine 1/2.
    let (cosine, sine) = (3.0_f64.sqrt() / 2.0, 0.5);
    let length = 14.0_f64.sqrt();
    let axis = [1.0 / length, 2.0 / length, 3.0 / length];
    map_points(domain, |p| {
        let along = (axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2]) * (1.0 - cosine);
        [0, 1, 2].map(|k: usize| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            p[k] * cosine + (axis[i] * p[j] - axis[j] * p[i]) * sine + axis[k] * along
        })
    })
}

/// The domain with a function applied to all its points: vertices and seeds.
#[must_use]
pub fn map_points(domain: &Domain, image: impl Fn(Point) -> Point) -> Domain {
    let mut domain = domain.clone();
    let seeds = domain.holes.iter_mut().chain(domain.regions.iter_mut().map(|r| &mut r.seed));
    let seeds = seeds.chain(domain.facets.iter_mut().flat_map(|f| &mut f.holes));
    seeds.chain(&mut domain.vertices).for_each(|p| *p = image(*p));
    domain
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltbw_domain::{CheckOptions, DefectKind};

    fn volume(name: &str, domain: &Domain, oriented: bool) -> f64 {
        let options = CheckOptions { oriented, ..CheckOptions::default() };
        let report = domain.check(&options).expect("a domain");
        assert!(report.passed(), "{name}: {:?}", report.defects.first());
        report.volume().expect("cells").to_f64()
    }

    #[test]
    fn the_surfaces_are_sound_and_have_their_volumes() {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        // Six triangles of radius 1/2.
        let hexagon = 6.0 * 3.0_f64.sqrt() / 16.0;
        assert!(near(volume("prism", &prism(6, 0.0, 0), true), hexagon));
        for noise in [1e-6, 1e-4, 1e-2] {
            volume("noisy prism", &prism(48, noise, 3), true);
            volume("noisy globe", &single(globe(30, 30, noise, 1)), true);
        }
        let ball = volume("globe", &globe(100, 100, 0.0, 0), true);
        assert!((0.52..std::f64::consts::FRAC_PI_6).contains(&ball), "{ball}");
        let ring = volume("torus", &single(torus(49)), true);
        assert!((0.38..0.3948).contains(&ring), "{ring}");
        assert!(near(volume("book", &book(6, 10.0), false), 8.0));
        assert!(near(volume("plate", &plate(4, 0.001), true), 0.016));
        assert!(near(volume("shell", &shell(0.25), true), 0.875));
    }

    #[test]
    fn a_book_has_its_sheets_and_a_globe_its_triangles() {
        let domain = book(6, 10.0);
        let report = domain.check(&CheckOptions::default()).expect("a domain");
        // Three free edges a sheet.
        assert_eq!(report.count(DefectKind::Dangling), 18, "{:?}", report.counts);
        assert_eq!(globe(30, 30, 0.0, 0).facets.len(), 1680);
        assert_eq!(torus(99).facets.len(), 19_602);
        assert_eq!(prism(12, 1e-6, 0).facets.len(), 44);
    }

    #[test]
    fn a_turn_keeps_lengths_and_the_axis() {
        let domain =
            Domain { vertices: vec![[1.0, 2.0, 3.0], [1.0, -2.0, 1.0]], ..Domain::default() };
        let turned = turned(&domain);
        let square = |p: &Point| p.iter().map(|c| c * c).sum::<f64>();
        assert!((0..3).all(|k| (turned.vertices[0][k] - domain.vertices[0][k]).abs() < 1e-14));
        assert!((square(&turned.vertices[1]) - square(&domain.vertices[1])).abs() < 1e-14);
        // By 30 degrees: the second vertex is at a right angle to the axis.
        let dot: f64 = (0..3).map(|k| turned.vertices[1][k] * domain.vertices[1][k]).sum();
        assert!((dot / 6.0 - 3.0_f64.sqrt() / 2.0).abs() < 1e-14, "{dot}");
    }
}
