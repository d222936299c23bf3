//! Numbers and orders that are functions of the mesh alone, in whatever order its points were
//! inserted: arrays and files of one mesh are equal byte for byte.
//!
//! Vertices of the domain keep their indices, its points follow in their order, the others along a
//! Hilbert curve. Vertices of a tetrahedron: the smallest, the next, then as the orientation says.
//! Tetrahedra are in the lexicographic order of these.

use super::key::{OrderKey, order_key};
use super::state::State;
use crate::complex::plc::Plc;
use crate::table::Map;
use ltbw_core::cavity::OTHERS;
use ltbw_core::mesh::Vertex;
use ltbw_core::order::hilbert;
use ltbw_core::topology::{TetId, VertexId};
use ltbw_exact::Point;
use rayon::prelude::*;

/// Vertices whose tetrahedra one thread sorts at a time.
const SHARE: usize = if cfg!(test) { 7 } else { 1024 };

/// The vertices of a triangle from the smallest on; it keeps its side.
pub fn from_smallest([a, b, c]: [Vertex; 3]) -> [Vertex; 3] {
    match a.min(b).min(c) {
        least if least == a => [a, b, c],
        least if least == b => [b, c, a],
        _ => [c, a, b],
    }
}

/// The vertices of a tetrahedron: the smallest, the next, then as its orientation says.
pub fn in_order(v: [Vertex; 4]) -> [Vertex; 4] {
    let first = (1..4).fold(0, |first, k| if v[k] < v[first] { k } else { first });
    let [a, b, c] = from_smallest(OTHERS[first].map(|k| v[k]));
    [v[first], a, b, c]
}

/// The numbers that a domain gives vertices: to its corners their own, to its points those that
/// follow.
#[derive(Debug)]
pub struct GivenNumbers {
    /// The number of the first vertex that has none.
    pub count: Vertex,
    pub(crate) points: Map<OrderKey, Vertex>,
}

impl Plc {
    pub(crate) fn given_numbers(&self) -> GivenNumbers {
        let first = self.corners.len() as Vertex;
        let points = (first..).zip(&self.points);
        GivenNumbers {
            count: self.count() as Vertex,
            points: points.map(|(number, own)| (order_key(&own.0), number)).collect(),
        }
    }
}

impl State {
    /// Numbers the vertices anew that the domain does not say.
    pub(crate) fn number_vertices(&mut self) {
        let first = self.plc.count() as Vertex;
        let numbers = self.mesh.numbers();
        let is_new = |v: &VertexId| numbers[v.index()] >= first;
        let mut new: Vec<(OrderKey, VertexId)> = (1..=self.mesh.num_vertices())
            .into_par_iter()
            .map(VertexId::at)
            .filter(is_new)
            .map(|v| (order_key(&self.at(v)), v))
            .collect();
        // Points of one cell of the curve stay in the order in which they come.
        new.par_sort_unstable();
        let points: Vec<Point> = new.iter().map(|&(_, v)| self.at(v)).collect();
        let numbers = self.mesh.numbers_mut();
        for (number, k) in (first..).zip(hilbert(&points)) {
            numbers[new[k as usize].1.index()] = number;
        }
    }

    /// The finite tetrahedra in the order of their vertices' numbers, which are below `end`.
    pub(crate) fn tets_in_order(&self, end: Vertex) -> Vec<TetId> {
        let (numbers, topology) = (self.mesh.numbers(), self.mesh.topology());
        let corners = |t: TetId| topology.at(t).vertices().map(|v| numbers[v.index()]);
        let smallest = |t: TetId| corners(t).into_iter().fold(end, Vertex::min);
        let finite = topology.par_iter().filter(|(_, tet)| !tet.is_ghost());
        let all: Vec<(TetId, Vertex)> = finite.map(|(t, _)| (t, smallest(t))).collect();
        // Tetrahedra of one smallest vertex are together, and few.
        let mut starts = vec![0u32; end as usize + 2];
        all.iter().for_each(|&(_, least)| starts[least as usize + 1] += 1);
        for v in 1..starts.len() {
            starts[v] += starts[v - 1];
        }
        let mut order = vec![TetId::default(); all.len()];
        for (t, least) in all {
            let place = &mut starts[least as usize];
            order[*place as usize] = t;
            *place += 1;
        }
        // Each start has become the next one.
        let (mut rest, mut start, mut shares) = (&mut order[..], 0, Vec::new());
        for ends in starts.chunks(SHARE) {
            let end = ends.last().map_or(start, |&end| end);
            let (own, more) = std::mem::take(&mut rest).split_at_mut((end - start) as usize);
            shares.push((own, ends, start));
            (rest, start) = (more, end);
        }
        shares.into_par_iter().for_each(|(own, ends, first)| {
            let (mut few, mut start) = (Vec::new(), first);
            for &end in ends {
                let list = &mut own[(start - first) as usize..(end - first) as usize];
                few.clear();
                few.extend(list.iter().map(|&t| (in_order(corners(t)), t)));
                few.sort_unstable();
                list.iter_mut().zip(&few).for_each(|(to, &(_, t))| *to = t);
                start = end;
            }
        });
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_permutations_have_one_order_and_odd_ones_another() {
        let (mut even, mut odd) = (0, 0);
        for code in 0..256 {
            let v = [0, 2, 4, 6].map(|shift| code >> shift & 3);
            let is_below = |i: usize, j: usize| u32::from(v[i] < v[j]);
            let mut sorted = v;
            sorted.sort_unstable();
            if sorted != [0, 1, 2, 3] {
                continue;
            }
            let pairs = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
            match pairs.into_iter().map(|[i, j]| is_below(i, j)).sum::<u32>() % 2 {
                0 => {
                    assert_eq!(in_order(v), [0, 1, 2, 3], "{v:?}");
                    even += 1;
                }
                _ => {
                    assert_eq!(in_order(v), [0, 1, 3, 2], "{v:?}");
                    odd += 1;
                }
            }
        }
        assert_eq!((even, odd), (12, 12));
        assert_eq!([[1, 2, 3], [3, 1, 2], [2, 3, 1]].map(from_smallest), [[1, 2, 3]; 3]);
        assert_eq!([[1, 3, 2], [2, 1, 3], [3, 2, 1]].map(from_smallest), [[1, 3, 2]; 3]);
    }
}
