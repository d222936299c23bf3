//! Words that parts of a mesh send each other, looked at before use.

use crate::error::BorderError;

/// Words by part: of the receiver on their way out, of the sender on their way in.
pub type Words = Vec<Vec<u64>>;

/// Some words of a part.
pub(super) fn numbers(
    part: usize,
    words: &[u64],
    at: usize,
    count: usize,
) -> Result<&[u64], BorderError> {
    let end = at.checked_add(count);
    end.and_then(|end| words.get(at..end)).ok_or(BorderError {
        part,
        at: words.len(),
        length: words.len(),
        what: "the words end too early",
    })
}

/// A word that is a number below a bound.
pub(super) fn place(
    part: usize,
    words: &[u64],
    at: usize,
    below: usize,
) -> Result<usize, BorderError> {
    let word = numbers(part, words, at, 1)?[0];
    let fits = usize::try_from(word).ok().filter(|&word| word < below);
    let what = "a number that is too large";
    fits.ok_or(BorderError { part, at, length: words.len(), what })
}

/// Three numbers of two words.
pub(super) fn triple(first: u64, second: u64) -> [u32; 3] {
    [(first >> 32) as u32, first as u32, second as u32]
}
