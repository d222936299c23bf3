//! Borders of the parts of all members: `ltbw_formats` knows what is to be told; this tells it.

use super::records::{Record, bytes_of, refused, values_of};
use crate::protocol::WorkerId;
use crate::team::{Team, TeamError};
use ltbw_formats::{Border, BorderError, Bordering, PartOf, Piece, Words};

/// The border of this member's part: all that it has in common with those of others.
///
/// Cost: two sorts of the own faces; four exchanges of what is at the own surface.
///
/// # Errors
/// [`TeamError`] if a member has failed, has a part that is none, or has sent what makes no sense.
pub fn border(team: &mut Team, piece: &Piece) -> Result<Border, TeamError> {
    let found = border_of(team, piece);
    if found.is_err() {
        // Others may wait for this one.
        team.fail();
    }
    found
}

fn border_of(team: &mut Team, piece: &Piece) -> Result<Border, TeamError> {
    let place = PartOf { part: team.me().index(), of: team.size() as usize };
    let (mut own, words) = Bordering::begin(piece, place).map_err(odd)?;
    let asked = exchange(team, words)?;
    let answers = exchange(team, own.meet(&asked).map_err(odd)?)?;
    drop(asked);
    let told = exchange(team, own.number(&answers).map_err(odd)?)?;
    drop(answers);
    let sent = exchange(team, own.reach(&told).map_err(odd)?)?;
    own.finish(&sent).map_err(odd)
}

/// Words of all members for this one.
fn exchange(team: &mut Team, words: Words) -> Result<Words, TeamError> {
    let bytes = words.into_iter().map(|words| bytes_of(words.into_iter())).collect();
    let bytes = team.exchange(bytes)?;
    let each = WorkerId::below(team.size()).zip(&bytes);
    each.map(|(from, bytes)| Ok(values_of(from, bytes)?.collect())).collect()
}

/// The error for words of a member.
fn odd(error: BorderError) -> TeamError {
    let BorderError { part, at, length, what } = error;
    refused(WorkerId::new(part as u32), [at, length].map(|words| words * u64::BYTES), what).into()
}
