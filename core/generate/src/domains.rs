//! Model domains: those of the paper, and awkward ones, the same on every machine.
//!
//! Coordinates are made with + − × ÷ √ only, sines by a series of our own. All facets point
//! outwards, those of voids into the void.

use super::Random;
use ltbw_domain::{Domain, Facet, Region};
use ltbw_exact::Point;

/// The kinds of domains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum DomainKind {
    /// The paper's model problem: the unit cube with a suspended octahedral hole. Volume 47/48.
    CubeOctahedron,
    /// The unit cube with a cubic hole from 0.3125 to 0.6875. Volume 485/512.
    CubeInCube,
    /// A gear of 12 trapezoidal teeth with a bore, 0.25 thick. Volume 0.561246.
    Gear,
    /// A pipe tee of square sections, its facets squares of side 0.25. Volume 47/16.
    Tee,
    /// A triangular prism with a dihedral angle of the given size.
    Wedge,
    /// The unit cube with a square spike of height 1 on top, whose faces meet at the given angle.
    Spike,
    /// A block in the shape of an L, of three unit cubes.
    LBlock,
    /// A stair of N steps: two of its facets have 2N + 2 corners.
    Stair,
    /// A random union of N unit cubes of the integer grid: edges of four facets, voids.
    Voxels,
    /// Schönhardt's polyhedron, which has no tetrahedra without a further vertex.
    Schoenhardt,
    /// A box of two unit cubes of different materials, with a wall between them.
    TwoMaterial,
}

impl DomainKind {
    /// Every kind.
    pub const ALL: [DomainKind; 11] = [
        DomainKind::CubeOctahedron,
        DomainKind::CubeInCube,
        DomainKind::Gear,
        DomainKind::Tee,
        DomainKind::Wedge,
        DomainKind::Spike,
        DomainKind::LBlock,
        DomainKind::Stair,
        DomainKind::Voxels,
        DomainKind::Schoenhardt,
        DomainKind::TwoMaterial,
    ];

    /// Its name, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            DomainKind::CubeOctahedron => "cube-octahedron",
            DomainKind::CubeInCube => "cube-in-cube",
            DomainKind::Gear => "gear",
            DomainKind::Tee => "tee",
            DomainKind::Wedge => "wedge",
            DomainKind::Spike => "spike",
            DomainKind::LBlock => "l-block",
            DomainKind::Stair => "stair",
            DomainKind::Voxels => "voxels",
            DomainKind::Schoenhardt => "schoenhardt",
            DomainKind::TwoMaterial => "two-material",
        }
    }

    /// The kind in a few words.
    pub fn about(self) -> &'static str {
        match self {
            DomainKind::CubeOctahedron => "domain: unit cube with a suspended octahedral hole",
            DomainKind::CubeInCube => "domain: unit cube with a cubic hole",
            DomainKind::Gear => "domain: gear of 12 teeth with a bore",
            DomainKind::Tee => "domain: pipe tee of square sections",
            DomainKind::Wedge => "domain: prism with a dihedral angle of --angle (30)",
            DomainKind::Spike => "domain: cube with a spike of angle --angle (2)",
            DomainKind::LBlock => "domain: three unit cubes in the shape of an L",
            DomainKind::Stair => "domain: stair of N steps (4)",
            DomainKind::Voxels => "domain: random union of N unit cubes (100)",
            DomainKind::Schoenhardt => "domain: Schönhardt's polyhedron",
            DomainKind::TwoMaterial => "domain: box of two regions, a wall between them",
        }
    }
}

impl std::fmt::Display for DomainKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for DomainKind {
    type Err = super::UnknownKind;

    fn from_str(name: &str) -> Result<Self, super::UnknownKind> {
        let kind = Self::ALL.into_iter().find(|k| k.name() == name);
        kind.ok_or_else(|| super::UnknownKind(name.to_owned()))
    }
}

