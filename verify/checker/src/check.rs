//! The order of the levels.

use crate::adjacency_proof::{self, Proof};
use crate::chunks::Partial;
use crate::defect::{Findings, Kind, Level};
use crate::faces::{self, Faces};
use crate::geometry::{self, Oriented};
use crate::hash;
use crate::mesh::{Depth, Mesh, Options};
use crate::report::{Counts, Hash, LevelReport, Outcome, Report};
use crate::structure::{self, Sound};
use crate::topology::{self, Hull};
use crate::{hull, predicates::Tally};

/// Checks a mesh; never panics, whatever the mesh. Runs on the current rayon pool; the report
/// does not depend on the number of threads.
///
/// Cost: about O(T) time, some 60 bytes of memory per tetrahedron beside the mesh; for a good mesh
/// with its adjacency given, a fraction of the time and some 20 bytes.
///
/// ```
/// use ltbw_verify::{Mesh, Options, check};
///
/// let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let report = check(&Mesh::new(&points, &[[0, 1, 2, 3]]), &Options::default());
/// assert!(report.passed());
/// assert_eq!(report.counts.hull_facets, 4);
/// ```
pub fn check(mesh: &Mesh, options: &Options) -> Report {
    let mut run = Run::new(mesh, options);
    if !structure::fits(mesh) {
        run.findings.add(Kind::TooLarge, &[], &[]);
        return run.report(&Counts::default(), Hash::None(Kind::TooLarge.text().to_owned()));
    }
    let sound = structure::check(mesh, options, &mut run.findings);
    if run.findings.count(Level::Structure) > 0 {
        return run.level_by_level(sound, None);
    }
    let hash = || match options.depth {
        Depth::Fast => Hash::Skipped,
        Depth::Full => Hash::Value(hash::of_sorted(mesh.points, mesh.tets, &sound.vertices)),
    };
    if mesh.neighbours.is_none() {
        return run.level_by_level(sound, None);
    }
    // The hash is in part sequential: the proof fills the gaps.
    let (proof, hash) = rayon::join(|| adjacency_proof::prove(mesh, options, run.is_full()), hash);
    match proof {
        Some(proof) => run.proved(&sound, proof, hash),
        None => run.level_by_level(sound, Some(hash)),
    }
}

/// A check under way.
struct Run<'a> {
    mesh: &'a Mesh<'a>,
    options: &'a Options,
    findings: Findings,
    /// Per level: tests, tests that could not be posed, and whether the level was run.
    levels: [(Tally, u64, bool); 5],
    volume: f64,
    mirrored: bool,
}

impl<'a> Run<'a> {
    fn new(mesh: &'a Mesh<'a>, options: &'a Options) -> Self {
        let findings = Findings::new(options.max_defects);
        Self { mesh, options, findings, levels: Default::default(), volume: 0.0, mirrored: false }
    }

    fn is_full(&self) -> bool {
        self.options.depth == Depth::Full
    }

    fn take(&mut self, level: Level, part: Partial) {
        self.findings.merge(part.findings);
        self.tally(level, part.tally);
        self.levels[level as usize].1 += part.untested;
    }

    fn tally(&mut self, level: Level, tally: Tally) {
        self.levels[level as usize].0.merge(tally);
    }

    fn done(&mut self, level: Level) {
        self.levels[level as usize].2 = true;
    }

    /// The report of a mesh that was proved from its claimed adjacency.
    fn proved(mut self, sound: &Sound, proof: Proof, hash: Hash) -> Report {
        let Proof { orientation, delaunay, canonical, volume, hull, hull_facets, faces } = proof;
        self.tally(Level::Orientation, orientation);
        self.tally(Level::Delaunay, delaunay);
        self.tally(Level::Canonical, canonical);
        Level::ALL[..4].iter().for_each(|&level| self.done(level));
        if self.is_full() {
            self.done(Level::Canonical);
        }
        self.volume = volume;
        let (vertices, tets) = (sound.vertices.len() as u64, self.mesh.tets.len() as u64);
        // Euler's formula, which holds for a convex body tiled face to face.
        let edges = (vertices + faces).saturating_sub(tets + 1);
        let counts = Counts {
            points: self.mesh.points.len() as u64,
            vertices,
            unused_points: sound.unused as u64,
            places_left_out: sound.left_out as u64,
            tets,
            faces,
            edges: if self.is_full() { edges } else { 0 },
            hull_facets,
            hull_vertices: hull.vertices as u64,
            components: 1,
            negative_tets: 0,
        };
        self.report(&counts, hash)
    }

