//! The boundary in an open cavity, against slow twins.

use super::{model, refine};
use crate::Refiner;
use crate::complex::carrier::Carrier;
use crate::mesh::marks::ENDS;
use crate::mesh::state::{Place, State};
use crate::rules::walk::Way;
use crate::table::{Set, edge};
use ltbw_core::topology::{TetId, VertexId};

/// The edges of the open cavity that are marked, and those of them on no wall: by lists and sets.
fn slow_edges(state: &State) -> [Vec<[VertexId; 2]>; 2] {
    let mut all: Set<[VertexId; 2]> = Set::default();
    for t in state.mesh.cavity().tets() {
        let v = state.vertices(t);
        for (k, [i, j]) in ENDS.into_iter().enumerate() {
            if state.marks.of(t) >> (4 + k) & 1 == 1 {
                all.insert(edge(v[i], v[j]));
            }
        }
    }
    let walls = state.mesh.cavity().faces();
    let rim: Set<[VertexId; 2]> =
        walls.flat_map(|[a, b, c]| [edge(a, b), edge(b, c), edge(a, c)]).collect();
    let mut both = [true, false].map(|on| {
        all.iter().copied().filter(|e| rim.contains(e) == on).collect::<Vec<[VertexId; 2]>>()
    });
    both.iter_mut().for_each(|list| list.sort_unstable());
    both
}

/// A walk that nothing bars ends where its point is, from anywhere: inside, at a vertex, outside.
#[test]
fn the_holder_of_a_point_is_found_from_everywhere() {
    let refined = refine(&Refiner::new().max_volume(1e-2), &model());
    let (state, mut barred) = (&refined.state, 0);
    let tets: Vec<TetId> = refined.tets().collect();
    for (k, &from) in tets.iter().enumerate() {
        let to = tets[(k * 7919 + 13) % tets.len()];
        let corners = state.vertices(to).map(|v| state.at(v));
        let middle = [0, 1, 2].map(|k| corners.iter().map(|c| c[k] * 0.25).sum::<f64>().round());
        assert_eq!(state.holder(from, &middle), Some(to));
        barred += usize::from(state.way(from, &middle) != Way::Arrived(to));
        let holder = state.holder(from, &corners[k % 4]).expect("a walk ends");
        assert!(state.vertices(holder).contains(&state.vertices(to)[k % 4]));
        let outside = state.holder(from, &[3e16, 0.0, 0.0]).expect("a walk ends");
        assert!(state.mesh.topology().at(outside).is_ghost());
        assert_eq!(state.holder(outside, &middle), Some(to));
    }
    assert!(barred > 10, "{barred} ways cross the boundary");
}

/// One pass finds each marked edge of a cavity once, and those inside it.
#[test]
fn the_edges_of_a_cavity_are_found_once() {
    let refined = refine(&Refiner::new().max_volume(1e-2), &model());
    let mut state = refined.state;
    let (mut inner, mut rim) = (0, 0);
    for t in state.mesh.tet_ids().collect::<Vec<TetId>>() {
        let v = state.vertices(t).map(|v| state.at(v));
        // The middle of an edge that is a segment is in all tetrahedra around it.
        for [i, j] in ENDS {
            let p = [0, 1, 2].map(|k| ((v[i][k] + v[j][k]) / 2.0).round());
            let place = Place { p, carrier: Carrier::Free, from: t };
            let Ok(open) = state.begin_and_look(&place) else {
                continue;
            };
            let edges = &open.owner().survey.edges;
            let mut found = [false, true].map(|inner| {
                let own = edges.iter().filter(|edge| edge.is_inner == inner);
                own.map(|edge| edge.key).collect::<Vec<[VertexId; 2]>>()
            });
            found.iter_mut().for_each(|list| list.sort_unstable());
            assert_eq!(found, slow_edges(open.owner()));
            rim += found[0].len();
            inner += found[1].len();
        }
    }
    assert!(rim > 1000 && inner > 100, "{rim} {inner}");
}