/// The parameters of a domain; kinds that have no use for one ignore it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Shape {
    /// The number of steps, or of cubes; by default as [`DomainKind::about`] says.
    pub count: Option<u32>,
    /// An angle in degrees; by default as [`DomainKind::about`] says.
    pub angle: Option<f64>,
    /// Another seed gives another random domain.
    pub seed: u64,
}

/// A parameter with which there is no such domain.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeError {
    /// The angle is not in the range of the kind.
    #[error("a {kind} has an angle above 0 and below {limit} degrees, not {angle}")]
    Angle {
        /// The kind.
        kind: DomainKind,
        /// The angle.
        angle: f64,
        /// The least angle that is too large.
        limit: f64,
    },
    /// The count is not in the range of the kind.
    #[error("a domain of {kind} has 1 to {limit} parts, not {count}")]
    Count {
        /// The kind.
        kind: DomainKind,
        /// The count.
        count: u32,
        /// The largest count.
        limit: u32,
    },
}

/// Makes a domain.
///
/// # Errors
/// [`ShapeError`] for a parameter out of range.
pub fn generate_domain(kind: DomainKind, shape: &Shape) -> Result<Domain, ShapeError> {
    let angle = |default: f64, limit: f64| match shape.angle.unwrap_or(default) {
        angle if angle > 0.0 && angle < limit => Ok(angle),
        angle => Err(ShapeError::Angle { kind, angle, limit }),
    };
    let count = |default: u32, limit: u32| match shape.count.unwrap_or(default) {
        count if (1..=limit).contains(&count) => Ok(count),
        count => Err(ShapeError::Count { kind, count, limit }),
    };
    Ok(match kind {
        DomainKind::CubeOctahedron => cube_octahedron(),
        DomainKind::CubeInCube => cube_in_cube(),
        DomainKind::Gear => gear(),
        DomainKind::Tee => tee(),
        DomainKind::Wedge => wedge(angle(30.0, 180.0)?),
        DomainKind::Spike => spike(angle(2.0, 45.0)?),
        DomainKind::LBlock => prism(&L_BLOCK, 1.0),
        DomainKind::Stair => stair(count(4, 100_000)?),
        DomainKind::Voxels => voxels(count(100, 1_000_000)?, shape.seed),
        DomainKind::Schoenhardt => schoenhardt(),
        DomainKind::TwoMaterial => two_material(),
    })
}

/// The corners of a box; `low` and `high` differ in every coordinate.
fn corners(low: f64, high: f64) -> [Point; 8] {
    let at = |bits: usize| [0, 1, 2].map(|k| if bits >> k & 1 == 1 { high } else { low });
    [0, 1, 2, 3, 4, 5, 6, 7].map(at)
}

/// The faces of [`corners`], seen from outside.
const BOX: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

/// The unit cube; its facets have the marker 0.
fn unit_cube() -> Domain {
    Domain {
        vertices: corners(0.0, 1.0).to_vec(),
        facets: BOX.iter().map(|face| Facet::polygon(face, 0)).collect(),
        ..Domain::default()
    }
}

fn cube_octahedron() -> Domain {
    let mut domain = unit_cube();
    // 8 and 9 on the axis of x, 10 and 11 of y, 12 and 13 of z.
    for k in 0..3 {
        for c in [0.25, 0.75] {
            let mut p = [0.5; 3];
            p[k] = c;
            domain.vertices.push(p);
        }
    }
    for octant in 0..8_u32 {
        let [x, y, z] = [8 + (octant & 1), 10 + (octant >> 1 & 1), 12 + (octant >> 2)];
        // Outwards is out of the solid: towards the middle.
        let positive = octant.count_ones() % 2 == 1;
        let face = if positive { [x, z, y] } else { [x, y, z] };
        domain.facets.push(Facet::polygon(&face, 1));
    }
    domain.holes.push([0.5; 3]);
    domain
}

