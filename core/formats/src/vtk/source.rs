//! Lines and numbers of legacy VTK files, text or big-endian binary.

use crate::error::{ParseError, Reason, excerpt};
use crate::scalar::{Kind, Scalar};
use crate::text::{Tokens, capacity, float, integer};

/// A file that is being read.
pub(super) struct Source<'a> {
    bytes: &'a [u8],
    next: usize,
    /// The start of the last line.
    start: usize,
    pub(super) binary: bool,
}

impl<'a> Source<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, next: 0, start: 0, binary: false }
    }

    /// An error in the last line.
    pub(super) fn error(&self, reason: Reason) -> ParseError {
        ParseError::at(self.bytes, self.start, reason)
    }

    pub(super) fn syntax(&self, text: impl Into<String>) -> ParseError {
        self.error(Reason::Syntax(text.into()))
    }

    /// The next line as it is, without its end and blanks around it.
    pub(super) fn raw_line(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.next..).filter(|rest| !rest.is_empty())?;
        self.start = self.next;
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.next += length + usize::from(length < rest.len());
        Some(rest[..length].trim_ascii())
    }

    /// The words of the next line that has some.
    pub(super) fn words(&mut self) -> Option<Vec<&'a [u8]>> {
        // Every turn consumes a line.
        loop {
            let line = self.raw_line()?;
            if !line.is_empty() {
                let words = line.split(u8::is_ascii_whitespace);
                return Some(words.filter(|word| !word.is_empty()).collect());
            }
        }
    }

    /// The words of the line that comes next, which is not consumed.
    pub(super) fn peek(&mut self) -> Option<Vec<&'a [u8]>> {
        let before = (self.next, self.start);
        let words = self.words();
        (self.next, self.start) = before;
        words
    }

    /// `count` floats.
    pub(super) fn floats(&mut self, kind: Type, count: u64) -> Result<Vec<f64>, ParseError> {
        self.values(kind, count, float, Scalar::float)
    }

    /// `count` integers.
    pub(super) fn integers(&mut self, kind: Type, count: u64) -> Result<Vec<i64>, ParseError> {
        self.values(kind, count, integer, Scalar::integer)
    }

    fn values<T>(
        &mut self,
        kind: Type,
        count: u64,
        text: fn(&[u8]) -> Result<T, Reason>,
        binary: fn(Scalar, &[u8]) -> Result<T, Reason>,
    ) -> Result<Vec<T>, ParseError> {
        let Type::Number(scalar) = kind else {
            return Err(self.syntax("bits where numbers were expected"));
        };
        if self.binary {
            let raw = self.raw(count, scalar.bytes)?;
            let values: Result<_, _> =
                raw.chunks_exact(scalar.bytes).map(|v| binary(scalar, v)).collect();
            return values.map_err(|r| self.error(r));
        }
        let mut tokens = Tokens::starting_at(self.bytes, self.next);
        let mut values = Vec::with_capacity(capacity(count, tokens.remaining(), 2));
        for found in 0..count {
            let what = "values";
            let early = Reason::Truncated { what, announced: count, found };
            let token = tokens.next().ok_or(early).map_err(|r| tokens.error(r))?;
            values.push(text(token).map_err(|r| tokens.error(r))?);
        }
        self.next = tokens.position();
        Ok(values)
    }

    /// Passes over `count` values.
    pub(super) fn skip(&mut self, kind: Type, count: u64) -> Result<(), ParseError> {
        match (self.binary, kind) {
            (true, Type::Bit) => self.raw(count.div_ceil(8), 1).map(drop),
            (true, Type::Number(scalar)) => self.raw(count, scalar.bytes).map(drop),
            (false, _) => {
                let mut tokens = Tokens::starting_at(self.bytes, self.next);
                for found in 0..count {
                    let early = Reason::Truncated { what: "values", announced: count, found };
                    tokens.next().ok_or(early).map_err(|r| tokens.error(r))?;
                }
                self.next = tokens.position();
                Ok(())
            }
        }
    }

    /// The bytes of `count` numbers of `each` bytes.
    fn raw(&mut self, count: u64, each: usize) -> Result<&'a [u8], ParseError> {
        let rest = self.bytes.get(self.next..).unwrap_or_default();
        let length = usize::try_from(count).ok().and_then(|count| count.checked_mul(each));
        match length.and_then(|length| rest.get(..length)) {
            Some(raw) => {
                self.next += raw.len();
                Ok(raw)
            }
            None => {
                let found = (rest.len() / each) as u64;
                Err(self.error(Reason::Truncated { what: "values", announced: count, found }))
            }
        }
    }

    /// The type of values that a word names.
    pub(super) fn kind(&self, name: &[u8]) -> Result<Type, ParseError> {
        let number = |kind, bytes| Ok(Type::Number(Scalar { kind, bytes, big_endian: true }));
        match name.to_ascii_lowercase().as_slice() {
            b"bit" => Ok(Type::Bit),
            b"char" | b"signed_char" => number(Kind::Signed, 1),
            b"unsigned_char" => number(Kind::Unsigned, 1),
            b"short" => number(Kind::Signed, 2),
            b"unsigned_short" => number(Kind::Unsigned, 2),
            b"int" | b"vtkidtype" | b"vtktypeint32" => number(Kind::Signed, 4),
            b"unsigned_int" | b"vtktypeuint32" => number(Kind::Unsigned, 4),
            b"long" | b"vtktypeint64" => number(Kind::Signed, 8),
            b"unsigned_long" | b"vtktypeuint64" => number(Kind::Unsigned, 8),
            b"float" => number(Kind::Float, 4),
            b"double" => number(Kind::Float, 8),
            _ => {
                let text = format!("values of type `{}`", excerpt(name));
                Err(self.error(Reason::Unsupported(text)))
            }
        }
    }
}

/// A type of values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Type {
    /// Eight to the byte in binary files.
    Bit,
    Number(Scalar),
}

impl Type {
    /// The type of lists of cells in files before version 5.
    pub(super) const INT: Type =
        Type::Number(Scalar { kind: Kind::Signed, bytes: 4, big_endian: true });

    /// The type of colours in binary files.
    pub(super) const BYTE: Type =
        Type::Number(Scalar { kind: Kind::Unsigned, bytes: 1, big_endian: true });

    pub(super) fn is_whole(self) -> bool {
        matches!(self, Type::Number(scalar) if scalar.kind != Kind::Float)
    }
}
