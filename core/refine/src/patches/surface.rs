//! The surface of a patch: how a new point on it changes it.
//!
//! The subfaces of a patch are the faces where the label changes from its inner to its outer side.
//! A new tetrahedron inherits the label of the tetrahedron behind its wall, but one on a subface
//! of a patch that the point lies on is dust, and belongs to the outer side. So the labels tell the
//! new subfaces: the faces of the point and an edge of two walls where they differ; and a subface
//! that becomes a wall between two outer tetrahedra is one no longer.
//!
//! The verdict comes before anything is filled. Per patch, what goes and what comes must have one
//! outline (every edge of them an even number of times, but for the subsegment that is split), and
//! all that comes must have a positive area in the projection, with the inner side where it
//! belongs: then the patch is covered exactly once, as before. If that fails with dust on the outer
//! side, it is tried with labels that are inherited as they are; if that fails, too, the point is
//! refused.
//!
//! A point that is not on a patch may take dust of it into its cavity together with the subfaces
//! below. That is no loss: the other faces of the dust become the subfaces, under the same
//! condition, and the new tetrahedra on them belong to the inner side.

use crate::complex::carrier::Corner;
use crate::complex::patch::Sides;
use crate::complex::plc::Plc;
use crate::mesh::facet::Change;
use crate::mesh::marks::face_bit;
use crate::mesh::state::{FACE, Place, State};
use crate::mesh::survey::Face;
use crate::mesh::tiles::is_above;
use crate::rules::bounded::Bounded;
use crate::rules::verdict::Judge;
use crate::table::{Map, edge, sides, triangle};
use ltbw_core::topology::{INFINITE, TetId, VertexId, slot_of, tet_of};
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, orient3d};

/// A wall of a cavity.
struct Wall {
    /// Its corners, ascending.
    corners: [VertexId; 3],
    /// The label that its new tetrahedron has.
    label: u32,
    /// The patch of which it is a subface no longer.
    left: Option<u32>,
    /// The patch of which it becomes a subface.
    raised: Option<u32>,
}

/// The new point: a number that no vertex has.
const NEW: VertexId = VertexId::new(u32::MAX);

impl Plc {
    /// The labels on both sides of facet `f`, if it is a patch and they are known.
    fn sides_of(&self, f: u32) -> Option<Sides> {
        self.facets[f as usize].patch.as_ref()?.sides
    }

    /// The patch of which a face of a mesh is a subface. It is given as the face of a tetrahedron
    /// opposite a slot, with the labels of that tetrahedron and of the one beyond. While nothing is
    /// missing the label changes at the subfaces of patches only.
    pub(crate) fn patch_at(
        &self,
        corners: [Corner; 3],
        slot: usize,
        labels: [u32; 2],
    ) -> Option<u32> {
        let [a, b, c] = corners.each_ref().map(|own| &own.point);
        if labels[0] == labels[1] {
            return None;
        }
        let is_between = |f: &u32| {
            let Some(patch) = &self.facets[*f as usize].patch else { return false };
            let Some(sides) = patch.sides else { return false };
            let on_all = corners.iter().all(|own| self.lies_on(own.carrier, *f));
            on_all && {
                let turn = patch.turn([a, b, c]);
                let inwards = is_above(slot, turn) == sides.upwards;
                let [own, other] = labels;
                let known = if inwards { [own, other] } else { [other, own] };
                turn != 0 && known == [sides.inner, sides.outer]
            }
        };
        let all = || self.facets_of(&corners[0].carrier).iter().copied().filter(is_between);
        let mut several = all();
        match (several.next(), several.next()) {
            (one, None) => one,
            // Its corners are on the sides that patches have in common: it is within one of them.
            _ => all().find(|&f| {
                let patch = self.facets[f as usize].patch.as_ref();
                patch.is_some_and(|patch| patch.holds_triangle([a, b, c]))
            }),
        }
    }
}

impl State {
    /// Is facet `f` one whose triangulation is kept? Of patches that is so in joint steps only,
    /// where something is missing and labels are not certain.
    pub(crate) fn is_planned(&self, f: u32) -> bool {
        !self.is_patch(f) || self.journal.is_some()
    }
}

