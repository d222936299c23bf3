//! Reading and writing domains.

use ltbw_domain::{Domain, Facet};
use ltbw_formats as io;
use ltbw_formats::{
    DomainFile, Encoding, Format, IoError, ParseError, WriteOptions, obj, off, ply, poly, stl,
};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use proptest::prelude::*;
use std::path::Path;

type Read = fn(&[u8]) -> Result<DomainFile, ParseError>;

const READERS: [(&str, Read); 6] = [
    ("poly", poly::read_poly),
    ("smesh", poly::read_smesh),
    ("off", off::read_domain),
    ("obj", obj::read_domain),
    ("stl", stl::read_domain),
    ("ply", ply::read_domain),
];

fn model(kind: DomainKind) -> Domain {
    let shape = Shape { seed: 3, ..Shape::default() };
    generate_domain(kind, &shape).unwrap()
}

fn bits(domain: &Domain) -> Vec<[u64; 3]> {
    domain.vertices.iter().map(|p| p.map(f64::to_bits)).collect()
}

fn back(path: &Path, domain: &Domain, encoding: Encoding) -> DomainFile {
    io::write_domain_with(path, domain, WriteOptions { encoding, ..WriteOptions::default() })
        .unwrap();
    io::read_domain(path).unwrap()
}

#[test]
fn poly_keeps_every_domain_and_smesh_those_of_simple_facets() {
    let dir = tempfile::tempdir().unwrap();
    for kind in DomainKind::ALL {
        let mut domain = model(kind);
        domain.segments.push(([0, 3], -7));
        let file = back(&dir.path().join("a.poly"), &domain, Encoding::Binary);
        assert_eq!((&file.domain, file.oriented), (&domain, false), "{kind}");
        assert_eq!(bits(&file.domain), bits(&domain));
        let path = dir.path().join("a.smesh");
        if domain.facets.iter().all(|f| f.polygons.len() == 1 && f.holes.is_empty()) {
            assert_eq!(back(&path, &domain, Encoding::Binary).domain, domain, "{kind}");
        } else {
            let error = io::write_domain(&path, &domain).unwrap_err();
            assert_eq!(error.code(), "io.data");
            assert!(error.to_string().contains("is not a single polygon"), "{error}");
        }
    }
}

#[test]
fn surfaces_keep_polygons_and_coordinates() {
    let dir = tempfile::tempdir().unwrap();
    for kind in DomainKind::ALL {
        let domain = model(kind);
        let volume = |d: &Domain, oriented: bool| {
            let options = ltbw_domain::CheckOptions { oriented, ..Default::default() };
            d.check(&options).unwrap().volume().unwrap().to_string()
        };
        let simple = domain.facets.iter().all(|f| f.polygons.len() == 1);
        for extension in ["off", "obj", "ply", "stl"] {
            for encoding in [Encoding::Ascii, Encoding::Binary] {
                let path = dir.path().join(format!("a.{extension}"));
                let file = back(&path, &domain, encoding);
                assert!(file.oriented);
                if extension != "stl" {
                    assert_eq!(bits(&file.domain), bits(&domain), "{kind} {extension}");
                }
                if simple && extension != "stl" {
                    let polygons = |d: &Domain| -> Vec<Vec<Vec<u32>>> {
                        d.facets.iter().map(|f| f.polygons.clone()).collect()
                    };
                    assert_eq!(polygons(&file.domain), polygons(&domain), "{kind} {extension}");
                }
                if extension == "ply" && simple {
                    assert_eq!(file.domain.facets, domain.facets, "{kind}");
                }
                // Two filled regions meet at the wall, where no orientation is right.
                let same = volume(&file.domain, kind != DomainKind::TwoMaterial);
                assert_eq!(same, volume(&domain, false), "{kind} {extension}");
            }
        }
        let lost = io::not_kept(&domain, Format::Stl);
        assert_eq!(lost.iter().any(|l| l.starts_with("holes ")), !domain.holes.is_empty());
        assert!(io::not_kept(&domain, Format::Poly).is_empty());
    }
}

/// The tetrahedron of the tests below.
const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

