//! Messages that name what is not there: a submesh that gets one fails with a typed error and
//! changes nothing. It trusts no number of another worker.

use ltbw::PointSet;
use ltbw::mesh::{At, Layout, Lead, LocalMesh, Moving, NewTet, Patch, Relink, To, WireVertex};
use ltbw::protocol::{BlockId, Correct, Directory, Handle, Name, Submesh, SubmeshError, WorkerId};
use ltbw::topology::{INFINITE, TetId};
use ltbw_generate::{PointKind, generate};

fn submesh() -> (Directory, LocalMesh) {
    let set = PointSet::new(generate(PointKind::Uniform, 300, 1)).expect("finite points");
    let prepared = Layout::new(set.len(), 2).distribute(&set).expect("a start");
    let (directory, mesh, _) = prepared.workers.into_iter().next().expect("a worker");
    (directory, mesh)
}

fn handle(face: u8) -> Handle {
    Handle { name: Name { by: WorkerId::new(1), number: 1 }, block: BlockId::default(), face }
}

/// The submesh as text: tetrahedra with their neighbours.
fn shown(mesh: &LocalMesh) -> Vec<String> {
    let part = mesh.tets();
    part.tets().map(|(t, v)| format!("{t} {v:?} {:?}", part.neighbours(t))).collect()
}

/// The error for a patch that `damage` has changed.
fn damaged(damage: impl Fn(&mut Patch, TetId)) -> SubmeshError {
    let (directory, mut mesh) = submesh();
    let part = mesh.tets();
    let (t, v) = part.tets().find(|(_, v)| v[3] != INFINITE).expect("a tetrahedron");
    let vertices = v.map(|v| WireVertex::new(v.number(), part.point(v)));
    let new =
        NewTet { name: None, v: [0, 1, 2, 3], block: BlockId::default(), n: [To::Old(t, 0); 4] };
    let mut patch = Patch {
        remove: vec![t],
        vertices: vertices.to_vec(),
        create: vec![new],
        relink: Vec::new(),
    };
    damage(&mut patch, t);
    let before = shown(&mesh);
    mesh.apply::<Correct>(patch, &directory, &mut Vec::new(), &mut Vec::new());
    assert_eq!(shown(&mesh), before, "something has changed");
    mesh.error().expect("the submesh has failed")
}

fn of(what: &'static str, number: u32) -> SubmeshError {
    SubmeshError::Unknown { what, number }
}

#[test]
fn numbers_in_a_patch_are_compared_before_they_are_used() {
    const NONE: TetId = TetId::new(1 << 29);
    const LAST: TetId = TetId::new(u32::MAX);
    let tet = "an unlocked tetrahedron";
    assert_eq!(damaged(|patch, _| patch.remove.push(NONE)), of(tet, NONE.number()));
    assert_eq!(damaged(|patch, _| patch.create[0].n[2] = To::Old(LAST, 1)), of(tet, u32::MAX));
    let relink = |at, slot, face| Relink { at, slot, name: None, to: handle(face) };
    let added = |relink: Relink| damaged(move |patch, _| patch.relink.push(relink));
    assert_eq!(added(relink(At::Tet(NONE), 0, 0)), of(tet, NONE.number()));
    let slot = "a face by slot";
    assert_eq!(added(relink(At::Named(handle(0).name), 4, 0)), of(slot, 4));
    assert_eq!(added(relink(At::Named(handle(0).name), 0, 255)), of(slot, 255));
    assert_eq!(damaged(|patch, t| patch.create[0].n[0] = To::Old(t, 9)), of(slot, 9));
    assert_eq!(damaged(|patch, _| patch.create[0].n[3] = To::Far(handle(4))), of(slot, 4));
    let new = "a new tetrahedron";
    assert_eq!(damaged(|patch, _| patch.create[0].n[3] = To::New(1, 0)), of(new, 1));
    assert_eq!(damaged(|patch, _| patch.create[0].n[3] = To::New(0, 4)), of(new, 0));
    let vertex = "a vertex";
    assert_eq!(damaged(|patch, _| patch.create[0].v[3] = 4), of(vertex, 4));
    assert_eq!(damaged(|patch, _| patch.vertices[1].name = 301), of(vertex, 301));
    assert_eq!(damaged(|patch, _| patch.vertices[0].name = 0), of(vertex, 3));
}

#[test]
fn numbers_in_a_block_are_compared_before_they_are_used() {
    let sound = |mesh: &LocalMesh| {
        let part = mesh.tets();
        let (_, v) = part.tets().find(|(_, v)| v[3] != INFINITE).expect("a tetrahedron");
        let v = v.map(|v| WireVertex::new(v.number(), part.point(v)));
        Moving { name: Name { by: WorkerId::new(7), number: 1 }, v, n: [Lead::Far(handle(0)); 4] }
    };
    let adopted = |damage: &dyn Fn(&mut Moving)| {
        let (_, mut mesh) = submesh();
        let (mut moving, before) = (sound(&mesh), shown(&mesh));
        damage(&mut moving);
        mesh.adopt(vec![moving], &mut Vec::new());
        assert_eq!(shown(&mesh), before, "something has changed");
        mesh.error().expect("the submesh has failed")
    };
    let new = "a tetrahedron of the block";
    assert_eq!(adopted(&|moving| moving.n[1] = Lead::In(1, 0)), of(new, 1));
    assert_eq!(adopted(&|moving| moving.n[1] = Lead::In(0, 7)), of(new, 0));
    assert_eq!(adopted(&|moving| moving.n[0] = Lead::Far(handle(5))), of("a face by slot", 5));
    assert_eq!(adopted(&|moving| moving.v[2].name = 999), of("a vertex", 999));
    assert_eq!(adopted(&|moving| moving.v[0].name = 0), of("a finite vertex", 0));
}
