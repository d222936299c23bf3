//! `.vtk`: VTK's legacy files of all versions, text and binary, as meshes and as surfaces.

use ltbw_core::{BoundaryFace, TetMesh};
use ltbw_domain::{Domain, Facet};
use ltbw_formats::{self as io, Encoding, Format, WriteOptions, vtk};
use proptest::prelude::*;

use crate::strategies::{bits, meshes};

/// A tetrahedron, a triangle of it, a line, and data of all kinds, as version `version`.
fn text(version: &str) -> String {
    let cells = match version.starts_with('5') {
        true => {
            "CELLS 4 9\nOFFSETS vtktypeint64\n0 4 7 9\nCONNECTIVITY vtktypeint64\n\
             0 1 2 3 0 2\n1 0 1\n"
        }
        false => "CELLS 3 12\n4 0 1 2 3\n3 0 2 1 2 0 1\n",
    };
    format!(
        "# vtk DataFile Version {version}\na title: # 3 4\nASCII\nDATASET UNSTRUCTURED_GRID\n\
         FIELD FieldData 1\ntime 1 1 double\n0.5\n\
         POINTS 4 float\n0 0 0 1 0 0\n0 1 0 0 0 1\n\
         METADATA\nINFORMATION 1\nNAME L2 LOCATION vtk\nDATA 1\n\n\
         {cells}\nCELL_TYPES 3\n10\n5 3\n\
         POINT_DATA 4\nSCALARS tag int 1\nLOOKUP_TABLE default\n5 -6 7 8\n\
         SCALARS heat double\nLOOKUP_TABLE default\n1 2 3 4.5\n\
         VECTORS flow float\n1 2 3 1 2 3 1 2 3 1 2 3\n\
         COLOR_SCALARS rgb 3\n1 1 1 1 1 1 0 0 0 0 0 0\nLOOKUP_TABLE map 1\n0 0 0 1\n\
         TEXTURE_COORDINATES uv 2 float\n0 0 1 0 0 1 1 1\n\
         CELL_DATA 3\nFIELD FieldData 2\nregion 1 3 long\n9 9 0\nmarker 1 3 vtkIdType\n0 4 0\n"
    )
}

#[test]
fn every_version_gives_the_same_mesh() {
    for version in ["1.0", "2.0", "3.0", "4.2", "5.0", "5.1"] {
        let file = vtk::read(text(version).as_bytes()).expect(version);
        assert_eq!(file.mesh.points[1], [1.0, 0.0, 0.0], "{version}");
        assert_eq!(file.mesh.tets, [[0, 1, 2, 3]], "{version}");
        assert_eq!(file.mesh.point_tags, Some(vec![5, -6, 7, 8]), "{version}");
        assert_eq!(file.mesh.tet_tags, Some(vec![9]), "{version}");
        let face = BoundaryFace { corners: [0, 2, 1], marker: 4, tet: 0 };
        assert_eq!(file.mesh.faces, [face], "{version}");
        assert_eq!(file.notes.len(), 2, "other cells and arrays: {:?}", file.notes);
        assert!(!vtk::is_surface(text(version).as_bytes()));
    }
}

/// A triangle and a square behind a vertex and a line, with markers, in binary.
fn binary_surface() -> Vec<u8> {
    let ints = |list: &[i32]| list.iter().flat_map(|v| v.to_be_bytes()).collect::<Vec<u8>>();
    let points = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let points: Vec<u8> = points.iter().flatten().flat_map(|c| c.to_be_bytes()).collect();
    [
        &b"# vtk DataFile Version 3.0\r\n\nBINARY\nDATASET POLYDATA\nPOINTS 4 float\n"[..],
        &points,
        b"\nVERTICES 1 2\n",
        &ints(&[1, 0]),
        b"\nLINES 1 3\n",
        &ints(&[2, 0, 1]),
        b"\nPOLYGONS 2 9\n",
        &ints(&[3, 0, 1, 2, 4, 0, 1, 2, 3]),
        b"\nCELL_DATA 4\nSCALARS marker int\nLOOKUP_TABLE default\n",
        &ints(&[1, 2, 3, -4]),
        b"\nFIELD FieldData 1\nbits 1 4 bit\n\xf0\n",
    ]
    .concat()
}

#[test]
fn polygons_are_a_surface() {
    let bytes = binary_surface();
    assert!(vtk::is_surface(&bytes));
    let file = vtk::read_domain(&bytes).unwrap();
    assert!(file.oriented);
    let facets = [Facet::polygon(&[0, 1, 2], 3), Facet::polygon(&[0, 1, 2, 3], -4)];
    assert_eq!(file.domain.facets, facets);
    assert_eq!(file.notes.len(), 2, "{:?}", file.notes);
    let says = |bytes: &[u8]| vtk::read(bytes).unwrap_err().to_string();
    assert!(says(&bytes).ends_with("POLYDATA is a surface, where a mesh is wanted"));
    let mesh = vtk::read_domain(text("3.0").as_bytes()).unwrap_err().to_string();
    assert!(mesh.ends_with("an UNSTRUCTURED_GRID is a mesh, where a surface is wanted"));
    for cut in 0..bytes.len() - 2 {
        if let Err(error) = vtk::read_domain(&bytes[..cut]) {
            assert!(!error.to_string().contains('\n'), "{cut}: {error}");
        }
    }
}

