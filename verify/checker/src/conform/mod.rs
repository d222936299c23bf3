//! Does a mesh conform to a domain, and does it meet its bounds? Exactly, by code of its own.
//!
//! [`conforms`] looks at a mesh of a domain's inside (no exterior tetrahedra):
//!
//! 1. the mesh is sound: structure, positive orientation, no fold, every interior face locally
//!    Delaunay (the tests of [`crate::check`]; the hull of a domain need not be convex);
//! 2. every vertex of the domain is a vertex of the mesh. Here and below, what has nothing but
//!    exterior around it is no part of the domain (`exterior`);
//! 3. every edge of every facet, and every segment, is a chain of edges of the mesh. Where two
//!    polygons of one plane meet along an edge and nothing else does, the facet simply continues:
//!    such an edge need not be there. Facets of one plane are looked at together;
//! 4. every plane's facets are *tiled*: the faces of the mesh that lie in the plane and inside
//!    their polygons have their area, in integers. By 3 no face crosses the outline, and faces of
//!    a sound mesh do not overlap, so equal area leaves no gap;
//! 5. every face of only one tetrahedron lies on a facet;
//! 6. tetrahedra that no facet separates have one tag; no tetrahedron holds the point of a hole;
//!    every region's seed is in one. If tags are to be the numbers of regions, what is around the
//!    seeds has theirs, and nothing else has;
//! 7. every tetrahedron meets the bounds, exactly: circumradius to shortest edge, and volume. Those
//!    with a dihedral angle below one are counted.
//!
//! The volume is summed exactly and given as a fraction, to be compared with the domain's own.

mod bounds;
mod exterior;
mod facet;
mod finding;
mod flat;
mod incidence;
mod outline;
mod parted;
mod patch;
mod patches;
mod place;
mod plc;
mod regions;
mod slab;
mod tiles;
mod tree;
mod whole;

use crate::angles::{Bound, Found};
use crate::chunks::pieces;
use crate::defect::{Findings, Level};
use crate::faces::{self, Faces};
use crate::geometry;
use crate::mesh::{Mesh, Options, Point, Side, face};
use crate::structure;
use exterior::Exterior;
use facet::FlatFacet;
pub use finding::{Conformity, ConformityDefect, Finding, Limits};
use num_bigint::BigInt;
pub use parted::{DomainPart, conforms_parted};
use patches::{InUnits, Patches};
use place::holds;
pub use plc::{Plc, PlcFacet};
use std::collections::{HashMap, HashSet};
use tree::{Shape, Tree, bounds};
pub use whole::Fraction;
use whole::{Units, Whole, six_volumes};

/// Checks a mesh against the domain that it is to be a mesh of. `tags` are the regions of the
/// tetrahedra, if they are known. Never panics, whatever the mesh and the domain.
pub fn conforms(
    mesh: &Mesh,
    plc: &Plc,
    tags: Option<&[i64]>,
    limits: &Limits,
    options: &Options,
) -> Conformity {
    let left: Plc;
    let (limit, exterior) = (options.max_defects, Exterior::default());
    let mut run = Run { mesh, plc, exterior, limit, out: Conformity::default() };
    let Some(faces) = run.soundness(options) else { return run.out };
    let named = plc.facets.iter().flat_map(|f| &f.polygons).flatten().copied();
    let named = named.chain(plc.segments.iter().flatten().copied());
    let known = named.into_iter().all(|v| (v as usize) < plc.vertices.len());
    let Some(units) = Units::of(&[mesh.points, &plc.vertices]).filter(|_| known) else {
        run.add(ConformityDefect::TooFine, &[]);
        return run.out;
    };
    let points: Vec<Whole> = mesh.points.iter().map(|p| units.whole(p)).collect();
    let present = run.present(&units, &points);
    if let Some(exterior) = Exterior::find(plc, &units, &present) {
        left = exterior.left(plc);
        (run.plc, run.exterior) = (&left, exterior);
    }
    run.vertices(&present);
    let (on_facets, on_patches) = run.boundary(&units, &points, &faces, tags);
    run.hull(&faces, &on_facets);
    let cells = run.cells(&faces, &on_facets, tags);
    let seeds = run.seeds(&units, &points);
    let seeds = run.regions(&seeds).map(|seed| seed.map(|t| cells[t]));
    let seeds: Vec<Option<u32>> = seeds.collect();
    let regions = Regions { cells: &cells, seeds: &seeds };
    run.numbers(regions, tags.filter(|_| options.numbered_regions));
    run.out.volume = Some(units.sixth(&run.six_volumes(&points)));
    run.bounds(&units, &points, limits, regions, &on_patches);
    run.out
}

