//! The check of a mesh that is nowhere in one place: each member of a team has a part of it, and no
//! member needs more than some times its part.
//!
//! | module | what it holds |
//! |---|---|
//! | `exchange` | the way of bytes from member to member: the trait, and values in bulk |
//! | `found` | defects, as they travel |
//! | `vertices` | vertices meet by their coordinates, and the points that were given |
//! | `faces` | the faces at which parts touch meet; the tests of pairs |
//! | `hull` | the facets of the hull meet at their edges; convex, and once around |
//! | `hash` | tetrahedra sorted: those that are there twice, and the hash |
//!
//! Nothing that a part says of its neighbours is trusted, for it says nothing: vertices are the
//! same if their coordinates are, faces if their vertices are. The inside of a part is checked
//! there, by the code for whole meshes; whatever is between parts is checked where it meets. The
//! premises of the theorem in the crate documentation are tested one by one, and it concludes the
//! rest: that the tetrahedra are connected, and a ball at every vertex. Euler's formula is tested
//! all the same.
//!
//! *A face of three.* A part pairs two of its tetrahedra at a face without asking whether another
//! part has a third one there. The third one's face is then a facet of the hull, and the theorem
//! says that a mesh which has it fails a test of the hull: its name is another one then.

pub(crate) mod exchange;
pub(crate) mod faces;
pub(crate) mod found;
mod hash;
mod hull;
mod vertices;

pub use exchange::Exchange;

use crate::chunks::{Levels, Partial};
use crate::defect::{Defect, Findings, Kind, Level};
use crate::faces::Faces;
use crate::geometry::{self, Oriented};
use crate::mesh::{Depth, Mesh, Options, Point, VertexOrder};
use crate::predicates::Tally;
use crate::report::{Counts, Hash, Ran, Report, outcomes};
use crate::structure::{self, Sound};
use exchange::{before, deal, member_of, sums, tell_all};
use faces::{Asked, Facet, Met, Vertex};
use found::{Corner, Found, Names};
use rayon::prelude::*;
use vertices::{Own, Vertices};

/// A member's part of a mesh. Nothing about it is trusted.
#[derive(Debug, Clone, Copy)]
pub struct Part<'a> {
    /// Coordinates of the part's vertices.
    pub points: &'a [Point],
    /// Their numbers among all points that were given, one for each.
    pub numbers: &'a [u32],
    /// The part's tetrahedra: four indices into `points` each.
    pub tets: &'a [[u32; 4]],
    /// A stretch of the points that the mesh is to be the triangulation of: those of all members,
    /// one after the other, are all points. Each vertex must be one of them, under its number.
    pub given: &'a [Point],
}

/// Checks a mesh whose parts the members of a team have; all get the same report. It never panics,
/// whatever the parts. Tetrahedra must be positive: [`Options::vertex_order`] is not looked at.
///
/// A defect names tetrahedra by their numbers in the lists of all members, one after the other, and
/// vertices by their numbers among all points. In [`Report::counts`] `components` is 1 if the mesh
/// has passed, which proves it, and else 0.
///
/// # Errors
/// Those of the team; what makes no sense is [`Exchange::nonsense`].
///
/// Cost: each member's time and memory are those of [`check`](crate::check) without an adjacency
/// for its part, and about as much again for what meets there.
pub fn check_parted<E: Exchange>(
    team: &mut E,
    part: &Part<'_>,
    options: &Options,
) -> Result<Report, E::Error> {
    let mut run = begin(team, part, options)?;
    // A number is left for what is none.
    if run.counts.tets.max(run.counts.points) >= u64::from(u32::MAX) {
        if run.team.me() == 0 {
            run.found.add(Kind::TooLarge, &[], &[]);
        }
        return run.report();
    }
    run.check()
}

/// A check at its begin.
fn begin<'r, 'p, E: Exchange>(
    team: &'r mut E,
    part: &'r Part<'p>,
    options: &'r Options,
) -> Result<Run<'r, 'p, E>, E::Error> {
    let mesh = Mesh::new(part.points, part.tets);
    let fits = structure::fits(&mesh) && part.numbers.len() == part.points.len();
    let unfit = tell_all(team, &[u32::from(!fits)])?;
    if let Some(from) = unfit.iter().position(|own| own.contains(&1)) {
        return Err(team.nonsense(from, "more in a part than can be numbered"));
    }
    let [first, tets] = before(team, part.tets.len() as u64)?;
    let [given] = sums(team, [part.given.len() as u64])?;
    Ok(Run {
        team,
        part,
        mesh,
        options,
        names: Names { first: first as u32, numbers: part.numbers },
        found: Found::new(options.max_defects),
        levels: Default::default(),
        counts: Counts { tets, points: given, ..Counts::default() },
        volume: 0.0,
        hash: Hash::Skipped,
        vertex_order: VertexOrder::Oriented,
        tags: None,
    })
}

