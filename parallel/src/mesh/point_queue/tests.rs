//! Tests of the supply of points: what is given, in which order, and which points move.

use super::*;
use crate::protocol::WorkerId;
use ltbw_core::order::round_of;
use ltbw_core::submesh::MeshParams;
use ltbw_core::topology::VertexId;
use ltbw_exact::{Mode, Point};

fn field(count: u32) -> (PointQueue, LocalMesh) {
    let blocks = Blocks::even(count, 4);
    let all: Vec<Point> = (1..=count).map(|v| [f64::from(v); 3]).collect();
    let params = MeshParams::of(&all, Mode::Normal);
    let mut mesh = LocalMesh::new(WorkerId::default(), &params, blocks.clone(), 1..count + 1);
    mesh.tets.set_points(VertexId::new(1), &all);
    let queue = PointQueue::new(blocks, 1..count + 1, [], 3);
    // Of a part so large that any number of points may be under way.
    (PointQueue { begun_with: 1 << 20, ..queue }, mesh)
}

#[test]
fn few_points_are_under_way_while_the_part_is_small() {
    let (field, mesh) = field(9000);
    let mut field = PointQueue { begun_with: 100, ..field };
    let first = field.next(&mesh).expect("a point");
    let mut given = 1;
    while field.next(&mesh).is_some() {
        given += 1;
    }
    assert_eq!((given, field.is_ready(), field.left()), (10, false, 8990));
    field.inserted(&mesh, &first);
    assert!(field.is_ready() && field.next(&mesh).is_some() && !field.is_ready());
    // Even in an empty part there are some.
    let few = PointQueue::new(field.blocks.clone(), 1..9001, [], 3);
    let given = std::iter::successors(Some(few), |queue| {
        let mut queue = queue.clone();
        queue.next(&mesh).map(|_| queue)
    });
    assert_eq!(given.count() - 1, LEAST_UNDER_WAY);
    // Points that are in the mesh from the start count, too.
    let started = PointQueue::new(field.blocks.clone(), 1..9001, 1..401, 3);
    assert_eq!((started.begun_with, started.left()), (400, 8600));
}

#[test]
fn every_point_comes_once_and_a_waiting_one_keeps_its_cursor() {
    let (mut field, mesh) = field(9000);
    let mut seen = vec![0; 9001];
    let mut waiting: Option<WireVertex> = None;
    while !field.is_empty() {
        let Some(vertex) = field.next(&mesh) else {
            // Only the last cursors have nothing else to give.
            field.inserted(&mesh, &waiting.take().expect("a waiting point"));
            continue;
        };
        seen[vertex.name as usize] += 1;
        if vertex.name % 100 == 0 {
            if let Some(before) = waiting.replace(vertex) {
                field.released(&before);
            }
        } else {
            field.inserted(&mesh, &vertex);
        }
    }
    assert!(seen[1..].iter().all(|&n| n == 1));
    assert!(!field.is_ready() && field.next(&mesh).is_none());
}

#[test]
fn points_that_wait_are_far_from_each_other() {
    let (mut field, mesh) = field(900);
    let mut given: Vec<VertexName> = Vec::new();
    while let Some(vertex) = field.next(&mesh) {
        given.push(vertex.name);
    }
    assert!(!field.is_ready() && !field.is_empty());
    assert_eq!(given[..3], [1, 301, 601], "one point of each cursor");
    assert_eq!(given[3..6].iter().map(|v| v / 300).max(), Some(2), "{given:?}");
    given.sort_unstable();
    // The piece between two of them is too short to be cut.
    let gaps: Vec<u64> = given.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(gaps.iter().all(|&gap| gap > 1 && gap <= 1 + SHORTEST as u64), "{gaps:?}");
    let vertex = WireVertex::new(given[1], [0.0; 3]);
    field.released(&vertex);
    let next = field.next(&mesh).expect("a point");
    assert_eq!(next.name, given[1] + 1);
    assert!(!field.is_ready());
}

#[test]
fn the_next_round_begins_when_all_cursors_wait() {
    let (mut field, mesh) = field(9000);
    let round = |vertex: &WireVertex| round_of(vertex.name as u32, 1);
    let rounds: Vec<u32> =
        std::iter::from_fn(|| field.next(&mesh)).take(6).map(|s| round(&s)).collect();
    assert_eq!(rounds, [0, 0, 0, 1, 1, 1]);
}

