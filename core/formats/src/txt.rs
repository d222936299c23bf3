//! `.txt`: one point on a line, as `numpy.savetxt` writes it: coordinates separated by blanks, or
//! by commas where the line has one.
//!
//! Blank lines and comments (from `#` to the end of the line) are skipped. Values after the third
//! are not read; a note says so.

use super::PointFile;
use super::error::{ParseError, Reason};
use super::text::{Line, Lines};
pub use super::xyz::write;
use super::xyz::{FirstPoint, first_point, read_lines};

/// Reads a `.txt` file.
pub fn read(bytes: &[u8]) -> Result<PointFile, ParseError> {
    read_lines(bytes, Lines::new(bytes), parse)
}

/// The point of a line.
pub(super) fn parse(line: Line<'_>) -> Result<FirstPoint, Reason> {
    match line.text.contains(&b',') {
        // An empty field is no number: columns must not move.
        true => first_point(&mut line.text.split(|&b| b == b',').map(<[u8]>::trim_ascii)),
        false => first_point(&mut line.fields()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blanks_and_commas_and_comments() {
        let numpy = b"# x y z\n1.000000000000000000e+00 -2.5e+00 0.0\n4,5 , 6\n\n 7\t8 9 # last\n";
        let file = read(numpy).expect("numbers");
        assert_eq!(file.points, [[1.0, -2.5, 0.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]);
        assert!(file.notes.is_empty());
        assert_eq!(read(b"1 2 3 4\n1,2,3,\n").expect("numbers").notes.len(), 1);
        assert_eq!(read(b"# nothing\n").expect("no points"), PointFile::default());
        let says = |text: &str| read(text.as_bytes()).expect_err(text).to_string();
        assert_eq!(says("1 2 3\n1 2\n"), "line 2: expected 3 values, found 2");
        assert_eq!(says("1,,2,3"), "line 1: `` is not a number");
        assert_eq!(says("1;2;3"), "line 1: `1;2;3` is not a number");
        assert_eq!(says("1 2 inf"), "line 1: `inf` is not a finite number");
    }
}
