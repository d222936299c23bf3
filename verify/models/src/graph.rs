//! The state graph of a system: all states, breadth-first, and its strongly connected components.
//!
//! **Livelock.** A run that never ends stays, from some time on, in one component. It is *weakly
//! fair* if everything that is possible all the time happens at last: a message that can be
//! delivered is delivered, a worker that has work does it, a backoff ends. (Nobody is obliged to
//! move a block or to cancel.) A component has such a run if and only if every kind of event that
//! is possible in *all* its states also happens on one of its own transitions: if so, going round
//! all transitions is fair; if not, that event is possible throughout any part of the component
//! and never happens. So "no fair component and no deadlock" means: every weakly fair run ends.
//!
//! States are told apart by 64-bit hashes, as stateright does: n states collide with a probability
//! of about n² / 2^65, 3e-8 for a million.

use crate::system::{Choice, Migration, State, System, fingerprint};
use crate::variants::Variant;
use crate::witness::{ALL, Witness};
use crate::world::Network;
use std::collections::{BTreeSet, HashMap, VecDeque};

/// A kind of event that weak fairness is about.
type Kind = u16;

/// Events that nobody is obliged to.
const FREE: Kind = Kind::MAX;

/// All states reached, and what was found.
pub struct Graph {
    /// By state: the one it was first reached from, and how.
    parents: Vec<(u32, Choice)>,
    /// By state: where its transitions begin.
    starts: Vec<usize>,
    /// Target and kind.
    transitions: Vec<(u32, Kind)>,
    /// Faulty states, in the order found.
    pub faults: Vec<(u32, &'static str)>,
    /// States in which nothing can happen and which are not final.
    pub deadlocks: Vec<u32>,
    /// Final states.
    pub finals: usize,
    /// The longest of the shortest ways to a state.
    pub depth: usize,
    /// Was every state explored?
    pub complete: bool,
    /// The witnesses: events that have happened in some state.
    pub witnesses: BTreeSet<Witness>,
}

/// Strongly connected components that contain a transition.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Components {
    /// Their number.
    pub cyclic: usize,
    /// The number of those with a weakly fair run that never ends.
    pub fair: usize,
    /// A state of one of those.
    pub example: Option<u32>,
    /// States in the largest one.
    pub largest: usize,
}

/// When to stop before everything is explored.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// States at most.
    pub states: usize,
    /// Stop at the first fault or deadlock?
    pub first_fault: bool,
}

impl Graph {
    /// Explores the states of `system`, the nearest first.
    pub fn explore<C: Variant>(system: &System<C>, limits: Limits) -> Self {
        let start = system.initial();
        let mut index = HashMap::from([(fingerprint(&start), 0)]);
        let mut kinds: HashMap<u64, Kind> = HashMap::new();
        let mut frontier = VecDeque::from([(start, 0)]);
        let mut graph = Self {
            parents: vec![(0, Choice::Move)],
            starts: Vec::new(),
            transitions: Vec::new(),
            faults: Vec::new(),
            deadlocks: Vec::new(),
            finals: 0,
            depth: 0,
            complete: true,
            witnesses: BTreeSet::new(),
        };
        // Ends: no state enters twice, and there are `limits.states` at most.
        while let Some((state, depth)) = frontier.pop_front() {
            let id = graph.starts.len() as u32;
            graph.starts.push(graph.transitions.len());
            graph.depth = depth;
            let choices = system.choices(&state);
            graph.judge(system, &state, id, choices.is_empty());
            let found = !graph.faults.is_empty() || !graph.deadlocks.is_empty();
            if limits.first_fault && found || index.len() >= limits.states {
                graph.complete = false;
                break;
            }
            for choice in choices {
                let next = system.after(&state, choice);
                let new = index.len() as u32;
                let target = *index.entry(fingerprint(&next)).or_insert(new);
                let known = kinds.len() as Kind;
                let kind = kind(system, &state, choice)
                    .map_or(FREE, |kind| *kinds.entry(kind).or_insert(known));
                graph.transitions.push((target, kind));
                if target == new {
                    graph.parents.push((id, choice));
                    frontier.push_back((next, depth + 1));
                }
            }
        }
        graph
    }

    fn judge<C: Variant>(&mut self, system: &System<C>, state: &State<C>, id: u32, ends: bool) {
        self.witnesses.extend(ALL.into_iter().filter(|witness| witness.holds(state)));
        if let Some(what) = state.fault {
            self.faults.push((id, what));
        } else if system.is_final(state) {
            self.finals += 1;
        } else if ends {
            self.deadlocks.push(id);
        }
    }

    /// Number of states found.
    pub fn states(&self) -> usize {
        self.parents.len()
    }

    /// Number of transitions explored.
    pub fn transitions(&self) -> usize {
        self.transitions.len()
    }

