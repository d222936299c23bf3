//! `.vtu`: the ways in which arrays are stored, and malformed input of the binary ones.

use flate2::{Compression, write::ZlibEncoder};
use ltbw_core::{BoundaryFace, TetMesh};
use ltbw_domain::quality::Array;
use ltbw_formats::{Encoding, vtu};
use std::io::Write;

/// The storage of a file's arrays.
#[derive(Debug, Clone, Copy)]
struct Store {
    appended: bool,
    base64: bool,
    zlib: bool,
    big_endian: bool,
    wide_header: bool,
}

fn every_store() -> Vec<Store> {
    (0..32)
        .map(|k| Store {
            appended: k & 1 > 0,
            base64: k & 2 > 0,
            zlib: k & 4 > 0,
            big_endian: k & 8 > 0,
            wide_header: k & 16 > 0,
        })
        // Between tags only base64 is possible.
        .filter(|s| s.appended || s.base64)
        .collect()
}

impl Store {
    fn number(self, value: usize) -> Vec<u8> {
        let wide = (value as u64).to_be_bytes();
        let mut bytes = wide[if self.wide_header { 0 } else { 4 }..].to_vec();
        if !self.big_endian {
            bytes.reverse();
        }
        bytes
    }

    /// An array of numbers that are given in little endian.
    fn array(self, width: usize, little: &[u8]) -> Vec<u8> {
        let mut data = little.to_vec();
        if self.big_endian {
            data.chunks_mut(width).for_each(<[u8]>::reverse);
        }
        let (header, data) = if self.zlib {
            let blocks: Vec<Vec<u8>> = data.chunks(40).map(zlib).collect();
            let mut header = [blocks.len(), 40, data.len() % 40].map(|n| self.number(n)).concat();
            blocks.iter().for_each(|b| header.extend(self.number(b.len())));
            (header, blocks.concat())
        } else {
            (self.number(data.len()), data)
        };
        match (self.base64, self.zlib) {
            (false, _) => [header, data].concat(),
            // VTK pads the two one by one if there is compression, else together.
            (true, true) => [base64(&header), base64(&data)].concat(),
            (true, false) => base64(&[header, data].concat()),
        }
    }

    /// A file of one tetrahedron with tags.
    fn file(self) -> Vec<u8> {
        let floats = |v: &[f32]| v.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<u8>>();
        let ints = |v: &[i64]| v.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<u8>>();
        let xyz = floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 0.1]);
        let arrays: [(&str, &str, &str, usize, Vec<u8>); 6] = [
            ("PointData", "tag", "Int64", 8, ints(&[-1, 2, i64::MAX, 4])),
            ("CellData", "region", "Float64", 8, 17_f64.to_le_bytes().to_vec()),
            ("Points", "Points", "Float32", 4, xyz),
            ("Cells", "connectivity", "Int64", 8, ints(&[3, 1, 2, 0])),
            ("Cells", "offsets", "UInt16", 2, vec![4, 0]),
            ("Cells", "types", "Int8", 1, vec![10]),
        ];
        let (order, header) = (
            if self.big_endian { "BigEndian" } else { "LittleEndian" },
            if self.wide_header { " header_type=\"UInt64\"" } else { "" },
        );
        let zlib = if self.zlib { " compressor=\"vtkZLibDataCompressor\"" } else { "" };
        let mut out = format!(
            "<VTKFile type=\"UnstructuredGrid\" byte_order=\"{order}\"{header}{zlib}>\n\
             <UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">\n"
        )
        .into_bytes();
        let mut appended = Vec::new();
        for (section, name, kind, width, data) in arrays {
            let array = self.array(width, &data);
            let head = format!(
                "<{section}><DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"3\""
            );
            out.extend(head.into_bytes());
            if self.appended {
                out.extend(format!(" format=\"appended\" offset=\"{}\"/>", appended.len()).bytes());
                appended.extend(array);
            } else {
                out.extend(b" format=\"binary\">\n  ");
                out.extend(array);
                out.extend(b"\n<InformationKey/>\n</DataArray>");
            }
            out.extend(format!("</{section}>\n").bytes());
        }
        out.extend(b"</Piece></UnstructuredGrid>\n");
        if self.appended {
            let encoding = if self.base64 { "base64" } else { "raw" };
            out.extend(format!("<AppendedData encoding=\"{encoding}\">\n  _").bytes());
            out.extend(appended);
            out.extend(b"\n</AppendedData>");
        }
        out.extend(b"</VTKFile>\n");
        out
    }
}

