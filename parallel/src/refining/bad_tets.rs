//! One worker's list of bad tetrahedra: the paper's LB, as a source of points.

use super::Bounds;
use super::shape::Shape;
use crate::balance::Workload;
use crate::mesh::{LocalMesh, VertexName, WireVertex, made};
use crate::protocol::{BlockId, Item, Source, WorkerId};
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_exact::Point;
use rustc_hash::FxHashMap;
use std::collections::BinaryHeap;

/// Entries that are looked at for one that nobody has locked.
const LOOKS: usize = 8;

/// A bad tetrahedron: its place here, and its corners as numbers of the submesh. While a
/// tetrahedron there has these corners it is the same one: none comes back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Bad {
    /// The bits of its circumradius, which order positive numbers. The largest comes first: it
    /// makes the smallest meshes.
    radius: u64,
    tet: TetId,
    corners: [VertexId; 4],
}

impl Bad {
    fn stands(&self, mesh: &LocalMesh) -> bool {
        let tets = mesh.tets();
        tets.is_live(self.tet) && tets.vertices(self.tet) == self.corners
    }
}

/// Bad tetrahedra of one worker. The point of each is its circumcentre, if that lies in the box.
#[derive(Clone, Debug)]
pub struct BadTets {
    me: WorkerId,
    bounds: Bounds,
    waiting: BinaryHeap<Bad>,
    /// Tetrahedra whose point is under way, by the point's name.
    under_way: FxHashMap<VertexName, Bad>,
    /// Points made so far: a name is given once, whatever becomes of its point.
    made: u32,
}

impl BadTets {
    /// The bad ones of a submesh.
    pub fn new(me: WorkerId, bounds: Bounds, mesh: &LocalMesh) -> Self {
        let (waiting, under_way) = (BinaryHeap::new(), FxHashMap::default());
        let mut bad = Self { me, bounds, waiting, under_way, made: 0 };
        let all: Vec<TetId> = mesh.tets().tets().map(|(t, _)| t).collect();
        bad.created(mesh, &all);
        bad
    }

    /// The shape of tetrahedron `t`, and its point; `None` if it is good, or stays as it is.
    fn judge(&self, mesh: &LocalMesh, corners: [VertexId; 4]) -> Option<(f64, Point)> {
        if corners[3] == INFINITE {
            return None;
        }
        let shape = Shape::of(corners.map(|v| mesh.tets().point(v)));
        self.bounds.point_of(&shape)
    }
}

impl Source<LocalMesh> for BadTets {
    const WATCHES: bool = true;

    fn next(&mut self, mesh: &LocalMesh) -> Option<WireVertex> {
        let mut locked = Vec::new();
        let mut chosen = None;
        // Ends: the list gets shorter.
        while let Some(bad) = self.waiting.pop() {
            if !bad.stands(mesh) {
                continue;
            }
            if mesh.tets().holder(bad.tet).is_none() {
                chosen = Some(bad);
                break;
            }
            locked.push(bad);
            if locked.len() == LOOKS {
                break;
            }
        }
        // All are locked: the first one waits, for whatever is left of it.
        let mut locked = locked.into_iter();
        let bad = chosen.or_else(|| locked.next())?;
        self.waiting.extend(locked);
        let (_, p) = self.judge(mesh, bad.corners)?;
        self.made += 1;
        let name = made(self.me, self.made);
        self.under_way.insert(name, bad);
        Some(WireVertex::new(name, p))
    }

    fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    fn item(&self, mesh: &LocalMesh, point: &WireVertex) -> Item<TetId> {
        match self.under_way.get(&point.name) {
            Some(bad) if bad.stands(mesh) => Item::At(bad.tet),
            _ => Item::Gone,
        }
    }

    fn created(&mut self, mesh: &LocalMesh, tets: &[TetId]) {
        for &tet in tets.iter().filter(|&&t| mesh.tets().is_live(t)) {
            let corners = mesh.tets().vertices(tet);
            if let Some((radius, _)) = self.judge(mesh, corners) {
                self.waiting.push(Bad { radius: radius.to_bits(), tet, corners });
            }
        }
    }

    fn released(&mut self, point: &WireVertex) {
        self.under_way.remove(&point.name);
    }

    fn inserted(&mut self, _: &LocalMesh, point: &WireVertex) {
        self.under_way.remove(&point.name);
    }

    /// The receiver finds the bad ones among the tetrahedra that come.
    fn remove_block(&mut self, _: &LocalMesh, _: BlockId) -> Vec<WireVertex> {
        Vec::new()
    }

    fn add(&mut self, _: BlockId, _: Vec<WireVertex>) {}

    fn clear(&mut self) {
        self.bounds = Bounds::NONE;
        self.waiting.clear();
    }
}

impl Workload for BadTets {
    fn left(&self) -> u64 {
        self.waiting.len() as u64
    }

    fn in_block(&self, _: BlockId) -> u64 {
        0
    }
}
