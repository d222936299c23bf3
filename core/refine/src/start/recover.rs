//! Recovery of the boundary: from the Delaunay mesh of the corners to one that has every subsegment
//! and every subface.
//!
//! First the segments. Then each facet gets its planar Delaunay triangulation: that of its
//! vertices together with one apex off the plane, whose tetrahedra stand on the triangles wanted
//! (the perturbation is the same, and the apex has no part in a decision between coplanar points).
//! Those of its triangles that lie in the facet's polygons are its subfaces.

use crate::RefineError;
use crate::complex::carrier::Carrier;
use crate::complex::parts::Parts;
use crate::heed::Heed;
use crate::mesh::item::{Item, Queues};
use crate::mesh::marks::{ENDS, face_bit};
use crate::mesh::state::{FACE, State};
use crate::table::{Map, Set, edge, triangle};
use ltbw_core::Builder;
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_domain::vector::dominant;
use ltbw_exact::{Point, PointSet};

/// The distance of an apex from its facet along an axis, in fine steps.
const APEX: f64 = (1u64 << 52) as f64;

impl State {
    /// Enters all segments; marks those that the mesh has, puts those that it lacks.
    ///
    /// # Errors
    /// [`RefineError::Cancelled`].
    pub(crate) fn enter_segments(
        &mut self,
        work: &mut Queues,
        heed: Heed<'_>,
    ) -> Result<(), RefineError> {
        let mut kernel = vec![INFINITE; self.plc.corners.len()];
        let mut inner: Vec<(u32, i64, VertexId)> = Vec::new();
        for (v, &carrier) in (0..).map(VertexId::new).zip(&self.carriers).skip(1) {
            match carrier {
                Carrier::Corner(c) => kernel[c as usize] = v,
                Carrier::Segment(s, parameter) => inner.push((s, parameter, v)),
                Carrier::Facet(_) | Carrier::Free => {}
            }
        }
        // In their order along each segment.
        inner.sort_unstable();
        let mut inner = inner.into_iter().peekable();
        for (s, segment) in (0..).zip(&self.plc.segments) {
            let [mut at, end] = segment.ends.map(|c| kernel[c as usize]);
            while let Some((.., next)) = inner.next_if(|own| own.0 == s) {
                self.segments.insert(edge(at, next), s);
                at = next;
            }
            self.segments.insert(edge(at, end), s);
        }
        let mut found: Set<[VertexId; 2]> = Set::default();
        for (k, t) in self.mesh.tet_ids().collect::<Vec<TetId>>().into_iter().enumerate() {
            heed.ask_at(k)?;
            let v = self.vertices(t);
            for (k, [i, j]) in ENDS.into_iter().enumerate() {
                let key = edge(v[i], v[j]);
                if self.segments.contains_key(&key) {
                    found.insert(key);
                    self.marks.set(t, 1 << (4 + k));
                }
            }
        }
        self.mark_ghost_edges();
        let mut keys: Vec<[VertexId; 2]> = self.segments.keys().copied().collect();
        keys.sort_unstable();
        for key in keys {
            if !found.contains(&key) {
                self.miss(Item::Segment(key), work);
            }
        }
        heed.ask()
    }

    /// Ghosts carry marks like all others: a wall may border on one.
    fn mark_ghost_edges(&mut self) {
        let ghosts: Vec<TetId> =
            self.mesh.topology().iter().filter(|(_, t)| t.is_ghost()).map(|(t, _)| t).collect();
        for t in ghosts {
            let v = self.vertices(t);
            for (k, [i, j]) in ENDS.into_iter().enumerate() {
                if self.segments.contains_key(&edge(v[i], v[j])) {
                    self.marks.set(t, 1 << (4 + k));
                }
            }
        }
    }