#[test]
fn surfaces_survive() {
    let folder = tempfile::tempdir().unwrap();
    let vertices = vec![[0.1, 0.0, -0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1e-300]];
    let facets = |marker| {
        let corners = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        corners.map(|c| Facet::polygon(&c, marker)).to_vec()
    };
    for (marker, encoding) in
        [(0, Encoding::Ascii), (-7, Encoding::Ascii), (0, Encoding::Binary), (9, Encoding::Binary)]
    {
        let facets = facets(marker);
        let domain = Domain { vertices: vertices.clone(), facets, ..Domain::default() };
        let path = folder.path().join("s.vtk");
        let options = WriteOptions { encoding, ..WriteOptions::default() };
        io::write_domain_with(&path, &domain, options).unwrap();
        let back = io::read_domain(&path).unwrap();
        assert_eq!(back.domain, domain);
        assert_eq!(bits(&back.domain.vertices), bits(&vertices));
        assert!(back.notes.is_empty() && io::not_kept(&domain, Format::Vtk).is_empty());
    }
}

#[test]
fn what_is_wrong_has_a_place() {
    let says = |text: &str| vtk::read(text.as_bytes()).unwrap_err().to_string();
    let whole = text("3.0");
    let with = |from: &str, to: &str| {
        assert!(whole.contains(from), "{from}");
        says(&whole.replacen(from, to, 1))
    };
    assert_eq!(says(""), "line 1: not a legacy VTK file of version 1 to 5");
    assert_eq!(with("3.0", "6.0"), "line 1: not a legacy VTK file of version 1 to 5");
    assert_eq!(with("ASCII", "Text"), "line 3: neither ASCII nor BINARY");
    let grid = with("UNSTRUCTURED_GRID", "STRUCTURED_POINTS");
    assert_eq!(grid, "line 4: not supported: a dataset `STRUCTURED_POINTS`");
    assert!(with("POINTS 4", "POINTS 5").contains("`METADATA` is not a number"));
    assert!(with("POINTS 4", "POINTS 1000000000000000000").contains("is not a number"));
    assert!(with("0 1 0 0 0 1", "0 1 0 0 0 nan").contains("`nan` is not a finite number"));
    assert!(with("4 0 1 2 3\n", "4 0 1 2 7\n").contains("cell 0 names point 7"));
    assert!(with("4 0 1 2 3\n", "9 0 1 2 3\n").contains("too short for its cells"));
    assert!(with("4 0 1 2 3\n", "3 0 1 2 0\n").contains("cell"));
    assert!(with("10\n5 3", "12\n5 3").contains("VTK type 12"));
    assert!(with("POINT_DATA 4\nSCALARS tag", "POINT_DATA 3\nSCALARS tag").contains("`8`"));
    assert!(with("tag int", "tag string").contains("values of type `string`"));
    assert!(with("CELL_DATA 3", "NONSENSE 3").contains("`NONSENSE` where a section"));
    let newer = text("5.1");
    let first = newer.replacen("0 4 7 9", "1 4 7 9", 1);
    assert!(says(&first).contains("the first offset is not 0"));
    assert!(says(&newer.replacen("0 4 7 9", "0 7 4 9", 1)).contains("cell 0"));
    assert!(says(&newer.replacen("OFFSETS", "SETS", 1)).contains("no OFFSETS"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn meshes_survive_on_bits(mesh in meshes(), ascii in any::<bool>()) {
        let encoding = if ascii { Encoding::Ascii } else { Encoding::Binary };
        let mut out = Vec::new();
        vtk::write_with(&mut out, &mesh, &[], encoding).unwrap();
        let back = vtk::read(&out).unwrap();
        prop_assert_eq!(bits(&back.mesh.points), bits(&mesh.points));
        prop_assert_eq!(&back.mesh, &TetMesh { points: back.mesh.points.clone(), ..mesh });
        prop_assert!(back.notes.is_empty(), "{:?}", back.notes);
    }

    #[test]
    fn damaged_files_are_errors_of_one_line(
        mesh in meshes(),
        ascii in any::<bool>(),
        at in any::<prop::sample::Index>(),
        byte in any::<u8>(),
        cut in any::<prop::sample::Index>(),
    ) {
        let encoding = if ascii { Encoding::Ascii } else { Encoding::Binary };
        let mut out = Vec::new();
        vtk::write_with(&mut out, &mesh, &[], encoding).unwrap();
        for mut bytes in [out, binary_surface()] {
            let place = at.index(bytes.len());
            bytes[place] = byte;
            bytes.truncate(cut.index(2 * bytes.len()));
            let errors = [vtk::read(&bytes).err(), vtk::read_domain(&bytes).err()];
            for error in errors.into_iter().flatten() {
                let text = error.to_string();
                prop_assert!(!text.contains('\n') && text.len() < 300, "{text:?}");
            }
        }
    }
}
