//! The regions of the tetrahedra that fill a cavity: each is in that of the one which was behind
//! its outer face.

use super::values::{DomainPiece, ItemKey, subface_key};
use crate::mesh::{Link, Side, VertexName};
use crate::protocol::Part;
use rustc_hash::{FxHashMap, FxHashSet};

/// The sides of a cavity that are its boundary, by the names of their vertices, with their pieces
/// and their places there.
fn sides(
    parts: &[Part<DomainPiece>],
) -> impl Iterator<Item = ([VertexName; 3], &DomainPiece, usize)> {
    let pieces = || parts.iter().flat_map(|(_, pieces)| pieces);
    let named: FxHashSet<_> = pieces().flat_map(|own| own.piece.names.iter().copied()).collect();
    let is_outer =
        move |side: &Side| !matches!(side.link, Link::Far(far) if named.contains(&far.name));
    let all = pieces().flat_map(|own| own.piece.sides.iter().enumerate().map(move |s| (own, s)));
    all.filter_map(move |(own, (k, side))| {
        let name = |v: u32| own.piece.vertices[v as usize].name;
        is_outer(side).then(|| (side.v.map(name), own, k))
    })
}

/// The region of the tetrahedra on the sides of a cavity; if they are not in one, those by side.
pub(super) fn regions(parts: &[Part<DomainPiece>]) -> Result<u32, FxHashMap<ItemKey, u32>> {
    let mut all = parts.iter().flat_map(|(_, pieces)| pieces).flat_map(|own| &own.regions);
    let first = all.next().copied().unwrap_or_default();
    if all.all(|&region| region == first) {
        return Ok(first);
    }
    let region = |own: &DomainPiece, k: usize| match own.regions[..] {
        [one] => one,
        _ => own.regions[k],
    };
    Err(sides(parts).map(|(v, own, k)| (subface_key(v), region(own, k))).collect())
}
