//! Random domains, the same on every machine, and domains as refinement and the checker take them.

use crate::layered::{Stack, random_honeycomb, random_laminate};
use ltbw::domain::{Domain, Facet, PrepareOptions, Prepared};
use ltbw_generate::{DomainKind, Shape, generate_domain, surfaces};
use ltbw_verify::Plc;

/// The faces of a box whose corners are numbered by the bits of their places.
const FACES: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

/// The paper's problems, each with a largest volume and the most tetrahedra that it may have
/// without a bound on dihedral angles: TetGen's, for the gear 0.99 of those that splitting one item
/// after the other took.
pub const PROBLEMS: [(DomainKind, f64, usize); 4] = [
    (DomainKind::CubeOctahedron, 1.73783e-5, 104_182),
    (DomainKind::CubeInCube, 1.68e-5, 104_956),
    (DomainKind::Tee, 5e-5, 109_003),
    (DomainKind::Gear, 1e-5, 106_023),
];

/// Named domains, each with a largest volume and an angle, if it has one, and the hashes of the
/// whole mesh, exterior included, in rounds from 256 vertices on, with the usual bound on dihedral
/// angles and without one: the same on every machine. Refinement may change them, by rules of its
/// own; a run on another machine, or with other threads, may not.
pub const NAMED: [(DomainKind, f64, Option<f64>, [&str; 2]); 20] = [
    (DomainKind::CubeOctahedron, 1e-2, None, ["5b6987983821008c", "1ad722d693ffe295"]),
    (DomainKind::CubeOctahedron, 1e-3, None, ["14abc10b7f1b2097", "4eff388bba03d92b"]),
    (DomainKind::CubeInCube, 1e-2, None, ["e875526381ffded3", "e875526381ffded3"]),
    (DomainKind::CubeInCube, 1e-3, None, ["7fdc4fee3dc85043", "2f1b302e57baab19"]),
    (DomainKind::Gear, 1e-2, None, ["5c6abe08abee17f8", "e8653e1c0984e683"]),
    (DomainKind::Gear, 1e-3, None, ["7a5bb943336c447d", "b55034a22a18e1a3"]),
    (DomainKind::Tee, 1e-3, None, ["49e564265ac165c6", "8094364a9f731824"]),
    (DomainKind::Tee, 3e-4, None, ["7ae1b9871c3fed9a", "892632b4a3e2bad1"]),
    (DomainKind::Wedge, 1e-2, Some(45.0), ["61bd2dc31f9e437f", "7fca10b507540fc6"]),
    (DomainKind::Wedge, 1e-2, Some(30.0), ["16393843bb8f65b0", "16393843bb8f65b0"]),
    (DomainKind::Wedge, 1e-2, Some(5.0), ["11ee54907962d03e", "11ee54907962d03e"]),
    (DomainKind::Wedge, 1e-2, Some(1.0), ["df24dbf5dd61bf59", "df24dbf5dd61bf59"]),
    (DomainKind::Spike, 1e-2, Some(30.0), ["f7ffadf8f62251e4", "4ee40f0ce92e48c2"]),
    (DomainKind::Spike, 1e-2, Some(10.0), ["e5cf4a62bcbf7785", "6b6248848f23c598"]),
    (DomainKind::Spike, 1e-2, Some(2.0), ["3428e730c4fd0de1", "b3db02f3df07103f"]),
    (DomainKind::LBlock, 1e-2, None, ["7d05c3c978ef064e", "537bbd7f7c35ffda"]),
    (DomainKind::Stair, 1e-2, None, ["7484f466aeb23c2b", "bc4f74ddf3450b4d"]),
    (DomainKind::Voxels, 1e-1, None, ["309655a1a39c00b3", "a31000a7bb2da875"]),
    (DomainKind::Schoenhardt, 1e-3, None, ["abfc523b5a29eb77", "958eeec6fb670181"]),
    (DomainKind::TwoMaterial, 1e-2, None, ["c0246c37d00ceedc", "c6c9b70d2bab9f60"]),
];

/// A domain prepared with the usual options.
///
/// # Panics
/// If it is not sound.
#[must_use]
pub fn prepared(domain: &Domain) -> Prepared {
    domain.prepare(&PrepareOptions::default()).expect("a sound domain")
}

/// The two thousandth part of the volume of a domain's box: as a bound, it makes a few hundred
/// tetrahedra or more.
///
/// # Panics
/// If the domain has no vertices: a sound one has.
#[must_use]
pub fn small_volume(domain: &Domain) -> f64 {
    let (low, high) = domain.bounds().expect("vertices");
    (0..3).map(|k| high[k] - low[k]).product::<f64>() / 2000.0
}

/// A domain as the checker takes it, without a tolerance.
#[must_use]
pub fn plc_of(domain: &Domain) -> Plc {
    ltbw_cli::plc_of(domain, 0.0)
}

/// A random domain and the kind of it: a box with a turned box hole, a star-shaped polyhedron, a
/// union of cubes, a stack of layers, a honeycomb, or a laminate with holes, in turn.
///
/// # Panics
/// If the library does not know the kind: it does.
#[must_use]
pub fn random_domain(seed: u64) -> (&'static str, Domain) {
    let mut random = Random(0x9e37_79b9_7f4a_7c15 ^ (seed + 1).wrapping_mul(0x2545_f491_4f6c_dd1d));
    match seed % 6 {
        0 => ("turned hole", box_with_turned_hole(&mut random)),
        1 => ("star", star(&mut random)),
        2 => {
            let shape = Shape { seed, count: Some(8), ..Shape::default() };
            ("voxels", generate_domain(DomainKind::Voxels, &shape).expect("voxels"))
        }
        // Thinner layers, which take many more tetrahedra, are in the test of stacks.
        3 => ("stack", Stack::random(seed, 1_500.0).domain()),
        4 => ("honeycomb", random_honeycomb(seed).1),
        _ => ("laminate", random_laminate(seed).1),
    }
}