struct Run<'a> {
    mesh: &'a Mesh<'a>,
    plc: &'a Plc,
    /// The items that were left out of it.
    exterior: Exterior,
    limit: usize,
    out: Conformity,
}

/// The components of a mesh between facets.
#[derive(Clone, Copy)]
struct Regions<'a> {
    /// That of each tetrahedron.
    cells: &'a [u32],
    /// That of each region of the domain.
    seeds: &'a [Option<u32>],
}

/// An edge, its ends ascending.
fn edge(a: u32, b: u32) -> [u32; 2] {
    if a < b { [a, b] } else { [b, a] }
}

impl Run<'_> {
    fn add(&mut self, breach: ConformityDefect, ids: &[u32]) {
        let count = self.out.counts.entry(breach).or_default();
        *count += 1;
        if *count <= self.limit as u64 {
            self.out.findings.push(Finding { breach, ids: ids.to_vec() });
        }
    }

    /// The levels structure, orientation and Delaunay (of interior faces); the adjacency, if they
    /// pass.
    fn soundness(&mut self, options: &Options) -> Option<Faces> {
        let (mesh, limit) = (self.mesh, self.limit);
        let mut findings = Findings::new(limit);
        let mut faces = None;
        if structure::fits(mesh) {
            let mut sound = structure::check(mesh, options, &mut findings);
            let found = faces::matched(mesh, &mut sound.tet, limit, &mut findings);
            let (oriented, mut tally) = geometry::signs(mesh, &sound.tet);
            let order = options.vertex_order;
            let part = geometry::orientation(&oriented, &found, &sound.tet, order, limit);
            let levels = geometry::delaunay(&oriented, &found, false, limit);
            for part in [part, levels.delaunay] {
                tally.merge(part.tally);
                findings.merge(part.findings);
            }
            self.out.tests = (tally.filter, tally.exact);
            faces = Some(found);
        } else {
            findings.add(crate::Kind::TooLarge, &[], &[]);
        }
        self.out.mesh_defects = findings.defects(mesh.points);
        self.out.mesh_defect_count = Level::ALL.iter().map(|&level| findings.count(level)).sum();
        faces.filter(|_| self.out.mesh_defect_count == 0)
    }

    /// Which points tetrahedra have.
    fn used(&self) -> Vec<bool> {
        let mut used = vec![false; self.mesh.points.len()];
        self.mesh.tets.iter().flatten().for_each(|&v| used[v as usize] = true);
        used
    }

    /// Which vertices of the domain the mesh has.
    fn present(&self, units: &Units, points: &[Whole]) -> Vec<bool> {
        let used = self.used();
        let used = points.iter().zip(&used).filter(|(_, used)| **used);
        let places: HashSet<Whole> = used.map(|(p, _)| *p).collect();
        self.plc.vertices.iter().map(|p| places.contains(&units.whole(p))).collect()
    }

    /// Every vertex of the domain is there.
    fn vertices(&mut self, present: &[bool]) {
        for (v, &is_there) in present.iter().enumerate() {
            if !is_there && !self.exterior.has_vertex(v) {
                self.add(ConformityDefect::VertexMissing, &[v as u32]);
            }
        }
    }

    /// The facets in their planes; `None` of those without.
    fn flats(&self, units: &Units, corners: &[Whole]) -> Vec<Option<FlatFacet>> {
        let flat = |facet: &PlcFacet| {
            let holes: Vec<Whole> = facet.holes.iter().map(|p| units.whole(p)).collect();
            FlatFacet::new(&facet.polygons, &holes, |v| corners[v as usize])
        };
        self.plc.facets.iter().map(flat).collect()
    }

    /// A facet is in no plane.
    fn degenerate(&mut self, f: u32) {
        if !self.exterior.has_facet(f as usize) {
            self.add(ConformityDefect::FacetDegenerate, &[f]);
        }
    }

    /// Edges and facets of the domain; returns the codes of the faces on facets, and per vertex the
    /// patches that it is on.
    fn boundary(
        &mut self,
        units: &Units,
        points: &[Whole],
        faces: &Faces,
        tags: Option<&[i64]>,
    ) -> (HashSet<u32>, Vec<Vec<u32>>) {
        let corners: Vec<Whole> = self.plc.vertices.iter().map(|p| units.whole(p)).collect();
        let mut flat = self.flats(units, &corners);
        let degenerate = (0u32..).zip(&flat).filter(|(_, flat)| flat.is_none()).map(|own| own.0);
        degenerate.for_each(|f| self.degenerate(f));
        let patches = Patches::find(self.plc, &corners, units).unwrap_or_else(|| {
            self.add(ConformityDefect::TooFine, &[]);
            Patches::none(self.plc, units)
        });
        let used = self.used();
        let order = (0..points.len() as u32).filter(|&v| used[v as usize]);
        let tree = Tree::new(points, order.collect());
        let on = self.vertices_on(&flat, &corners, &tree);
        let groups = patches.groups(&mut flat, &corners);
        let outline = self.edges(&corners, points, &tree, &groups);
        let mut codes = self.tiles(&flat, points, faces, &on, &groups);
        let on = patches.at(&on, points);
        let mesh = InUnits { units, points, faces, tags, part: None };
        self.patches(&patches, &mesh, &on, &outline, &mut codes);
        (codes, on)
    }

    /// Every face of one tetrahedron is on a facet.
    fn hull(&mut self, faces: &Faces, on_facets: &HashSet<u32>) {
        for &code in faces.hull.iter().filter(|code| !on_facets.contains(code)) {
            let Side { t, i } = crate::mesh::split(code);
            let [a, b, c] = face(&self.mesh.tets[t], i);
            self.add(ConformityDefect::HullFaceOffFacet, &[t as u32, a, b, c]);
        }
    }

    /// The component of each tetrahedron between facets; each has one tag.
    fn cells(&mut self, faces: &Faces, on_facets: &HashSet<u32>, tags: Option<&[i64]>) -> Vec<u32> {
        let count = self.mesh.tets.len();
        let tag = |t: usize| tags.and_then(|tags| tags.get(t));
        let mut cell = vec![u32::MAX; count];
        let mut next = 0;
        for first in 0..count {
            if cell[first] != u32::MAX {
                continue;
            }
            cell[first] = next;
            let mut stack = vec![first];
            while let Some(t) = stack.pop() {
                for i in 0..4 {
                    let Some(Side { t: u, .. }) = faces.other(t, i) else { continue };
                    if on_facets.contains(&((4 * t + i) as u32)) {
                        continue;
                    }
                    if tag(t) != tag(u) && t < u {
                        self.add(ConformityDefect::TagsDiffer, &[t as u32, u as u32]);
                    }
                    if cell[u] == u32::MAX {
                        cell[u] = next;
                        stack.push(u);
                    }
                }
            }
            next += 1;
        }
        self.out.cells = u64::from(next);
        cell
    }

    /// A tetrahedron of each point of a hole, and then of each seed of a region, if it is in one.
    fn seeds(&self, units: &Units, points: &[Whole]) -> Vec<Option<usize>> {
        let (mesh, plc) = (self.mesh, self.plc);
        let all: Vec<&Point> = plc.holes.iter().chain(&plc.regions).collect();
        // Rounded likewise, so that what is in a box stays in it.
        let places: Vec<Whole> = all.iter().map(|p| units.whole(p)).collect();
        let tree = Tree::new(&places, (0..all.len() as u32).collect());
        let parts = pieces(mesh.tets.len(), |range| {
            let mut found = Vec::new();
            for t in range {
                let own = bounds(mesh.tets[t].iter().map(|&v| points[v as usize]));
                tree.search(&Shape::within(own), |k| {
                    found.extend(holds(mesh, t, all[k as usize]).then_some((k as usize, t)));
                });
            }
            found
        });
        let mut seeds = vec![None; all.len()];
        for (k, t) in parts.into_iter().flatten() {
            seeds[k].get_or_insert(t);
        }
        seeds
    }

    /// No hole is meshed, and every region is; returns a tetrahedron of each region, of those that
    /// hold holes and seeds.
    fn regions<'s>(
        &mut self,
        seeds: &'s [Option<usize>],
    ) -> impl Iterator<Item = Option<usize>> + 's {
        let (holes, regions) = seeds.split_at(self.plc.holes.len());
        for (k, t) in (0u32..).zip(holes).filter_map(|(k, t)| Some((k, (*t)?))) {
            self.add(ConformityDefect::HoleMeshed, &[k, t as u32]);
        }
        for (k, _) in (0u32..).zip(regions).filter(|(_, seed)| seed.is_none()) {
            self.add(ConformityDefect::RegionNotMeshed, &[k]);
        }
        regions.iter().copied()
    }

    /// Six times the exact volume, in cubic units.
    fn six_volumes(&self, points: &[Whole]) -> BigInt {
        let parts = pieces(self.mesh.tets.len(), |range| {
            let six = |t: usize| {
                let six = six_volumes(self.mesh.tets[t].map(|v| points[v as usize]));
                if six < BigInt::ZERO { -six } else { six }
            };
            range.map(six).sum::<BigInt>()
        });
        parts.into_iter().sum()
    }

    /// The bounds of every tetrahedron.
    fn bounds(
        &mut self,
        units: &Units,
        points: &[Whole],
        limits: &Limits,
        regions: Regions<'_>,
        on_patches: &[Vec<u32>],
    ) {
        let Regions { cells, seeds } = regions;
        let own = |bound: &Option<f64>, seed: &Option<u32>| {
            Some(((*seed)?, units.cubic(bound.filter(|&b| b > 0.0)?)))
        };
        let pairs = limits.region_volumes.iter().zip(seeds);
        let regions: HashMap<u32, f64> = pairs.filter_map(|(b, s)| own(b, s)).collect();
        let general = limits.max_volume.map(|bound| units.cubic(bound));
        let longest = limits.max_edge.map(|bound| units.linear(bound));
        let least = limits.min_dihedral.map(Bound::new);
        let parts = pieces(self.mesh.tets.len(), |range| {
            let (mut found, mut small) = (Vec::new(), Found::new(self.limit));
            for t in range {
                let corners = self.mesh.tets[t].map(|v| points[v as usize]);
                if let Some(bound) = least {
                    small.add(t as u32, &bound.of_whole(corners));
                }
                // A tetrahedron between the triangles of one patch has no shape to speak of.
                let [a, b, c, d] = self.mesh.tets[t].map(|v| &on_patches[v as usize]);
                let is_flat = a.iter().any(|k| b.contains(k) && c.contains(k) && d.contains(k));
                if is_flat {
                    continue;
                }
                if limits.radius_edge.is_some_and(|b| bounds::ratio_exceeds(corners, b)) {
                    found.push((ConformityDefect::RatioExceeded, t as u32));
                }
                let volumes = [general, regions.get(&cells[t]).copied()];
                if volumes.into_iter().flatten().any(|b| bounds::volume_exceeds(corners, b)) {
                    found.push((ConformityDefect::VolumeExceeded, t as u32));
                }
                if longest.is_some_and(|b| bounds::edge_exceeds(corners, b)) {
                    found.push((ConformityDefect::EdgeExceeded, t as u32));
                }
            }
            (found, small)
        });
        self.out.tets = self.mesh.tets.len() as u64;
        let mut small = Found::new(self.limit);
        for (found, part) in parts {
            found.into_iter().for_each(|(breach, t)| self.add(breach, &[t]));
            small = small.merge(part);
        }
        self.out.below_dihedral = limits.min_dihedral.map(|degrees| small.under(degrees));
    }
}
