//! The worlds that are explored. `docs/protocol.md`'s table names the first ones by the pattern of
//! their cavities; a test makes sure that the coordinates have that pattern.

use crate::witness::Witness::{
    Bounce, Crossing, Installation, LateWound, Move, SetBack, Stray, Walk,
};
use crate::world::{Network, World};

/// A hexagon whose edges a far point sees three at a time.
const HEXAGON: [(i16, i16); 6] = [(26, 0), (13, 22), (-13, 22), (-26, 0), (-13, -22), (13, -22)];

/// Three points, each of which sees the hexagon's edges 5, 0 and 1.
const EAST: [(i16, i16); 3] = [(95, 31), (87, 50), (74, 67)];

fn hexagon(blocks: [u8; 6]) -> Vec<(i16, i16, u8)> {
    HEXAGON.into_iter().zip(blocks).map(|((x, y), block)| (x, y, block)).collect()
}

fn east(blocks: &[u8]) -> Vec<(i16, i16, u8)> {
    EAST.into_iter().zip(blocks).map(|((x, y), &block)| (x, y, block)).collect()
}

/// Two points see the same two edges, one at each worker.
pub fn same_two() -> World {
    let pentagon = [(-10, -8, 0), (8, -8, 0), (10, 0, 1), (8, 8, 1), (-10, 8, 0)];
    World::new("2 owners, same 2 cells", &[0, 1], &pentagon, &[(30, -2, 0), (30, 2, 1)])
        .shows(&[SetBack, Crossing, Walk])
}

/// Two points see the same three edges, one at each worker.
pub fn two_on_three() -> World {
    let points = [(95, 31, 0), (74, 67, 2)];
    World::new("2 cavities, 3 owners", &[0, 1, 2], &hexagon([1, 2, 2, 2, 0, 0]), &points).shows(&[
        SetBack,
        Crossing,
        Installation,
        Walk,
    ])
}

/// Three cavities in a ring, each at two workers and overlapping the next in one edge.
pub fn three_cycle() -> World {
    let points = [(43, 25, 0), (-43, 25, 1), (0, -50, 2)];
    World::new("3-cycle", &[0, 1, 2], &hexagon([0, 1, 1, 2, 2, 2]), &points)
        .shows(&[SetBack, Crossing])
}

/// Three cavities in a ring that share no edge: only their rings overlap.
pub fn three_rings() -> World {
    let points = [(14, 25, 0), (-29, 0, 1), (14, -25, 2)];
    World::new("3-cycle of rings", &[0, 1, 2], &hexagon([0, 1, 1, 2, 2, 2]), &points)
        .shows(&[SetBack])
}

/// Three points see the same three edges at two workers.
pub fn three_on_two() -> World {
    let points = east(&[0, 1, 0]);
    World::new("3 cavities, 2 owners", &[0, 1], &hexagon([0, 1, 1, 1, 0, 0]), &points)
        .shows(&[SetBack, Crossing, Walk])
}

/// Three points see the same three edges, one at each worker.
pub fn three_on_all() -> World {
    let points = east(&[0, 1, 2]);
    World::new("3 cavities, all 3 owners", &[0, 1, 2], &hexagon([1, 2, 2, 2, 0, 0]), &points)
        .shows(&[SetBack, Crossing, Installation, Walk])
}

/// Two points, then one, at two workers.
pub fn rounds_on_two() -> World {
    World { name: "rounds, 2 owners", ..same_two() }.then(&[(60, 0, 0)])
}

/// Two points that see the same edges, then one, at three workers.
pub fn rounds_on_three() -> World {
    World { name: "rounds, 3 owners", ..two_on_three() }.then(&[(87, 50, 1)])
}

/// Three cavities at four workers.
pub fn four_owners() -> World {
    let points = [(95, 31, 0), (74, 67, 3), (-29, 0, 2)];
    World::new("3 cavities, 4 owners", &[0, 1, 2, 3], &hexagon([1, 2, 3, 3, 0, 0]), &points)
        .shows(&[SetBack, Crossing, Installation, Walk])
}

/// The oldest operation has three cells, its ring is at worker 1 on both sides: while it waits for
/// one side, which a second operation holds, it asks for the other side, which a third one holds.
pub fn asked_again() -> World {
    // A regular octagon, less its symmetry.
    let polygon = [
        (-24, 10, 3),
        (-25, -10, 4),
        (-10, -25, 5),
        (11, -24, 2),
        (24, -10, 2),
        (25, 10, 0),
        (10, 25, 1),
        (-10, 24, 2),
    ];
    let points = [(0, 80, 1), (19, -20, 2), (-19, -20, 4)];
    World::new("an owner asked twice while it waits", &[1, 0, 2, 1, 3, 2], &polygon, &points)
        .shows(&[SetBack])
}

/// Two contested cavities while a block goes away and comes back.
pub fn there_and_back() -> World {
    let moves = [(2, 1), (2, 2)];
    World { name: "a block goes and returns", ..two_on_three() }.moving(&moves).shows(&[
        SetBack,
        Crossing,
        Installation,
        Bounce,
        Walk,
        Move,
    ])
}

/// Two contested cavities while two blocks change places.
pub fn swap() -> World {
    World { name: "two blocks change places", ..same_two() }
        .moving(&[(0, 1), (1, 0)])
        .shows(&[SetBack, Crossing, Bounce, Walk, Move])
}

