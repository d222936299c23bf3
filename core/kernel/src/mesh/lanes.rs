//! Points inserted into one mesh by several threads, each in a *lane* of its own.
//!
//! Every point comes with its cavity in the mesh as it is before. All lanes insert at once. The
//! first lane that asks for a slot has it, until all have ended; no lane looks at a slot of
//! another: a point whose closure has one is set back and put off, for the caller to insert when
//! all lanes have ended. Few are where each lane has the points of one piece of space. The Delaunay
//! mesh is unique: which points were put off changes slots, and nothing else.
//!
//! Unsafe code is here, and in the aliases of arenas that it makes, since
//! no borrow can tell slots of one array apart. That no slot is used by two lanes does not rest on
//! what callers say: each slot is asked for before it is looked at.
#![allow(unsafe_code)]

use super::Mesh;
use crate::arena::{NoMemory, ask_for};
use crate::cavity::{Cavity, Role, Setback};
use crate::geometry::Geometry;
use crate::sync::Claims;
use crate::topology::{FaceId, Tet, TetId, Topology, VertexId, slot_of, tet_of};
use crate::transaction::OpenCavity;
use ltbw_exact::Point;
#[cfg(not(tsan))]
use rayon::prelude::*;

/// Free slots that a lane is given, by point: on average a point makes seven tetrahedra.
const SPARE: usize = 8;
/// Free slots that a lane is given beside these.
const MARGIN: usize = 256;

/// A point to be inserted, in kernel coordinates, and its cavity in the mesh before.
#[derive(Clone, Copy, Debug)]
pub struct Chosen<'a> {
    /// The point, which is no vertex, and no other one of those inserted together.
    pub p: Point,
    /// Its tetrahedra.
    pub cavity: &'a [TetId],
    /// Is it to be put off if something of its closure was written since they were found?
    pub is_fixed: bool,
}

/// Points to be inserted together.
#[derive(Debug)]
pub struct Batch<'b, C> {
    /// Public number of the first one; the others follow it.
    pub number: u32,
    /// The number of points.
    pub count: usize,
    /// Tells the k-th one.
    pub chosen: &'b C,
}

/// The work that the owner of a mesh does in each lane.
pub trait Follow: Sync {
    /// The memory of one lane.
    type Own: Send;

    /// Was slot `t`, one of the lane's own, written since the cavities were found?
    fn changed(&self, t: TetId) -> bool;

    /// Asks the processor to fetch what [`Self::changed`] and [`Self::opened`] read of slot `t`. A
    /// hint.
    fn fetch(&self, t: TetId);

    /// A cavity is open, and is going to be filled. `boundary` are its boundary faces, as seen from
    /// inside, in the order of the star.
    fn opened(&self, own: &mut Self::Own, boundary: impl Iterator<Item = FaceId>);

    /// That of the k-th point was filled with this star.
    fn filled(&self, own: &mut Self::Own, k: usize, star: &[TetId], view: View<'_>);

    /// The lane has ended.
    fn ended(&self, own: &mut Self::Own, view: View<'_>);
}

/// The part of a mesh that a lane may look at.
#[derive(Clone, Copy)]
pub struct View<'v> {
    topology: &'v Topology,
    geometry: &'v Geometry,
    claims: &'v Claims,
    lane: u8,
}

impl View<'_> {
    /// The tetrahedron in slot `t`, which may be free, if the slot is the lane's own.
    #[inline(always)]
    pub fn tet(&self, t: TetId) -> Option<Tet> {
        self.claims.has(t, self.lane).then(|| *self.topology.tet(t))
    }

    /// Kernel coordinates of a vertex; they are no numbers where there is none.
    #[inline(always)]
    pub fn point(&self, v: VertexId) -> Point {
        self.geometry.get_point(v).copied().unwrap_or([f64::NAN; 3])
    }
}

/// The memory of lanes, to be used again.
#[derive(Debug, Default)]
pub struct Lanes {
    claims: Claims,
    memory: Vec<Memory>,
}

/// The memory of one lane, in cache lines of its own.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Memory {
    cavity: Cavity,
    /// The points that it has put off.
    put_off: Vec<usize>,
}

impl Lanes {
    /// The most lanes that there may be.
    pub const MOST: usize = Claims::MOST;
}

/// A lane at work, in cache lines of its own.
#[repr(align(128))]
struct Lane<'a> {
    topology: Topology,
    geometry: Geometry,
    memory: &'a mut Memory,
    claims: &'a Claims,
    /// Its number.
    own: u8,
    /// A tetrahedron of the last star.
    last: Option<TetId>,
}

