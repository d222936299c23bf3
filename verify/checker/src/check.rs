//! The order of the levels.

use crate::adjacency_proof::{self, Proof};
use crate::chunks::Partial;
use crate::defect::{Findings, Kind, Level};
use crate::elements::{self, Verdict, verdict};
use crate::faces::{self, Faces};
use crate::geometry::{self, Oriented};
use crate::hash;
use crate::mesh::{Depth, Mesh, Options};
use crate::report::{Counts, Hash, Information, Ran, Report, outcomes};
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
    Run::new(mesh, options, Asked::Canonical).check()
}

/// Judges a mesh as a finite element mesh of any body; never panics, whatever the mesh. Runs on the
/// current rayon pool; the report does not depend on the number of threads.
///
/// *Defects*: what [`check`] finds at the level structure, but for two vertices at one place; faces
/// of three tetrahedra, wrong claims; flat and inverted tetrahedra; and at the level *overlap*
/// tetrahedra that overlap, hanging vertices and edges that cross. *Information*
/// ([`Report::information`]): two vertices at one place (a crack), pieces, pinched edges and
/// vertices, and what else keeps the mesh from being Delaunay, convex or canonical. With `delaunay`
/// all of these but the last are defects, too.
///
/// Cost: that of [`check`], and O(n log n) for `n` tetrahedra, if the mesh is not convex and
/// Delaunay; the module `elements` says when it is more.
///
/// ```
/// use ltbw_verify::{Kind, Mesh, Options, check_elements};
///
/// // Two tetrahedra that share an edge and nothing else, and one that is in the second.
/// let points = [
///     [0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0],
///     [-4.0, 0.0, 0.0], [-4.0, -4.0, 0.0],
///     [-2.0, -1.0, 0.5], [-1.5, -1.0, 0.5], [-2.0, -0.5, 0.5], [-2.0, -1.0, 1.0],
/// ];
/// let tets = [[0, 2, 3, 1], [0, 4, 5, 1], [6, 7, 8, 9]];
/// let report = check_elements(&Mesh::new(&points, &tets[..2]), &Options::default(), false);
/// assert!(report.passed());
/// assert_eq!(report.information.expect("always told").count(Kind::HullEdge), 1);
/// let report = check_elements(&Mesh::new(&points, &tets), &Options::default(), false);
/// assert_eq!(report.defects[0].tets, [1, 2]);
/// assert_eq!(report.count(Kind::Overlap), 1);
/// ```
pub fn check_elements(mesh: &Mesh, options: &Options, delaunay: bool) -> Report {
    let asked = if delaunay { Asked::DelaunayElements } else { Asked::Elements };
    Run::new(mesh, options, asked).check()
}

/// The exact orientation of every tetrahedron: 1, -1, or 0 for a flat one and for one that names a
/// point twice, or one that is not there or not finite. Never panics, whatever the mesh.
pub fn signs(mesh: &Mesh) -> Vec<i8> {
    if !structure::fits(mesh) {
        return vec![0; mesh.tets.len()];
    }
    let sound = structure::check(mesh, &Options::default(), &mut Findings::new(0));
    let (oriented, _) = geometry::signs(mesh, &sound.tet);
    (0..mesh.tets.len()).map(|t| oriented.sign(t)).collect()
}

/// The demands on a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Asked {
    /// The Delaunay mesh of its vertices, the canonical one.
    Canonical,
    /// A finite element mesh.
    Elements,
    /// One that is Delaunay and convex.
    DelaunayElements,
}

impl Asked {
    /// The levels of the report, in order.
    fn levels(self) -> &'static [Level] {
        match self {
            Self::Canonical => &Level::ALL,
            _ => &Level::ELEMENTS,
        }
    }

    /// Whether a level is more than information.
    fn includes(self, level: Level) -> bool {
        match level {
            Level::Delaunay => self != Self::Elements,
            Level::Canonical => self == Self::Canonical,
            Level::Overlap => self != Self::Canonical,
            _ => true,
        }
    }
}

/// A check under way.
struct Run<'a> {
    mesh: &'a Mesh<'a>,
    options: &'a Options,
    asked: Asked,
    findings: Findings,
    /// By level.
    levels: [Ran; 6],
    volume: f64,
    mirrored: bool,
}

impl<'a> Run<'a> {
    fn new(mesh: &'a Mesh<'a>, options: &'a Options, asked: Asked) -> Self {
        let (findings, levels) = (Findings::new(options.max_defects), Default::default());
        Self { mesh, options, asked, findings, levels, volume: 0.0, mirrored: false }
    }

