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
//!    every region's seed is in one;
//! 7. every tetrahedron meets the bounds, exactly: circumradius to shortest edge, and volume.
//!
//! The volume is summed exactly and given as a fraction, to be compared with the domain's own.

mod bounds;
mod exterior;
mod facet;
mod finding;
mod flat;
mod patch;
mod place;
mod plc;
mod slab;
mod whole;

use crate::chunks::pieces;
use crate::defect::{Findings, Level};
use crate::faces::{self, Faces};
use crate::geometry;
use crate::mesh::{Mesh, Options, Point, face};
use crate::predicates::{Tally, orient3d};
use crate::structure;
use exterior::Exterior;
use facet::FlatFacet;
pub use finding::{Conformity, ConformityDefect, Finding, Limits};
use num_bigint::BigInt;
use place::{along, groups, holds};
pub use plc::{Plc, PlcFacet};
use std::collections::{HashMap, HashSet};
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
    if let Some(exterior) = Exterior::find(plc, &units, mesh, &points) {
        left = exterior.left(plc);
        (run.plc, run.exterior) = (&left, exterior);
    }
    let (on_facets, on_patches) = run.boundary(&units, &points, &faces, tags);
    run.hull(&faces, &on_facets);
    let cells = run.cells(&faces, &on_facets, tags);
    let seeds = run.seeds();
    run.volume(&units, &points);
    run.bounds(&units, &points, limits, (&cells, &seeds), &on_patches);
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
            let (delaunay, _) = geometry::delaunay(&oriented, &found, false, limit);
            for part in [part, delaunay] {
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

    /// Vertices, edges and facets of the domain; returns the codes of the faces on facets, and per
    /// vertex the patches that it is on.
    fn boundary(
        &mut self,
        units: &Units,
        points: &[Whole],
        faces: &Faces,
        tags: Option<&[i64]>,
    ) -> (HashSet<u32>, Vec<Vec<u32>>) {
        let corners: Vec<Whole> = self.plc.vertices.iter().map(|p| units.whole(p)).collect();
        let mut used = vec![false; points.len()];
        self.mesh.tets.iter().flatten().for_each(|&v| used[v as usize] = true);
        let place: HashMap<Whole, u32> =
            (0u32..).zip(points).filter(|(v, _)| used[*v as usize]).map(|(v, p)| (*p, v)).collect();
        for (v, p) in (0u32..).zip(&corners) {
            if !place.contains_key(p) && !self.exterior.has_vertex(v as usize) {
                self.add(ConformityDefect::VertexMissing, &[v]);
            }
        }
        let mut facets = Vec::new();
        for (f, facet) in (0u32..).zip(&self.plc.facets) {
            let holes: Vec<Whole> = facet.holes.iter().map(|p| units.whole(p)).collect();
            let flat = FlatFacet::new(&facet.polygons, &holes, |v| corners[v as usize]);
            if flat.is_none() && !self.exterior.has_facet(f as usize) {
                self.add(ConformityDefect::FacetDegenerate, &[f]);
            }
            facets.push(flat);
        }
        let patches = flat::find(self.plc, &corners).unwrap_or_else(|| {
            self.add(ConformityDefect::TooFine, &[]);
            Vec::new()
        });
        let on = self.vertices_on(&facets, &corners, points, &used);
        let mut flat = facets;
        for &f in patches.iter().flat_map(|patch| &patch.facets) {
            flat[f as usize] = None;
        }
        let mut groups = groups(&flat, &corners);
        for patch in &patches {
            patch.facets.iter().for_each(|&f| groups[f as usize] = patch.facets[0]);
        }
        let outline = self.edges(&corners, points, &on, &groups);
        let mut codes = self.tiles(&flat, points, faces, &on, &groups);
        let on = self.patches(&patches, units, points, faces, &on, &outline, tags, &mut codes);
        (codes, on)
    }

    /// Per vertex of the mesh the facets in whose plane and box it lies, ascending.
    fn vertices_on(
        &self,
        facets: &[Option<FlatFacet>],
        corners: &[Whole],
        points: &[Whole],
        used: &[bool],
    ) -> Vec<Vec<u32>> {
        // By the first coordinate, so that a facet looks at a slab only.
        let mut order: Vec<u32> = (0..points.len() as u32).filter(|&v| used[v as usize]).collect();
        let orders = [0, 1, 2].map(|axis| {
            order.sort_unstable_by_key(|&v| points[v as usize][axis]);
            order.clone()
        });
        let parts = pieces(facets.len(), |range| {
            let mut pairs = Vec::new();
            for f in range {
                let Some(flat) = &facets[f] else { continue };
                let all = self.plc.facets[f].polygons.iter().flatten();
                let all: Vec<Whole> = all.map(|&v| corners[v as usize]).collect();
                let ends = [0, 1, 2].map(|k| {
                    let low = all.iter().map(|p| p[k]).min().unwrap_or(0);
                    (low, all.iter().map(|p| p[k]).max().unwrap_or(0))
                });
                let slab = (0..3)
                    .map(|k| {
                        let list = &orders[k];
                        let start = list.partition_point(|&v| points[v as usize][k] < ends[k].0);
                        let end = list.partition_point(|&v| points[v as usize][k] <= ends[k].1);
                        &list[start..end]
                    })
                    .min_by_key(|slab| slab.len());
                let [a, b, c] = flat.frame.map(|v| &self.plc.vertices[v as usize]);
                for &v in slab.unwrap_or_default() {
                    let p = &points[v as usize];
                    let inside = (0..3).all(|k| ends[k].0 <= p[k] && p[k] <= ends[k].1);
                    let at = &self.mesh.points[v as usize];
                    if inside && orient3d([a, b, c, at], &mut Tally::default()) == 0 {
                        pairs.push((v, f as u32));
                    }
                }
            }
            pairs
        });
        let mut on = vec![Vec::new(); points.len()];
        for (v, f) in parts.into_iter().flatten() {
            on[v as usize].push(f);
        }
        on
    }

    /// The edges inside the facets of one plane: of exactly two polygons there, and nothing else.
    fn continued(&self, groups: &[u32]) -> HashSet<[u32; 2]> {
        let mut uses: HashMap<[u32; 2], Vec<Option<u32>>> = HashMap::new();
        for (f, facet) in self.plc.facets.iter().enumerate() {
            for polygon in &facet.polygons {
                let group = (polygon.len() > 2).then_some(groups[f]);
                for (k, &a) in polygon.iter().enumerate() {
                    let key = edge(a, polygon[(k + 1) % polygon.len()]);
                    uses.entry(key).or_default().push(group);
                }
            }
        }
        for &[a, b] in &self.plc.segments {
            uses.entry(edge(a, b)).or_default().push(None);
        }
        let inner = |uses: &[Option<u32>]| matches!(uses, [Some(a), Some(b)] if a == b);
        uses.into_iter().filter(|(_, u)| inner(u)).map(|(edge, _)| edge).collect()
    }

    /// Every edge of a polygon and every segment is a chain of edges of the mesh. Returns these.
    fn edges(
        &mut self,
        corners: &[Whole],
        points: &[Whole],
        on: &[Vec<u32>],
        groups: &[u32],
    ) -> HashSet<[u32; 2]> {
        let continued = self.continued(groups);
        let mut by_facet: Vec<Vec<u32>> = vec![Vec::new(); self.plc.facets.len()];
        for (v, facets) in (0u32..).zip(on) {
            facets.iter().for_each(|&f| by_facet[f as usize].push(v));
        }
        let everything: Vec<u32> = match self.plc.segments.is_empty() {
            true => Vec::new(),
            false => (0..points.len() as u32).collect(),
        };
        let mut wanted: HashMap<[u32; 2], Vec<[u32; 2]>> = HashMap::new();
        let mut want = |ends: [u32; 2], candidates: &[u32]| {
            let [a, b] = ends.map(|v| corners[v as usize]);
            let mut chain: Vec<(i128, u32)> = candidates
                .iter()
                .filter_map(|&v| Some((along(a, b, points[v as usize])?, v)))
                .collect();
            chain.sort_unstable();
            for pair in chain.windows(2) {
                wanted.entry(edge(pair[0].1, pair[1].1)).or_default().push(ends);
            }
        };
        for (f, facet) in self.plc.facets.iter().enumerate() {
            for polygon in &facet.polygons {
                for (k, &a) in polygon.iter().enumerate() {
                    let b = polygon[(k + 1) % polygon.len()];
                    if !continued.contains(&edge(a, b)) {
                        want([a, b], &by_facet[f]);
                    }
                }
            }
        }
        self.plc.segments.iter().for_each(|&ends| want(ends, &everything));
        let chains = wanted.keys().copied().collect();
        for tet in self.mesh.tets {
            for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
                wanted.remove(&edge(tet[i], tet[j]));
            }
        }
        let mut broken: Vec<[u32; 2]> = wanted.into_values().flatten().collect();
        broken.sort_unstable();
        broken.dedup();
        broken.iter().for_each(|ends| self.add(ConformityDefect::SegmentBroken, ends));
        chains
    }

    /// The faces on the facets of each plane have their area. Returns their codes, from both sides.
    fn tiles(
        &mut self,
        facets: &[Option<FlatFacet>],
        points: &[Whole],
        faces: &Faces,
        on: &[Vec<u32>],
        groups: &[u32],
    ) -> HashSet<u32> {
        // A face may cross from one facet of its plane to the next: by groups, then.
        let on: Vec<Vec<u32>> = on
            .iter()
            .map(|facets| {
                let mut planes: Vec<u32> = facets.iter().map(|&f| groups[f as usize]).collect();
                planes.sort_unstable();
                planes.dedup();
                planes
            })
            .collect();
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); facets.len()];
        (0u32..).zip(groups).for_each(|(f, &g)| members[g as usize].push(f));
        let mut areas: Vec<BigInt> = vec![BigInt::ZERO; facets.len()];
        let mut codes = HashSet::new();
        for (t, tet) in self.mesh.tets.iter().enumerate() {
            for i in 0..4 {
                let corners = face(tet, i);
                let other = faces.other(t, i);
                // An interior face is looked at from one side.
                let twice = other.is_some_and(|(u, _)| u < t);
                if twice || corners.iter().any(|&v| on[v as usize].is_empty()) {
                    continue;
                }
                let [a, b, c] = corners.map(|v| &on[v as usize]);
                let places = corners.map(|v| points[v as usize]);
                let mut found = false;
                for &g in a.iter().filter(|g| b.contains(g) && c.contains(g)) {
                    let mut flats =
                        members[g as usize].iter().filter_map(|&f| facets[f as usize].as_ref());
                    if let Some(flat) = flats.find(|flat| flat.holds_centroid(places)) {
                        areas[g as usize] += flat.area_of(places);
                        found = true;
                    }
                }
                if found {
                    self.out.subfaces += 1;
                    codes.insert((4 * t + i) as u32);
                    codes.extend(other.map(|(u, j)| (4 * u + j) as u32));
                }
            }
        }
        for (list, area) in members.iter().zip(areas) {
            let flats = list.iter().filter_map(|&f| facets[f as usize].as_ref());
            if let Some(&first) = list.first()
                && flats.map(FlatFacet::area).sum::<BigInt>() != area
            {
                self.add(ConformityDefect::FacetNotTiled, &[first]);
            }
        }
        codes
    }

    /// Every face of one tetrahedron is on a facet.
    fn hull(&mut self, faces: &Faces, on_facets: &HashSet<u32>) {
        for &code in faces.hull.iter().filter(|code| !on_facets.contains(code)) {
            let (t, i) = crate::mesh::split(code);
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
                    let Some((u, _)) = faces.other(t, i) else { continue };
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

    /// Locates the points of holes and the seeds of regions; returns a tetrahedron per region.
    fn seeds(&mut self) -> Vec<Option<usize>> {
        let (mesh, plc) = (self.mesh, self.plc);
        let find = |p: &Point| {
            let parts = pieces(mesh.tets.len(), |mut range| range.find(|&t| holds(mesh, t, p)));
            parts.into_iter().flatten().next()
        };
        for (k, p) in (0u32..).zip(&plc.holes) {
            if let Some(t) = find(p) {
                self.add(ConformityDefect::HoleMeshed, &[k, t as u32]);
            }
        }
        let seeds: Vec<Option<usize>> = plc.regions.iter().map(find).collect();
        for (k, _) in (0u32..).zip(&seeds).filter(|(_, seed)| seed.is_none()) {
            self.add(ConformityDefect::RegionNotMeshed, &[k]);
        }
        seeds
    }

    /// The exact volume.
    fn volume(&mut self, units: &Units, points: &[Whole]) {
        let parts = pieces(self.mesh.tets.len(), |range| {
            let six = |t: usize| {
                let six = six_volumes(self.mesh.tets[t].map(|v| points[v as usize]));
                if six < BigInt::ZERO { -six } else { six }
            };
            range.map(six).sum::<BigInt>()
        });
        self.out.volume = Some(units.sixth(&parts.into_iter().sum()));
    }

    /// The bounds of every tetrahedron.
    fn bounds(
        &mut self,
        units: &Units,
        points: &[Whole],
        limits: &Limits,
        (cells, seeds): (&[u32], &[Option<usize>]),
        on_patches: &[Vec<u32>],
    ) {
        let own = |bound: &Option<f64>, seed: &Option<usize>| {
            Some((cells[(*seed)?], units.cubic(bound.filter(|&b| b > 0.0)?)))
        };
        let pairs = limits.region_volumes.iter().zip(seeds);
        let regions: HashMap<u32, f64> = pairs.filter_map(|(b, s)| own(b, s)).collect();
        let general = limits.max_volume.map(|bound| units.cubic(bound));
        let parts = pieces(self.mesh.tets.len(), |range| {
            let mut found = Vec::new();
            for t in range {
                let corners = self.mesh.tets[t].map(|v| points[v as usize]);
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
            }
            found
        });
        self.out.tets = self.mesh.tets.len() as u64;
        parts.into_iter().flatten().for_each(|(breach, t)| self.add(breach, &[t]));
    }
}
