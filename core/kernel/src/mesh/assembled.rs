//! A mesh of tetrahedra that were made elsewhere.

use super::{Duplicate, Mesh, Vertex};
use crate::PredicateStats;
use crate::arena::Arena;
use crate::cavity::Cavity;
use crate::cavity::hole::Filling;
use crate::geometry::{Geometry, Rim};
use crate::topology::{INFINITE, TetId, Topology, VertexId};
use ltbw_exact::{Mode, Point};
use std::sync::OnceLock;

/// All that a mesh built elsewhere needs beside its tetrahedra.
#[derive(Debug)]
pub struct Assembly<'a> {
    /// Kernel coordinates by vertex less 1.
    pub points: Vec<Point>,
    /// Public number by vertex less 1.
    pub numbers: Vec<Vertex>,
    /// Vertices whose points were vertices already, each with that vertex.
    pub duplicates: &'a [(VertexId, VertexId)],
    /// The mode of computing with the points.
    pub mode: Mode,
    /// Predicate calls made elsewhere.
    pub predicates: PredicateStats,
}

/// A point whose place was a vertex's already.
struct Met {
    number: Vertex,
    at: VertexId,
}

impl Mesh {
    /// The mesh of assembled submeshes. Vertices that are not `used` by a tetrahedron are left out.
    pub(crate) fn assembled(
        mut topology: Topology,
        mut geometry: Geometry,
        used: &[bool],
        assembly: Assembly<'_>,
    ) -> Self {
        let Assembly { mut points, mut numbers, duplicates, mode, .. } = assembly;
        let count = points.len();
        points.insert(0, [f64::NAN; 3]);
        numbers.insert(0, Vertex::MAX);
        let mut met: Vec<Met> = Vec::new();
        if used[1..].iter().all(|&used| used) {
            // So there is no duplicate, either.
            geometry.set_points(Arena::of(points));
        } else {
            let mut names = vec![INFINITE; count + 1];
            let (mut kept, mut arena) = (vec![numbers[0]], Arena::with_capacity(count + 1));
            arena.push(points[0]);
            for v in (1..=count).filter(|&v| used[v]) {
                names[v] = VertexId::at(kept.len());
                kept.push(numbers[v]);
                arena.push(points[v]);
            }
            topology.rename(|v| if v == INFINITE { v } else { names[v.index()] });
            geometry.set_points(arena);
            let named = |&(duplicate, v): &(VertexId, VertexId)| Met {
                number: numbers[duplicate.index()],
                at: names[v.index()],
            };
            met.extend(duplicates.iter().map(named));
            numbers = kept;
        }
        let vertices = numbers.len();
        let mut mesh = Self {
            topology,
            geometry,
            cavity: Cavity::for_vertices(vertices),
            numbers,
            vacant: Vec::new(),
            filling: Filling::default(),
            rim: Rim::default(),
            duplicates: Vec::new(),
            mode,
            next_number: count as Vertex,
            hint: TetId::default(),
            numbering: OnceLock::new(),
        };
        mesh.hint = mesh.topology.iter().next().map(|(t, _)| t).unwrap_or_default();
        mesh.note_duplicates(met);
        mesh
    }

    /// The smallest number of equal points is the vertex, whichever was inserted first.
    fn note_duplicates(&mut self, mut met: Vec<Met>) {
        for Met { number, at } in &mut met {
            let kept = &mut self.numbers[at.index()];
            (*number, *kept) = ((*number).max(*kept), (*number).min(*kept));
        }
        let kept = |Met { number, at }| Duplicate { number, kept: self.numbers[at.index()] };
        self.duplicates = met.into_iter().map(kept).collect();
        self.duplicates.sort_unstable();
    }
}
