//! The tiles of patches: what parts have of one is put together by one member.

use super::super::Run;
use super::super::patches::{Patches, Tiled, Tiles};
use crate::parted::exchange::{Exchange, deal, member_of};
use num_bigint::BigInt;
use std::collections::HashSet;

/// The tiles of one patch in one part: its number, the digits of their area, how many turn each
/// way, and the tetrahedron and corners of one of each, in two halves.
type Told = [u64; 10];

/// No tile.
const NONE: [u64; 2] = [u64::MAX; 2];

fn told(k: u64, tiles: &Tiles) -> Told {
    let mut area = tiles.area.iter_u64_digits();
    let mut digit = || area.next().unwrap_or_default();
    let pair = |a: u32, b: u32| u64::from(a) << 32 | u64::from(b);
    let [[a, b], [c, d]] =
        tiles.first.map(|first| first.map_or(NONE, |[t, a, b, c]| [pair(t, a), pair(b, c)]));
    let [one, other] = tiles.turns;
    [k, digit(), digit(), digit(), one, other, a, b, c, d]
}

/// Adds what a part has of a patch.
fn add(to: &mut Tiles, own: &Told) {
    let [_, low, middle, high, one, other, a, b, c, d] = *own;
    to.area += (BigInt::from(high) << 128) + (BigInt::from(middle) << 64) + BigInt::from(low);
    for (sum, own) in to.turns.iter_mut().zip([one, other]) {
        *sum = sum.saturating_add(own);
    }
    let ids = |[a, b]: [u64; 2]| [(a >> 32) as u32, a as u32, (b >> 32) as u32, b as u32];
    for (first, own) in to.first.iter_mut().zip([[a, b], [c, d]]) {
        let own = (own != NONE).then_some(ids(own));
        *first = [*first, own].into_iter().flatten().min();
    }
}

impl Run<'_> {
    /// Judges the tiles of all patches, of which each member has found some. `outline` are edges of
    /// the mesh on edges of the domain.
    pub(super) fn patches_in_parts<E: Exchange>(
        &mut self,
        team: &mut E,
        patches: &Patches,
        Tiled { tiles, subfaces, steps }: Tiled,
        outline: &[[u32; 2]],
    ) -> Result<(), E::Error> {
        self.out.subfaces += subfaces;
        self.out.steps += steps;
        if patches.list.is_empty() {
            return Ok(());
        }
        let (me, members) = (team.me(), team.members());
        let at = |ends: &[u32]| member_of(ends, members);
        let odd = (0u32..).zip(&tiles).flat_map(|(k, own)| own.odd().map(move |[a, b]| [a, b, k]));
        let mut odd = deal(team, odd, |edge| at(&edge[..2]))?.concat();
        let outline = deal(team, outline.iter().copied(), |edge| at(edge))?;
        let outline: HashSet<[u32; 2]> = outline.into_iter().flatten().collect();
        odd.sort_unstable();
        let open = odd.chunk_by(|a, b| a == b).filter(|edge| edge.len() % 2 == 1);
        let open = open.map(|edge| edge[0]).filter(|&[a, b, _]| !outline.contains(&[a, b]));
        let mut open: Vec<u32> = open.map(|edge| edge[2]).collect();
        open.sort_unstable();
        open.dedup();
        let open = deal(team, open.into_iter(), |&k| k as usize % members)?;
        let open: HashSet<u32> = open.into_iter().flatten().collect();
        let own = (0u64..).zip(&tiles).filter(|(_, own)| own.first != [None; 2]);
        let own = own.map(|(k, own)| told(k, own));
        let met = deal(team, own, |own| own[0] as usize % members)?;
        let mut sums = patches.tiled().tiles;
        for own in met.iter().flatten() {
            let Some(sum) = sums.get_mut(own[0] as usize) else { continue };
            add(sum, own);
        }
        for (k, sum) in sums.iter().enumerate().filter(|(k, _)| k % members == me) {
            self.judge_tiles(&patches.list[k], sum, open.contains(&(k as u32)));
        }
        Ok(())
    }
}
