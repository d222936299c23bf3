//! The canonical hash of a mesh in parts, and tetrahedra that are there twice.
//!
//! Tetrahedra are sorted by the numbers of their vertices, each member has a stretch of them, and
//! the bytes of all stretches go through the hash in their order: its state travels, they do not.

use super::exchange::{Exchange, before, bytes_of, cuts, stretch, values_of};
use super::found::Found;
use super::vertices::point;
use crate::defect::Kind;
use rayon::prelude::*;
use sha2::digest::common::hazmat::{SerializableState, SerializedState};
use sha2::{Digest, Sha256};
use std::fmt::Write;

/// The numbers of a tetrahedron's vertices, ascending, then its own.
pub(super) type Row = [u32; 5];

/// Sorts the rows of all members and reports those that are there twice; this member's stretch.
pub(super) fn sorted<E: Exchange>(
    team: &mut E,
    mut own: Vec<Row>,
    found: &mut Found,
) -> Result<Vec<Row>, E::Error> {
    own.par_sort_unstable();
    // By vertices alone: equal ones come to one member.
    let cut = |row: &Row| [row[0], row[1], row[2], row[3]];
    let keys: Vec<[u32; 4]> = own.iter().map(cut).collect();
    let cuts = cuts(team, &keys)?;
    drop(keys);
    let mut parts = vec![Vec::new(); team.members()];
    let to = |row: &Row| stretch(&cuts, &cut(row));
    for run in own.chunk_by(|a, b| to(a) == to(b)) {
        parts[to(&run[0])] = bytes_of(run);
    }
    drop(own);
    let mut rows = Vec::new();
    for (from, bytes) in team.exchange(parts)?.iter().enumerate() {
        rows.extend(values_of::<E, Row>(team, from, bytes)?);
    }
    rows.par_sort_unstable();
    for group in rows.chunk_by(|a, b| cut(a) == cut(b)) {
        for other in &group[1..] {
            found.add(Kind::DuplicateTet, &[group[0][4], other[4]], &[]);
        }
    }
    Ok(rows)
}

/// The hash of the mesh with these stretches of vertices and of tetrahedra: the same at all.
pub(super) fn hash<E: Exchange>(
    team: &mut E,
    vertices: &[[u64; 3]],
    rows: &[Row],
) -> Result<String, E::Error> {
    let [_, all_vertices] = before(team, vertices.len() as u64)?;
    let [_, all_rows] = before(team, rows.len() as u64)?;
    let is_first = team.me() == 0;
    let mut begun = Sha256::new();
    begun.update(b"ltbw.mesh/1\n");
    begun.update(all_vertices.to_le_bytes());
    let state = feed(team, &begun, &mut |sha| {
        for block in vertices.chunks(1 << 11) {
            let points: Vec<[f64; 3]> = block.iter().map(point).collect();
            sha.update(bytes_of(&points));
        }
    })?;
    let sha = feed(team, &state, &mut |sha| {
        if is_first {
            sha.update(all_rows.to_le_bytes());
        }
        for block in rows.chunks(1 << 12) {
            let numbers: Vec<[u32; 4]> =
                block.iter().map(|&[a, b, c, d, _]| [a, b, c, d]).collect();
            sha.update(bytes_of(&numbers));
        }
    })?;
    let mut text = String::with_capacity(64);
    for byte in sha.finalize() {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
    }
    Ok(text)
}

/// Feeds a hash at every member in turn.
fn feed<E: Exchange>(
    team: &mut E,
    begun: &Sha256,
    own: &mut dyn FnMut(&mut Sha256),
) -> Result<Sha256, E::Error> {
    let mut is_nonsense = false;
    let state = team.in_turn(begun.serialize().to_vec(), &mut |state| {
        let Some(mut sha) = of_state(&state) else {
            is_nonsense = true;
            return state;
        };
        own(&mut sha);
        sha.serialize().to_vec()
    })?;
    match of_state(&state) {
        Some(sha) if !is_nonsense => Ok(sha),
        _ => Err(team.nonsense(0, "no state of a hash")),
    }
}

fn of_state(state: &[u8]) -> Option<Sha256> {
    let state = SerializedState::<Sha256>::try_from(state).ok()?;
    Sha256::deserialize(&state).ok()
}

/// The row of a tetrahedron.
pub(super) fn row(tet: &[u32; 4], number: &[u32], own: u32) -> Row {
    let mut row = tet.map(|v| number[v as usize]);
    row.sort_unstable();
    let [a, b, c, d] = row;
    [a, b, c, d, own]
}
