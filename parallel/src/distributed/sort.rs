//! Values of all members, sorted: each member gets a stretch of them, in the order of members.

use super::records::{Record, bytes_of, refused, values_of};
use crate::protocol::WorkerId;
use crate::team::{Team, TeamError};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Values of each member that say where the stretches are cut: with that many, none is longer than
/// its share by more than a few hundredths.
const SAMPLES: usize = 64;

/// Brings sorted values of all members where they belong: every member gets a stretch of about
/// equal length, by sender, each sorted: a stable sort merges these. Equal values come to one
/// member.
///
/// # Errors
/// [`TeamError`] if a member has failed, or has sent no such values.
pub(super) fn stretch_of<R>(team: &mut Team, own: &[R]) -> Result<Vec<Vec<R>>, TeamError>
where
    R: Record + Ord + Serialize + DeserializeOwned,
{
    stretch_cut(team, own, |cut| cut)
}

/// As [`stretch_of`], where no stretch begins but at what `begin` makes of a value: the first one
/// of those that are to come to one member.
///
/// # Errors
/// As of [`stretch_of`].
pub(super) fn stretch_cut<R>(
    team: &mut Team,
    own: &[R],
    begin: impl Fn(R) -> R,
) -> Result<Vec<Vec<R>>, TeamError>
where
    R: Record + Ord + Serialize + DeserializeOwned,
{
    let cuts: Vec<R> = cuts(team, own)?.into_iter().map(begin).collect();
    let mut from = 0;
    let mut parts = Vec::with_capacity(team.size() as usize);
    for until in cuts.iter().map(|cut| own.partition_point(|value| value < cut)) {
        // Cuts ascend, whatever was told.
        parts.push(bytes_of(own[from..until.max(from)].iter().copied()));
        from = until.max(from);
    }
    parts.push(bytes_of(own[from..].iter().copied()));
    let stretches = team.exchange(parts)?;
    let by_sender = WorkerId::below(team.size()).zip(&stretches);
    by_sender.map(|(sender, bytes)| Ok(values_of(sender, bytes)?.collect())).collect()
}

/// The place of the first of sorted values that is not below this one; near `last`, if it can be.
pub(super) fn place_in<R: Ord>(own: &R, sorted: &[R], last: usize) -> usize {
    /// Places that are looked at before a search.
    const NEAR: usize = 8;
    let near = || sorted[last..].iter().take(NEAR).position(|other| other >= own);
    match last == 0 || sorted[last - 1] < *own {
        true => near().map(|k| last + k),
        false => None,
    }
    .unwrap_or_else(|| sorted.partition_point(|other| other < own))
}

/// One member's sorted values, as far as the first one knows.
#[derive(Serialize, serde::Deserialize)]
struct Samples<R> {
    length: u64,
    samples: Vec<R>,
}

/// The first values of all stretches but the first: the same at all members. The first one finds
/// them, since many members have many samples.
fn cuts<R>(team: &mut Team, own: &[R]) -> Result<Vec<R>, TeamError>
where
    R: Record + Ord + Serialize + DeserializeOwned,
{
    let count = own.len().min(SAMPLES);
    let samples: Vec<R> = (0..count).map(|k| own[(2 * k + 1) * own.len() / (2 * count)]).collect();
    let members = team.size() as usize;
    let all = team.gather_values(&Samples { length: own.len() as u64, samples })?;
    let cuts = team.tell_value(all.map(|all| cuts_of(all, members)))?;
    match cuts.len() < members {
        true => Ok(cuts),
        false => {
            let place = [members, cuts.len()];
            Err(refused(WorkerId::default(), place, "more stretches than members").into())
        }
    }
}

/// As [`cuts`], by what all members have.
fn cuts_of<R: Record + Ord>(all: Vec<Samples<R>>, members: usize) -> Vec<R> {
    // Each stands for as many values as any other of its member.
    let weigh = |Samples { length, samples }: Samples<R>| {
        let weight = length as f64 / samples.len().max(1) as f64;
        samples.into_iter().map(move |sample| (sample, weight))
    };
    let mut samples: Vec<(R, f64)> = all.into_iter().flat_map(weigh).collect();
    samples.sort_by_key(|&(sample, _)| sample);
    let whole: f64 = samples.iter().map(|&(_, weight)| weight).sum();
    let (mut cuts, mut before) = (Vec::with_capacity(members - 1), 0.0);
    for &(sample, weight) in &samples {
        while cuts.len() + 1 < members && before >= whole * (cuts.len() + 1) as f64 / members as f64
        {
            cuts.push(sample);
        }
        before += weight;
    }
    // All the rest is the last cut's, and of those before it.
    if let Some(&(last, _)) = samples.last() {
        cuts.resize(members - 1, last);
    }
    cuts
}

#[cfg(all(test, not(any(loom, shuttle))))]
mod tests {
    use super::*;
    use crate::team::threads;

    #[test]
    fn places_are_those_of_a_search() {
        let sorted: Vec<u32> = (0..60).map(|k| k * k / 9).collect();
        for last in 0..=sorted.len() {
            for own in 0..=400 {
                let expected = sorted.partition_point(|&other| other < own);
                assert_eq!(place_in(&own, &sorted, last), expected, "{own} from {last}");
            }
        }
    }

    /// A first member that tells more cuts than there are members is refused.
    #[test]
    fn more_stretches_than_members_are_refused() {
        let mut posts = threads(2).into_iter();
        let (first, second) = (posts.next().expect("two"), posts.next().expect("two"));
        std::thread::scope(|scope| {
            scope.spawn(move || {
                let mut team = Team::new(first);
                let own = Samples { length: 0, samples: Vec::<[u64; 5]>::new() };
                let all = team.gather_values(&own).expect("samples");
                assert_eq!(all.map(|all| all.len()), Some(2));
                team.tell_value(Some(vec![[1_u64; 5]; 2])).expect("cuts");
            });
            let refused = cuts(&mut Team::new(second), &[[7_u64; 5]]);
            let why = refused.expect_err("three stretches of two").to_string();
            assert!(why.contains("more stretches than members"), "{why}");
        });
    }
}
