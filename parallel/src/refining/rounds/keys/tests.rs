use super::super::source::Stage;
use super::super::{Ending, RoundNode, rounds_by};
use super::*;
use crate::mesh::Layout;
use crate::protocol::{Action, Config, Correct, Event, Submesh, WorkerId};
use ltbw_domain::PrepareOptions;
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_refine::Refiner;
use std::collections::VecDeque;

/// After the exchanges of a round each worker has heard of every interface face what stands beyond.
/// Returns the faces, those with a rank beyond, and those with something behind that comes first.
fn compare(nodes: &[RoundNode<'_, Correct>]) -> [usize; 3] {
    let mut figures = [0; 3];
    for node in nodes {
        let (mesh, keys) = (node.mesh(), &node.source().keys);
        let tets = mesh.inner.tets();
        let far_slots = (0..keys.interface.len() as u32).filter_map(|k| tets.far_at(k));
        for slot in
            far_slots.map(|(slot, ..)| slot).chain(tets.topology().free_slots().iter().copied())
        {
            assert_eq!(keys.own.at(slot), 0, "nothing here has the key of slot {slot}");
        }
        for (own, far) in keys.interface.iter().zip(&keys.far) {
            let Some(own) = own else { continue };
            let other = &nodes[node.directory().owner(own.beyond.block).number() as usize];
            let (there, told) = (other.mesh(), &other.source().keys);
            let t = there.resolve(own.beyond.name).expect("a tetrahedron beyond");
            let face = there.inner.tets().neighbours(t)[usize::from(own.beyond.face)];
            let place = there.inner.tets().far_place(tet_of(face)).expect("a far face") as usize;
            assert_eq!(told.interface[place].map(|own| own.t), Some(t));
            assert_eq!(far.rank, told.rank::<Correct>(there, t));
            assert_eq!(far.is_beaten, told.far[place].told);
            let beaten = keys.rank::<Correct>(mesh, own.t).is_some_and(|own_rank| {
                let beyond = told.interface[place].expect("an interface face");
                told.beats::<Correct>(there, &beyond, &own_rank)
            });
            assert_eq!(far.is_beaten, beaten);
            figures[0] += 1;
            figures[1] += usize::from(far.rank.is_some());
            figures[2] += usize::from(far.is_beaten);
        }
    }
    figures
}

/// Runs workers to their end, a message or a piece of work of each in turn.
fn run<'c>(
    mut nodes: Vec<RoundNode<'c, Correct>>,
    figures: &mut [usize; 3],
) -> Vec<RoundNode<'c, Correct>> {
    let mut inboxes: Vec<VecDeque<_>> = nodes.iter().map(|_| VecDeque::new()).collect();
    let (mut actions, mut compared) = (Vec::new(), 0);
    while nodes.iter().any(|node| !node.is_stopped()) {
        let mut has_stepped = false;
        for k in 0..nodes.len() {
            let event = match inboxes[k].pop_front() {
                Some((from, message)) => Event::Message { from, message },
                None if nodes[k].has_work() => Event::Work,
                None => continue,
            };
            has_stepped = true;
            nodes[k].step(event, &mut actions);
            for action in actions.drain(..) {
                if let Action::Send { to, message } = action {
                    inboxes[to.number() as usize].push_back((WorkerId::new(k as u32), message));
                }
            }
            let first = nodes[0].source().exchange.number;
            let waits = |node: &RoundNode<'_, Correct>| {
                node.source().stage == Stage::Choosing && node.source().exchange.number == first
            };
            if compared < first && nodes.iter().all(waits) {
                compared = first;
                figures.iter_mut().zip(compare(&nodes)).for_each(|(sum, own)| *sum += own);
            }
        }
        assert!(has_stepped, "nobody has anything to do");
    }
    nodes
}

#[test]
fn exchanges_tell_what_stands_beyond_every_interface_face() {
    for (kind, volume, processors) in
        [(DomainKind::CubeOctahedron, 4e-5, 2), (DomainKind::LBlock, 2e-4, 5)]
    {
        let domain = generate_domain(kind, &Shape::default()).expect("a shape");
        let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
        let refiner = Refiner::new().max_volume(volume);
        let layout = |points| (Layout::new(points, processors), Config::new(processors));
        let mut figures = [0; 3];
        let whole = (&ready.domain, &ready.lattice);
        let run = rounds_by(&refiner, whole, layout, |nodes| Ok(run(nodes, &mut figures)));
        let ending = run.expect("a mesh").1;
        assert_eq!(ending.ok(), Some(Ending::Done), "{kind:?}");
        let [faces, ranked, beaten] = figures;
        assert!(faces > ranked && ranked > beaten && beaten > 100, "{kind:?}: {figures:?}");
    }
}

/// A cavity found ahead holds as long as neither it nor the ring around it is written.
#[test]
fn a_cavity_has_changed_if_its_ring_has() {
    let domain = generate_domain(DomainKind::LBlock, &Shape::default()).expect("a shape");
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let refiner = Refiner::new().max_volume(1e-3).start(100);
    let layout = |points| (Layout::new(points, 2), Config::new(2));
    let mut looked_at = 0;
    let run = rounds_by(&refiner, (&ready.domain, &ready.lattice), layout, |nodes| {
        let mesh = nodes[0].mesh();
        let tets = mesh.inner.tets();
        let (mut keys, all) = (Keys::default(), RankedHere::<Correct>::of(mesh));
        keys.grow(tets.topology().slots());
        keys.begin_look();
        let look = keys.look();
        for (t, _) in tets.tets() {
            let ring = tets.neighbours(t).map(tet_of);
            assert!(keys.are_unchanged(&all, &[t], look));
            for written in ring.into_iter().chain([t]) {
                keys.write(written, 0, look + 1);
                assert!(!keys.are_unchanged(&all, &[t], look), "{written} beside {t}");
                assert!(keys.are_unchanged(&all, &[t], look + 1));
                keys.write(written, 0, look);
            }
            looked_at += 1;
        }
        Ok(run(nodes, &mut [0; 3]))
    });
    assert!(run.is_ok() && looked_at > 10, "{looked_at}");
}
