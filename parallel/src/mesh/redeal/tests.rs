//! Tests of redeals.

use super::*;
use crate::mesh::{Layout, Mark, Ownership, Prepared, SharedInput, gather};
use ltbw_core::Builder;
use ltbw_exact::PointSet;
use ltbw_generate::{PointKind, generate};

const WORKERS: u32 = 4;

/// Submeshes with all points of a set, and their directories.
struct Meshes {
    all: Vec<(Directory, LocalMesh)>,
    common: SharedInput,
    each: u32,
}

fn begin(set: &PointSet, ownership: Ownership) -> Meshes {
    let layout = Layout { ownership, sample: set.len(), ..Layout::new(set.len(), WORKERS) };
    let Prepared { workers, common, .. } = layout.distribute(set).expect("a mesh");
    let all = workers.into_iter().map(|(directory, mesh, _)| (directory, mesh)).collect();
    Meshes { all, common, each: layout.blocks_per_worker }
}

/// Cuts by the work at places that differ each time; the tetrahedra that move.
fn deal(meshes: &mut Meshes, turn: u64) -> u64 {
    let Meshes { all, common, each } = meshes;
    let own = &all[0].1;
    let mark = |(k, p)| Mark { key: own.key(p), weight: 1 + k * turn % 97 };
    let keyed: Vec<Mark> = (0..).zip(&common.points).map(mark).collect();
    let blocks = own.blocks().recut(&common.points, &keyed).expect("a curve");
    let (mut dealt, mut words) = (Vec::new(), vec![Vec::new(); all.len()]);
    for (directory, mesh) in &mut *all {
        let first = mesh.me.number() * *each;
        let own = blocks.stretch(first..first + *each);
        let own = mesh.recut(&blocks, directory, own);
        own.words.iter().for_each(|(to, own)| words[to.index()].extend(own));
        dealt.push(own);
    }
    let (mut parcels, mut moved) = (vec![Vec::new(); all.len()], 0);
    for ((dealt, words), (_, mesh)) in dealt.iter().zip(words).zip(&mut *all) {
        for own in mesh.send_off(dealt, words.into_iter()).expect("room") {
            assert_eq!(own.vertices.len(), own.parcel.vertices.len());
            moved += own.parcel.len() as u64;
            assert!(own.parcel.bytes() > 0);
            parcels[own.to.index()].push(own.parcel);
        }
    }
    for (parcels, (directory, mesh)) in parcels.iter().zip(&mut *all) {
        let parcels: Vec<&Parcel> = parcels.iter().collect();
        let unpacked = mesh.unpack(&parcels, directory).expect("room");
        for (own, parcel) in unpacked.iter().zip(parcels) {
            assert_eq!((own.tets.len(), own.vertices.len()), (parcel.len(), parcel.vertices.len()));
        }
        assert_eq!(mesh.misplaced(directory), None);
    }
    moved
}

#[test]
fn a_mesh_that_is_dealt_anew_is_the_mesh() {
    let set = PointSet::new(generate(PointKind::Uniform, 1500, 3)).expect("points");
    let expected = Builder::new().build(&set).expect("a mesh").mesh.hash();
    for ownership in Ownership::ALL {
        let mut meshes = begin(&set, ownership);
        for turn in 1..8 {
            let moved = deal(&mut meshes, turn);
            assert!(moved > 100, "{ownership:?}, {turn}: {moved} have moved");
            assert!(meshes.all.iter().all(|(_, own)| own.num_tets() > 0));
        }
        let Meshes { all, common, .. } = meshes;
        let all = all.into_iter().map(|own| own.1).collect();
        let whole = gather(all, common).expect("parts that fit").mesh;
        assert_eq!(whole.hash(), expected, "{ownership:?}");
    }
}

#[test]
fn what_makes_no_sense_is_refused_by_name() {
    let set = PointSet::new(generate(PointKind::Uniform, 400, 3)).expect("points");
    let mut meshes = begin(&set, Ownership::Newest);
    let name = Name { by: WorkerId::new(7), number: 9 };
    let face = unknown("an interface face", 9);
    let none = Dealt { blocks: Vec::new(), leaving: Vec::new(), words: Vec::new() };
    let word = |name, face, block| Turned { name, face, block: BlockId::new(block) };
    let (&own, _) = meshes.all[1].1.names.iter().next().expect("a name");
    let (_, mesh) = &mut meshes.all[1];
    let mut told = |word| mesh.send_off(&none, std::iter::once(word)).map(|own| own.len());
    assert_eq!(told(word(name, 0, 0)), Err(face));
    let face = unknown("an interface face", own.number);
    assert_eq!(told(word(own, 4, 0)), Err(face));
    assert_eq!(told(word(own, 0, u32::MAX)), Err(face));
    let corner = |k: u32| WireVertex::new(made_by_nobody(k), [f64::from(k), 0.0, 1.0]);
    let vertices: Vec<WireVertex> = (0..4).map(corner).collect();
    let far = Handle { name, block: BlockId::new(u32::MAX), face: 0 };
    let good = Sent { name: None, v: [0, 1, 2, 3], n: [Lead::In(0, 0); 4] };
    let nowhere = WireVertex { name: NOWHERE, bits: [0; 3] };
    let last = Handle { block: BlockId::default(), face: 4, ..far };
    let mine = Handle { block: directory_block(&meshes.all[1].0), ..far };
    let parcel = |sent| Parcel { tets: vec![sent], vertices: vertices.clone() };
    let bad = [
        (parcel(Sent { v: [0, 1, 2, 9], ..good }), unknown("a vertex", 9)),
        (
            parcel(Sent { n: [Lead::In(1, 0); 4], ..good }),
            unknown("a tetrahedron of the parcel", 1),
        ),
        (
            parcel(Sent { n: [Lead::In(0, 4); 4], ..good }),
            unknown("a tetrahedron of the parcel", 0),
        ),
        (parcel(Sent { n: [Lead::Far(far); 4], ..good }), unknown("a far face", 9)),
        (parcel(Sent { n: [Lead::Far(last); 4], ..good }), unknown("a far face", 9)),
        (Parcel { vertices: vec![nowhere; 4], ..parcel(good) }, unknown("a vertex", 3)),
        (
            parcel(Sent { n: [Lead::Far(mine); 4], ..good }),
            unknown("a tetrahedron beyond a face", 9),
        ),
    ];
    let (directory, mesh) = &mut meshes.all[1];
    for (parcel, error) in bad {
        assert_eq!(mesh.unpack(&[&parcel], directory).map(|_| ()), Err(error));
    }
}

/// The name of a vertex that a worker beyond all has made.
fn made_by_nobody(count: u32) -> u64 {
    crate::mesh::made(WorkerId::new(99), count + 1)
}

/// A block of this worker.
fn directory_block(directory: &Directory) -> BlockId {
    directory.blocks().find(|&block| directory.is_mine(block)).unwrap_or_default()
}