impl<B: Bounded> Judge<'_, B> {
    /// The changes that the point makes to the patches that it lies on, given those to the other
    /// facets; `None` if it leaves a patch torn. `split`: the subsegment that it divides.
    ///
    /// While the boundary is recovered there are no changes: layers are looked for afterwards.
    pub(crate) fn plan_patches(
        &self,
        place: &Place,
        split: Option<[VertexId; 2]>,
        others: &[Change],
    ) -> Option<Vec<Change>> {
        let (plc, survey) = (self.closure.plc(), self.survey);
        if self.closure.state().is_some_and(|state| state.journal.is_some()) {
            return Some(Vec::new());
        }
        let facets = plc.facets_of(&place.carrier).iter();
        let patches: Vec<u32> = facets.copied().filter(|&f| plc.is_patch(f)).collect();
        if patches.iter().any(|&f| plc.sides_of(f).is_none()) {
            return Some(Vec::new());
        }
        let stays = |s: &[VertexId; 3]| !others.iter().any(|c| c.removed.contains(s));
        let foreign = |face: &&Face<B::Tet>| !patches.contains(&face.facet) && stays(&face.key);
        if patches.is_empty() && !survey.inner().any(|face| plc.is_patch(face.facet)) {
            return Some(Vec::new());
        }
        let mut lost: Vec<u32> = survey.inner().filter(foreign).map(|face| face.facet).collect();
        lost.sort_unstable();
        lost.dedup();
        if patches.is_empty() && lost.is_empty() {
            return Some(Vec::new());
        }
        if lost.iter().all(|&f| plc.sides_of(f).is_some()) {
            let places = [&patches[..], &lost];
            let plan = |dust: bool| {
                let walls = self.labelled_walls(places, dust)?;
                self.plan_labels(&walls, &place.p, places, split, others)
            };
            let planned = plan(true).or_else(|| plan(false));
            if planned.is_some() || lost.is_empty() {
                return planned;
            }
        }
        // A point that takes something else out of the mesh has to wait: no labels would fit.
        let mut own: Vec<Change> = patches.iter().map(|&f| Change::of(f)).collect();
        for change in &mut own {
            let inner = survey.inner().filter(|face| face.facet == change.facet);
            change.removed.extend(inner.map(|face| face.key));
        }
        Some(own)
    }

    /// The plan by the labels that walls would have, for patches that the point is on, and others
    /// that it takes subfaces of.
    fn plan_labels(
        &self,
        walls: &[Wall],
        p: &Point,
        [patches, lost]: [&[u32]; 2],
        split: Option<[VertexId; 2]>,
        others: &[Change],
    ) -> Option<Vec<Change>> {
        let all = || patches.iter().chain(lost);
        let mut changes: Vec<Change> = all().map(|&f| Change::of(f)).collect();
        let place = |f: u32| all().position(|&g| g == f);
        for face in self.survey.inner() {
            if let Some(k) = place(face.facet) {
                changes[k].removed.push(face.key);
            }
        }
        for wall in walls {
            if let Some(k) = wall.left.and_then(place) {
                changes[k].removed.push(wall.corners);
                changes[k].relabelled.push((wall.corners, wall.label));
            }
            if let Some(f) = wall.raised {
                if !self.faces_inwards(f, wall.corners, p) {
                    return None;
                }
                changes[place(f)?].raised.push(wall.corners);
                changes[place(f)?].relabelled.push((wall.corners, wall.label));
            }
        }
        let mut edges: Vec<([VertexId; 2], usize)> = Vec::with_capacity(3 * walls.len());
        for (i, wall) in walls.iter().enumerate() {
            let [a, b, c] = wall.corners;
            edges.extend([edge(a, b), edge(b, c), edge(a, c)].map(|e| (e, i)));
        }
        edges.sort_unstable();
        for pair in edges.chunks(2) {
            let [(e, i), (same, j)] = *pair else { return None };
            if e != same {
                return None;
            }
            let planned = others.iter().any(|change| change.rim.contains(&e));
            if walls[i].label == walls[j].label || planned {
                continue;
            }
            let of = patches.iter().filter(|&&f| self.fits(p, f, e, [&walls[i], &walls[j]]));
            let mut of = of.copied();
            let (Some(f), None) = (of.next(), of.next()) else { return None };
            changes[place(f)?].rim.push(e);
        }
        let whole = changes.iter().all(|change| self.keeps_outline(change, split));
        whole.then_some(changes)
    }

    /// The walls of the cavity with the labels of their new tetrahedra, `dust` by its rule or not;
    /// `None` if some that changes sides meets a third one.
    fn labelled_walls(&self, [patches, lost]: [&[u32]; 2], dust: bool) -> Option<Vec<Wall>> {
        let (closure, plc) = (&self.closure, self.closure.plc());
        let wall = |(t, slot): (B::Tet, usize)| {
            let v = closure.vertices(t);
            let [a, b, c] = FACE[slot].map(|k| v[k]);
            let (corners, own) = (triangle(a, b, c), closure.region(t));
            let mut wall = Wall { corners, label: own, left: None, raised: None };
            let facet = closure.facet_at(t, slot);
            if let Some((f, label)) = self.dust_of(t, lost) {
                wall.label = label;
                let beyond = || closure.beyond(t, slot).map(|other| closure.region(other));
                match facet {
                    Some(_) if beyond() != Some(label) => return None,
                    Some(f) => wall.left = Some(Some(f).filter(|f| lost.contains(f))?),
                    None => wall.raised = Some(f),
                }
                return Some(wall);
            }
            if dust {
                let patch = facet.filter(|f| patches.contains(f));
                let outer = patch.and_then(|f| plc.sides_of(f)).map(|sides| sides.outer);
                if let Some(outer) = outer.filter(|&outer| outer != own) {
                    wall.label = outer;
                    wall.left = patch;
                }
            }
            Some(wall)
        };
        closure.walls().map(wall).collect()
    }

    /// The patch among some that `t` is dust of, on the outer side, and the label of the inner one.
    fn dust_of(&self, t: B::Tet, patches: &[u32]) -> Option<(u32, u32)> {
        let region = self.closure.region(t);
        let of = |&f: &u32| {
            let sides = self.closure.plc().sides_of(f).filter(|sides| sides.outer == region)?;
            self.closure.vertices(t).iter().all(|&v| self.is_on(v, f)).then_some((f, sides.inner))
        };
        patches.iter().find_map(of)
    }

    /// Does a vertex lie on facet `f`?
    fn is_on(&self, v: VertexId, f: u32) -> bool {
        v != INFINITE && self.closure.plc().lies_on(self.closure.carrier(v), f)
    }

    /// Is `p` on the inner side of a face in patch `f` that is not nothing in the projection?
    fn faces_inwards(&self, f: u32, corners: [VertexId; 3], p: &Point) -> bool {
        let Some(patch) = &self.closure.plc().facets[f as usize].patch else { return false };
        let [a, b, c] = corners.map(|v| self.closure.at(v));
        let turn = patch.turn([&a, &b, &c]);
        let above = match orient3d(&a, &b, &c, p) {
            Sign::Positive => turn > 0,
            Sign::Negative => turn < 0,
            Sign::Zero => return false,
        };
        turn != 0 && patch.sides.is_some_and(|sides| sides.upwards == above)
    }

    /// May the face of `p` and the edge of two walls be a subface of patch `f`: are its corners on
    /// it, and is the inner side where it belongs?
    fn fits(&self, p: &Point, f: u32, [a, b]: [VertexId; 2], walls: [&Wall; 2]) -> bool {
        let Some(patch) = &self.closure.plc().facets[f as usize].patch else { return false };
        let Some(sides) = patch.sides else { return false };
        let labels = walls.map(|wall| wall.label);
        let are_sides = labels.contains(&sides.inner) && labels.contains(&sides.outer);
        if !self.is_on(a, f) || !self.is_on(b, f) || !are_sides {
            return false;
        }
        let inner = walls[usize::from(labels[0] != sides.inner)];
        let Some(apex) = inner.corners.into_iter().find(|&v| v != a && v != b) else {
            return false;
        };
        let [a, b, apex] = [a, b, apex].map(|v| self.closure.at(v));
        let turn = patch.turn([p, &a, &b]);
        let above = match orient3d(p, &a, &b, &apex) {
            Sign::Positive => turn > 0,
            Sign::Negative => turn < 0,
            Sign::Zero => return false,
        };
        turn != 0 && above == sides.upwards
    }

    /// Do what goes and what comes have one outline, but for the subsegment that is split?
    fn keeps_outline(&self, change: &Change, split: Option<[VertexId; 2]>) -> bool {
        let mut counts: Map<[VertexId; 2], [u32; 2]> = Map::default();
        let added = change.rim.iter().map(|&[a, b]| triangle(a, b, NEW));
        let added = added.chain(change.raised.iter().copied());
        for (k, list) in [change.removed.clone(), added.collect()].into_iter().enumerate() {
            for (side, _) in list.into_iter().flat_map(sides) {
                counts.entry(side).or_default()[k] += 1;
            }
        }
        if let Some([a, b]) = split {
            let segment = self.closure.segment([a, b]);
            let segment = segment.map(|s| &self.closure.plc().segments[s as usize]);
            let Some(segment) = segment else { return false };
            let polygons = if segment.twice.contains(&change.facet) { 2 } else { 1 };
            let counted = [
                counts.remove(&[a, b]).unwrap_or_default(),
                counts.remove(&edge(a, NEW)).unwrap_or_default(),
                counts.remove(&edge(b, NEW)).unwrap_or_default(),
            ];
            if counted != [[polygons, 0], [0, polygons], [0, polygons]] {
                return false;
            }
        }
        !change.removed.is_empty()
            && counts.iter().all(|(side, &[gone, come])| match side.contains(&NEW) {
                true => come == 2,
                false => gone <= 2 && come <= 2 && (gone + come) % 2 == 0,
            })
    }
}

