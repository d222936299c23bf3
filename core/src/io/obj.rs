//! `.obj`: Wavefront's object files, read as points.
//!
//! Read: the coordinates of every statement `v`. Weights and colours behind them, and all other
//! statements, are not read; a note says so.
//! Source: Wavefront, "Advanced Visualizer Manual", appendix B1.

use super::PointFile;
use super::error::{ParseError, Reason, excerpt};
use super::text::{Lines, point};

/// The statements of the format, other than `v`, sorted.
const OTHER: &[&[u8]] = &[
    b"bevel",
    b"bmat",
    b"bsp",
    b"bzp",
    b"c_interp",
    b"call",
    b"cdc",
    b"cdp",
    b"con",
    b"csh",
    b"cstype",
    b"ctech",
    b"curv",
    b"curv2",
    b"d_interp",
    b"deg",
    b"end",
    b"f",
    b"fo",
    b"g",
    b"hole",
    b"l",
    b"lod",
    b"maplib",
    b"mg",
    b"mtllib",
    b"o",
    b"p",
    b"parm",
    b"res",
    b"s",
    b"scrv",
    b"shadow_obj",
    b"sp",
    b"stech",
    b"step",
    b"surf",
    b"trace_obj",
    b"trim",
    b"usemap",
    b"usemtl",
    b"vn",
    b"vp",
    b"vt",
];

/// Reads an `.obj` file.
pub fn read(bytes: &[u8]) -> Result<PointFile, ParseError> {
    let mut file = PointFile::default();
    let (mut more, mut others) = (false, false);
    // A line that ends in a backslash goes on in the next; coordinates are never split so.
    let mut continued = false;
    for line in Lines::new(bytes) {
        let at = |reason| ParseError::at(bytes, line.offset, reason);
        let mut fields = line.fields();
        let word = fields.next().unwrap_or_default();
        if !continued && word == b"v" {
            file.points.push(point(&mut fields, 0).map_err(at)?);
            more |= fields.next().is_some();
        } else if continued || OTHER.binary_search(&word).is_ok() {
            others = true;
            continued = line.text.ends_with(b"\\");
        } else {
            let text = format!("`{}` is no statement of an OBJ file", excerpt(word));
            return Err(at(Reason::Syntax(text)));
        }
    }
    if more {
        file.notes.push("values after the third of a vertex are not read".to_owned());
    }
    if others {
        file.notes.push("statements other than `v` are not read".to_owned());
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_of_statements_is_sorted() {
        assert!(OTHER.is_sorted());
    }

    #[test]
    fn vertices_among_other_statements() {
        let text = b"# c\nmtllib a.mtl\no x\nv 1 2 3 1.0\nvn 0 0 1\nv -1e-3 0 5\nf 1 2 \\\n 1\n";
        let file = read(text).unwrap();
        assert_eq!(file.points, [[1.0, 2.0, 3.0], [-1e-3, 0.0, 5.0]]);
        assert_eq!(file.notes.len(), 2);
        let says = |text: &str| read(text.as_bytes()).expect_err(text).to_string();
        assert_eq!(says("v 1 2\n"), "line 1: expected 3 values, found 2");
        assert_eq!(says("v 1 2 inf\n"), "line 1: `inf` is not a finite number");
        assert_eq!(says("v 0 0 0\nhello\n"), "line 2: `hello` is no statement of an OBJ file");
    }
}