    /// Goes through all levels on the checker's own adjacency. `hash` may be known already.
    fn level_by_level(mut self, mut sound: Sound, hash: Option<Hash>) -> Report {
        let (mesh, options) = (self.mesh, self.options);
        let limit = options.max_defects;
        let faces = faces::matched(mesh, &mut sound.tet, limit, &mut self.findings);
        self.done(Level::Structure);

        let (hull, components, edges) = self.topology(&sound, &faces);
        self.done(Level::Topology);

        let (oriented, tally) = geometry::signs(mesh, &sound.tet);
        let order = options.vertex_order;
        let part = geometry::orientation(&oriented, &faces, &sound.tet, order, limit);
        self.take(Level::Orientation, part);
        self.tally(Level::Orientation, tally);
        self.done(Level::Orientation);
        self.mirrored = oriented.is_mirrored();
        self.volume = oriented.volume;

        self.delaunay(&oriented, &faces, &hull);
        let counts = Counts {
            points: mesh.points.len() as u64,
            vertices: sound.vertices.len() as u64,
            unused_points: sound.unused as u64,
            places_left_out: sound.left_out as u64,
            tets: mesh.tets.len() as u64,
            faces: faces.count,
            edges,
            hull_facets: faces.hull.len() as u64,
            hull_vertices: hull.vertices as u64,
            components: components as u64,
            negative_tets: oriented.negative,
        };
        drop((faces, hull, oriented)); // the hash needs room
        let hash = hash.unwrap_or_else(|| match options.depth {
            Depth::Fast => Hash::Skipped,
            Depth::Full => match hash::canonical_hash(mesh.points, mesh.tets) {
                Ok(hash) => Hash::Value(hash),
                Err(why) => Hash::None(why.to_string()),
            },
        });
        self.report(&counts, hash)
    }

    /// Runs the level *topology*. Returns the hull and the numbers of components and edges.
    fn topology(&mut self, sound: &Sound, faces: &Faces) -> (Hull, usize, u64) {
        let (mesh, limit) = (self.mesh, self.options.max_defects);
        let order = self.options.vertex_order;
        let part = topology::neighbours(mesh, faces, &sound.tet, order, limit);
        self.take(Level::Topology, part);
        topology::claimed_hull(mesh, &faces.hull, &mut self.findings);
        let components = topology::components(mesh, faces, &sound.tet, &mut self.findings);
        let hull = topology::hull(mesh, &faces.hull, &mut self.findings);
        if !self.is_full() {
            return (hull, components, 0);
        }
        let (part, edges) = topology::links(mesh, faces, &sound.tet, limit);
        self.take(Level::Topology, part);
        self.findings.merge(topology::euler(faces, sound, edges));
        self.findings.merge(topology::hull_euler(mesh, &faces.hull, &hull));
        (hull, components, edges)
    }

    /// Runs the levels *Delaunay* and *canonical*.
    fn delaunay(&mut self, oriented: &Oriented, faces: &Faces, hull: &Hull) {
        let (canonical, limit) = (self.is_full(), self.options.max_defects);
        let inside = geometry::delaunay(oriented, faces, canonical, limit);
        let on_hull = hull::edges(oriented, &faces.hull, &hull.pairs, canonical, limit);
        for (part, ties) in [inside, on_hull] {
            self.take(Level::Delaunay, part);
            self.take(Level::Canonical, ties);
        }
        // The global test presumes all that came before it.
        let sane = Level::ALL[..3].iter().all(|&l| self.findings.count(l) == 0);
        if sane && self.findings.count(Level::Delaunay) == 0 {
            self.take(Level::Delaunay, hull::once_around(oriented, &faces.hull, 0, limit));
        } else {
            self.levels[Level::Delaunay as usize].1 += 1;
        }
        self.done(Level::Delaunay);
        if canonical {
            self.done(Level::Canonical);
        }
    }

    fn report(self, counts: &Counts, hash: Hash) -> Report {
        let mut sane = true;
        let levels = Level::ALL.map(|level| {
            let (tally, untested, ran) = self.levels[level as usize];
            let defects = self.findings.count(level);
            let outcome = match () {
                () if defects > 0 => Outcome::Failed,
                () if !ran => Outcome::Skipped,
                () if untested > 0 || !sane => Outcome::Incomplete,
                () => Outcome::Passed,
            };
            sane &= outcome == Outcome::Passed;
            let Tally { filter, exact } = tally;
            LevelReport { level, outcome, filter, exact, untested, defects }
        });
        Report {
            levels: levels.to_vec(),
            defects: self.findings.defects(self.mesh.points),
            defect_counts: self.findings.counts,
            counts: *counts,
            volume: self.volume,
            mirrored: self.mirrored,
            hash,
        }
    }
}