fn zlib(data: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(data).expect("memory");
    encoder.finish().expect("memory")
}

fn base64(data: &[u8]) -> Vec<u8> {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = Vec::new();
    for group in data.chunks(3) {
        let mut bytes = [0; 4];
        bytes[1..=group.len()].copy_from_slice(group);
        let word = u32::from_be_bytes(bytes) as usize;
        let digits = [18, 12, 6, 0].map(|shift| DIGITS[word >> shift & 63]);
        out.extend(&digits[..=group.len()]);
        out.extend(vec![b'='; 3 - group.len()]);
    }
    out
}

#[test]
fn every_way_to_store_arrays_reads_the_same() {
    let want = TetMesh {
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, f64::from(0.1_f32)]],
        tets: vec![[3, 1, 2, 0]],
        point_tags: Some(vec![-1, 2, i64::MAX, 4]),
        tet_tags: Some(vec![17]),
        ..TetMesh::default()
    };
    let stores = every_store();
    assert_eq!(stores.len(), 24);
    for store in stores {
        let file = vtu::read(&store.file()).unwrap_or_else(|e| panic!("{store:?}: {e}"));
        assert_eq!(file.mesh, want, "{store:?}");
        assert!(file.notes.is_empty());
    }
}

/// Every byte in turn is overwritten, and the file is cut there: errors are one line.
#[test]
fn damage_anywhere_is_an_error_or_another_mesh() {
    for store in every_store() {
        let whole = store.file();
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x41;
            if let Err(error) = vtu::read(&bytes) {
                let text = error.to_string();
                assert!(!text.contains('\n') && text.len() < 300, "{text:?}");
            }
            let cut = vtu::read(&whole[..at]);
            // Only the line end behind it may be missing.
            assert!(cut.is_err() || at + 1 == whole.len(), "{store:?}: {at}");
        }
    }
}

#[test]
fn appended_arrays_that_overlap_are_refused() {
    let store =
        Store { appended: true, base64: false, zlib: false, big_endian: false, wide_header: true };
    // A second piece that names the arrays of the first: a file could name one many times.
    let mut bytes = store.file();
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let (start, end) = (text.find("<Piece").unwrap(), text.find("</UnstructuredGrid>").unwrap());
    let piece = bytes[start..end].to_vec();
    bytes.splice(start..start, piece);
    let error = vtu::read(&bytes).unwrap_err().to_string();
    assert!(error.ends_with("appended arrays overlap"), "{error}");
}

#[test]
fn binary_is_smaller_and_text_is_text() {
    let mesh = TetMesh {
        points: vec![[0.1, 0.2, 0.3]; 100],
        tets: vec![[96, 97, 98, 99]; 300],
        ..TetMesh::default()
    };
    let written = |encoding| {
        let mut out = Vec::new();
        vtu::write(&mut out, &mesh, encoding).expect("memory");
        out
    };
    let (binary, text) = (written(Encoding::Binary), written(Encoding::Ascii));
    assert!(text.is_ascii() && !text.windows(8).any(|w| w == b"appended"));
    // 24 bytes for a point, 16 + 4 + 1 for a tetrahedron, and less than 1200 for what is around.
    assert!(binary.len() < 24 * 100 + 21 * 300 + 1200, "{}", binary.len());
}

