//! Questions to other members, each of which knows a stretch of numbers.

use super::Slice;
use super::records::{Record, bytes_of, refused, values_of};
use crate::protocol::WorkerId;
use crate::team::{Team, TeamError};
use rayon::prelude::*;

/// The answers to what this member asks for, `asked`, ascending. Member k knows the numbers from
/// `firsts[k]` to before `firsts[k + 1]`; to one that it does not know it has no answer, and says
/// so of whoever has asked.
///
/// # Errors
/// [`TeamError`] if a member has failed, or has sent what makes no sense.
pub(crate) fn ask<R>(
    team: &mut Team,
    asked: &[u32],
    firsts: &[u64],
    answer: impl Fn(u32) -> Option<R> + Sync,
) -> Result<Vec<R>, TeamError>
where
    R: Record + Send,
{
    let mut questions = Vec::with_capacity(team.size() as usize);
    let mut counts = Vec::with_capacity(team.size() as usize);
    let mut from = 0;
    for member in WorkerId::below(team.size()) {
        let end = firsts.get(member.index() + 1).copied().unwrap_or(u64::MAX);
        let until = asked.partition_point(|&number| u64::from(number) < end).max(from);
        questions.push(bytes_of(asked[from..until].iter().copied()));
        counts.push(until - from);
        from = until;
    }
    let questions = team.exchange(questions)?;
    let mut answers = Vec::with_capacity(questions.len());
    for (from, bytes) in WorkerId::below(team.size()).zip(&questions) {
        let numbers: Vec<u32> = values_of(from, bytes)?.collect();
        let known: Vec<Option<R>> = numbers.par_iter().map(|&number| answer(number)).collect();
        if let Some(k) = known.iter().position(Option::is_none) {
            return Err(refused(from, [4 * k, bytes.len()], "a number of nothing here").into());
        }
        let known: Vec<R> = known.into_iter().flatten().collect();
        answers.push(bytes_of(known.into_iter()));
    }
    drop(questions);
    let answers = team.exchange(answers)?;
    let mut all = Vec::with_capacity(asked.len());
    for ((from, bytes), count) in WorkerId::below(team.size()).zip(&answers).zip(counts) {
        if bytes.len() != count * R::BYTES {
            return Err(refused(from, [0, bytes.len()], "not as many answers as questions").into());
        }
        all.extend(values_of::<R>(from, bytes)?);
    }
    Ok(all)
}

/// The tags of points by their numbers, ascending, if those of all slices have tags: the own ones
/// are `tags`.
///
/// # Errors
/// [`TeamError`] if a member has failed, or has sent what makes no sense.
pub fn tags(
    team: &mut Team,
    slice: &Slice,
    tags: Option<&[i64]>,
    numbers: &[u32],
) -> Result<Option<Vec<i64>>, TeamError> {
    let has_none = tags.is_none_or(|tags| tags.len() != slice.points().len());
    if team.is_any(has_none)? {
        return Ok(None);
    }
    let tag = |number: u32| {
        let place = number.checked_sub(slice.first())?;
        tags?.get(place as usize).map(|&tag| tag as u64)
    };
    let told: Vec<u64> = ask(team, numbers, slice.firsts(), tag)?;
    Ok(Some(told.into_iter().map(|tag| tag as i64).collect()))
}