impl Lane<'_> {
    fn view(&self) -> View<'_> {
        let Self { topology, geometry, claims, own, .. } = self;
        View { topology, geometry, claims, lane: *own }
    }

    /// Inserts the k-th point as vertex `v`; `false` if it has to be put off.
    #[inline(always)]
    fn insert<F: Follow>(
        &mut self,
        k: usize,
        v: VertexId,
        chosen: &Chosen<'_>,
        follow: &F,
        kept: &mut F::Own,
    ) -> bool {
        let Self { topology, geometry, memory, claims, own, last } = self;
        let cavity = &mut memory.cavity;
        let mut conflict = geometry.conflict_of(&chosen.p);
        let mut is_own = |t: TetId, _: Role| claims.ask(t, *own);
        let changed = |t: TetId| follow.changed(t);
        match cavity.reopen(topology, chosen.cavity, &mut conflict, &changed, &mut is_own) {
            Ok(Some(is_same)) if is_same || !chosen.is_fixed => {}
            Ok(Some(_)) => {
                cavity.set_back(topology);
                return false;
            }
            // All of the cavity has changed, or a slot is another lane's, or none is left.
            Ok(None) | Err(Setback::Refused(_) | Setback::Full) => return false,
        }
        let inner = |outer: FaceId| topology.tet(tet_of(outer)).neighbours()[slot_of(outer)];
        follow.opened(kept, cavity.boundary().map(|(_, outer)| inner(outer)));
        *last = Some(cavity.fill(topology, v));
        geometry.created(0, &cavity.star(), &chosen.p);
        geometry.stats.insphere_calls += cavity.tests() as u64;
        follow.filled(kept, k, self.memory.cavity.star().tets, self.view());
        true
    }

    /// A hint to fetch what the next insertion goes on with: what is around the cavity, which is in
    /// the cache by now. Its slots are asked for, as they are to be looked at.
    fn fetch_around(&self, next: &Chosen<'_>, follow: &impl Follow) {
        for &t in next.cavity.iter().take_while(|&&t| self.claims.ask(t, self.own)) {
            let around = self.topology.tet(t).neighbours();
            around.into_iter().for_each(|face| self.fetch_slot(tet_of(face), follow));
        }
    }

    /// Asks the processor to fetch what a later insertion begins with. A hint.
    fn fetch(&self, next: &Chosen<'_>, follow: &impl Follow) {
        next.cavity.iter().for_each(|&t| self.fetch_slot(t, follow));
    }

    fn fetch_slot(&self, t: TetId, follow: &impl Follow) {
        self.topology.prefetch(t);
        self.claims.prefetch(t);
        follow.fetch(t);
    }
}

/// Calls `f` with each of some things, which are few, and its number, on as many threads.
#[cfg(not(tsan))]
fn side_by_side<T: Send>(things: impl Iterator<Item = T>, f: impl Fn(usize, T) + Sync) {
    let things: Vec<T> = things.collect();
    things.into_par_iter().enumerate().for_each(|(k, thing)| f(k, thing));
}

/// A version without rayon, whose fences the thread sanitizer does not know.
#[cfg(tsan)]
fn side_by_side<T: Send>(things: impl Iterator<Item = T>, f: impl Fn(usize, T) + Sync) {
    std::thread::scope(|scope| {
        let f = &f;
        let spawn = |(k, thing)| scope.spawn(move || f(k, thing));
        let threads: Vec<_> = things.enumerate().map(spawn).collect();
        // It knows a thread's end by its join alone.
        threads.into_iter().for_each(|thread| thread.join().expect("a lane's end"));
    });
}

impl Mesh {
    /// Makes room for `count` points that are to be inserted in `lanes` lanes; returns the number
    /// of slots from then on.
    ///
    /// # Errors
    /// [`NoMemory`]: arrays that have to grow are moved, and there is no room for both.
    #[doc(hidden)]
    pub fn make_room_for(&mut self, count: usize, lanes: usize) -> Result<usize, NoMemory> {
        let free = count.saturating_mul(SPARE).saturating_add(MARGIN * lanes);
        let slots = self.topology.slots_with(free);
        if slots > self.topology.slots() {
            ask_for(count, slots)?;
        }
        let Self { topology, geometry, .. } = self;
        // Memory that nobody has touched takes its time.
        rayon::join(|| topology.make_free(free), || geometry.reserve_spheres(slots));
        Ok(slots)
    }

