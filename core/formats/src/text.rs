//! Numbers and lines of text files, read from byte slices without a string per line.
//!
//! Cost: one pass; a 64-bit float takes about 30 to 60 ns each way. Floats are written in the
//! shortest form that reads back to the same bits.

use super::error::{ParseError, Reason, excerpt};
use ltbw_exact::Point;
use rayon::prelude::*;
use std::io::Write;

/// A line that is neither blank nor a comment.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    /// The offset of its content in the file.
    pub(super) offset: usize,
    /// Its content, without comment, surrounding blanks and line end.
    pub(super) text: &'a [u8],
}

impl<'a> Line<'a> {
    /// Its values, separated by blanks.
    pub(super) fn fields(self) -> impl Iterator<Item = &'a [u8]> + Clone + use<'a> {
        self.text.split(u8::is_ascii_whitespace).filter(|t| !t.is_empty())
    }
}

/// The lines of a text that carry content. A comment runs from `#` to the end of its line.
pub(super) struct Lines<'a> {
    bytes: &'a [u8],
    next: usize,
}

impl<'a> Lines<'a> {
    /// A leading UTF-8 byte order mark is skipped.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, next: if bytes.starts_with(b"\xEF\xBB\xBF") { 3 } else { 0 } }
    }

    /// The lines from byte `next` on, with which a line begins.
    pub(super) fn from(bytes: &'a [u8], next: usize) -> Self {
        match next {
            0 => Self::new(bytes),
            next => Self { bytes, next },
        }
    }

    /// The lines of a text that has begun before these bytes.
    pub(super) fn inside(bytes: &'a [u8]) -> Self {
        Self { bytes, next: 0 }
    }

    /// Bytes that are not read yet: bounds what a count in a header may reserve.
    pub(super) fn remaining(&self) -> usize {
        self.bytes.len() - self.next
    }

    /// The offset of the next line.
    pub(super) fn position(&self) -> usize {
        self.next
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        // Every turn moves `next` forward, at most to the end.
        while self.next < self.bytes.len() {
            let start = self.next;
            let rest = &self.bytes[start..];
            let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            self.next = start + length + usize::from(length < rest.len());
            let line = &rest[..length];
            let content = line.iter().position(|&b| b == b'#').map_or(line, |c| &line[..c]);
            let lead = content.len() - content.trim_ascii_start().len();
            let text = content.trim_ascii();
            if !text.is_empty() {
                return Some(Line { offset: start + lead, text });
            }
        }
        None
    }
}

/// Values separated by blanks and line ends. A comment runs from `#` to the end of its line.
pub(super) struct Tokens<'a> {
    pub(super) bytes: &'a [u8],
    next: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self::starting_at(bytes, 0)
    }

    /// The values behind the first `next` bytes; errors still count lines from the first.
    pub(super) fn starting_at(bytes: &'a [u8], next: usize) -> Self {
        Self { bytes, next: next.min(bytes.len()) }
    }

    pub(super) fn remaining(&self) -> usize {
        self.bytes.len() - self.next
    }

    /// Just behind the last token that was read.
    pub(super) fn position(&self) -> usize {
        self.next
    }

    /// An error at the last token that was read.
    pub(super) fn error(&self, reason: Reason) -> ParseError {
        ParseError::at(self.bytes, self.next.saturating_sub(1), reason)
    }

    /// The token that `next` will give.
    pub(super) fn peek(&mut self) -> Option<&'a [u8]> {
        let start = self.skip_blanks();
        let rest = &self.bytes[start..];
        let end = rest.iter().position(|&b| b.is_ascii_whitespace() || b == b'#');
        let token = &rest[..end.unwrap_or(rest.len())];
        (!token.is_empty()).then_some(token)
    }

    fn skip_blanks(&mut self) -> usize {
        // Every turn moves `next` forward, at most to the end.
        while let Some(&b) = self.bytes.get(self.next) {
            if b == b'#' {
                let rest = &self.bytes[self.next..];
                self.next += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            } else if b.is_ascii_whitespace() {
                self.next += 1;
            } else {
                break;
            }
        }
        self.next
    }
}

impl<'a> Iterator for Tokens<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let token = self.peek()?;
        self.next += token.len();
        Some(token)
    }
}

/// A finite float.
pub(super) fn float(token: &[u8]) -> Result<f64, Reason> {
    let value = std::str::from_utf8(token).ok().and_then(|s| s.parse::<f64>().ok());
    match value {
        Some(v) if v.is_finite() => Ok(v),
        Some(_) => Err(Reason::NotFinite(excerpt(token))),
        None => Err(Reason::NotANumber(excerpt(token))),
    }
}

/// An integer.
pub(super) fn integer(token: &[u8]) -> Result<i64, Reason> {
    let value = std::str::from_utf8(token).ok().and_then(|s| s.parse::<i64>().ok());
    value.ok_or_else(|| Reason::NotAnInteger(excerpt(token)))
}

