//! Remedies for what is excused: the tolerance or the bound with which less would be.

use ltbw::Point;
use ltbw::domain::{Domain, Prepared};
use ltbw::refine::{Excused, Reason, Refined, largest_tolerance};
use std::collections::HashSet;

/// The largest bound of shape that is still one.
const LOOSEST: f64 = 20.0;

/// The vertices of the domain that a reason is about.
pub(crate) fn vertices(reason: &Reason) -> Vec<u32> {
    match *reason {
        Reason::SmallDihedral { segment } => segment.to_vec(),
        Reason::SmallFaceAngle { corner } | Reason::NearFacet { corner } => vec![corner],
        Reason::NearSegments { first, second } => [first, second].concat(),
        _ => Vec::new(),
    }
}

/// Options that would help at these places.
pub(crate) fn remedies(
    refined: &Refined,
    ready: &Prepared,
    places: &[Excused],
    radius_edge: Option<f64>,
) -> Vec<String> {
    let around = |excused: &Excused| Around::of(&ready.domain, &vertices(&excused.reason));
    let around: Vec<Around<'_>> = places.iter().map(around).collect();
    let limit = largest_tolerance(&ready.domain);
    // The least tolerance that does something at every place where one does.
    let largest = |of: &dyn Fn(&Around<'_>) -> Option<f64>| {
        around.iter().filter_map(of).max_by(f64::total_cmp).map(rounded_up)
    };
    let within = |from: f64| move |&tolerance: &f64| from < tolerance && tolerance <= limit / 1.1;
    let flat = largest(&|at| at.flat(within(refined.stats.flat_tolerance)));
    let weld = largest(&|at| at.gap(within(0.0)));
    let shape = radius_edge.and_then(|bound| largest(&|at| at.shape(bound)));
    let options = [
        ("--flat-tolerance", flat, "takes facets there for one"),
        ("--repair", weld, "welds vertices there"),
        ("--radius-edge", shape, "suits the angles there"),
    ];
    let option = |(name, value, does): (&str, Option<f64>, &str)| {
        value.map(|value| format!("{name} {value} {does}"))
    };
    options.into_iter().filter_map(option).collect()
}

/// A number with two digits that is not below `x`.
pub(crate) fn rounded_up(x: f64) -> f64 {
    let short = |x: f64| format!("{x:.1e}").parse().unwrap_or(x);
    let near: f64 = short(x);
    if near >= x { near } else { short(1.05 * x) }
}

/// The polygons at some vertices.
struct Around<'a> {
    domain: &'a Domain,
    vertices: Vec<u32>,
    polygons: Vec<&'a Vec<u32>>,
}

impl<'a> Around<'a> {
    fn of(domain: &'a Domain, vertices: &[u32]) -> Self {
        let all = domain.facets.iter().flat_map(|facet| &facet.polygons);
        let polygons = all.filter(|p| p.len() > 2 && p.iter().any(|v| vertices.contains(v)));
        Self { domain, vertices: vertices.to_vec(), polygons: polygons.collect() }
    }

    fn at(&self, v: u32) -> Point {
        self.domain.vertices.get(v as usize).copied().unwrap_or_default()
    }

    /// Twice the area of a polygon along its normal.
    fn normal(&self, polygon: &[u32]) -> Point {
        let first = self.at(polygon[0]);
        let arm = |v: u32| minus(self.at(v), first);
        let crosses = polygon.windows(2).map(|w| cross(arm(w[0]), arm(w[1])));
        crosses.fold([0.0; 3], |sum, c| [0, 1, 2].map(|k| sum[k] + c[k]))
    }