/// A check under way.
struct Run<'r, 'p, E> {
    team: &'r mut E,
    part: &'r Part<'p>,
    mesh: Mesh<'p>,
    options: &'r Options,
    names: Names<'p>,
    found: Found,
    levels: [Ran; 6],
    counts: Counts,
    volume: f64,
    hash: Hash,
    vertex_order: VertexOrder,
    /// The tags of the part's tetrahedra, which go with its faces.
    tags: Option<&'r [i64]>,
}

impl<E: Exchange> Run<'_, '_, E> {
    fn check(mut self) -> Result<Report, E::Error> {
        let is_full = self.options.depth == Depth::Full;
        let part = self.part;
        let mut sound = self.structure();
        let own = own_of(part, &sound, Some(part.given));
        let vertices = vertices::meet(self.team, own, self.options.all_points, &mut self.found)?;
        self.counts.vertices = vertices.count;
        self.counts.unused_points = vertices.given.saturating_sub(vertices.count);
        self.counts.places_left_out = vertices.left_out;
        self.rows(&sound, &vertices)?;
        if is_full {
            self.counts.edges = self.edges(&sound, &vertices)?;
        }
        let Vertices { numbers, .. } = vertices;
        let asked = Asked { canonical: is_full, pairs: false };
        let Inside { met, inner, .. } = self.inside(&mut sound, &numbers, asked)?;
        drop((sound, numbers));
        let Met { hull, levels, .. } = met;
        self.hull(inner, &hull, levels)?;
        self.report()
    }

    /// Checks the inside of the part, and lets its surface meet those of others.
    fn inside(
        &mut self,
        sound: &mut Sound,
        numbers: &[u32],
        asked: Asked,
    ) -> Result<Inside, E::Error> {
        let (part, mesh, is_full) = (self.part, self.mesh, asked.canonical);
        let limit = self.options.max_defects;
        let mut local = Findings::new(limit);
        let faces = crate::faces::matched(&mesh, &mut sound.tet, limit, &mut local);
        // Duplicates were found among all, or their faces meet.
        drop(local.take(|kind| kind == Kind::DuplicateTet && !asked.pairs));
        self.found.local(&local, part.points, self.names);
        self.done(Level::Structure);

        let (mut oriented, tally) = geometry::signs(&mesh, &sound.tet);
        self.volume = oriented.volume;
        self.counts.negative_tets = oriented.negative;
        // A part that is negative throughout is no mirror image of a mesh.
        oriented.positive += 1;
        let order = self.vertex_order;
        let swept = geometry::orientation(&oriented, &faces, &sound.tet, order, limit);
        self.sweep(Level::Orientation, swept);
        self.levels[Level::Orientation as usize].tally.merge(tally);
        let Levels { delaunay, canonical } = geometry::delaunay(&oriented, &faces, is_full, limit);
        self.sweep(Level::Delaunay, delaunay);
        self.sweep(Level::Canonical, canonical);

        let vertex = |v: u32| Vertex {
            by_place: numbers[v as usize],
            corner: Corner { number: part.numbers[v as usize], at: part.points[v as usize] },
        };
        let surface = faces::surface(&oriented, &faces, vertex, self.names.first, self.tags);
        let met = faces::meet(self.team, surface, asked, &mut self.found)?;
        self.sweep(Level::Orientation, met.orientation.clone());
        self.counts.faces = met.count + faces.count - faces.hull.len() as u64;
        self.done(Level::Orientation);
        let inner = inner(&oriented);
        Ok(Inside { faces, met, inner })
    }

    /// Finds the defects of the part by itself; two vertices at one place are found among all.
    fn structure(&mut self) -> Sound {
        let mut local = Findings::new(self.options.max_defects);
        let options = Options { all_points: false, ..*self.options };
        let sound = structure::check(&self.mesh, &options, &mut local);
        drop(local.take(|kind| [Kind::Empty, Kind::EqualVertices].contains(&kind)));
        self.found.local(&local, self.part.points, self.names);
        if self.counts.tets == 0 && self.team.me() == 0 {
            self.found.add(Kind::Empty, &[], &[]);
        }
        sound
    }