fn cube_in_cube() -> Domain {
    let mut domain = unit_cube();
    domain.vertices.extend(corners(0.3125, 0.6875));
    let inner = BOX.iter().map(|&[a, b, c, d]| [d, c, b, a].map(|v| v + 8));
    domain.facets.extend(inner.map(|face| Facet::polygon(&face, 1)));
    domain.holes.push([0.5; 3]);
    domain
}

/// Sine and cosine of an angle in degrees of at most 180, by their series: an error of some ulps,
/// the same on every machine.
pub(super) fn sine_cosine(degrees: f64) -> [f64; 2] {
    let x = degrees * (std::f64::consts::PI / 180.0);
    let (mut sine, mut cosine, mut term) = (0.0, 0.0, 1.0);
    // π^40 / 40! is below 10^-27.
    for n in 0..40 {
        match n % 4 {
            0 => cosine += term,
            1 => sine += term,
            2 => cosine -= term,
            _ => sine -= term,
        }
        term *= x / f64::from(n + 1);
    }
    [sine, cosine]
}

/// A prism over a polygon that runs counterclockwise, from z = 0 to `height`.
fn prism(profile: &[[f64; 2]], height: f64) -> Domain {
    let n = profile.len() as u32;
    let level = |z: f64| profile.iter().map(move |&[x, y]| [x, y, z]);
    let mut facets = vec![
        Facet::polygon(&(0..n).rev().collect::<Vec<_>>(), 1),
        Facet::polygon(&(n..2 * n).collect::<Vec<_>>(), 2),
    ];
    facets.extend((0..n).map(|i| {
        let next = (i + 1) % n;
        Facet::polygon(&[i, next, n + next, n + i], 3)
    }));
    Domain { vertices: level(0.0).chain(level(height)).collect(), facets, ..Domain::default() }
}

const L_BLOCK: [[f64; 2]; 6] =
    [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];

fn stair(steps: u32) -> Domain {
    let n = f64::from(steps);
    let mut profile = vec![[0.0, 0.0], [n, 0.0], [n, n]];
    for i in (1..steps).rev().map(f64::from) {
        profile.extend([[i, i + 1.0], [i, i]]);
    }
    profile.push([0.0, 1.0]);
    prism(&profile, 1.0)
}

fn wedge(angle: f64) -> Domain {
    let [sine, cosine] = sine_cosine(angle);
    prism(&[[0.0, 0.0], [1.0, 0.0], [cosine, sine]], 1.0)
}

fn spike(angle: f64) -> Domain {
    let mut domain = unit_cube();
    let [sine, cosine] = sine_cosine(angle / 2.0);
    // Half of the base: the height is 1, and the tangent is of half the angle.
    let half = sine / cosine;
    for [x, y] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
        domain.vertices.push([0.5 + x * half, 0.5 + y * half, 1.0]);
    }
    domain.vertices.push([0.5, 0.5, 2.0]);
    // The face z = 1 gets a hole where the spike stands.
    domain.facets[1].polygons.push(vec![8, 9, 10, 11]);
    domain.facets[1].holes.push([0.5, 0.5, 1.0]);
    for [a, b] in [[8, 9], [9, 10], [10, 11], [11, 8]] {
        domain.facets.push(Facet::polygon(&[a, b, 12], 1));
    }
    domain
}