    /// Inserts a batch of points in as many lanes as there are entries of `kept`; each lane has a
    /// contiguous share of them. Room was made before ([`Mesh::make_room_for`]). All get vertices,
    /// from the returned one on; those in the list that is returned, too, in their order, are in no
    /// tetrahedron yet, and have to be filled in by [`OpenCavity::fill_vertex`].
    ///
    /// # Panics
    /// If `follow` does. The mesh has vertices without tetrahedra then, and is to be dropped.
    #[doc(hidden)]
    pub fn fill_in_lanes<'c, F: Follow>(
        &mut self,
        lanes: &mut Lanes,
        batch: Batch<'_, impl Fn(usize) -> Chosen<'c> + Sync>,
        follow: &F,
        kept: &mut [F::Own],
    ) -> (VertexId, Vec<usize>) {
        let Batch { number, count, chosen } = batch;
        let first = self.numbers.len();
        let vertex = |k: usize| VertexId::at(first + k);
        self.enter_in_a_row(number, (0..count).map(|k| chosen(k).p));
        // Nothing in the memory of a larger mesh is for this one.
        if lanes.claims.len() > self.topology.slots() {
            *lanes = Lanes::default();
        }
        let Lanes { claims, memory } = lanes;
        let many = kept.len().min(Lanes::MOST);
        if many == 0 {
            return (vertex(0), (0..count).collect());
        }
        memory.resize_with(memory.len().max(many), Memory::default);
        claims.clear(self.topology.slots());
        self.geometry.reserve_spheres(self.topology.slots());
        let share = |lane: usize| lane * count / many..(lane + 1) * count / many;
        let mut free = self.topology.take_free();
        let (vertices, claims) = (self.numbers.len(), &*claims);
        let mut work: Vec<Lane<'_>> = Vec::new();
        for (memory, own) in memory[..many].iter_mut().zip(1..=u8::MAX) {
            let left = free.len() / (many + 1 - own as usize);
            let mut free = free.split_off(free.len() - left);
            free.retain(|&t| claims.give(t, own));
            memory.put_off.clear();
            memory.cavity.reserve_vertices(vertices);
            // SAFETY: the mesh is not used until all lanes have ended, and arrays do not grow: all
            // vertices have entered, and spheres have room. Vertices are only read. A lane reads
            // and writes no slot that is not its own: those of a cavity and its neighbours are
            // asked for when they are admitted, before they are looked at; free ones, each once in
            // one list, were given here, before any lane has begun. No slot is the own one of two.
            let (topology, geometry) =
                unsafe { (self.topology.alias(free), self.geometry.alias()) };
            work.push(Lane { topology, geometry, memory, claims, own, last: None });
        }
        side_by_side(work.iter_mut().zip(kept), |lane, (own, kept)| {
            let all = share(lane);
            for k in all.clone() {
                let later = |n: usize| Some(k + n).filter(|&k| k < all.end).map(chosen);
                later(2).into_iter().for_each(|next| own.fetch(&next, follow));
                later(1).into_iter().for_each(|next| own.fetch_around(&next, follow));
                if !own.insert(k, vertex(k), &chosen(k), follow, kept) {
                    own.memory.put_off.push(k);
                }
            }
            follow.ended(kept, own.view());
        });
        let mut put_off = Vec::new();
        for Lane { topology, geometry, memory, last, .. } in work {
            self.topology.rejoin(topology);
            self.geometry.stats += geometry.stats;
            self.hint = last.unwrap_or(self.hint);
            put_off.append(&mut memory.put_off);
        }
        (vertex(0), put_off)
    }
}

