//! Sums over all members: areas, volumes, findings, components.

use super::super::Run;
use super::super::finding::{Conformity, ConformityDefect, Finding};
use super::super::tiles::Planes;
use crate::angles::{LeastAngle, SmallAngles};
use crate::parted::exchange::{
    Exchange, Record, bytes_of, deal, sums, tell_all, tell_all_bytes, values_of,
};
use num_bigint::{BigInt, Sign};
use std::collections::HashMap;

/// Digits of an area: twice nine of a face are below 2^126, and no mesh has 2^32 faces.
const DIGITS: usize = 3;

/// The values of all members, by member.
pub(super) fn all<E: Exchange, R: Record>(team: &mut E, own: &[R]) -> Result<Vec<R>, E::Error> {
    Ok(tell_all(team, own)?.into_iter().flatten().collect())
}

impl Run<'_> {
    /// The tiles of each plane have its area: the tiles of all members, at one of them.
    pub(super) fn untiled<E: Exchange>(
        &mut self,
        team: &mut E,
        planes: &Planes<'_>,
        areas: &[BigInt],
    ) -> Result<(), E::Error> {
        let (me, members) = (team.me(), team.members());
        let told =
            (0u64..).zip(areas).filter(|(_, area)| **area != BigInt::ZERO).map(|(g, area)| {
                let mut own = [0; 1 + DIGITS];
                own[0] = g;
                own[1..]
                    .iter_mut()
                    .zip(area.iter_u64_digits())
                    .for_each(|(own, digit)| *own = digit);
                own
            });
        let met = deal(team, told, |own: &[u64; 1 + DIGITS]| own[0] as usize % members)?;
        let mut sums = vec![BigInt::ZERO; areas.len()];
        for own in met.into_iter().flatten() {
            let Some(sum) = sums.get_mut(own[0] as usize) else { continue };
            for digit in own[1..]
                .iter()
                .rev()
                .enumerate()
                .map(|(k, &d)| BigInt::from(d) << (64 * (DIGITS - 1 - k)))
            {
                *sum += digit;
            }
        }
        for (g, sum) in sums.iter().enumerate().filter(|(g, _)| g % members == me) {
            if let Some(f) = planes.untiled(g, sum) {
                self.add(ConformityDefect::FacetNotTiled, &[f]);
            }
        }
        Ok(())
    }
}

/// The sum of volumes, none of which is negative.
pub(super) fn volume<E: Exchange>(team: &mut E, own: &BigInt) -> Result<BigInt, E::Error> {
    let all = tell_all_bytes(team, &own.to_bytes_le().1)?;
    Ok(all.iter().map(|bytes| BigInt::from_bytes_le(Sign::Plus, bytes)).sum())
}

/// Components that are joined to others: each with one below it.
pub(super) struct Roots {
    below: HashMap<u32, u32>,
    /// Number of components that are left.
    pub(super) count: u64,
}

impl Roots {
    /// The roots of `count` components that pairs join.
    pub(super) fn of(count: u64, pairs: &[[u32; 2]]) -> Self {
        let mut own = Self { below: HashMap::new(), count };
        for pair in pairs {
            let [a, b] = pair.map(|cell| own.root(cell));
            if a != b {
                own.below.insert(a.max(b), a.min(b));
                own.count = own.count.saturating_sub(1);
            }
        }
        own
    }

    /// The least of the components that are joined to one.
    pub(super) fn root(&self, mut cell: u32) -> u32 {
        // Ends: each is below the one before.
        while let Some(&next) = self.below.get(&cell) {
            cell = next;
        }
        cell
    }
}

/// The findings of all members, whose first tetrahedra have these numbers: the same at all.
pub(super) fn findings<E: Exchange>(
    team: &mut E,
    mut own: Conformity,
    first: u32,
    limit: usize,
) -> Result<Conformity, E::Error> {
    let small = own.below_dihedral.take();
    let mut words: Vec<u64> = Vec::new();
    for (breach, count) in &own.counts {
        let listed: Vec<&Finding> = own.findings.iter().filter(|f| f.breach == *breach).collect();
        words.extend([*breach as u64, *count, listed.len() as u64]);
        for finding in listed {
            words.push(finding.ids.len() as u64);
            words.extend(shifted(finding, first));
        }
    }
    own.counts.clear();
    own.findings.clear();
    for (from, bytes) in tell_all_bytes(team, &bytes_of(&words))?.iter().enumerate() {
        let words: Vec<u64> = values_of(team, from, bytes)?;
        if read(&mut words.into_iter(), &mut own, limit).is_none() {
            return Err(team.nonsense(from, "no list of findings"));
        }
    }
    [own.subfaces, own.steps] = sums(team, [own.subfaces, own.steps])?;
    if let Some(small) = small {
        own.below_dihedral = Some(angles(team, small, first, limit)?);
    }
    own.findings.sort_by_key(|finding| finding.breach);
    Ok(own)
}

/// The ids of a finding, its tetrahedra by their numbers in the lists of all members.
fn shifted(finding: &Finding, first: u32) -> impl Iterator<Item = u64> + '_ {
    use ConformityDefect::{EdgeExceeded, RatioExceeded, TagNotOfSeed, VolumeExceeded};
    let is_own =
        matches!(finding.breach, RatioExceeded | VolumeExceeded | EdgeExceeded | TagNotOfSeed);
    let by = if is_own { first } else { 0 };
    finding.ids.iter().map(move |&id| u64::from(id.saturating_add(by)))
}

/// Adds the findings that words tell; `None` if they tell none.
fn read(words: &mut impl Iterator<Item = u64>, to: &mut Conformity, limit: usize) -> Option<()> {
    while let Some(kind) = words.next() {
        let breach = *ConformityDefect::EVERY.get(usize::try_from(kind).ok()?)?;
        let count = to.counts.entry(breach).or_default();
        *count = count.saturating_add(words.next()?);
        for _ in 0..words.next()? {
            let mut ids = Vec::new();
            for _ in 0..words.next()? {
                ids.push(u32::try_from(words.next()?).ok()?);
            }
            let listed = to.findings.iter().filter(|f| f.breach == breach).count();
            if listed < limit {
                to.findings.push(Finding { breach, ids });
            }
        }
    }
    Some(())
}

/// The small angles of all members.
fn angles<E: Exchange>(
    team: &mut E,
    own: SmallAngles,
    first: u32,
    limit: usize,
) -> Result<SmallAngles, E::Error> {
    let [count] = sums(team, [own.count])?;
    let tets: Vec<u32> = own.tets.iter().map(|t| t.saturating_add(first)).collect();
    let mut tets = all(team, &tets)?;
    tets.truncate(limit);
    let least =
        own.least.map(|own| [own.value.to_bits(), u64::from(own.tet.saturating_add(first))]);
    let least =
        all(team, least.as_slice())?.into_iter().map(|[value, tet]| (f64::from_bits(value), tet));
    let least = least.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let least = least.map(|(value, tet)| LeastAngle { value, tet: tet as u32 });
    Ok(SmallAngles { bound: own.bound, count, tets, least })
}