/// An edge is made for block 2, which its maker believes at worker 2. The block goes to worker 1,
/// which is asked for the edge before it is there, and goes back.
pub fn late_installation() -> World {
    let polygon = hexagon([0, 2, 1, 1, 0, 0]);
    let points = [(22, 13, 3), (17, 25, 4), (-22, -14, 5)];
    let owners = [0, 1, 2, 0, 1, 2];
    World::new("an edge for a block that moves", &owners, &polygon, &points)
        .moving(&[(2, 1), (2, 2)])
        .shows(&[SetBack, Crossing, Installation, Bounce, Stray, Walk, Move])
}

/// A late installation that is asked for by an operation that holds nothing at worker 1, so that
/// the block may leave while the question waits there. The block takes a point along, so that its
/// owner is busy.
pub fn late_elsewhere() -> World {
    let polygon = hexagon([0, 2, 1, 1, 0, 0]);
    let points = [(22, 13, 3), (29, 0, 3), (-22, -14, 2)];
    World::new("an edge for a block that leaves", &[0, 1, 2, 0], &polygon, &points)
        .moving(&[(2, 1), (2, 2)])
        .shows(&[Installation, Bounce, Stray, Move])
}

/// A block leaves, edges are made where it was, and it returns.
pub fn slots_again() -> World {
    let polygon = hexagon([0, 0, 1, 1, 0, 0]);
    let points = [(22, 13, 2), (-22, -14, 3), (22, -13, 2)];
    World::new("a block leaves its slots", &[0, 0, 0, 1], &polygon, &points)
        .moving(&[(1, 1), (1, 0)])
        .shows(&[Walk, Move])
}

/// One point walks to another worker and has its closure at three.
pub fn one_far_point() -> World {
    let polygon = hexagon([2, 0, 0, 1, 1, 2]);
    World::new("token, 1 cavity, 3 owners", &[0, 1, 2, 1], &polygon, &[(87, 50, 3)])
        .terminating()
        .shows(&[Walk])
}

/// One point, with its closure at two workers: the smallest run with messages.
pub fn one_on_two() -> World {
    let world = same_two().terminating().shows(&[]);
    World { name: "token, 1 cavity, 2 owners", points: world.points[..1].to_vec(), ..world }
}

/// Termination is detected while two cavities are contested.
pub fn token_same_two() -> World {
    World { name: "token, 2 owners, same 2 cells", ..same_two() }
        .terminating()
        .shows(&[SetBack, Crossing, Walk])
}

/// Termination is detected while two cavities at three workers are contested.
pub fn token_two_on_three() -> World {
    World { name: "token, 2 cavities, 3 owners", ..two_on_three() }.terminating().shows(&[
        SetBack,
        Crossing,
        Installation,
        Walk,
    ])
}

/// Termination is detected while a block moves.
pub fn token_move() -> World {
    let moves = [(1, 2), (1, 0)];
    World { name: "token, a block moves", ..one_far_point() }.moving(&moves).shows(&[Walk, Move])
}

/// Points that walk elsewhere and are inserted there at once: messages of these kinds may overtake
/// each other, so that termination detection can be explored without any order.
pub fn walks_unordered() -> World {
    let polygon = hexagon([1, 1, 1, 1, 1, 0]);
    let points = [(0, 24, 3), (-22, 13, 4)];
    World::new("token, walks in any order", &[0, 1, 2, 0, 2], &polygon, &points)
        .terminating()
        .network(Network::Unordered)
        .shows(&[Walk])
}

/// Two contested cavities, and a cancel of every worker at any time.
pub fn cancels() -> World {
    World { name: "cancels", ..token_two_on_three() }.cancelled().shows(&[
        SetBack,
        Crossing,
        Installation,
        Walk,
    ])
}

/// A block moves with its point, and all are cancelled at any time.
pub fn cancels_with_a_move() -> World {
    World { name: "cancels, a block moves", ..late_elsewhere() }
        .moving(&[(2, 1)])
        .terminating()
        .cancelled()
        .shows(&[Move])
}

/// The worlds in which all three rules are explored.
pub fn contests() -> Vec<World> {
    vec![same_two(), two_on_three(), three_rings(), three_on_two(), three_on_all(), three_cycle()]
}

/// Worlds with moves, tokens and cancels.
pub fn journeys() -> Vec<World> {
    vec![
        four_owners(),
        asked_again(),
        there_and_back(),
        swap(),
        late_installation(),
        late_elsewhere(),
        slots_again(),
        one_far_point(),
        token_same_two(),
        token_two_on_three(),
        token_move(),
        walks_unordered(),
        cancels(),
        cancels_with_a_move(),
        rounds_on_two(),
        rounds_on_three(),
    ]
}

/// Larger worlds: everything at once.
pub fn larger() -> Vec<World> {
    vec![
        World { name: "token, 3 cavities, all 3 owners", ..three_on_all().terminating() },
        World { name: "token, 3 cavities, 4 owners", ..four_owners().terminating() },
        World { name: "token, 3-cycle", ..three_cycle().terminating() },
        World { name: "3 cavities, all 3 owners, moves", ..three_on_all() }
            .moving(&[(2, 1), (1, 0), (2, 2)])
            .shows(&[SetBack, Crossing, Bounce, Stray, Move, LateWound]),
        World { name: "token, an edge for a block that moves", ..late_installation() }
            .terminating(),
    ]
}