    /// Sorts the tetrahedra of all, and hashes them if the mesh has a hash.
    fn rows(&mut self, sound: &Sound, vertices: &Vertices) -> Result<(), E::Error> {
        let first = self.names.first;
        let tets = self
            .part
            .tets
            .par_iter()
            .zip(&sound.tet)
            .zip(first..first.saturating_add(self.part.tets.len() as u32));
        let rows = tets
            .filter(|((_, sound), _)| **sound)
            .map(|((tet, _), own)| hash::row(tet, &vertices.numbers, own));
        let rows = hash::sorted(self.team, rows.collect(), &mut self.found)?;
        if self.options.depth == Depth::Fast {
            return Ok(());
        }
        let own = self.found.counts.values().sum();
        let [defects] = sums(self.team, [own])?;
        self.hash = match defects {
            0 => Hash::Value(hash::hash(self.team, &vertices.stretch, &rows)?),
            _ => Hash::None("its vertices and tetrahedra have defects".to_owned()),
        };
        Ok(())
    }

    /// Number of different edges of the whole mesh.
    fn edges(&mut self, sound: &Sound, vertices: &Vertices) -> Result<u64, E::Error> {
        let number = |v: u32| vertices.numbers[v as usize];
        let of_tet = |tet: &[u32; 4]| {
            let [a, b, c, d] = tet.map(number);
            [[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]].map(|[x, y]| [x.min(y), x.max(y)])
        };
        let tets: Vec<usize> = (0..self.part.tets.len()).filter(|&t| sound.tet[t]).collect();
        // Neighbours lie near each other: most edges are met again soon.
        let chunks: Vec<Vec<[u32; 2]>> = tets
            .par_chunks(1 << 14)
            .map(|chunk| {
                let all = chunk.iter().flat_map(|&t| of_tet(&self.part.tets[t]));
                ascending(all.collect())
            })
            .collect();
        drop(tets);
        let members = self.team.members();
        let own = chunks.into_iter().flatten();
        let met = deal(self.team, own, |edge| member_of(edge, members))?;
        let [edges] = sums(self.team, [ascending(met.concat()).len() as u64])?;
        Ok(edges)
    }

    /// The level *Delaunay* of the hull, and Euler's formulas.
    fn hull(
        &mut self,
        inner: Option<[Point; 4]>,
        facets: &[Facet],
        mut levels: Levels,
    ) -> Result<(), E::Error> {
        let is_full = self.options.depth == Depth::Full;
        let counts = hull::edges(self.team, facets, is_full, &mut levels, &mut self.found)?;
        (self.counts.hull_facets, self.counts.hull_vertices) = (counts.facets, counts.vertices);
        self.sweep(Level::Delaunay, levels.delaunay);
        self.sweep(Level::Canonical, levels.canonical);
        let own = [self.counts.faces, self.found.counts.values().sum()];
        let [faces, defects] = sums(self.team, own)?;
        self.counts.faces = faces;
        let Counts { vertices, edges, tets, .. } = self.counts;
        let [vertices, edges, faces, tets] = [vertices, edges, faces, tets].map(i128::from);
        let is_ball = vertices - edges + faces - tets == 1;
        let is_first = self.team.me() == 0;
        if is_full && !is_ball && tets > 0 && is_first {
            self.found.add(Kind::Euler, &[], &[]);
        }
        self.done(Level::Topology);
        // The global test presumes all that came before it.
        match defects {
            0 => {
                let part = hull::once_around(self.team, inner, facets, &mut self.found)?;
                self.sweep(Level::Delaunay, part);
            }
            _ => self.levels[Level::Delaunay as usize].untested += u64::from(is_first),
        }
        self.done(Level::Delaunay);
        if is_full {
            self.done(Level::Canonical);
        }
        Ok(())
    }

    fn sweep(&mut self, level: Level, part: Partial) {
        let Partial { tally, untested, .. } = self.found.sweep(part, self.part.points, self.names);
        let ran = &mut self.levels[level as usize];
        ran.tally.merge(tally);
        ran.untested += untested;
    }

    fn done(&mut self, level: Level) {
        self.levels[level as usize].ran = true;
    }

