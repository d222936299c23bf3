//! The numbers of a `.msh` file, whether they are text or binary.

use crate::error::{ParseError, Place, Reason, excerpt};
use crate::scalar::{Kind, Scalar};
use crate::text;

/// The storage of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Form {
    /// Decimal text.
    Text,
    /// Binary; `size` is the number of bytes of a count.
    Binary { big_endian: bool, size: usize },
}

/// A file and a place in it.
pub(super) struct Source<'a> {
    bytes: &'a [u8],
    next: usize,
    /// The offset of the number that was read last.
    last: usize,
    form: Form,
}

impl<'a> Source<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, next: 0, last: 0, form: Form::Text }
    }

    pub(super) fn set_form(&mut self, form: Form) {
        self.form = form;
    }

    pub(super) fn is_text(&self) -> bool {
        self.form == Form::Text
    }

    /// Bytes that are not read yet.
    pub(super) fn remaining(&self) -> usize {
        self.bytes.len() - self.next
    }

    /// An error at the number or line that was read last.
    pub(super) fn error(&self, reason: Reason) -> ParseError {
        match self.form {
            Form::Text => ParseError::at(self.bytes, self.last, reason),
            Form::Binary { .. } => ParseError::new(Place::Byte(self.last as u64), reason),
        }
    }

    /// The next line that is not blank, without surrounding blanks; text also in binary files.
    pub(super) fn line(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.next..];
        self.next += rest.len() - rest.trim_ascii_start().len();
        self.last = self.next;
        let rest = &self.bytes[self.next..];
        if rest.is_empty() {
            return None;
        }
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.next += length + usize::from(length < rest.len());
        Some(rest[..length].trim_ascii())
    }

    /// The next line, which must be there.
    pub(super) fn expect_line(&mut self) -> Result<&'a [u8], ParseError> {
        match self.line() {
            Some(line) => Ok(line),
            None => Err(self.error(Reason::Syntax("the file ends inside a section".into()))),
        }
    }

    /// Checks that the next line is the end of section `name` (without its `$`).
    pub(super) fn end(&mut self, name: &str) -> Result<(), ParseError> {
        let line = self.expect_line()?;
        if line.strip_prefix(b"$End") == Some(name.as_bytes()) {
            return Ok(());
        }
        let text = format!("`{}` where `$End{name}` was expected", excerpt(line));
        Err(self.error(Reason::Syntax(text)))
    }

    /// Goes behind the end of section `name` (without its `$`).
    pub(super) fn skip_section(&mut self, name: &[u8]) -> Result<(), ParseError> {
        let mut from = self.next;
        // Every turn moves `from` forward.
        while let Some(at) = self.bytes[from..].iter().position(|&b| b == b'$') {
            from += at + 1;
            let word = self.bytes[from..].strip_prefix(b"End").and_then(|r| r.strip_prefix(name));
            if word.is_some_and(|rest| rest.first().is_none_or(u8::is_ascii_whitespace)) {
                self.next = from + 3 + name.len();
                return Ok(());
            }
        }
        let text = format!("the file ends inside `${}`", excerpt(name));
        Err(self.error(Reason::Syntax(text)))
    }

    /// The bytes of the next number: a token of text, or `bytes` bytes; `None` where the file
    /// ends. A section's end is no number: text that ends early stops there.
    fn raw(&mut self, bytes: usize) -> Result<&'a [u8], Reason> {
        let rest = &self.bytes[self.next..];
        let (skip, length) = match self.form {
            Form::Text => {
                let token = rest.trim_ascii_start();
                let length = token.iter().position(u8::is_ascii_whitespace);
                (rest.len() - token.len(), length.unwrap_or(token.len()))
            }
            Form::Binary { .. } => (0, bytes.min(rest.len())),
        };
        self.last = self.next + skip;
        let raw = &rest[skip..skip + length];
        if raw.is_empty() || (self.form != Form::Text && length < bytes) {
            return Err(Reason::Syntax("the file ends inside a section".into()));
        }
        self.next += skip + length;
        Ok(raw)
    }

    fn scalar(&self, kind: Kind, bytes: usize) -> Scalar {
        let big_endian = matches!(self.form, Form::Binary { big_endian: true, .. });
        Scalar { kind, bytes, big_endian }
    }

    /// A signed integer, in binary of 4 bytes.
    pub(super) fn int(&mut self) -> Result<i64, ParseError> {
        let raw = self.raw(4).map_err(|r| self.error(r))?;
        let value = match self.form {
            Form::Text => text::integer(raw),
            Form::Binary { .. } => self.scalar(Kind::Signed, 4).integer(raw),
        };
        value.map_err(|r| self.error(r))
    }

    /// A count or the number of a node or element, in binary of 4 or 8 bytes.
    pub(super) fn size(&mut self) -> Result<u64, ParseError> {
        let bytes = if let Form::Binary { size, .. } = self.form { size } else { 8 };
        let raw = self.raw(bytes).map_err(|r| self.error(r))?;
        match self.form {
            Form::Text => text::count(raw).map_err(|r| self.error(r)),
            Form::Binary { .. } => Ok(self.scalar(Kind::Unsigned, bytes).word(raw)),
        }
    }

    /// A count or number that is an `int` of 4 bytes in the older version.
    pub(super) fn small_size(&mut self) -> Result<u64, ParseError> {
        let value = self.int()?;
        let negative = |_| Reason::NotAnInteger(value.to_string());
        u64::try_from(value).map_err(negative).map_err(|r| self.error(r))
    }

    /// A finite float.
    pub(super) fn double(&mut self) -> Result<f64, ParseError> {
        let raw = self.raw(8).map_err(|r| self.error(r))?;
        let value = match self.form {
            Form::Text => text::float(raw),
            Form::Binary { .. } => self.scalar(Kind::Float, 8).float(raw),
        };
        value.map_err(|r| self.error(r))
    }

    /// The first `N` of `count` numbers, which are no fewer, that `read` reads.
    pub(super) fn first<const N: usize>(
        &mut self,
        count: u64,
        read: fn(&mut Self) -> Result<u64, ParseError>,
    ) -> Result<[u64; N], ParseError> {
        let mut numbers = [0; N];
        for number in &mut numbers {
            *number = read(self)?;
        }
        self.skip(count - N as u64, read)?;
        Ok(numbers)
    }

    /// Reads `count` numbers with `read` and forgets them.
    pub(super) fn skip<T>(
        &mut self,
        count: u64,
        read: fn(&mut Self) -> Result<T, ParseError>,
    ) -> Result<(), ParseError> {
        // At most as many turns as there are bytes.
        for _ in 0..count {
            read(self)?;
        }
        Ok(())
    }
}