fn gear() -> Domain {
    const TEETH: usize = 12;
    // Per tooth of 30 degrees: the root, the rising flank, the tip, the falling flank.
    const PARTS: [(f64, f64); 4] = [(0.0, 0.8), (12.6, 0.8), (15.6, 1.0), (27.0, 1.0)];
    // `bore`: the radius of a ring that is round.
    let ring = |bore: Option<f64>, z: f64| {
        (0..TEETH).flat_map(move |tooth| {
            PARTS.map(|(degrees, outer)| {
                let radius = bore.unwrap_or(outer);
                let full = degrees + 30.0 * tooth as f64;
                // The series is for angles up to 180 degrees.
                let [sine, cosine] = sine_cosine(if full > 180.0 { full - 360.0 } else { full });
                [radius * cosine, radius * sine, z]
            })
        })
    };
    let n = 4 * TEETH as u32;
    let (low, high) = (0.0, 0.25);
    let level = |z: f64| ring(None, z).chain(ring(Some(0.3), z));
    let vertices = level(low).chain(level(high)).collect();
    // Outer and inner ring of a level, seen from above.
    let rings = |start: u32| {
        [(start..start + n).collect::<Vec<_>>(), (start + n..start + 2 * n).rev().collect()]
    };
    let [below, above] = [rings(0), rings(2 * n)];
    let below = below.map(|ring| ring.into_iter().rev().collect());
    let facet = |polygons: [Vec<u32>; 2], z: f64, marker| Facet {
        polygons: polygons.to_vec(),
        holes: vec![[0.0, 0.0, z]],
        marker,
    };
    let mut facets = vec![facet(above, high, 1), facet(below, low, 2)];
    for i in 0..n {
        let next = (i + 1) % n;
        facets.push(Facet::polygon(&[i, next, 2 * n + next, 2 * n + i], 3));
        facets.push(Facet::polygon(&[n + next, n + i, 3 * n + i, 3 * n + next], 4));
    }
    Domain { vertices, facets, ..Domain::default() }
}

fn tee() -> Domain {
    // Units of a quarter; the bar runs along x, the branch along y.
    let solid = |[x, y, z]: [i64; 3]| {
        let within = |c: i64, half: i64| (-half..half).contains(&c);
        let bar = within(x, 6) && within(y, 2) && within(z, 2);
        let branch = within(x, 2) && (0..6).contains(&y) && within(z, 2);
        let bores = within(z, 1) && (within(y, 1) || (within(x, 1) && y >= 0));
        (bar || branch) && !bores
    };
    let cubes = grid(-6, 6).filter(|&c| solid(c));
    union_of_cubes(&cubes.collect::<Vec<_>>(), 0.25, 1)
}

/// The integer triples from `low` to below `high`.
fn grid(low: i64, high: i64) -> impl Iterator<Item = [i64; 3]> {
    (low..high)
        .flat_map(move |x| (low..high).flat_map(move |y| (low..high).map(move |z| [x, y, z])))
}

/// The squares that bound a union of grid cubes; its vertices are sorted.
fn union_of_cubes(cubes: &[[i64; 3]], size: f64, marker: i32) -> Domain {
    let solid: std::collections::HashSet<[i64; 3]> = cubes.iter().copied().collect();
    let mut squares: Vec<[[i64; 3]; 4]> = Vec::new();
    for &cube in cubes {
        for face in BOX {
            let square = face.map(|corner| [0, 1, 2].map(|k| cube[k] + i64::from(corner >> k & 1)));
            // The axis across the square is the one in which its corners agree.
            let axis = (0..3).find(|&k| square.iter().all(|c| c[k] == square[0][k])).unwrap_or(0);
            let mut next = cube;
            next[axis] += if square[0][axis] > cube[axis] { 1 } else { -1 };
            if !solid.contains(&next) {
                squares.push(square);
            }
        }
    }
    let mut places: Vec<[i64; 3]> = squares.iter().flatten().copied().collect();
    places.sort_unstable();
    places.dedup();
    let number = |p: &[i64; 3]| places.partition_point(|q| q < p) as u32;
    let facet = |s: &[[i64; 3]; 4]| Facet::polygon(&[0, 1, 2, 3].map(|i| number(&s[i])), marker);
    let facets = squares.iter().map(facet).collect();
    let vertices = places.iter().map(|p| p.map(|c| c as f64 * size)).collect();
    Domain { vertices, facets, ..Domain::default() }
}