fn tetrahedron() -> Vec<Facet> {
    TETRAHEDRON.iter().map(|t| Facet::polygon(t, 0)).collect()
}

#[test]
fn poly_with_comments_holes_regions_and_numbers_from_one() {
    let text = "# a comment\n\n5 3 1 1\n1 0 0 0 9 3\n2 4 0 0 9 3\n3 0 4 0 9 3 # here\n\
         4 0 0 4 9 3\n5 1 1 0 9 3\n3 1\n2 1 -5\n3 1 2\n3\n2 1 5\n1 0.5 0.5 0\n1\n3 1 2 4\n\
         1 0 8\n2 1 4\n1\n1 0.25 0.25 0.25\n2\n1 0.5 0.5 0.5 7\n2 0.125 1 1 8 -1\n";
    let file = poly::read_poly(text.as_bytes()).unwrap();
    let d = &file.domain;
    assert_eq!(d.vertices.len(), 5);
    let facet = Facet {
        polygons: vec![vec![0, 1, 2], vec![0, 4]],
        holes: vec![[0.5, 0.5, 0.0]],
        marker: -5,
    };
    assert_eq!(d.facets, [facet, Facet::polygon(&[0, 1, 3], 0)]);
    assert_eq!(d.segments, [([0, 3], 8)]);
    assert_eq!(d.holes, [[0.25; 3]]);
    assert_eq!((d.regions[0].attribute, d.regions[0].max_volume), (7.0, None));
    assert_eq!((d.regions[1].attribute, d.regions[1].max_volume), (8.0, None));
    assert_eq!(file.notes.len(), 2);
}

#[test]
fn poly_with_its_points_in_a_node_file() {
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
    write("a.poly", "0 3 0 0\n1 0\n1\n3 1 2 3\n0\n");
    let path = dir.path().join("a.poly");
    let missing = io::read_domain(&path).unwrap_err();
    assert!(
        matches!(&missing, IoError::Read { path, .. } if path.ends_with("a.node")),
        "{missing}"
    );
    write("a.node", "3 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n");
    let domain = io::read_domain(&path).unwrap().domain;
    assert_eq!(domain.facets, [Facet::polygon(&[0, 1, 2], 0)]);
    write("a.smesh", "0 3 0 0\n1 1\n3 1 2 3 4\n0\n");
    let domain = io::read_domain(dir.path().join("a.smesh")).unwrap().domain;
    assert_eq!(domain.facets, [Facet::polygon(&[0, 1, 2], 4)]);
}

#[test]
fn faces_of_objects() {
    let text = b"v 0 0 0\nv 1 0 0 # x\nv 0 1 0\nf 1/1 3//2 2/3/4\nf -3 -2 \\\n4\nv 0 0 1 0.5\n\
         f 2 3 4\ng part\nf 3 1 -1\nl 1 2\nf 1 4\n";
    let file = obj::read_domain(text).unwrap();
    let mut facets = tetrahedron();
    facets[3].marker = 1;
    assert_eq!(file.domain.facets, facets);
    assert_eq!(file.domain.segments, [([0, 3], 0)]);
    assert_eq!(file.notes.len(), 2);
}

#[test]
fn faces_of_stanford_files() {
    let text = "ply\nformat ascii 1.0\nelement face 1\nproperty uchar flags\n\
         property list uchar int vertex_index\nproperty int marker\nelement vertex 3\n\
         property float x\nproperty float y\nproperty float z\nelement edge 1\nproperty int a\n\
         end_header\n9 3 2 1 0 -4\n0 0 0\n1 0 0\n0 1 0\n5\n";
    let file = ply::read_domain(text.as_bytes()).unwrap();
    assert_eq!(file.domain.facets, [Facet::polygon(&[2, 1, 0], -4)]);
    assert_eq!(file.notes.len(), 1);
}