    fn check(mut self) -> Report {
        let (mesh, options) = (self.mesh, self.options);
        if !structure::fits(mesh) {
            self.findings.add(Kind::TooLarge, &[], &[]);
            return self.report(&Counts::default(), Hash::None(Kind::TooLarge.text().to_owned()));
        }
        let sound = structure::check(mesh, options, &mut self.findings);
        if self.findings.count(Level::Structure) > 0 || mesh.neighbours.is_none() {
            return self.level_by_level(sound, None);
        }
        let hash = || match options.depth {
            Depth::Fast => Hash::Skipped,
            Depth::Full => Hash::Value(hash::of_sorted(mesh.points, mesh.tets, &sound.vertices)),
        };
        // The hash is in part sequential: the proof fills the gaps.
        let prove = || adjacency_proof::prove(mesh, options, self.is_full());
        let (proof, hash) = rayon::join(prove, hash);
        match proof {
            Some(proof) => self.proved(&sound, proof, hash),
            None => self.level_by_level(sound, Some(hash)),
        }
    }

    fn is_full(&self) -> bool {
        self.options.depth == Depth::Full
    }

    fn take(&mut self, level: Level, part: Partial) {
        self.findings.merge(part.findings);
        self.tally(level, part.tally);
        self.levels[level as usize].untested += part.untested;
    }

    fn tally(&mut self, level: Level, tally: Tally) {
        self.levels[level as usize].tally.merge(tally);
    }

    fn done(&mut self, level: Level) {
        self.levels[level as usize].ran = true;
    }

    /// The report of a mesh that was proved from its claimed adjacency.
    fn proved(mut self, sound: &Sound, proof: Proof, hash: Hash) -> Report {
        let Proof { orientation, delaunay, canonical, volume, hull, hull_facets, faces } = proof;
        self.tally(Level::Orientation, orientation);
        self.tally(Level::Delaunay, delaunay);
        self.tally(Level::Canonical, canonical);
        Level::ALL[..4].iter().for_each(|&level| self.done(level));
        // A tiling, says the theorem.
        self.done(Level::Overlap);
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
        if self.asked != Asked::Canonical {
            self.overlap(&oriented, &faces);
        }
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
        for levels in [inside, on_hull] {
            self.take(Level::Delaunay, levels.delaunay);
            self.take(Level::Canonical, levels.canonical);
        }
        // The global test presumes all that came before it.
        let sane = Level::ALL[..3].iter().all(|&l| self.findings.count(l) == 0);
        if sane && self.findings.count(Level::Delaunay) == 0 {
            self.take(Level::Delaunay, hull::once_around(oriented, &faces.hull, 0, limit));
        } else {
            self.levels[Level::Delaunay as usize].untested += 1;
        }
        self.done(Level::Delaunay);
        if canonical {
            self.done(Level::Canonical);
        }
    }

    /// Runs the level *overlap*. Nothing overlaps in what the theorem says to be a tiling.
    fn overlap(&mut self, oriented: &Oriented, faces: &Faces) {
        let is_tiling = Level::ALL[..4].iter().all(|&level| {
            self.findings.count(level) == 0 && self.levels[level as usize].untested == 0
        });
        if !is_tiling {
            let part = elements::contacts(oriented, faces, self.options.max_defects);
            self.take(Level::Overlap, part);
        }
        self.done(Level::Overlap);
    }

    /// Takes out of the findings what is no defect of a finite element mesh.
    fn information(&mut self) -> Information {
        let delaunay = self.asked == Asked::DelaunayElements;
        let of = |wanted: Verdict| move |kind| verdict(kind, delaunay) == wanted;
        drop(self.findings.take(of(Verdict::Implied)));
        let told = self.findings.take(of(Verdict::Information));
        Information { listed: told.defects(self.mesh.points), counts: told.counts }
    }

    fn report(mut self, counts: &Counts, hash: Hash) -> Report {
        let information = (self.asked != Asked::Canonical).then(|| self.information());
        let defects = |level| self.findings.count(level);
        let includes = |level| self.asked.includes(level);
        let levels = outcomes(self.asked.levels(), &self.levels, defects, includes);
        Report {
            levels,
            defects: self.findings.defects(self.mesh.points),
            defect_counts: self.findings.counts,
            counts: *counts,
            volume: self.volume,
            mirrored: self.mirrored,
            hash,
            information,
            parts: None,
        }
    }
}
