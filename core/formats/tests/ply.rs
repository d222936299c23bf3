//! `.ply`: round trips on bits, both byte orders, and malformed input.

use ltbw_formats as io;
use ltbw_formats::{
    DataError, Encoding, IoError, ParseError, PointFile, WriteOptions, obj, off, ply, stl,
};
use proptest::prelude::*;
use std::path::Path;

use crate::strategies::{bits, float_tags, meshes};

const ENCODINGS: [Encoding; 2] = [Encoding::Binary, Encoding::Ascii];

fn written(file: &PointFile, encoding: Encoding) -> Vec<u8> {
    let mut out = Vec::new();
    ply::write(&mut out, &file.points, file.point_tags.as_deref(), encoding).expect("tags fit");
    out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn points_and_tags_survive_on_bits(mesh in meshes(), small in any::<bool>()) {
        let tags = float_tags(&mesh.point_tags);
        let tags = if small { tags.map(|t| t.iter().map(|v| v >> 22).collect()) } else { tags };
        let file = PointFile { points: mesh.points, point_tags: tags, notes: Vec::new() };
        for encoding in ENCODINGS {
            let back = ply::read(&written(&file, encoding)).unwrap();
            prop_assert_eq!(bits(&back.points), bits(&file.points), "{:?}", encoding);
            prop_assert_eq!(&back.point_tags, &file.point_tags, "{:?}", encoding);
            prop_assert!(back.notes.is_empty());
        }
    }

    /// Cutting and overwriting bytes gives points or an error of one line, never a panic.
    #[test]
    fn damaged_files_are_errors_of_one_line(
        mesh in meshes(),
        cut in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(),
        byte in any::<u8>(),
    ) {
        let tags = float_tags(&mesh.point_tags);
        let file = PointFile { points: mesh.points, point_tags: tags, notes: Vec::new() };
        for encoding in ENCODINGS {
            let mut bytes = written(&file, encoding);
            let i = at.index(bytes.len());
            bytes[i] = byte;
            bytes.truncate(cut.index(2 * bytes.len()));
            if let Err(error) = ply::read(&bytes) {
                let text = error.to_string();
                prop_assert!(!text.contains('\n') && text.len() < 300, "{text:?}");
            }
        }
    }

    #[test]
    fn any_bytes_are_read_without_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        head in prop::sample::select(vec!["", "OFF\n3 0 0\n", "solid ", "v ", "ply\nformat "]),
    ) {
        let bytes = [head.as_bytes(), &bytes].concat();
        let _ = (ply::read(&bytes), off::read(&bytes), obj::read(&bytes), stl::read(&bytes));
    }
}

/// A file with `header` between the first and the last line of one, and `body` behind.
fn file(header: &str, body: &[u8]) -> Result<PointFile, ParseError> {
    let mut bytes = format!("ply\n{header}end_header\n").into_bytes();
    bytes.extend(body);
    ply::read(&bytes)
}

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";

#[test]
fn byte_orders_types_lists_and_other_elements() {
    let mut body = Vec::new();
    // Two cells with lists, then two vertices with a tag, a list and a colour.
    for list in [&[7_u8, 8, 9][..], &[]] {
        body.extend((list.len() as u16).to_be_bytes());
        body.extend(list);
    }
    for (p, tag) in [([1.5_f32, -2.0, 3.25], -5_i16), ([0.0, 1.0, 2.0], 300)] {
        body.extend(tag.to_be_bytes());
        body.extend([1, 0xaa]);
        p.iter().for_each(|c| body.extend(c.to_be_bytes()));
        body.push(255);
    }
    body.extend(b"faces, not looked at");
    let header = format!(
        "format binary_big_endian 1.0\ncomment by hand\nelement cell 2\n\
         property list ushort uchar v\nelement vertex 2\nproperty short tag\n\
         property list uchar uint8 more\n{XYZ}property uchar red\nelement face 3\n\
         property list uchar int vertex_indices\n"
    );
    let back = file(&header, &body).unwrap();
    assert_eq!(back.points, [[1.5, -2.0, 3.25], [0.0, 1.0, 2.0]]);
    assert_eq!(back.point_tags, Some(vec![-5, 300]));
    assert_eq!(back.notes.len(), 2);

    let header = format!(
        "format ascii 1.0\r\nelement cell 2\nproperty list int int v\nelement vertex 1\n{XYZ}\
         property double tag\n"
    );
    let back = file(&header, b"3 1 2 3\n0\n0.1 2 3 0.5\n").unwrap();
    assert_eq!(back.points, [[0.1, 2.0, 3.0]]);
    assert_eq!(back.point_tags, None);
    assert!(back.notes.contains(&"the property `tag` is not read: it is not integers".to_owned()));
}