/// A count: an integer that is not negative.
pub(super) fn count(token: &[u8]) -> Result<u64, Reason> {
    let value = std::str::from_utf8(token).ok().and_then(|s| s.parse::<u64>().ok());
    value.ok_or_else(|| Reason::NotAnInteger(excerpt(token)))
}

/// The next three values as a point; `before` values of the line were already taken.
pub(super) fn point<'a>(
    fields: &mut impl Iterator<Item = &'a [u8]>,
    before: usize,
) -> Result<Point, Reason> {
    let mut p = [0.0; 3];
    for (k, c) in p.iter_mut().enumerate() {
        let token = fields
            .next()
            .ok_or(Reason::TooFewValues { expected: before + 3, found: before + k })?;
        *c = float(token)?;
    }
    Ok(p)
}

/// A capacity for `announced` elements of at least `bytes_each` bytes that does not believe
/// more than the `remaining` bytes can hold.
pub(super) fn capacity(announced: u64, remaining: usize, bytes_each: usize) -> usize {
    usize::try_from(announced).unwrap_or(usize::MAX).min(remaining / bytes_each + 1)
}

/// Appends the shortest text that reads back to the bits of `value`.
pub(super) fn push_float(out: &mut Vec<u8>, value: f64) {
    let mut buffer = zmij::Buffer::new();
    let text = buffer.format(value).as_bytes();
    out.extend_from_slice(text.strip_suffix(b".0").unwrap_or(text));
}

/// Appends the coordinates of `point`, separated by `separator`.
pub(super) fn push_point(out: &mut Vec<u8>, point: &Point, separator: u8) {
    push_float(out, point[0]);
    out.push(separator);
    push_float(out, point[1]);
    out.push(separator);
    push_float(out, point[2]);
}

/// Appends a decimal integer.
pub(super) fn push_integer(out: &mut Vec<u8>, value: i64) {
    let mut digits = [0_u8; 20];
    let mut at = digits.len();
    let mut rest = value.unsigned_abs();
    // At most 20 turns: u64::MAX has 20 digits.
    loop {
        at -= 1;
        digits[at] = b'0' + (rest % 10) as u8;
        rest /= 10;
        if rest == 0 {
            break;
        }
    }
    if value < 0 {
        out.push(b'-');
    }
    out.extend_from_slice(&digits[at..]);
}

/// Writes rows `0..rows`, formatted by `row` in parallel on the current rayon pool, in order.
/// Memory: a few megabytes for each thread, taken by the calling thread before the others begin.
/// Those ask for more only if rows are long: where little is left, threads that ask at once are
/// refused although there is room, for each tries in passing to get a heap of its own.
pub(super) fn write_rows(
    out: &mut dyn Write,
    rows: usize,
    row: impl Fn(usize, &mut Vec<u8>) + Sync,
) -> std::io::Result<()> {
    const ROWS: usize = 1 << 14;
    const LONG: usize = 96;
    let threads = rayon::current_num_threads().max(1).min(rows.div_ceil(ROWS));
    let room = rows.min(ROWS) * LONG;
    let mut blocks: Vec<Vec<u8>> = (0..threads).map(|_| Vec::with_capacity(room)).collect();
    for start in (0..rows).step_by(ROWS * threads.max(1)) {
        let starts: Vec<usize> = (start..rows).step_by(ROWS).take(threads).collect();
        let filled = starts.len();
        blocks.par_iter_mut().zip(starts).for_each(|(block, s)| {
            block.clear();
            (s..rows.min(s + ROWS)).for_each(|i| row(i, block));
        });
        blocks[..filled].iter().try_for_each(|b| out.write_all(b))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn integers_print_as_std_prints_them() {
        for v in [0, 1, -1, 9, 10, 99, 100, -100, i64::MAX, i64::MIN] {
            let mut out = Vec::new();
            push_integer(&mut out, v);
            assert_eq!(String::from_utf8(out).unwrap(), v.to_string());
        }
    }

    #[test]
    fn lines_skip_blanks_and_comments_and_keep_offsets() {
        let text = b"\xEF\xBB\xBF# head\r\n\r\n  1 2 # tail\n\n3";
        let lines: Vec<_> = Lines::new(text).map(|l| (l.offset, l.text)).collect();
        assert_eq!(lines, [(15, &b"1 2"[..]), (27, &b"3"[..])]);
    }

    proptest! {
        #[test]
        fn floats_survive_on_bits(bits in any::<u64>()) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            let mut out = Vec::new();
            push_float(&mut out, value);
            prop_assert!(out.len() <= 24);
            prop_assert_eq!(float(&out).unwrap().to_bits(), bits);
        }
    }
}
