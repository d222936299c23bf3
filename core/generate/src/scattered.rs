//! Points at random in a domain: in its box, on its facets, on its edges.

use ltbw_core::Random;
use ltbw_domain::Domain;
use ltbw_exact::Point;

/// Points at random.
#[derive(Debug, Clone, PartialEq)]
pub struct Scattered {
    /// In the box of the domain: inside of it, or outside.
    pub in_box: Vec<Point>,
    /// In triangles of facets, up to rounding.
    pub on_facets: Vec<Point>,
    /// On edges of polygons, up to rounding.
    pub on_edges: Vec<Point>,
}

impl Scattered {
    /// All of them: those in the box first, then those on facets.
    #[must_use]
    pub fn all(self) -> Vec<Point> {
        [self.in_box, self.on_facets, self.on_edges].concat()
    }
}

/// As many points on facets and on edges of a domain as `count` says, and four times as many in
/// its box; none where it has no facets.
#[must_use]
pub fn scattered(domain: &Domain, seed: u64, count: usize) -> Scattered {
    let mut random = Random::new(seed);
    let all = 0..domain.facets.len() as u32;
    let found = all.filter_map(|f| domain.triangulate(f));
    let triangles: Vec<[u32; 3]> = found.flat_map(|found| found.triangles).collect();
    let at = |v: u32| domain.vertices[v as usize];
    let (mut on_facets, mut on_edges) = (Vec::new(), Vec::new());
    let (low, high) = domain.bounds().unwrap_or_default();
    let most = if triangles.is_empty() { 0 } else { count };
    for _ in 0..most {
        let t = triangles[random.below(triangles.len() as u64) as usize].map(at);
        let [x, y] = [random.unit(), random.unit()];
        let [x, y] = if x + y > 1.0 { [1.0 - x, 1.0 - y] } else { [x, y] };
        let z = 1.0 - x - y;
        on_facets.push([0, 1, 2].map(|k| z * t[0][k] + x * t[1][k] + y * t[2][k]));
        let polygons = &domain.facets[random.below(domain.facets.len() as u64) as usize].polygons;
        let Some(ring) = polygons.first() else { continue };
        let k = random.below(ring.len() as u64) as usize;
        let [a, b] = [at(ring[k]), at(ring[(k + 1) % ring.len()])];
        on_edges.push([0, 1, 2].map(|k| a[k] + x * (b[k] - a[k])));
    }
    let in_box = (0..4 * most)
        .map(|_| [0, 1, 2].map(|k| low[k] + random.unit() * (high[k] - low[k])))
        .collect();
    Scattered { in_box, on_facets, on_edges }
}