/// A random domain of a kind on which recovery of the boundary is hard, and the kind: corners of a
/// cap nearly in one plane, needles at the poles of a globe, a sharp wedge, bodies that touch.
///
/// # Panics
/// If the library does not know the kind: it does.
#[must_use]
pub fn awkward_domain(seed: u64) -> (&'static str, Domain) {
    let mut random = Random(0x9e37_79b9_7f4a_7c15 ^ (seed + 1).wrapping_mul(0x2545_f491_4f6c_dd1d));
    let mut below = |n: u32| (random.next() * f64::from(n)) as u32;
    match seed % 4 {
        0 => {
            let noise = [1e-8, 1e-6, 1e-4, 1e-2][below(4) as usize];
            ("nearly coplanar", surfaces::prism(6 + below(24), noise, seed))
        }
        1 => ("needles", surfaces::globe(4 + below(4), 24 + below(40), 0.0, seed)),
        2 => {
            let shape = Shape { angle: Some(f64::from(1 + below(24))), ..Shape::default() };
            ("sharp", generate_domain(DomainKind::Wedge, &shape).expect("a wedge"))
        }
        _ => {
            // Two boxes that have a side in common, and a third on an edge.
            let mut domain = Domain::default();
            let height = 1.0 / f64::from(1 + below(8));
            for [x, y] in [[0.0, 0.0], [1.0, 0.0], [2.0, 1.0]] {
                let first = domain.vertices.len() as u32;
                let bit = |i: u32, k: u32| f64::from(i >> k & 1);
                let corner = |i: u32| [bit(i, 0) + x, bit(i, 1) + y, bit(i, 2) * height];
                domain.vertices.extend((0..8).map(corner));
                let facet = |face: &[u32; 4]| Facet::polygon(&face.map(|v| v + first), 0);
                domain.facets.extend(FACES.iter().map(facet));
            }
            ("touching", domain)
        }
    }
}

/// xorshift, for domains that are the same on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A unit box with a box hole turned about its middle.
fn box_with_turned_hole(random: &mut Random) -> Domain {
    let mut domain = Domain::default();
    let corners = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 0 { -1.0 } else { 1.0 });
    domain.vertices.extend((0..8).map(|i| corners(i).map(|c: f64| 0.5 + c / 2.0)));
    // An orthogonal matrix from a quaternion.
    let q = [0; 4].map(|_| random.next() - 0.5);
    let n = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [w, x, y, z] = q.map(|c| c / n);
    let rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ];
    let size = [0; 3].map(|_| 0.08 + 0.12 * random.next());
    for i in 0..8 {
        let c = corners(i);
        let turned = rows.map(|r| 0.5 + (0..3).map(|k| r[k] * c[k] * size[k]).sum::<f64>());
        domain.vertices.push(turned);
    }
    for base in [0, 8] {
        domain.facets.extend(FACES.map(|f| Facet::polygon(&f.map(|c| base + c), 0)));
    }
    domain.holes.push([0.5; 3]);
    domain
}

/// A polyhedron that is star-shaped from its middle: the octahedron divided once, its corners
/// moved along their rays.
fn star(random: &mut Random) -> Domain {
    let mut domain = Domain::default();
    let mut place = |p: [f64; 3]| -> u32 {
        let n = p.iter().map(|c| c * c).sum::<f64>().sqrt();
        let unit = p.map(|c| c / n);
        let known = domain.vertices.iter().position(|v| *v == unit);
        known.unwrap_or_else(|| {
            domain.vertices.push(unit);
            domain.vertices.len() - 1
        }) as u32
    };
    let mut triangles = Vec::new();
    for i in 0..8 {
        let s = [0, 1, 2].map(|k| if i >> k & 1 == 0 { 1.0 } else { -1.0 });
        let [a, b, c] = [[s[0], 0.0, 0.0], [0.0, s[1], 0.0], [0.0, 0.0, s[2]]];
        let mid = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|k| p[k] + q[k]);
        let [ab, bc, ca] = [mid(a, b), mid(b, c), mid(c, a)];
        for t in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            triangles.push(t.map(&mut place));
        }
    }
    for v in &mut domain.vertices {
        let r = 0.7 + 0.6 * random.next();
        *v = v.map(|c| c * r);
    }
    domain.facets.extend(triangles.iter().map(|t| Facet::polygon(t, 0)));
    domain
}

#[cfg(test)]
mod tests {
    use super::awkward_domain;
    use ltbw::domain::PrepareOptions;

    #[test]
    fn awkward_domains_are_prepared() {
        let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
        for seed in 0..60 {
            let (kind, domain) = awkward_domain(seed);
            let prepared = domain.prepare(&options);
            let prepared = prepared.unwrap_or_else(|error| panic!("{kind} {seed}: {error}"));
            let inner = prepared.repairs.inner.len();
            assert_eq!(inner, usize::from(kind == "touching"), "{kind} {seed}");
            let volume = prepared.report.volume().expect("cells").to_f64();
            assert!(volume > 0.0, "{kind} {seed}");
        }
    }
}