#[test]
fn what_is_wrong_is_told_with_its_place() {
    let says = |extension: &str, text: &str| {
        let (_, read) = READERS.iter().find(|(e, _)| *e == extension).unwrap();
        read(text.as_bytes()).expect_err(text).to_string()
    };
    let points = "3 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n";
    let poly = |rest: &str| says("poly", &format!("{points}{rest}"));
    assert_eq!(poly(""), "line 5: the file ends before its facets");
    assert_eq!(poly("x"), "line 5: `x` is not an integer that fits");
    assert_eq!(poly("1 0 0"), "line 5: expected 2 values, found more");
    assert_eq!(poly("2\n1\n3 0 1 2\n"), "line 8: the file announces 2 facets, but ends after 1");
    assert_eq!(
        poly("1\n1\n3 0 1 3\n"),
        "line 7: facet 0 names point 3, but points are numbered 0 to 2"
    );
    assert_eq!(
        poly("1\n1\n3 0 1 -1\n"),
        "line 7: facet 0 names point -1, but points are numbered 0 to 2"
    );
    assert_eq!(poly("1\n1\n3 0 1\n"), "line 8: the file announces 3 corners, but ends after 2");
    assert_eq!(poly("1\n1\n1 0\n"), "line 7: a polygon of 1 corners");
    assert_eq!(
        poly("1\n1 0 99999999999\n3 0 1 2\n"),
        "line 6: `99999999999` is not an integer that fits"
    );
    assert_eq!(poly("1\n1 1\n3 0 1 2\n1 0 nan 0\n"), "line 8: `nan` is not a finite number");
    assert_eq!(poly("1\n1\n3 0 1 2 2\n0\n"), "line 7: expected 4 values, found more");
    assert_eq!(poly("1\n1\n3 0 1 2\n1\n"), "line 9: the file announces 1 holes, but ends after 0");
    assert_eq!(poly("1\n1\n3 0 1 2\n1\n0 0 0\n"), "line 9: expected 4 values, found 3");
    assert_eq!(poly("1\n1\n3 0 1 2\n0\n1\n0 0 0 0\n"), "line 10: expected 5 values, found 4");
    assert_eq!(poly("1\n1\n3 0 1 2\n0\n0\n7\n"), "line 10: unexpected data after the last region");
    let huge = u64::MAX;
    assert_eq!(
        poly(&format!("{huge}\n1\n3 0 1 2\n")),
        format!("line 8: the file announces {huge} facets, but ends after 1")
    );
    assert_eq!(
        poly(&format!("1\n1\n{huge} 0 1 2\n")),
        format!("line 8: the file announces {huge} corners, but ends after 3")
    );
    assert_eq!(
        says("poly", "0 3\n1\n1\n3 0 1 2\n"),
        "line 4: facet 0 names point 0, but points are numbered 1 to 0"
    );
    assert_eq!(
        says("smesh", &format!("{points}1 0\n3 0 1 2 5\n")),
        "line 6: expected 4 values, found more"
    );
    assert_eq!(
        says("off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
        "line 6: face 0 names point 3, but points are numbered 0 to 2"
    );
    assert_eq!(
        says("off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
        "line 7: the file announces 2 faces, but ends after 1"
    );
    assert_eq!(says("off", "OFF\n1 1 0\n0 0 0\n1 0\n"), "line 4: a face of 1 corners");
    assert_eq!(
        says("off", &format!("OFF\n1 1 0\n0 0 0\n{huge} 0\n")),
        format!("line 4: expected {huge} values, found 2")
    );
    assert_eq!(
        says("obj", "v 0 0 0\nf 1 2 3\n"),
        "line 2: face 0 names point 2, but points are numbered 1 to 1"
    );
    assert_eq!(
        says("obj", "v 0 0 0\nf 0 1 1\n"),
        "line 2: face 0 names point 0, but points are numbered 1 to 1"
    );
    assert_eq!(
        says("obj", "v 0 0 0\nf -2 1 1\n"),
        "line 2: face 0 names point -2, but points are numbered -1 to -1"
    );
    assert_eq!(says("obj", "v 0 0 0\nf a 1 1\n"), "line 2: `a` is not an integer that fits");
    let ply = |faces: &str, rest: &str| {
        says(
            "ply",
            &format!(
                "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\n\
             property double z\nelement face {faces}\nproperty list uchar int vertex_indices\n\
             end_header\n0 0 0\n{rest}"
            ),
        )
    };
    assert_eq!(
        ply("1", "3 0 0 1\n"),
        "face 0: face 0 names point 1, but points are numbered 0 to 0"
    );
    assert_eq!(ply("2", "3 0 0 0\n"), "line 11: the file announces 2 faces, but ends after 1");
    assert_eq!(ply("1", "-1\n"), "line 11: a list of length -1");
    assert_eq!(ply("1", "3 0 0.5 0\n"), "line 11: `0.5` is not an integer that fits");
    assert_eq!(ply("1", "1 0\n"), "face 0: a face of 1 corners");
    assert_eq!(
        says("stl", "solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendsolid\n"),
        "line 7: the file ends inside a facet"
    );
}

#[test]
fn formats_that_hold_no_domain() {
    let error = io::read_domain(Path::new("a.vtu")).unwrap_err();
    assert_eq!(error.to_string(), "a.vtu: this format holds a mesh, but a domain is wanted");
    let error = io::read_points(Path::new("a.poly")).unwrap_err();
    assert_eq!(error.to_string(), "a.poly: this format holds a domain, but points are wanted");
    assert_eq!(io::read_mesh(Path::new("a.smesh")).unwrap_err().code(), "io.wrong-kind");
    assert_eq!(io::check_domain_writable(Path::new("a.xyz")).unwrap_err().code(), "io.wrong-kind");
    let empty = io::write_domain(Path::new("a.poly"), &Domain::default()).unwrap_err();
    assert_eq!(empty.to_string(), "a.poly: cannot write: the domain has no facets");
}

/// Found by the test below: a segment forced across the rim of its facet's triangulation.
#[test]
fn a_damaged_block_is_no_reason_to_panic() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.ply");
    let shape = Shape { count: Some(3), ..Shape::default() };
    let domain = generate_domain(DomainKind::LBlock, &shape).unwrap();
    let options = WriteOptions { encoding: Encoding::Binary, ..WriteOptions::default() };
    io::write_domain_with(&path, &domain, options).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    let place = |index: u64, len: usize| ((u128::from(index) * len as u128) >> 64) as usize;
    let at = place(11_592_801_428_035_175_399, bytes.len());
    bytes.insert(at, 32);
    let at = place(5_159_741_458_298_468_786, bytes.len());
    bytes.remove(at);
    let file = ply::read_domain(&bytes).unwrap();
    assert!(!file.domain.check(&Default::default()).unwrap().defects.is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]

    /// Any bytes, and any damage to a good file, give a domain of valid indices or an error of one
    /// line; and the domain can be checked.
    #[test]
    fn damaged_files_are_told_or_read(
        reader in 0..READERS.len(),
        kind in 0..DomainKind::ALL.len(),
        encoding in prop::bool::ANY,
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4_u8), 0..6),
        noise in prop::option::weighted(0.1, prop::collection::vec(any::<u8>(), 0..200)),
    ) {
        let (extension, read) = READERS[reader];
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(format!("a.{extension}"));
        let shape = Shape { count: Some(3), ..Shape::default() };
        let domain = generate_domain(DomainKind::ALL[kind], &shape).unwrap();
        let encoding = if encoding { Encoding::Ascii } else { Encoding::Binary };
        let options = WriteOptions { encoding, ..WriteOptions::default() };
        let written = io::write_domain_with(&path, &domain, options).is_ok();
        let mut bytes = if written { std::fs::read(&path).unwrap() } else { Vec::new() };
        if let Some(noise) = noise {
            bytes = noise;
        }
        for (at, byte, how) in damage {
            if bytes.is_empty() {
                break;
            }
            let at = at.index(bytes.len());
            match how {
                0 => bytes[at] = byte,
                1 => drop(bytes.remove(at)),
                2 => bytes.insert(at, byte),
                _ => bytes.truncate(at),
            }
        }
        match read(&bytes) {
            Ok(file) => match file.domain.check(&Default::default()) {
                Ok(report) => prop_assert_eq!(report.counts.is_empty(), report.defects.is_empty()),
                Err(error) => prop_assert!(error.code() != "domain.index", "{}", error),
            },
            Err(error) => prop_assert!(!error.to_string().contains('\n'), "{}", error),
        }
    }
}
