//! Every tetrahedron is with the owner of its block, also beside a block that has moved away.

use ltbw::mesh::{Layout, LocalMesh, PointQueue, gather};
use ltbw::protocol::{Action, BlockId, Config, Event, Message, Worker, WorkerId};
use ltbw::{Builder, PointSet};
use ltbw_generate::{PointKind, Random, generate};
use std::collections::VecDeque;

type Node = Worker<LocalMesh, PointQueue>;

/// Steps of local work between two deliveries of messages.
const BURST: usize = 20;

struct World {
    nodes: Vec<Node>,
    /// Sender, receiver, message, in the order in which they were sent.
    under_way: VecDeque<(WorkerId, WorkerId, Message<LocalMesh>)>,
}

impl World {
    fn step(&mut self, worker: WorkerId, event: Event<LocalMesh>) {
        let mut out = Vec::new();
        self.nodes[worker.index()].step(event, &mut out);
        for action in out {
            if let Action::Send { to, message } = action {
                self.under_way.push_back((worker, to, message));
            }
        }
    }

    fn deliver(&mut self) {
        while let Some((from, to, message)) = self.under_way.pop_front() {
            self.step(to, Event::Message { from, message });
        }
    }

    /// A burst of work of every worker, then all messages; `false` when all have stopped.
    fn turn(&mut self) -> bool {
        for worker in 0..self.nodes.len() as u32 {
            for _ in 0..BURST {
                self.step(WorkerId::new(worker), Event::Work);
            }
        }
        self.deliver();
        !self.nodes.iter().all(Node::is_stopped)
    }
}

#[test]
fn tetrahedra_beside_blocks_that_have_moved_belong_to_them() {
    let (points, workers) = (3000, 3);
    let set = PointSet::new(generate(PointKind::Clusters, points, 2)).expect("finite points");
    let expected = Builder::new().build(&set).expect("a mesh").mesh.hash();
    let layout = Layout { blocks_per_worker: 48, ..Layout::new(points, workers) };
    let prepared = layout.distribute(&set).expect("a start");
    let node = |(directory, mesh, field)| Worker::new(Config::new(workers), directory, mesh, field);
    let nodes: Vec<Node> = prepared.workers.into_iter().map(node).collect();
    let mut world = World { nodes, under_way: VecDeque::new() };
    let (mut turns, mut random) = (0, Random::new(1));
    while world.turn() {
        turns += 1;
        assert!(turns < points, "no end");
        // No message is under way: every tetrahedron is where it belongs.
        for node in &world.nodes {
            let misplaced = node.mesh().misplaced(node.directory());
            assert_eq!(misplaced, None, "worker {}, turn {turns}", node.id());
        }
        for _ in 0..4 {
            let block = BlockId::new(random.below(u64::from(48 * workers)) as u32);
            let to = WorkerId::new(random.below(u64::from(workers)) as u32);
            let from = world.nodes[0].directory().owner(block);
            world.step(from, Event::Migrate { block, to });
        }
    }
    let meshes = world.nodes.into_iter().map(|node| node.into_parts().0).collect();
    let whole = gather(meshes, prepared.common).expect("parts that fit");
    assert_eq!(whole.mesh.hash(), expected);
}