impl OpenCavity<'_, Mesh> {
    /// Fills the cavity with the star of a vertex that was put off, whose point it is.
    pub fn fill_vertex(self, v: VertexId) {
        self.end(|mesh| {
            let p = mesh.geometry.points()[v.index()];
            mesh.fill_with(v, p);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::{Batch, Chosen, Follow, Lanes, View};
    use crate::cavity::AdmitAll;
    use crate::invariants::check_all;
    use crate::mesh::{Mesh, Vertex};
    use crate::topology::{FaceId, TetId, VertexId};
    use crate::{Builder, Point, PointSet};
    use ltbw_generate::{PointKind, generate};
    use std::collections::BTreeSet;
    use std::sync::Mutex;

    /// Slots written, and the number of faces of all cavities.
    #[derive(Default)]
    struct Written(Mutex<BTreeSet<TetId>>);

    impl Follow for Written {
        type Own = [usize; 2];

        fn changed(&self, t: TetId) -> bool {
            self.0.lock().expect("no panic").contains(&t)
        }

        fn fetch(&self, _: TetId) {}

        fn opened(&self, own: &mut [usize; 2], boundary: impl Iterator<Item = FaceId>) {
            own[0] = boundary.count();
        }

        fn filled(&self, own: &mut [usize; 2], _: usize, star: &[TetId], view: View<'_>) {
            assert_eq!(star.len(), own[0]);
            own[1] += 1;
            let v = star.iter().map(|&t| view.tet(t).expect("an own slot").vertices()[0]);
            assert_eq!(v.collect::<BTreeSet<_>>().len(), 1);
            self.0.lock().expect("no panic").extend(star);
        }

        fn ended(&self, _: &mut [usize; 2], view: View<'_>) {
            assert!(
                view.tet(TetId::new(1 << 29)).is_none()
                    && view.point(VertexId::new(1))[0].is_finite()
            );
            assert!(view.point(VertexId::new(1 << 29))[0].is_nan());
        }
    }

    fn insert(mesh: &mut Mesh, p: &Point) {
        let (from, number) = (mesh.hint(), mesh.num_vertices() as Vertex);
        mesh.begin(*p, from, &mut AdmitAll).expect("a new point").fill(*p, number);
    }

    fn cavity_of(mesh: &mut Mesh, p: &Point) -> Vec<TetId> {
        let from = mesh.hint();
        mesh.begin(*p, from, &mut AdmitAll).expect("a new point").tets().collect()
    }

    /// Inserts points in lanes, then those that were put off; returns the number of these.
    fn insert_in_lanes(mesh: &mut Mesh, lanes: &mut Lanes, points: &[Point], many: usize) -> usize {
        let found: Vec<_> = points.iter().map(|p| cavity_of(mesh, p)).collect();
        let chosen = |k: usize| Chosen { p: points[k], cavity: &found[k], is_fixed: false };
        let (follow, mut kept) = (Written::default(), vec![[0; 2]; many]);
        let number = mesh.num_vertices() as Vertex;
        mesh.make_room_for(points.len(), many).expect("memory");
        let batch = Batch { number, count: points.len(), chosen: &chosen };
        let (first, put_off) = mesh.fill_in_lanes(lanes, batch, &follow, &mut kept);
        let filled = kept.iter().map(|own| own[1]).sum::<usize>();
        assert_eq!(filled + put_off.len(), points.len());
        for &k in &put_off {
            let from = mesh.hint();
            let open = mesh.begin(points[k], from, &mut AdmitAll).expect("a new point");
            open.fill_vertex(VertexId::at(first.index() + k));
        }
        put_off.len()
    }

    #[test]
    fn lanes_make_the_mesh_that_one_after_the_other_makes() {
        for kind in [PointKind::Uniform, PointKind::Sphere] {
            let points = generate(kind, 4000, 5);
            let (start, rest) = points.split_at(1000);
            let set = PointSet::new(start.to_vec()).expect("points");
            let built = || Builder::new().build(&set).expect("a mesh").mesh;
            let mut one = built();
            rest.iter().for_each(|p| insert(&mut one, p));
            for many in 0..=4 {
                let (mut mesh, mut lanes) = (built(), Lanes::default());
                let mut put_off = [0; 2];
                // Lanes have a piece of space each, or little of their own.
                for (k, list) in rest.chunks(100).enumerate() {
                    let mut list = list.to_vec();
                    if k % 2 == 0 {
                        list.sort_by(|p, q| p[0].total_cmp(&q[0]));
                    }
                    put_off[k % 2] += insert_in_lanes(&mut mesh, &mut lanes, &list, many);
                    check_all(&mesh).expect("invariants");
                }
                assert_eq!(mesh.hash(), one.hash(), "{kind:?} {many}");
                let [sorted, mixed] = put_off;
                match many {
                    0 => assert_eq!(put_off, [1500; 2]),
                    // All of its cavity has changed, at most.
                    1 => assert!(sorted + mixed < 30, "{kind:?} {put_off:?}"),
                    _ => assert!(sorted < 1000 && sorted < mixed, "{kind:?} {put_off:?}"),
                }
            }
        }
    }

    #[test]
    fn a_point_that_is_fixed_is_put_off_if_its_closure_has_changed() {
        let points = generate(PointKind::Uniform, 400, 3);
        let set = PointSet::new(points[..300].to_vec()).expect("points");
        for (is_fixed, expected) in [(false, vec![]), (true, vec![1])] {
            let mut mesh = Builder::new().build(&set).expect("a mesh").mesh;
            let rest = &points[300..];
            let found: Vec<_> = rest.iter().map(|p| cavity_of(&mut mesh, p)).collect();
            // The first one, and another with a part of its cavity, but not all in it.
            let common = |k: usize| found[k].iter().filter(|t| found[0].contains(t)).count();
            let is_other = |&k: &usize| (1..found[k].len()).contains(&common(k));
            let all = [0, (1..rest.len()).find(is_other).expect("a cavity beside the first one")];
            let chosen = |k: usize| Chosen { p: rest[all[k]], cavity: &found[all[k]], is_fixed };
            mesh.make_room_for(2, 1).expect("memory");
            let (mut lanes, follow) = (Lanes::default(), Written::default());
            let batch = Batch { number: 300, count: 2, chosen: &chosen };
            let (first, put_off) = mesh.fill_in_lanes(&mut lanes, batch, &follow, &mut [[0; 2]]);
            assert_eq!(put_off, expected);
            for k in put_off {
                let from = mesh.hint();
                let open = mesh.begin(rest[all[k]], from, &mut AdmitAll).expect("a new point");
                open.fill_vertex(VertexId::at(first.index() + k));
            }
            check_all(&mesh).expect("invariants");
        }
    }

    #[test]
    fn points_without_free_slots_are_put_off() {
        let points = generate(PointKind::Uniform, 600, 8);
        let set = PointSet::new(points[..300].to_vec()).expect("points");
        let mut mesh = Builder::new().build(&set).expect("a mesh").mesh;
        let found: Vec<_> = points[300..].iter().map(|p| cavity_of(&mut mesh, p)).collect();
        let chosen = |k: usize| Chosen { p: points[300 + k], cavity: &found[k], is_fixed: false };
        // No room is made.
        let (mut lanes, follow) = (Lanes::default(), Written::default());
        let batch = Batch { number: 300, count: 300, chosen: &chosen };
        let (first, put_off) = mesh.fill_in_lanes(&mut lanes, batch, &follow, &mut [[0; 2]; 2]);
        assert!(put_off.len() > 200, "{}", put_off.len());
        for k in put_off {
            let from = mesh.hint();
            let open = mesh.begin(points[300 + k], from, &mut AdmitAll).expect("a new point");
            open.fill_vertex(VertexId::at(first.index() + k));
        }
        check_all(&mesh).expect("invariants");
        let set = PointSet::new(points).expect("points");
        let all = Builder::new().build(&set).expect("a mesh").mesh;
        assert_eq!(mesh.hash(), all.hash());
    }

    #[test]
    fn memory_of_a_larger_mesh_and_slots_that_are_doubled_do_no_harm() {
        let points = generate(PointKind::Uniform, 3000, 2);
        let built = |count: usize| {
            let set = PointSet::new(points[..count].to_vec()).expect("points");
            Builder::new().build(&set).expect("a mesh").mesh
        };
        let (mut large, mut small, mut lanes) = (built(2000), built(200), Lanes::default());
        insert_in_lanes(&mut large, &mut lanes, &points[2000..2200], 255);
        check_all(&large).expect("invariants");
        // Slots that the small mesh has not, and each of them twice.
        let mut follow = Written::default();
        let slots: Vec<TetId> = TetId::below(large.topology().slots() as u32).rev().collect();
        let chosen = |k: usize| Chosen { p: points[2200 + k], cavity: &slots, is_fixed: false };
        let batch = Batch { number: 200, count: 9, chosen: &chosen };
        let (_, put_off) = small.fill_in_lanes(&mut lanes, batch, &follow, &mut [[0; 2]; 3]);
        assert_eq!(put_off.len(), 9);
        let (mut small, found) = (built(200), cavity_of(&mut built(200), &points[2300]));
        let twice: Vec<TetId> = found.iter().chain(&found).copied().collect();
        for cavity in [&twice, &found] {
            let chosen = |_: usize| Chosen { p: points[2300], cavity, is_fixed: false };
            small.make_room_for(1, 4).expect("memory");
            let batch = Batch { number: 300, count: 1, chosen: &chosen };
            _ = small.fill_in_lanes(&mut lanes, batch, &follow, &mut [[0; 2]; 4]);
            follow = Written::default();
        }
    }
}