#[test]
fn malformed() {
    let says = |header: &str, body: &[u8]| file(header, body).expect_err(header).to_string();
    let little = format!("format binary_little_endian 1.0\nelement vertex 2\n{XYZ}");
    assert_eq!(
        says(&little, &[0; 23]),
        "end of file: the file announces 2 points, but ends after 1"
    );
    // Between the two come `ply` and `end_header` with their line ends.
    let body = |header: &str| header.len() + 15;
    assert_eq!(
        says(&little, &[0; 25]),
        format!("byte {}: unexpected data after the last element", body(&little) + 24)
    );
    let nan = [[0; 12].as_slice(), &f32::NAN.to_le_bytes().repeat(3)].concat();
    assert_eq!(says(&little, &nan), "point 1: `NaN` is not a finite number");
    let many = little.replace("vertex 2", "vertex 18446744073709551615");
    assert!(
        says(&many, &[0; 24]).ends_with("announces 18446744073709551615 points, but ends after 2")
    );
    let text = format!("format ascii 1.0\nelement vertex 1\n{XYZ}");
    assert_eq!(says(&text, b"1 2 x"), "line 8: `x` is not a number");
    assert_eq!(says(&text, b"1 2"), "line 8: the file announces 1 points, but ends after 0");
    assert_eq!(says(&text, b"1 2 3 4"), "line 8: unexpected data after the last element");
    let empty = format!("format ascii 1.0\nelement a 9999999999999\nelement vertex 0\n{XYZ}");
    assert_eq!(says(&empty, b""), "header: an element has no properties");
    let list = format!(
        "format binary_little_endian 1.0\nelement a 1\nproperty list int64 double v\n\
         element vertex 0\n{XYZ}"
    );
    let after = body(&list) + 8;
    assert_eq!(says(&list, &(-1_i64).to_le_bytes()), format!("byte {after}: a list of length -1"));
    assert_eq!(
        says(&list, &(1_i64 << 62).to_le_bytes()),
        format!("byte {after}: the file announces 1 rows, but ends after 0")
    );
    assert_eq!(says("format ascii 1.0\n", b""), "header: there is no element `vertex`");
    assert_eq!(
        says("format ascii 1.0\nelement vertex 1\nproperty float x\n", b""),
        "header: vertices need the properties x, y and z"
    );
    assert_eq!(says(XYZ, b""), "line 2: a property before the first element");
    assert_eq!(
        says("format ascii 2.0\n", b""),
        "line 2: `format ascii 2.0` is no line of a header"
    );
    assert_eq!(says("format morse 1.0\n", b""), "line 2: not supported: format `morse`");
    let only = |text: &str| ply::read(text.as_bytes()).expect_err(text).to_string();
    assert_eq!(only(""), "line 1: the file ends inside the header");
    assert_eq!(only("plyx\n"), "line 1: not a PLY file");
    assert_eq!(only("ply\nelement"), "line 2: the file ends inside the header");
}

#[test]
fn tags_that_are_no_doubles_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.ply");
    let tag = (1 << 53) + 1;
    let file =
        PointFile { points: vec![[0.0; 3]; 2], point_tags: Some(vec![1, tag]), notes: Vec::new() };
    match io::write_points(&path, &file) {
        Err(IoError::Data { reason, .. }) => {
            assert_eq!(reason, DataError::TagRange { what: "point", number: 1, tag });
        }
        other => panic!("{other:?}"),
    }
    assert!(!path.exists());
    let fine = PointFile { point_tags: None, ..file };
    let options = WriteOptions { encoding: Encoding::Ascii, ..WriteOptions::default() };
    io::write_points_with(&path, &fine, options).unwrap();
    assert!(std::fs::read(&path).unwrap().starts_with(b"ply\nformat ascii 1.0\n"));
    assert_eq!(io::read_points(&path).unwrap(), fine);
}

#[test]
fn point_sources_are_not_written() {
    for name in ["a.off", "a.OBJ", "a.stl"] {
        let path = Path::new(name);
        let error = io::write_points(path, &PointFile::default()).unwrap_err();
        assert_eq!(error.code(), "io.read-only", "{error}");
        assert!(io::check_points_writable(path).is_err());
        assert!(matches!(io::read_mesh(path), Err(IoError::WrongKind { .. })));
    }
}
