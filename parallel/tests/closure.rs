//! The closure that an operation locks: the cavity and its face neighbours, or all that touches the
//! cavity.

use ltbw::PointSet;
use ltbw::mesh::{Layout, LocalMesh, Ownership, PointQueue};
use ltbw::protocol::{Action, Closure, Config, Event, Message, Worker, WorkerId};
use ltbw_generate::{PointKind, generate};
use std::collections::{BTreeSet, VecDeque};

type Node = Worker<LocalMesh, PointQueue>;

/// Operations one after the other, each alone, on three workers. Their messages are delivered by
/// hand.
struct World {
    workers: Vec<Node>,
    /// From, to, message.
    messages: VecDeque<(WorkerId, WorkerId, Message<LocalMesh>)>,
    /// The vertices around which the operation under way locks.
    around: Vec<u64>,
    /// Workers asked for it.
    asked: BTreeSet<WorkerId>,
}

impl World {
    fn new(closure: Closure, ownership: Ownership) -> Self {
        let set = PointSet::new(generate(PointKind::Uniform, 3000, 7)).expect("finite points");
        let layout = Layout { ownership, ..Layout::new(set.len(), 3) };
        let config = Config { closure, ..Config::new(3) };
        let prepared = layout.distribute(&set).expect("a start");
        let worker = |(directory, mesh, field)| Worker::new(config, directory, mesh, field);
        let workers = prepared.workers.into_iter().map(worker).collect();
        Self { workers, messages: VecDeque::new(), around: Vec::new(), asked: BTreeSet::new() }
    }

    fn step(&mut self, worker: WorkerId, event: Event<LocalMesh>) {
        let mut actions = Vec::new();
        self.workers[worker.index()].step(event, &mut actions);
        for action in actions {
            if let Action::Send { to, message } = action {
                if let Message::Expand { around, .. } = &message {
                    self.asked.insert(to);
                    if !around.is_empty() {
                        self.around.clone_from(around);
                    }
                }
                self.messages.push_back((worker, to, message));
            }
        }
    }

    /// The number of tetrahedra locked, and of those that either are locked or touch the cavity,
    /// not both; a worker that was asked and holds nothing counts there, too.
    fn locked(&self) -> (usize, usize) {
        let (mut locked, mut wrong) = (0, 0);
        for worker in &self.workers {
            let part = worker.mesh().tets();
            let is_asked = self.asked.contains(&worker.id());
            wrong += usize::from(is_asked && part.locked().next().is_none());
            for (t, v) in part.tets() {
                let names = v.map(|v| worker.mesh().name(v));
                let touches = names.iter().any(|v| self.around.binary_search(v).is_ok());
                let is_locked = part.holder(t).is_some();
                locked += usize::from(is_locked);
                wrong += usize::from(touches != is_locked);
            }
        }
        (locked, wrong)
    }

    /// Runs `operations` of more than one worker; returns the number of tetrahedra they locked.
    fn run(&mut self, operations: usize) -> usize {
        let (mut done, mut all) = (0, 0);
        while done < operations {
            self.around.clear();
            self.asked.clear();
            let worker = (0..3).find(|&w| self.workers[w as usize].has_work());
            self.step(WorkerId::new(worker.expect("points left")), Event::Work);
            let mut last = None;
            while let Some((from, to, message)) = self.messages.pop_front() {
                // If it is the last grant all is locked.
                if matches!(message, Message::Grant { .. }) && self.messages.is_empty() {
                    last = Some(self.locked());
                }
                self.step(to, Event::Message { from, message });
                // A setback of the only operation there is would be a defect.
                assert!(!self.messages.iter().any(|m| matches!(m.2, Message::Abort { .. })));
                if last.is_some() && self.messages.iter().any(|m| m.2.kind() == "commit") {
                    let (locked, wrong) = last.take().expect("just looked");
                    assert!(locked > 0 && (self.around.is_empty() || wrong == 0), "{wrong} wrong");
                    all += locked;
                    done += 1;
                }
            }
        }
        all
    }
}

#[test]
fn the_vertex_closure_is_all_that_touches_the_cavity() {
    for ownership in Ownership::ALL {
        let vertex = World::new(Closure::Vertex, ownership).run(200);
        let face = World::new(Closure::Face, ownership).run(200);
        println!("{ownership:?}: {} locked by an operation, {} by faces", vertex / 200, face / 200);
        assert!(vertex > 3 * face, "{vertex} and {face} locked");
    }
}

#[test]
fn what_is_not_owned_by_blocks_is_not_given_away() {
    for ownership in Ownership::ALL {
        let moves = usize::from(ownership == Ownership::Block);
        let mut world = World::new(Closure::Face, ownership);
        let directory = world.workers[0].directory();
        let block = directory.blocks().find(|&b| directory.is_mine(b)).expect("a block");
        world.step(WorkerId::default(), Event::Migrate { block, to: WorkerId::new(1) });
        assert_eq!(world.messages.len(), moves, "{ownership:?}");
    }
}