#[test]
fn figures_and_boundary_leave_the_mesh_as_it_is() {
    let mesh = TetMesh {
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]],
        tets: vec![[0, 1, 2, 3], [1, 2, 3, 4]],
        tet_tags: Some(vec![1, 2]),
        tet_attributes: Some(vec![70.0, 90.5]),
        faces: vec![
            BoundaryFace { corners: [0, 2, 1], marker: -7, tet: 0 },
            BoundaryFace { corners: [1, 2, 4], marker: 8, tet: 1 },
        ],
        ..TetMesh::default()
    };
    let values = [Array { name: "volume", values: vec![0.25, f64::INFINITY] }];
    for encoding in [Encoding::Binary, Encoding::Ascii] {
        let mut bytes = Vec::new();
        vtu::write_with(&mut bytes, &mesh, &values, encoding).expect("memory");
        let file = vtu::read(&bytes).expect("our own file");
        assert_eq!(file.mesh, mesh);
        assert_eq!(file.notes.len(), 1, "{:?}", file.notes);
    }
    let mut bytes = Vec::new();
    vtu::write_with(&mut bytes, &mesh, &values, Encoding::Ascii).expect("memory");
    let text = String::from_utf8(bytes).expect("text");
    let array = |name: &str| {
        let (_, rest) =
            text.split_once(&format!("Name=\"{name}\" format=\"ascii\">\n")).expect(name);
        rest.split_once("</").expect("an end").0.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    assert_eq!(array("connectivity"), "0 1 2 3 1 2 3 4 0 2 1 1 2 4");
    assert_eq!(array("offsets"), "4 8 11 14");
    assert_eq!(array("types"), "10 10 5 5");
    assert_eq!(array("region"), "1 2 1 2", "a triangle looks like its tetrahedron");
    assert_eq!(array("marker"), "0 0 -7 8");
    assert_eq!(array("attribute"), "70 90.5 70 90.5");
    assert_eq!(array("volume"), "0.25 inf 0.25 inf");
}

/// A tetrahedron with arrays of points.
fn with_arrays(arrays: &str) -> String {
    format!(
        "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">\n<PointData>{arrays}</PointData>\n\
         <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\
         0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>\n<Cells>\
         <DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray>\
         <DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4</DataArray>\
         <DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray></Cells>\n\
         </Piece></UnstructuredGrid></VTKFile>\n"
    )
}

#[test]
fn a_field_of_the_points_is_read_by_its_name() {
    let array = |name: &str, more: &str, values: &str| {
        format!("<DataArray Name=\"{name}\" format=\"ascii\" {more}>{values}</DataArray>")
    };
    let float = "type=\"Float32\" NumberOfComponents=\"1\"";
    let vector = "type=\"Float64\" NumberOfComponents=\"2\"";
    let whole = "type=\"Int32\"";
    let one = array("size", float, "1 0.5 3 4") + &array("way", vector, "1 2 3 4 5 6 7 8");
    let other = array("number", whole, "4 3 2 1") + &array("tag", whole, "0 0 0 1");
    let text = with_arrays(&(one.clone() + &other));
    let read = |text: &str, name: Option<&str>| vtu::read_field(text.as_bytes(), name);
    for (name, values) in [
        (None, [1.0, 0.5, 3.0, 4.0]),
        (Some("size"), [1.0, 0.5, 3.0, 4.0]),
        (Some("number"), [4.0, 3.0, 2.0, 1.0]),
    ] {
        let found = read(&text, name).expect("a field");
        assert_eq!((found.values, found.mesh.tets.len()), (values.to_vec(), 1), "{name:?}");
    }
    let says = |text: &str, name| read(text, name).expect_err("no field").to_string();
    assert!(says(&text, Some("way")).contains("the array `way` has 2 numbers for each point"));
    assert!(says(&text, Some("sizes")).contains("points without the array `sizes`"));
    assert!(says(&with_arrays(&other), None).contains("points without an array of floats"));
    let several = with_arrays(&(one.clone() + &array("error", float, "1 1 1 1")));
    assert!(says(&several, None).contains("the arrays `size` and `error` of points"));
    assert_eq!(read(&several, Some("error")).expect("a field").values, [1.0; 4]);
    for values in ["1 2 3", "1 2 3 4 5"] {
        assert!(read(&with_arrays(&array("size", float, values)), None).is_err(), "{values}");
    }
    assert!(read(&with_arrays(&array("size", float, "1 2 nan 4")), None).is_err());
    // Without a field the mesh is read as before.
    assert_eq!(vtu::read(several.as_bytes()).expect("a mesh").mesh.tets, [[0, 1, 2, 3]]);
}