#[test]
fn what_lies_at_the_interface_goes_first_in_short_pieces_far_from_each_other() {
    let (field, mesh) = field(9000);
    let pieces = [1000..1400, 5000..5200];
    let at = |v: VertexName| pieces.iter().any(|piece| piece.contains(&(v as Place)));
    let mut field = field.interface(pieces.to_vec(), 4);
    let next = |field: &mut PointQueue| field.next(&mesh).expect("a point");
    let given: Vec<WireVertex> = (0..4).map(|_| next(&mut field)).collect();
    assert!(given.iter().all(|vertex| at(vertex.name)), "{given:?}");
    let pairs = given.iter().flat_map(|a| given.iter().map(|b| (a.name, b.name)));
    let near = pairs.filter(|(a, b)| a < b).map(|(a, b)| b - a).min();
    assert!(near >= Some(32), "pieces, not points of one piece: {given:?}");
    // Four are under way: others go on, as they lie.
    let others: Vec<WireVertex> = (0..3)
        .map(|_| {
            let vertex = next(&mut field);
            field.inserted(&mesh, &vertex);
            vertex
        })
        .collect();
    assert!(others.windows(2).all(|pair| pair[0].name < pair[1].name), "{others:?}");
    assert!(!others.iter().any(|vertex| at(vertex.name)), "{others:?}");
    // One of them is inserted: its piece goes on.
    field.inserted(&mesh, &given[2]);
    let after = next(&mut field);
    assert!(after.name > given[2].name && after.name < given[2].name + 64);
    // Every point comes once all the same.
    let mut seen = vec![0; 9001];
    let so_far = given.iter().chain(&others).chain([&after]);
    so_far.for_each(|vertex| seen[vertex.name as usize] += 1);
    given.iter().chain([&after]).for_each(|vertex| field.inserted(&mesh, vertex));
    while let Some(vertex) = field.next(&mesh) {
        seen[vertex.name as usize] += 1;
        field.inserted(&mesh, &vertex);
    }
    assert!(seen[1..].iter().all(|&n| n == 1) && field.is_empty());
    assert_eq!(field.given(), 9000);
}

#[test]
fn no_more_points_than_said_are_under_way_while_others_may_go() {
    // Three rounds: in the first one an interface cursor has a single point or none.
    let (field, mesh) = field(70_000);
    let pieces = [20_000..26_000, 28_000..31_000];
    let at = |v: VertexName| pieces.iter().any(|piece| piece.contains(&(v as Place)));
    let mut field = field.interface(pieces.clone(), 10);
    let (mut under_way, mut most) = (Vec::new(), 0);
    while !field.is_empty() {
        // Points under way when nothing else may go are another matter.
        if field.ready.is_empty() {
            under_way.drain(..).for_each(|vertex: WireVertex| field.inserted(&mesh, &vertex));
        }
        let others = !field.ready.is_empty();
        let vertex = field.next(&mesh).expect("a point");
        if at(vertex.name) {
            under_way.push(vertex);
            most = most.max(if others { under_way.len() } else { 0 });
        } else {
            field.inserted(&mesh, &vertex);
        }
    }
    assert_eq!(most, 10);
}

#[test]
fn a_block_moves_with_its_points() {
    let (mut field, mesh) = field(1000);
    for _ in 0..10 {
        let vertex = field.next(&mesh).expect("a point");
        field.inserted(&mesh, &vertex);
    }
    let before = field.left();
    assert_eq!(field.in_block(BlockId::new(3)), 250);
    let taken = field.remove_block(&mesh, BlockId::new(3));
    assert_eq!(
        (taken.len(), field.left(), field.in_block(BlockId::new(3))),
        (250, before - 250, 0)
    );
    field.add(BlockId::new(3), taken);
    assert_eq!((field.in_block(BlockId::new(3)), field.left()), (250, before));
    field.clear();
    assert!(field.is_empty() && field.next(&mesh).is_none());
}

/// A cancelled worker may be told to give a block away: it has no points, though rounds had
/// not begun when it was cancelled.
#[test]
fn a_block_moves_without_points_once_the_field_is_cleared() {
    for begun in [0, 10] {
        let (mut field, mesh) = field(9000);
        for _ in 0..begun {
            let vertex = field.next(&mesh).expect("a point");
            field.inserted(&mesh, &vertex);
        }
        field.clear();
        for block in 0..4 {
            assert_eq!(field.remove_block(&mesh, BlockId::new(block)).len(), 0, "block {block}");
            assert_eq!(field.in_block(BlockId::new(block)), 0);
        }
        assert!(field.is_empty() && !field.is_ready() && field.next(&mesh).is_none());
    }
}