    /// The least distance, among those wanted, within which two polygons with a common edge that
    /// turn less than 60 degrees are coplanar.
    fn flat(&self, is_wanted: impl Fn(&f64) -> bool) -> Option<f64> {
        let share_edge = |a: &[u32], b: &[u32]| a.iter().filter(|v| b.contains(v)).count() > 1;
        let pairs = self.polygons.iter().enumerate().flat_map(|(k, a)| {
            self.polygons[k + 1..].iter().map(move |b| (a, b)).filter(|(a, b)| share_edge(a, b))
        });
        let apart = pairs.filter_map(|(a, b)| {
            let (m, n) = (self.normal(a), self.normal(b));
            let (large, normal, small) = if length(m) >= length(n) { (a, m, b) } else { (b, n, a) };
            let turns_little = dot(m, n).abs() > 0.5 * length(m) * length(n);
            let off = |&v: &u32| dot(normal, minus(self.at(v), self.at(large[0]))).abs();
            let most = small.iter().map(off).max_by(f64::total_cmp)?;
            turns_little.then_some(most / length(normal))
        });
        apart.filter(is_wanted).min_by(f64::total_cmp)
    }

    /// The least distance, among those wanted, from one of the vertices to one with which it
    /// shares no polygon.
    fn gap(&self, is_wanted: impl Fn(&f64) -> bool) -> Option<f64> {
        let gap = |&v: &u32| {
            let own = self.polygons.iter().filter(|p| p.contains(&v));
            let beside: HashSet<u32> = own.flat_map(|p| p.iter().copied()).chain([v]).collect();
            let others = (0..).zip(&self.domain.vertices).filter(|(w, _)| !beside.contains(w));
            let distances = others.map(|(_, p)| length(minus(*p, self.at(v))));
            distances.filter(&is_wanted).min_by(f64::total_cmp)
        };
        self.vertices.iter().filter_map(gap).min_by(f64::total_cmp)
    }

    /// The ratio of circumradius to shortest edge of an isosceles triangle in the sharpest angle of
    /// a polygon there, if that is over the bound.
    fn shape(&self, bound: f64) -> Option<f64> {
        let ratio = |v: u32, polygon: &Vec<u32>| {
            let (k, count) = (polygon.iter().position(|&w| w == v)?, polygon.len());
            let arm = |w: u32| minus(self.at(w), self.at(v));
            let (a, b) = (arm(polygon[(k + 1) % count]), arm(polygon[(k + count - 1) % count]));
            let sine = length(cross(a, b)) / (length(a) * length(b));
            (dot(a, b) > 0.0).then_some(0.5 / sine)
        };
        let pairs = self.vertices.iter().flat_map(|&v| self.polygons.iter().map(move |p| (v, *p)));
        let ratios = pairs.filter_map(|(v, polygon)| ratio(v, polygon));
        ratios.filter(|&r| bound < r && r <= LOOSEST).max_by(f64::total_cmp)
    }
}

fn minus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i] * b[j] - a[j] * b[i]
    })
}

fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_up_to_two_digits() {
        let cases = [(1.0, 1.0), (0.012_01, 0.013), (9.99e-5, 1e-4), (2.5e-7, 2.5e-7)];
        for (x, expected) in cases {
            assert_eq!(rounded_up(x), expected, "{x}");
        }
        assert!(rounded_up(1.949_99) >= 1.949_99);
    }

    #[test]
    fn a_tolerance_a_gap_and_an_angle_are_found() {
        // Two triangles on an edge, one corner 1e-4 off; a vertex beside a corner.
        let vertices = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 0.25, 0.0],
            [0.0, 0.5, 1e-4],
            [0.0, 3e-5, 0.0],
        ];
        let facet = |f: &[u32]| ltbw::Facet::polygon(f, 0);
        let facets = vec![facet(&[0, 1, 2]), facet(&[0, 2, 3])];
        let domain = Domain { vertices, facets, ..Domain::default() };
        let at = Around::of(&domain, &[0]);
        let near = |found: Option<f64>, expected: f64| {
            found.is_some_and(|f| (f - expected).abs() < 1e-6 * expected)
        };
        let any = |&x: &f64| x < 1e-3;
        assert!(near(at.gap(any), 3e-5), "{:?}", at.gap(any));
        let flat = at.flat(any).expect("a tolerance");
        assert!(0.4e-4 < flat && flat <= 1e-4, "{flat:e}");
        assert_eq!(at.flat(|&x| x > 1e-4), None);
        // The angle of the first triangle has the tangent 1/4.
        let shape = at.shape(2.0).expect("a bound");
        assert!(near(Some(shape), 0.5 * 17.0_f64.sqrt()), "{shape}");
        assert_eq!(at.shape(2.5), None);
    }
}