/// Distinct random cubes in a box of twice as many places or a little more.
fn voxels(count: u32, seed: u64) -> Domain {
    let mut random = Random::new(seed);
    // At most 127 turns: 127³ is over two million.
    let side = (1..=127_i64).find(|s| s.pow(3) >= 2 * i64::from(count)).unwrap_or(127);
    let mut places: Vec<[i64; 3]> = grid(0, side).collect();
    random.shuffle(&mut places);
    let mut cubes = places.split_off(places.len() - count as usize);
    cubes.sort_unstable();
    let mut domain = union_of_cubes(&cubes, 1.0, 1);
    domain.holes = enclosed(&places, side);
    domain
}

/// The middle of a cube in each connected set of empty cubes that does not reach the border.
fn enclosed(empty: &[[i64; 3]], side: i64) -> Vec<Point> {
    let mut left: std::collections::BTreeSet<[i64; 3]> = empty.iter().copied().collect();
    let mut holes = Vec::new();
    // Every turn takes a cube out of `left`, and so does every turn inside.
    while let Some(start) = left.pop_first() {
        let (mut stack, mut outside) = (vec![start], false);
        while let Some(cube) = stack.pop() {
            outside |= cube.iter().any(|&c| c == 0 || c == side - 1);
            for k in 0..3 {
                for step in [-1, 1] {
                    let mut next = cube;
                    next[k] += step;
                    if left.remove(&next) {
                        stack.push(next);
                    }
                }
            }
        }
        if !outside {
            holes.push(start.map(|c| c as f64 + 0.5));
        }
    }
    holes
}

fn schoenhardt() -> Domain {
    let half = 0.5;
    let root = 3.0_f64.sqrt() / 2.0;
    // The top is the bottom turned by 30 degrees.
    let bottom = [[1.0, 0.0], [-half, root], [-half, -root]];
    let top = [[root, half], [-root, half], [0.0, -1.0]];
    let level = |z: f64| move |[x, y]: [f64; 2]| [x, y, z];
    let vertices = bottom.map(level(0.0)).into_iter().chain(top.map(level(1.0))).collect();
    let mut facets = vec![Facet::polygon(&[2, 1, 0], 1), Facet::polygon(&[3, 4, 5], 2)];
    for i in 0..3 {
        let next = (i + 1) % 3;
        // The diagonal from i to the one above the next is bent inwards.
        facets.push(Facet::polygon(&[i, next, 3 + next], 3));
        facets.push(Facet::polygon(&[i, 3 + next, 3 + i], 3));
    }
    Domain { vertices, facets, ..Domain::default() }
}

fn two_material() -> Domain {
    // Sections at x = 0, 1 and 2, each counterclockwise seen from x = 2.
    let section = |x: f64| [[x, 0.0, 0.0], [x, 1.0, 0.0], [x, 1.0, 1.0], [x, 0.0, 1.0]];
    let vertices = [0.0, 1.0, 2.0].into_iter().flat_map(section).collect();
    let mut facets = vec![
        Facet::polygon(&[3, 2, 1, 0], 1),
        Facet::polygon(&[8, 9, 10, 11], 1),
        // The wall.
        Facet::polygon(&[4, 5, 6, 7], 2),
    ];
    for i in 0..4 {
        let next = (i + 1) % 4;
        // Six corners, two of them where the wall ends; and the edge of the wall.
        let side = vec![i, next, 4 + next, 8 + next, 8 + i, 4 + i];
        let polygons = vec![side, vec![4 + i, 4 + next]];
        facets.push(Facet { polygons, holes: Vec::new(), marker: 1 });
    }
    let region =
        |x: f64, attribute, max_volume| Region { seed: [x, 0.5, 0.5], attribute, max_volume };
    let regions = vec![region(0.5, 1.0, None), region(1.5, 2.0, Some(0.001))];
    Domain { vertices, facets, regions, ..Domain::default() }
}