    fn next(&self, state: usize) -> &[(u32, Kind)] {
        let Some(&start) = self.starts.get(state) else { return &[] };
        let end = self.starts.get(state + 1).copied().unwrap_or(self.transitions.len());
        &self.transitions[start..end]
    }

    /// A shortest way to a state.
    pub fn way(&self, state: u32) -> Vec<Choice> {
        let mut way = Vec::new();
        let mut at = state;
        while at != 0 {
            let (parent, choice) = self.parents[at as usize];
            way.push(choice);
            at = parent;
        }
        way.reverse();
        way
    }

    /// Tarjan's algorithm with a stack of its own, then the test for a fair run.
    pub fn components(&self) -> Components {
        let n = self.states();
        let mut found = Components::default();
        let (mut order, mut low) = (vec![0_u32; n], vec![0_u32; n]);
        let mut component = vec![u32::MAX; n];
        let (mut visited, mut closed) = (0, 0);
        let (mut path, mut calls): (Vec<u32>, Vec<(u32, usize)>) = (Vec::new(), Vec::new());
        for root in 0..n {
            if order[root] == 0 {
                calls.push((root as u32, 0));
            }
            while let Some((state, edge)) = calls.pop() {
                let s = state as usize;
                if edge == 0 {
                    visited += 1;
                    (order[s], low[s]) = (visited, visited);
                    path.push(state);
                } else {
                    let done = self.next(s)[edge - 1].0 as usize;
                    if component[done] == u32::MAX {
                        low[s] = low[s].min(low[done]);
                    }
                }
                if let Some(&(target, _)) = self.next(s).get(edge) {
                    calls.push((state, edge + 1));
                    if order[target as usize] == 0 {
                        calls.push((target, 0));
                    }
                } else if low[s] == order[s] {
                    let from = path.iter().rposition(|&p| p == state).unwrap_or(0);
                    let members = path.split_off(from);
                    for &member in &members {
                        component[member as usize] = closed;
                    }
                    self.examine(&members, &component, closed, &mut found);
                    closed += 1;
                }
            }
        }
        found
    }

    /// Is there a fair run inside this component?
    fn examine(&self, members: &[u32], component: &[u32], me: u32, found: &mut Components) {
        let mut taken = BTreeSet::new();
        let mut always: Option<BTreeSet<Kind>> = None;
        let mut cyclic = false;
        for &member in members {
            let next = self.next(member as usize);
            let inside = |&&(target, _): &&(u32, Kind)| component[target as usize] == me;
            taken.extend(next.iter().filter(inside).map(|&(_, kind)| kind));
            cyclic |= next.iter().any(|t| inside(&t));
            let possible: BTreeSet<Kind> =
                next.iter().map(|&(_, kind)| kind).filter(|&kind| kind != FREE).collect();
            always = Some(match always {
                None => possible,
                Some(always) => &always & &possible,
            });
        }
        if cyclic {
            found.cyclic += 1;
            found.largest = found.largest.max(members.len());
            if always.is_none_or(|always| always.is_subset(&taken)) {
                found.fair += 1;
                found.example = found.example.or(members.first().copied());
            }
        }
    }
}

/// The kind of a choice: what has to happen at last if it is possible all the time.
fn kind<C: Variant>(system: &System<C>, state: &State<C>, choice: Choice) -> Option<u64> {
    match choice {
        Choice::Move | Choice::Cancel(_) => None,
        Choice::Deliver(from, to, place) => match system.world.network {
            Network::Fifo => Some(fingerprint(&(from, to))),
            // Every message on its own must arrive.
            Network::Unordered => {
                let letter = state.channels.get(&(from, to)).and_then(|l| l.get(place));
                Some(fingerprint(&(from, to, letter)))
            }
        },
        Choice::Work(_) | Choice::Retry(..) => Some(fingerprint(&choice)),
    }
}

/// The steps of a run, one line each.
pub fn tell<C: Variant>(system: &System<C>, way: &[Choice]) -> String {
    let mut text = String::new();
    let mut state = system.initial();
    for (step, &choice) in way.iter().enumerate() {
        let what = match choice {
            Choice::Deliver(from, to, place) => {
                let letter = &state.channels[&(from, to)][place];
                let about = letter.ticket().map(|t| format!(" {}.{}", t.worker, t.sequence));
                format!("{from} -> {to}: {}{}", letter.kind(), about.unwrap_or_default())
            }
            Choice::Work(at) => format!("{at}: work"),
            Choice::Retry(at, _) => format!("{at}: backoff ends"),
            Choice::Move => {
                let Migration { from, block, to } = system.next_move(&state).unwrap_or_default();
                format!("block {block} moves from {from} to {to}")
            }
            Choice::Cancel(at) => format!("{at}: cancel"),
        };
        text.push_str(&format!("{:3} {what}\n", step + 1));
        state = system.after(&state, choice);
    }
    if let Some(fault) = state.fault {
        text.push_str(&format!("    {fault}\n"));
    }
    text
}
