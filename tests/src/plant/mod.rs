//! Defects planted into sound meshes: does the checker find every one, and call it by its name?
//!
//! A [`Subject`] is a sound mesh as plain lists. [`PLANTS`] lists the ways to spoil it; each says
//! at which level the first defect must be found and what it is called. What makes a plant a defect
//! is decided without the checker: by counting, by the exact oracle ([`crate::oracle`]), or by the
//! theorem that the canonical mesh of a point set is unique, so that any other set of tetrahedra
//! over all of its points is wrong.

mod flips;
mod lists;
mod parted;
mod places;

pub use parted::{Among, Deal, try_plant_in_parts};

use crate::oracle;
use ltbw::topology::TetId;
use ltbw::{Mesh, Point, Sign};
use ltbw_verify::{Depth, Kind, Level, NO_NEIGHBOUR, Options, Report, check, check_elements};
use std::collections::HashMap;

/// A mesh as plain lists, with the claims that the checker verifies.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Subject {
    /// Points; each is a vertex.
    pub points: Vec<Point>,
    /// Positive tetrahedra.
    pub tets: Vec<[u32; 4]>,
    /// Claimed neighbours, opposite each vertex.
    pub neighbours: Vec<[u32; 4]>,
    /// Claimed hull facets.
    pub hull: Vec<[u32; 3]>,
}

impl Subject {
    /// The lists of a mesh; its vertices, renumbered.
    #[must_use]
    pub fn of(mesh: &Mesh) -> Self {
        let vertices: Vec<(u32, Point)> = mesh.vertices().collect();
        let number: HashMap<u32, u32> = vertices.iter().map(|v| v.0).zip(0..).collect();
        let ids: HashMap<TetId, u32> = mesh.tet_ids().zip(0..).collect();
        let neighbour =
            |t: TetId, slot: usize| mesh.neighbour(t, slot).map_or(NO_NEIGHBOUR, |u| ids[&u]);
        Self {
            points: vertices.iter().map(|v| v.1).collect(),
            tets: mesh.tets().map(|t| t.map(|v| number[&v])).collect(),
            neighbours: mesh.tet_ids().map(|t| [0, 1, 2, 3].map(|s| neighbour(t, s))).collect(),
            hull: mesh.hull_facets().map(|f| f.map(|v| number[&v])).collect(),
        }
    }

    /// The tetrahedron and the slot that a number names.
    fn place(&self, choice: usize) -> (usize, usize) {
        (choice / 4 % self.tets.len(), choice % 4)
    }

    fn at(&self, v: u32) -> &Point {
        &self.points[v as usize]
    }

    /// Exact orientation of four vertices.
    fn orient(&self, [a, b, c, d]: [u32; 4]) -> Sign {
        oracle::orient3d(self.at(a), self.at(b), self.at(c), self.at(d))
    }

    /// Makes the claims those of the tetrahedra as they are: a face has the neighbour that shares
    /// it (of several, the first), and is a hull facet if none does.
    fn claim(&mut self) {
        let mut faces: HashMap<[u32; 3], Vec<u32>> = HashMap::new();
        for (tet, t) in self.tets.iter().zip(0..) {
            (0..4).for_each(|i| faces.entry(sorted(opposite(tet, i))).or_default().push(t));
        }
        let other = |tet: &[u32; 4], t: u32, i: usize| {
            let owners = &faces[&sorted(opposite(tet, i))];
            owners.iter().find(|&&u| u != t).copied().unwrap_or(NO_NEIGHBOUR)
        };
        let tets = self.tets.iter().zip(0..);
        self.neighbours = tets.map(|(tet, t)| [0, 1, 2, 3].map(|i| other(tet, t, i))).collect();
        let all = self.tets.iter().zip(&self.neighbours);
        let hull = all.flat_map(|(tet, n)| {
            (0..4).filter(|&i| n[i] == NO_NEIGHBOUR).map(|i| opposite(tet, i))
        });
        self.hull = hull.collect();
    }

