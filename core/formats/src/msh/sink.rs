//! Numbers on their way into a `.msh` file, as text or as bytes.

use crate::text::{push_integer, push_point, write_rows};
use std::io::{Result, Write};

/// The destination of numbers, and their form.
pub(super) struct Sink<'a> {
    pub(super) out: &'a mut dyn Write,
    pub(super) text: bool,
}

impl Sink<'_> {
    pub(super) fn line(&mut self, text: &str) -> Result<()> {
        writeln!(self.out, "{text}")
    }

    /// The head of a file of this version.
    pub(super) fn head(&mut self, version: &str) -> Result<()> {
        let text = self.text;
        self.line(&format!("$MeshFormat\n{version} {} 8", u8::from(!text)))?;
        if text {
            return self.line("$EndMeshFormat");
        }
        // Tells the byte order.
        self.row(|row| row.int(1))?;
        self.end("MeshFormat")
    }

    /// One row, outside of long lists.
    pub(super) fn row(&mut self, fill: impl Fn(&mut Row<'_>)) -> Result<()> {
        let mut bytes = Vec::new();
        fill(&mut Row { bytes: &mut bytes, text: self.text });
        if self.text {
            bytes.push(b'\n');
        }
        self.out.write_all(&bytes)
    }

    /// A long list, in text a row on a line.
    pub(super) fn rows(
        &mut self,
        rows: usize,
        fill: impl Fn(usize, &mut Row<'_>) + Sync,
    ) -> Result<()> {
        let text = self.text;
        write_rows(self.out, rows, |i, bytes| {
            fill(i, &mut Row { bytes, text });
            if text {
                bytes.push(b'\n');
            }
        })
    }

    /// The end of a section; binary data ends without a line end.
    pub(super) fn end(&mut self, name: &str) -> Result<()> {
        if !self.text {
            self.out.write_all(b"\n")?;
        }
        writeln!(self.out, "$End{name}")
    }
}

/// A row of numbers.
pub(super) struct Row<'a> {
    bytes: &'a mut Vec<u8>,
    text: bool,
}

impl Row<'_> {
    fn blank(&mut self) {
        if self.bytes.last().is_some_and(|&b| b != b'\n') {
            self.bytes.push(b' ');
        }
    }

    pub(super) fn int(&mut self, value: i64) {
        if self.text {
            self.blank();
            push_integer(self.bytes, value);
        } else {
            self.bytes.extend((value as i32).to_le_bytes());
        }
    }

    pub(super) fn size(&mut self, value: u64) {
        if self.text {
            self.blank();
            push_integer(self.bytes, value as i64);
        } else {
            self.bytes.extend(value.to_le_bytes());
        }
    }

    pub(super) fn point(&mut self, point: &[f64; 3]) {
        if self.text {
            self.blank();
            push_point(self.bytes, point, b' ');
        } else {
            point.iter().for_each(|c| self.bytes.extend(c.to_le_bytes()));
        }
    }

    /// The group of an entity; 0: none.
    pub(super) fn group(&mut self, group: i64) {
        self.size(u64::from(group != 0));
        if group != 0 {
            self.int(group);
        }
    }

    /// An integer as the double that it equals.
    pub(super) fn whole(&mut self, value: i64) {
        if self.text {
            self.int(value);
        } else {
            self.bytes.extend((value as f64).to_le_bytes());
        }
    }
}
