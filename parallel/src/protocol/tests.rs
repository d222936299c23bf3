//! Memory of what has ended is used again: no field of the old value may be left. The values below
//! are written field by field, so that a new field has to be entered here.

use super::state::{Asker, Operation, Phase, Request, Want};
use super::table::Table;
use super::{Attempt, BlockId, Handle, Name, WorkerId};
#[cfg(test)] // the protocol knows no mesh
use crate::mesh::{LocalMesh, WireVertex};
use ltbw_core::topology::TetId;

const NAME: Name = Name { by: WorkerId::new(1), number: 2 };
const HANDLE: Handle = Handle { name: NAME, block: BlockId::new(3), face: 1 };

fn vertex(number: u32) -> WireVertex {
    WireVertex::new(number, [1.0, 2.0, 3.0])
}

fn table<K: Ord + Copy, V>(key: K, value: V) -> Table<K, V> {
    let mut table = Table::default();
    table.insert_new(key, || value);
    table
}

#[test]
fn a_reused_operation_equals_a_new_one() {
    let used = Operation::<LocalMesh> {
        point: vertex(5),
        attempt: Attempt::new(7),
        phase: Phase::Releasing(3),
        asked: table(WorkerId::new(4), 5),
        whereabouts: table(NAME, WorkerId::new(6)),
        parts: table(WorkerId::new(3), Vec::new()),
        around: vec![8],
    };
    let reused = Box::new(used).renew(vertex(1), Attempt::new(1), Phase::Expanding);
    let new = Operation::<LocalMesh>::new(vertex(1), Attempt::new(1), Phase::Expanding);
    assert_eq!(format!("{reused:?}"), format!("{new:?}"));
}

#[test]
fn a_reused_request_equals_a_new_one() {
    let used = Request::<LocalMesh> {
        home: WorkerId::new(1),
        attempt: Attempt::new(2),
        point: vertex(3),
        wants: vec![Want::Seed(HANDLE)],
        held: vec![TetId::new(4)],
        cavity: vec![TetId::new(5)],
        pieces: Vec::new(),
        foreign: vec![HANDLE],
        bounced: vec![HANDLE],
        owed: 6,
        around: vec![7],
        stalled: true,
        wounded: true,
    };
    let asker = || Asker { home: WorkerId::new(9), attempt: Attempt::new(8), point: vertex(1) };
    let reused = Box::new(used).renew(asker());
    let new = Request::<LocalMesh>::new(asker());
    assert_eq!(format!("{reused:?}"), format!("{new:?}"));
}