    /// The checker's report, with or without the claims.
    fn report(&self, depth: Depth, claims: bool) -> Report {
        let options = Options { depth, all_points: true, ..Options::default() };
        let view = ltbw_verify::Mesh::new(&self.points, &self.tets);
        if claims {
            check(&view.with_neighbours(&self.neighbours).with_hull(&self.hull), &options)
        } else {
            check(&view, &options)
        }
    }

    /// The checker passes this mesh, in every way of asking; else its defects.
    pub fn passes(&self) -> Result<(), String> {
        for depth in [Depth::Fast, Depth::Full] {
            for claims in [false, true] {
                let report = self.report(depth, claims);
                if !report.passed() || report.mirrored {
                    return Err(format!("{depth:?}, claims {claims}: {:?}", report.defects));
                }
            }
        }
        Ok(())
    }
}

/// The face opposite vertex `i`, outward.
fn opposite([a, b, c, d]: &[u32; 4], i: usize) -> [u32; 3] {
    match i {
        0 => [*b, *c, *d],
        1 => [*a, *d, *c],
        2 => [*a, *b, *d],
        _ => [*a, *c, *b],
    }
}

fn sorted<const N: usize>(mut row: [u32; N]) -> [u32; N] {
    row.sort_unstable();
    row
}

/// The checker's right answer to a planted defect.
#[derive(Debug, Clone, Copy)]
struct Expected {
    /// The first level that fails is one of these.
    levels: &'static [Level],
    /// One of these is reported.
    kinds: &'static [Kind],
    /// Or one of [`Kind::SHAPE`].
    of_shape: bool,
    /// Only the claims are wrong: without them the mesh is sound.
    in_claims: bool,
}

impl Expected {
    const fn new(levels: &'static [Level], kinds: &'static [Kind]) -> Self {
        Self { levels, kinds, of_shape: false, in_claims: false }
    }

    /// Is one of its kinds reported?
    fn is_named_in(&self, report: &Report) -> bool {
        let shape: &[Kind] = if self.of_shape { &Kind::SHAPE } else { &[] };
        self.kinds.iter().chain(shape).any(|&kind| report.count(kind) > 0)
    }
}

/// A way to spoil a mesh.
#[derive(Debug, Clone, Copy)]
pub struct Plant {
    /// The change to the mesh, in words.
    pub name: &'static str,
    /// Spoils the mesh at a place that the number names: what the checker must say. `None` where
    /// this plant does not grow.
    spoil: fn(&mut Subject, usize) -> Option<Expected>,
}

/// Every way.
pub const PLANTS: [Plant; 20] = [
    Plant { name: "swapped neighbours", spoil: lists::swapped_neighbours },
    Plant { name: "wrong neighbour", spoil: lists::wrong_neighbour },
    Plant { name: "missing hull facet", spoil: lists::missing_hull_facet },
    Plant { name: "foreign hull facet", spoil: lists::foreign_hull_facet },
    Plant { name: "missing tetrahedron", spoil: lists::missing_tet },
    Plant { name: "duplicated tetrahedron", spoil: lists::duplicated_tet },
    Plant { name: "foreign tetrahedron", spoil: lists::foreign_tet },
    Plant { name: "repeated vertex", spoil: lists::repeated_vertex },
    Plant { name: "index out of range", spoil: lists::index_out_of_range },
    Plant { name: "renamed vertex", spoil: lists::renamed_vertex },
    Plant { name: "vertex moved beyond its face", spoil: places::moved_beyond },
    Plant { name: "vertex moved onto another", spoil: places::moved_onto_another },
    Plant { name: "vertex not finite", spoil: places::not_finite },
    Plant { name: "forgotten point", spoil: places::forgotten_point },
    Plant { name: "second body", spoil: places::second_body },
    Plant { name: "flipped tetrahedron", spoil: flips::flipped },
    Plant { name: "flip 2-3", spoil: flips::flip23 },
    Plant { name: "flip 3-2", spoil: flips::flip32 },
    Plant { name: "flip 4-4", spoil: flips::flip44 },
    Plant { name: "flip 2-2", spoil: flips::flip22 },
];

