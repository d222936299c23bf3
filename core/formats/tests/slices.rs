//! Slices of point files: all together are the whole, and what is wrong has the whole file's words.

use ltbw_formats::slices::{Size, Slice, Slices};
use ltbw_formats::{self as io, Format, IoError, PartOf, PointFile};
use proptest::prelude::*;
use std::path::Path;

/// Reads a file by several readers, one after the other, as they would tell each other.
fn by_slices(path: &Path, format: Format, of: usize) -> Result<PointFile, IoError> {
    let open = || Ok::<_, IoError>(Slices::open(path, format)?.expect("a format that is cut"));
    let (head, length) = (open()?.head().to_vec(), open()?.length());
    let slices = (0..of).map(|part| open()?.slice(PartOf { part, of }));
    let slices: Vec<Slice> = slices.collect::<Result<_, _>>()?;
    // Each byte behind the head is in one slice.
    let mut ranges: Vec<_> = slices.iter().flat_map(Slice::ranges).cloned().collect();
    ranges.retain(|range| !range.is_empty());
    ranges.sort_by_key(|range| range.start);
    let ends = ranges.iter().map(|range| range.end);
    let starts = ranges.iter().map(|range| range.start).chain([length]);
    assert!([head.len() as u64].into_iter().chain(ends).eq(starts), "{of}: {ranges:?}");
    let mut before = Size::default();
    let mut whole: Option<PointFile> = None;
    for slice in slices {
        let Size { lines, points } = slice.size();
        let file = slice.parse(&head, before)?;
        assert_eq!(file.points.len() as u64, points);
        before = Size { lines: before.lines + lines, points: before.points + points };
        whole = Some(match whole {
            None => file,
            Some(mut whole) => {
                whole.points.extend(file.points);
                whole.notes.extend(file.notes);
                whole.notes.dedup();
                whole.point_tags = whole.point_tags.zip(file.point_tags).map(|(mut all, own)| {
                    all.extend(own);
                    all
                });
                whole
            }
        });
    }
    Ok(whole.unwrap_or_default())
}

/// Compares slices with the whole; whether the file is read.
fn compare(bytes: &[u8], format: Format) -> bool {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points").with_extension(format.extension());
    std::fs::write(&path, bytes).unwrap();
    let whole = io::read_points(&path);
    for of in [1, 2, 3, 5, 8, 64] {
        match (&whole, by_slices(&path, format, of)) {
            (Ok(whole), Ok(read)) => assert_eq!(*whole, read, "{of} slices"),
            (Err(whole), Err(error)) => assert_eq!(whole.to_string(), error.to_string(), "{of}"),
            (whole, read) => panic!("{of} slices: {read:?}, not {whole:?}"),
        }
    }
    whole.is_ok()
}

/// Lines of text, most of them a point, and their ends.
fn text() -> impl Strategy<Value = String> {
    let number = || prop_oneof![(-99_i32..99).prop_map(|n| n.to_string()), Just("1e-3".to_owned())];
    let point = [number(), number(), number()].prop_map(|p| p.join(","));
    let line = prop_oneof![
        40 => point,
        4 => Just(String::new()),
        4 => Just("# 1 2 3".to_owned()),
        1 => Just("  ".to_owned()),
        1 => prop_oneof![Just("4,5,6,7"), Just("nan,0,0"), Just("1,2"), Just("x")]
            .prop_map(str::to_owned),
    ];
    let end = prop_oneof![5 => Just("\n"), 1 => Just("\r\n")];
    (proptest::collection::vec((line, end), 0..40), any::<[bool; 2]>()).prop_map(
        |(lines, [mark, open])| {
            let mut text: String = lines.into_iter().flat_map(|(l, e)| [l, e.to_owned()]).collect();
            if open {
                text.pop();
            }
            if mark { format!("\u{feff}{text}") } else { text }
        },
    )
}

/// A `.node` file of these lines, which have no number.
fn node(text: &str, [first, header, tagged]: [u64; 3]) -> String {
    let lines = text.trim_start_matches('\u{feff}').lines().map(|line| line.replace(',', " "));
    let (mut next, mut body) = (first, String::new());
    for line in lines {
        let is_point = !line.trim().is_empty() && !line.starts_with('#');
        match is_point {
            true if tagged == 1 => body += &format!("{next} {line} {}\n", next * 3),
            true => body += &format!("{next} {line}\n"),
            false => body += &format!("{line}\n"),
        }
        next += u64::from(is_point);
    }
    format!("# points\n{} 3 0 {tagged}\n{body}", next - first + header)
}

proptest! {
    #[test]
    fn texts(text in text(), header in 0..4_usize, numbers in [0..2_u64, 0..3, 0..2]) {
        compare(text.replace(',', " ").as_bytes(), Format::Xyz);
        compare(text.as_bytes(), Format::Txt);
        let header = ["", "x,y,z\n", "# none\n\ny,x,tag,z,more\n", "tag,z,y,x\n"][header];
        compare(format!("{header}{text}").as_bytes(), Format::Csv);
        let [first, surplus, tagged] = numbers;
        compare(node(&text, [first, surplus, tagged]).as_bytes(), Format::Node);
    }

    #[test]
    fn arrays(
        values in proptest::collection::vec(any::<[i16; 3]>(), 0..40),
        bad in 0..80_usize,
        [fortran, short] in any::<[bool; 2]>(),
    ) {
        let n = values.len();
        let value = |k: usize, i: usize| match i == bad && k == 1 {
            true => f64::NAN,
            false => f64::from(values[i][k]),
        };
        let at = |j: usize| if fortran { value(j / n, j % n) } else { value(j % 3, j / 3) };
        let order = if fortran { "True" } else { "False" };
        let header =
            format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': ({n}, 3), }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend((0..3 * n).flat_map(|j| at(j).to_le_bytes()));
        if short {
            bytes.pop();
        }
        let is_read = compare(&bytes, Format::Npy);
        prop_assert_eq!(is_read, bad >= n && !short);
    }
}

#[test]
fn sound_files_of_all_formats_are_read() {
    let points = "1,2,3\n4,5,6\n# no\n7,8,9\n";
    assert!(compare(points.replace(',', " ").as_bytes(), Format::Xyz));
    assert!(compare(points.as_bytes(), Format::Txt));
    assert!(compare(format!("x,y,tag,z\n{}", "1,2,3,4\n".repeat(9)).as_bytes(), Format::Csv));
    for tagged in [0, 1] {
        assert!(compare(node(points, [1, 0, tagged]).as_bytes(), Format::Node));
        assert!(!compare(node(points, [0, 1, tagged]).as_bytes(), Format::Node), "one too few");
    }
    assert!(!compare("3 3 0 0\n0 1 2 3\n1 1 2 3\n".as_bytes(), Format::Node), "too few");
    assert!(!compare("1 3 0 0\n0 1 2 3\n1 1 2 3\n".as_bytes(), Format::Node), "too many");
    assert!(!compare("1\u{0} 2\u{0}\n\u{0}3\u{0} ".as_bytes(), Format::Xyz), "UTF-16");
}

#[test]
fn what_is_no_file_and_what_is_not_cut() {
    let folder = tempfile::tempdir().unwrap();
    let error = Slices::open(folder.path(), Format::Npy).unwrap_err();
    assert!(error.to_string().contains("not a regular file"), "{error}");
    assert!(Slices::open(folder.path().join("none.xyz"), Format::Xyz).is_err());
    for format in [Format::Npz, Format::Ply, Format::Stl, Format::Obj, Format::Off] {
        assert!(Slices::open("anything", format).unwrap().is_none(), "{format:?}");
    }
}