    /// The report of all members.
    fn report(self) -> Result<Report, E::Error> {
        let Self { team, found, mut levels, mut counts, volume, hash, .. } = self;
        let found = found.of_all(team)?;
        for ran in &mut levels {
            let Tally { filter, exact } = ran.tally;
            let [filter, exact, untested] = sums(team, [filter, exact, ran.untested])?;
            (ran.tally, ran.untested) = (Tally { filter, exact }, untested);
        }
        let [negative] = sums(team, [counts.negative_tets])?;
        counts.negative_tets = negative;
        let volume = tell_all(team, &[volume])?.into_iter().flatten().sum();
        let defects = |level: Level| {
            let of_level = found.counts.iter().filter(|(kind, _)| kind.level() == level);
            of_level.fold(0, |sum: u64, (_, count)| sum.saturating_add(*count))
        };
        let levels = outcomes(&Level::ALL, &levels, defects, |level| level != Level::Overlap);
        let defect_counts = found.counts.clone();
        let mut report = Report {
            levels,
            defects: found.into_listed(),
            defect_counts,
            counts,
            volume,
            mirrored: false,
            hash,
            information: None,
            parts: Some(team.members() as u64),
        };
        report.counts.components = u64::from(report.passed());
        Ok(report)
    }
}

/// The vertices of a part, of which sound tetrahedra use some.
fn own_of<'o>(part: &Part<'o>, sound: &'o Sound, given: Option<&'o [Point]>) -> Own<'o> {
    Own { points: part.points, numbers: part.numbers, used: &sound.vertices, given }
}

/// The inside of a part, and what has met at this member.
struct Inside {
    faces: Faces,
    met: Met,
    /// A positive tetrahedron.
    inner: Option<[Point; 4]>,
}

/// A mesh in parts whose tetrahedra have their places: structure, orientation, and the Delaunay
/// property inside. Its vertices may be any points, and its hull any surface.
pub(crate) struct Soundness {
    /// The defects of all members: the same at all.
    pub(crate) defects: Vec<Defect>,
    pub(crate) count: u64,
    /// Tests of all members that a filter decided, and those that were exact.
    pub(crate) tests: (u64, u64),
    /// The number of this member's first tetrahedron.
    pub(crate) first: u32,
    /// Tetrahedra of all members.
    pub(crate) tets: u64,
    /// The faces of the part.
    pub(crate) faces: Faces,
    /// The numbers of the part's vertices by coordinates.
    pub(crate) by_place: Vec<u32>,
    /// The faces that have met here.
    pub(crate) met: Met,
}

/// Checks that a mesh in parts is sound; with the tags of the part's tetrahedra, if there are some.
///
/// # Errors
/// Those of the team; what makes no sense.
pub(crate) fn soundness<E: Exchange>(
    team: &mut E,
    part: &Part<'_>,
    tags: Option<&[i64]>,
    options: &Options,
) -> Result<Soundness, E::Error> {
    let mut run = begin(team, part, options)?;
    (run.vertex_order, run.tags) = (options.vertex_order, tags);
    let mut sound = run.structure();
    let own = own_of(part, &sound, None);
    let vertices = vertices::meet(run.team, own, false, &mut run.found)?;
    vertices::meet_by_number(run.team, &own, &vertices.numbers, &mut run.found)?;
    let asked = Asked { canonical: false, pairs: true };
    let Inside { faces, met, .. } = run.inside(&mut sound, &vertices.numbers, asked)?;
    run.sweep(Level::Delaunay, met.levels.delaunay.clone());
    let Run { team, found, levels, names, counts, .. } = run;
    let found = found.of_all(team)?;
    let own = levels
        .iter()
        .fold([0, 0], |[filter, exact], ran| [filter + ran.tally.filter, exact + ran.tally.exact]);
    let [filter, exact] = sums(team, own)?;
    Ok(Soundness {
        count: found.counts.values().sum(),
        defects: found.into_listed(),
        tests: (filter, exact),
        first: names.first,
        tets: counts.tets,
        faces,
        by_place: vertices.numbers,
        met,
    })
}

/// Sorts, and keeps each once.
fn ascending(mut all: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    all.par_sort_unstable();
    all.dedup();
    all
}

/// The first tetrahedron that is positive.
fn inner(mesh: &Oriented<'_>) -> Option<[Point; 4]> {
    let t = (0..mesh.mesh.tets.len()).find(|&t| mesh.sign(t) > 0)?;
    Some(mesh.mesh.tets[t].map(|v| *mesh.at(v)))
}