const STRUCTURE: &[Level] = &[Level::Structure];
const TOPOLOGY: &[Level] = &[Level::Topology];
const TIES: &[Kind] = &[Kind::NotCanonical, Kind::HullNotCanonical];
/// The answer where other tetrahedra over the same points may break a level first.
const TILING: Expected = Expected {
    of_shape: true,
    ..Expected::new(
        &[Level::Structure, Level::Topology, Level::Orientation, Level::Delaunay],
        &[
            Kind::PointLeftOut,
            Kind::DuplicateTet,
            Kind::FaceOverused,
            Kind::SameSide,
            Kind::FlatTet,
            Kind::InvertedTet,
            Kind::FoldedFace,
            Kind::NotDelaunay,
        ],
    )
};

/// Plants a defect and asks the checker, in every way of asking. `Ok(false)` where the plant does
/// not grow.
///
/// # Errors
/// Which defect was overlooked, or called by a wrong name.
pub fn try_plant(mesh: &Subject, plant: Plant, choice: usize) -> Result<bool, String> {
    let mut spoilt = mesh.clone();
    let Some(expected) = (plant.spoil)(&mut spoilt, choice) else {
        return Ok(false);
    };
    for claims in [false, true] {
        for depth in [Depth::Full, Depth::Fast] {
            let report = spoilt.report(depth, claims);
            let counts = &report.defect_counts;
            let ask = || format!("{} {choice}, {depth:?}, claims {claims}: {counts:?}", plant.name);
            // Without its claims, the mesh is sound; ties are the business of the full depth.
            let ties = expected.kinds == TIES;
            if (expected.in_claims && !claims) || (ties && depth == Depth::Fast) {
                if !report.passed() {
                    return Err(format!("accused in vain: {}", ask()));
                }
                continue;
            }
            if report.passed() {
                return Err(format!("overlooked: {}", ask()));
            }
            let first = report.levels.iter().find(|l| l.defects > 0).map(|l| l.level);
            let at_level = first.is_some_and(|level| expected.levels.contains(&level));
            if !at_level || !expected.is_named_in(&report) {
                return Err(format!("not {expected:?}: {}", ask()));
            }
        }
    }
    Ok(true)
}

/// Plants a defect and asks the judge of finite element meshes. `Ok(false)` where the plant does
/// not grow, or leaves a mesh that is not Delaunay, convex or canonical, and no more.
///
/// # Errors
/// Which defect was overlooked, or which information is missing.
pub fn try_plant_elements(mesh: &Subject, plant: Plant, choice: usize) -> Result<bool, String> {
    let mut spoilt = mesh.clone();
    let Some(expected) = (plant.spoil)(&mut spoilt, choice) else {
        return Ok(false);
    };
    let view = ltbw_verify::Mesh::new(&spoilt.points, &spoilt.tets);
    let view = view.with_neighbours(&spoilt.neighbours).with_hull(&spoilt.hull);
    let report = check_elements(&view, &Options::default(), false);
    let told = report.information.clone().unwrap_or_default();
    let ask = || format!("{} {choice}: {report} {:?}", plant.name, told.counts);
    let is_told = match plant.name {
        // Sound finite element meshes: what is unusual about them is told.
        "forgotten point" => report.passed() && report.counts.unused_points == 1,
        // In a wide mesh it may lie in the first one.
        "second body" => {
            let apart = report.passed() || report.count(Kind::Overlap) > 0;
            apart && report.counts.components == 2
        }
        "missing tetrahedron" if !spoilt.tets.is_empty() => return report_of_shape(&report, ask),
        _ if expected.levels == [Level::Delaunay] || expected.kinds == TIES => {
            return report_of_shape(&report, ask);
        }
        _ => !report.passed(),
    };
    if is_told { Ok(true) } else { Err(format!("overlooked: {}", ask())) }
}

/// No defect is told of a mesh that only is not Delaunay, convex or canonical.
fn report_of_shape(report: &Report, ask: impl Fn() -> String) -> Result<bool, String> {
    if report.passed() { Ok(false) } else { Err(format!("accused in vain: {}", ask())) }
}