impl State {
    /// After the filling: gives the tetrahedra on walls that are subfaces no longer their labels.
    pub(crate) fn relabel_walls(&mut self, changes: &[Change]) {
        if changes.iter().all(|change| change.relabelled.is_empty()) {
            return;
        }
        let wall = |&t: &TetId| {
            let [_, a, b, c] = self.vertices(t);
            (triangle(a, b, c), t)
        };
        let star: Map<[VertexId; 3], TetId> =
            self.mesh.cavity().star().tets.iter().map(wall).collect();
        for (wall, label) in changes.iter().flat_map(|change| &change.relabelled) {
            let Some(&t) = star.get(wall) else { continue };
            let across = self.mesh.topology().at(t).neighbours()[0];
            self.marks.set_region(t, *label);
            self.marks.clear(t, face_bit(0));
            self.marks.clear(tet_of(across), face_bit(slot_of(across)));
        }
        for change in changes {
            for wall in &change.raised {
                let Some(&t) = star.get(wall) else { continue };
                let across = self.mesh.topology().at(t).neighbours()[0];
                self.marks.set(t, face_bit(0));
                self.marks.set(tet_of(across), face_bit(slot_of(across)));
                self.add_subface(*wall, change.facet);
            }
        }
    }

    /// Does the label change at the subfaces of these new tetrahedra only, and from the side of
    /// each patch where it should?
    pub(crate) fn is_labelled(&self, tets: impl IntoIterator<Item = TetId>) -> bool {
        let topology = self.mesh.topology();
        tets.into_iter().all(|t| {
            let v = self.vertices(t);
            let (word, own) = (self.marks.of(t), self.marks.region(t));
            (0..4).all(|slot| {
                let other = self.marks.region(tet_of(topology.at(t).neighbours()[slot]));
                if word & face_bit(slot) == 0 {
                    return own == other;
                }
                let corners = FACE[slot].map(|k| v[k]);
                let [a, b, c] = corners;
                let Some(&f) = self.subfaces.get(&triangle(a, b, c)) else { return false };
                let Some(patch) = &self.plc.facets[f as usize].patch else { return true };
                let Some(sides) = patch.sides else { return false };
                let [a, b, c] = corners.map(|v| self.at(v));
                let turn = patch.turn([&a, &b, &c]);
                let inwards = is_above(slot, turn) == sides.upwards;
                let labels = if inwards { [own, other] } else { [other, own] };
                turn != 0 && labels == [sides.inner, sides.outer]
            })
        })
    }
}