    /// Enters the subfaces of all facets, marks those that the mesh has and puts those that it
    /// lacks.
    ///
    /// # Errors
    /// A facet that has no triangulation; [`RefineError::Cancelled`].
    pub(crate) fn enter_subfaces(
        &mut self,
        work: &mut Queues,
        heed: Heed<'_>,
    ) -> Result<(), RefineError> {
        let mut on: Vec<Vec<VertexId>> = vec![Vec::new(); self.plc.facets.len()];
        for (v, &carrier) in (0..).map(VertexId::new).zip(&self.carriers).skip(1) {
            for &f in self.plc.facets_of(&carrier) {
                on[f as usize].push(v);
            }
        }
        self.at_edge = Some(Map::default());
        for (f, vertices) in (0..).zip(on) {
            heed.ask()?;
            // The layers of patches are found when the rest is there.
            if self.is_patch(f) {
                continue;
            }
            for key in self.triangulate(f, &vertices)? {
                self.add_subface(key, f);
            }
        }
        let mut present: Set<[VertexId; 3]> = Set::default();
        let all: Vec<TetId> = self.mesh.topology().iter().map(|(t, _)| t).collect();
        for (k, t) in all.into_iter().enumerate() {
            heed.ask_at(k)?;
            let v = self.vertices(t);
            for (slot, face) in FACE.into_iter().enumerate() {
                let [a, b, c] = face.map(|k| v[k]);
                let key = triangle(a, b, c);
                if self.subfaces.contains_key(&key) {
                    self.marks.set(t, face_bit(slot));
                    present.insert(key);
                }
            }
        }
        let mut missing: Vec<[VertexId; 3]> =
            self.subfaces.keys().filter(|k| !present.contains(*k)).copied().collect();
        missing.sort_unstable();
        missing.into_iter().for_each(|key| self.miss(Item::Subface(key), work));
        Ok(())
    }

    /// The triangles of facet `f`'s planar Delaunay triangulation that lie in the facet.
    pub(crate) fn triangulate(
        &self,
        f: u32,
        vertices: &[VertexId],
    ) -> Result<Vec<[VertexId; 3]>, RefineError> {
        let facet = &self.plc.facets[f as usize];
        let axis = dominant(&facet.plane.normal());
        let mut points: Vec<Point> = vertices.iter().map(|&v| self.at(v)).collect();
        let mut apex = points[0];
        apex[axis] += if apex[axis] > 0.0 { -APEX } else { APEX };
        points.push(apex);
        let count = vertices.len() as u32;
        let set = PointSet::new(points)?;
        let built = Builder::new().build(&set)?.mesh;
        // The triangles, each with those across its edges.
        let mut number: Map<TetId, usize> = Map::default();
        let mut triangles = Vec::new();
        for t in built.tet_ids() {
            let Some(v) = built.tet(t) else { continue };
            let Some(slot) = v.iter().position(|&w| w == count) else { continue };
            number.insert(t, triangles.len());
            triangles.push((t, v, slot));
        }
        let keys: Vec<[VertexId; 3]> = triangles
            .iter()
            .map(|&(_, v, slot)| {
                let [a, b, c] = FACE[slot].map(|k| vertices[v[k] as usize]);
                triangle(a, b, c)
            })
            .collect();
        let parts = Parts::new(facet, &self.plc.corners);
        let mut inside = vec![None; triangles.len()];
        for first in 0..triangles.len() {
            if inside[first].is_some() {
                continue;
            }
            // A component between subsegments is in the facet as a whole, or not at all.
            let verdict = Some(parts.at_centroid(keys[first].map(|v| self.at(v))).is_some());
            let mut stack = vec![first];
            inside[first] = verdict;
            while let Some(k) = stack.pop() {
                let (t, v, slot) = triangles[k];
                for side in FACE[slot] {
                    let [a, b] = two_others(slot, side).map(|k| vertices[v[k] as usize]);
                    let Some(&other) = built.neighbour(t, side).and_then(|u| number.get(&u)) else {
                        continue;
                    };
                    if inside[other].is_none() && !self.segments.contains_key(&edge(a, b)) {
                        inside[other] = verdict;
                        stack.push(other);
                    }
                }
            }
        }
        Ok(keys.into_iter().zip(inside).filter(|(_, i)| *i == Some(true)).map(|(k, _)| k).collect())
    }
}

/// The slots other than two.
fn two_others(a: usize, b: usize) -> [usize; 2] {
    let mut rest = (0..4).filter(|&k| k != a && k != b);
    [rest.next().unwrap_or(0), rest.next().unwrap_or(0)]
}
