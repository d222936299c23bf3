//! Files that other programs write and users bring: strips, cells of second order, no ends, pieces,
//! TetGen's arrays, text in UTF-16.

use ltbw_core::{BoundaryFace, TetMesh};
use ltbw_domain::Domain;
use ltbw_exact::Point;
use ltbw_formats as io;
use ltbw_formats::{MeshFile, medit, msh, ply, pvtu, tetgen, vtk, vtu};
use std::fmt::Write as _;

/// Two tetrahedra at a common face, with the points in the midst of their edges behind the corners.
struct Curved {
    points: Vec<Point>,
    /// Corners, then the other nodes.
    tets: [[usize; 10]; 2],
    triangle: [usize; 6],
}

fn curved() -> Curved {
    let mut points: Vec<Point> =
        vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let mut known: Vec<[usize; 2]> = Vec::new();
    let mut middle = |a: usize, b: usize| {
        let ends = [a.min(b), a.max(b)];
        let place = known.iter().position(|e| *e == ends).unwrap_or_else(|| {
            let (p, q) = (points[a], points[b]);
            points.push([0, 1, 2].map(|k| 0.5 * (p[k] + q[k])));
            known.push(ends);
            known.len() - 1
        });
        5 + place
    };
    let tets = [[0, 1, 2, 3], [0, 2, 1, 4]].map(|[a, b, c, d]| {
        let edges = [[a, b], [b, c], [c, a], [a, d], [b, d], [c, d]];
        let [e, f, g, h, i, j] = edges.map(|[p, q]| middle(p, q));
        [a, b, c, d, e, f, g, h, i, j]
    });
    let [e, f, g] = [[1, 2], [2, 3], [3, 1]].map(|[p, q]| middle(p, q));
    Curved { points, tets, triangle: [1, 2, 3, e, f, g] }
}

impl Curved {
    fn rows(&self, first: usize) -> [String; 3] {
        let row = |nodes: &[usize]| {
            let names: Vec<String> = nodes.iter().map(|n| (n + first).to_string()).collect();
            names.join(" ")
        };
        [row(&self.tets[0]), row(&self.tets[1]), row(&self.triangle)]
    }

    /// The points, each with what comes before and behind it.
    fn list(&self, before: impl Fn(usize) -> String, behind: &str) -> String {
        self.points.iter().enumerate().fold(String::new(), |mut text, (i, [x, y, z])| {
            let _ = writeln!(text, "{}{x} {y} {z}{behind}", before(i));
            text
        })
    }

    /// The things to be read: the corners, all points, regions and the marker of the triangle.
    fn expect(&self, name: &str, file: &MeshFile) {
        let mesh = &file.mesh;
        assert_eq!(mesh.points, self.points, "{name}");
        assert_eq!(mesh.tets, [[0, 1, 2, 3], [0, 2, 1, 4]], "{name}");
        assert_eq!(mesh.tet_tags, Some(vec![7, 8]), "{name}");
        let face = BoundaryFace { corners: [1, 2, 3], marker: 9, tet: 0 };
        assert_eq!(mesh.faces, [face], "{name}");
        let told = |note: &String| note.contains("2 tetrahedra, 1 triangles of higher order");
        assert!(file.notes.iter().any(told), "{name}: {:?}", file.notes);
    }
}

#[test]
fn tetrahedra_of_second_order_are_read_by_their_corners() {
    let whole = curved();
    let count = whole.points.len();
    let [a, b, t] = whole.rows(1);
    let medit = format!(
        "MeshVersionFormatted 2\nDimension 3\nVertices {count}\n{}TetrahedraP2 2\n{a} 7\n{b} 8\n\
         TetrahedraP2Ordering 1\n1 2 3\nTrianglesP2 1\n{t} 9\nEnd\n",
        whole.list(|_| String::new(), " 0")
    );
    whole.expect("mesh", &medit::read(medit.as_bytes()).unwrap());
    for others in ["HexahedraQ2", "PrismsP2", "PyramidsP2"] {
        let error = medit::read(format!("Dimension 3\n{others} 0\n").as_bytes()).unwrap_err();
        assert_eq!(error.to_string(), format!("line 2: not supported: this section `{others}`"));
    }
    let older = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{count}\n{}$EndNodes\n$Elements\n3\n\
         1 11 2 7 1 {a}\n2 11 2 8 2 {b}\n3 9 2 9 1 {t}\n$EndElements\n",
        whole.list(|i| format!("{} ", i + 1), "")
    );
    whole.expect("msh 2.2", &msh::read(older.as_bytes()).unwrap());
    let names: String = (1..=count).fold(String::new(), |mut names, n| {
        let _ = writeln!(names, "{n}");
        names
    });
    let box_of = "0 0 0 1 1 1 1";
    let newer = format!(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 2\n1 {box_of} 9 0\n1 {box_of} 7 0\n\
         2 {box_of} 8 0\n$EndEntities\n$Nodes\n1 {count} 1 {count}\n3 1 0 {count}\n{names}{}\
         $EndNodes\n$Elements\n3 3 1 3\n3 1 11 1\n1 {a}\n3 2 11 1\n2 {b}\n2 1 9 1\n3 {t}\n\
         $EndElements\n",
        whole.list(|_| String::new(), "")
    );
    whole.expect("msh 4.1", &msh::read(newer.as_bytes()).unwrap());
    let node = format!("{count} 3\n{}", whole.list(|i| format!("{} ", i + 1), ""));
    let file = tetgen::read_pair(node.as_bytes(), format!("2 10 1\n1 {a} 7\n2 {b} 8\n").as_bytes());
    let file = tetgen::parse_face(format!("1 1\n1 {t} 9\n").as_bytes(), file.unwrap(), 1).unwrap();
    assert_eq!(file.notes.len(), 2);
    let notes = vec!["2 tetrahedra, 1 triangles of higher order".to_owned()];
    whole.expect("ele", &MeshFile { notes, ..file });
}

/// A `.vtk` and a `.vtu` with cells of these types.
fn of_vtk(whole: &Curved, types: [u8; 3]) -> [String; 2] {
    let (count, [a, b, t]) = (whole.points.len(), whole.rows(0));
    let points = whole.list(|_| String::new(), "");
    let types = types.map(|kind| kind.to_string()).join(" ");
    let old = format!(
        "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {count} double\n\
         {points}CELLS 3 29\n10 {a}\n10 {b}\n6 {t}\nCELL_TYPES 3\n{types}\nCELL_DATA 3\n\
         SCALARS region int 1\nLOOKUP_TABLE default\n7 8 8\nSCALARS marker int 1\n0 0 9\n"
    );
    let array = |section: &str, kind: &str, name: &str, text: &str| {
        format!(
            "<{section}><DataArray type='{kind}' Name='{name}' NumberOfComponents='{}' \
             format='ascii'>{text}</DataArray></{section}>\n",
            if section == "Points" { 3 } else { 1 }
        )
    };
    let xml = format!(
        "<VTKFile type='UnstructuredGrid'><UnstructuredGrid>\n<Piece NumberOfPoints='{count}' \
         NumberOfCells='3'>\n{}{}{}{}{}{}</Piece></UnstructuredGrid></VTKFile>",
        array("Points", "Float64", "Points", &points),
        array("Cells", "Int64", "connectivity", &[a, b, t].join(" ")),
        array("Cells", "Int64", "offsets", "10 20 26"),
        array("Cells", "UInt8", "types", &types),
        array("CellData", "Int64", "region", "7 8 8"),
        array("CellData", "Int64", "marker", "0 0 9"),
    );
    [old, xml]
}

#[test]
fn quadratic_and_lagrange_cells_of_vtk_are_read_by_their_corners() {
    let whole = curved();
    for types in [[24, 24, 22], [71, 71, 69]] {
        let [old, xml] = of_vtk(&whole, types);
        whole.expect("vtk", &vtk::read(old.as_bytes()).unwrap());
        whole.expect("vtu", &vtu::read(xml.as_bytes()).unwrap());
    }
    // A quadratic tetrahedron has ten points.
    let [old, xml] = of_vtk(&whole, [22, 24, 24]);
    for error in [vtk::read(old.as_bytes()).unwrap_err(), vtu::read(xml.as_bytes()).unwrap_err()] {
        assert!(error.to_string().contains("cell 0 has 10 corners, not 6"), "{error}");
    }
}

#[test]
fn regions_of_tetgen_are_read_from_its_vtk() {
    let text = |arrays: &str| {
        format!(
            "# vtk DataFile Version 2.0\nUnstructured Grid\nASCII\nDATASET UNSTRUCTURED_GRID\n\
             POINTS 5 double\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 0 -1\n\nCELLS 2 10\n4 0 1 2 3\n\
             4 0 2 1 4\n\nCELL_TYPES 2\n10\n10\n\nCELL_DATA 2\n{arrays}"
        )
    };
    let scalars = "SCALARS cell_scalars int 1\nLOOKUP_TABLE default\n2\n-3\n";
    let file = vtk::read(text(scalars).as_bytes()).unwrap();
    assert_eq!((file.mesh.tet_tags, file.notes), (Some(vec![2, -3]), vec![]));
    // Our own array comes first, and a note says that the other is not read.
    let both = format!("{scalars}SCALARS region int 1\nLOOKUP_TABLE default\n5\n6\n");
    let file = vtk::read(text(&both).as_bytes()).unwrap();
    assert_eq!((file.mesh.tet_tags, file.notes.len()), (Some(vec![5, 6]), 1));
    let floats = scalars.replace(" int", " double");
    let file = vtk::read(text(&floats).as_bytes()).unwrap();
    assert_eq!((file.mesh.tet_tags, file.notes.len()), (None, 1));
}

#[test]
fn medit_files_may_lack_their_end() {
    let text = "MeshVersionFormatted 1\nDimension 3\nVertices\n4\n0 0 0 1\n1 0 0 1\n0 1 0 1\n\
                0 0 1 1\nTetrahedra\n1\n1 2 3 4 1\n";
    let file = medit::read(text.as_bytes()).unwrap();
    assert_eq!(file.mesh.tets, [[0, 1, 2, 3]]);
    assert_eq!(file.notes, ["there is no `End`: sections may be missing"]);
    let whole = medit::read(format!("{text}End\n").as_bytes()).unwrap();
    assert_eq!((whole.mesh, whole.notes), (file.mesh, vec![]));
    // A file that was cut must not pass for points, or for fewer tetrahedra.
    let cut = medit::read(&text.as_bytes()[..text.find("Tetra").unwrap()]).unwrap_err();
    assert_eq!(cut.to_string(), "line 8: the file ends without `End`");
    assert!(medit::read(text.replace("\n1\n1 2", "\n2\n1 2").as_bytes()).is_err());
}

/// The facets of a domain as triangles, each from its least corner on.
fn triangles(domain: &Domain) -> Vec<(Vec<u32>, i32)> {
    let turned = |facet: &ltbw_domain::Facet| {
        let mut corners = facet.polygons.concat();
        let least = (0..corners.len()).min_by_key(|&k| corners[k]).expect("a corner");
        corners.rotate_left(least);
        (corners, facet.marker)
    };
    let mut all: Vec<_> = domain.facets.iter().map(turned).collect();
    all.sort();
    all
}

/// A grid of squares, each of two triangles, and for each row of it a strip.
fn sheet(width: u32, height: u32) -> (Vec<Point>, Vec<[u32; 3]>, Vec<Vec<i64>>) {
    let at = |x: u32, y: u32| y * (width + 1) + x;
    let vertices = (0..=height).flat_map(|y| (0..=width).map(move |x| (x, y)));
    let points = vertices.map(|(x, y)| [f64::from(x), f64::from(y), 0.0]).collect();
    let (mut faces, mut strips) = (Vec::new(), Vec::new());
    for y in 0..height {
        for x in 0..width {
            let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
            faces.extend([[c, a, d], [a, b, d]]);
        }
        let pairs = (0..=width).flat_map(|x| [at(x, y + 1), at(x, y)]);
        strips.push(pairs.map(i64::from).collect());
    }
    (points, faces, strips)
}

#[test]
fn strips_and_fans_are_triangles_that_are_turned_alike() {
    let (points, faces, strips) = sheet(4, 3);
    let expected = |markers: [i32; 3]| {
        let facets = faces.iter().zip(0..).map(|(&[a, b, c], k): (_, usize)| {
            ltbw_domain::Facet::polygon(&[a, b, c], markers[k / 8])
        });
        triangles(&Domain { facets: facets.collect(), ..Domain::default() })
    };
    let row = |list: &[i64]| {
        let words: Vec<String> = list.iter().map(i64::to_string).collect();
        format!("{} {}", list.len(), words.join(" "))
    };
    let rows: Vec<String> =
        points.iter().map(|p| format!("{} {} {}\n", p[0], p[1], p[2])).collect();
    let head = |element: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
             property float z\n{element}end_header\n{}",
            points.len(),
            rows.concat()
        )
    };
    let list = "property list int int vertex_indices\n";
    // A row for each strip, with its marker.
    let text: String =
        (5..).zip(&strips).map(|(m, strip)| format!("{} {m}\n", row(strip))).collect();
    let text = head(&format!("element tristrips 3\n{list}property int marker\n")) + &text;
    let found = ply::read_domain(text.as_bytes()).unwrap();
    assert_eq!(triangles(&found.domain), expected([5, 6, 7]));
    assert!(found.notes.is_empty());
    // One row, with -1 between them and at the end; corners twice, that lead a strip on.
    let mut one = Vec::new();
    for strip in &strips {
        one.extend([strip, &vec![strip[9], strip[9]], &vec![-1]].into_iter().flatten());
    }
    let text = head(&format!("element tristrips 1\n{list}")) + &row(&one);
    let found = ply::read_domain(text.as_bytes()).unwrap();
    assert_eq!(triangles(&found.domain), expected([0; 3]));
    // The four triangles around the second vertex of the second row.
    let fan = "element face 1\nproperty list int int vertex_indices\nelement trifans 1\n";
    let text = head(&format!("{fan}{list}")) + "3 0 1 6\n6 6 1 7 11 5 -1\n";
    let found = ply::read_domain(text.as_bytes()).unwrap();
    let corners: Vec<_> =
        triangles(&found.domain).into_iter().map(|(corners, _)| corners).collect();
    assert_eq!(corners, [[0, 1, 6], [1, 7, 6], [5, 6, 11], [6, 7, 11]]);
    // A corner that is not there, in the line of its strip.
    let text = head(&format!("element tristrips 2\n{list}")) + "3 0 1 2\n4 0 1 2 20\n";
    let error = ply::read_domain(text.as_bytes()).unwrap_err().to_string();
    let line = text.lines().count();
    assert!(error.starts_with(&format!("line {line}: strip 1 names point 20")), "{error}");
    let negative = text.replace("2 20", "2 -2");
    assert!(ply::read_domain(negative.as_bytes()).unwrap_err().to_string().contains("point -2"));
}

#[test]
fn strips_of_a_vtk_surface_come_behind_its_polygons() {
    let (points, faces, strips) = sheet(4, 3);
    let rows: Vec<String> =
        points.iter().map(|p| format!("{} {} {}\n", p[0], p[1], p[2])).collect();
    let row = |list: &[i64]| {
        let words: Vec<String> = list.iter().map(i64::to_string).collect();
        format!("{} {}\n", list.len(), words.join(" "))
    };
    let text = format!(
        "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS {} double\n{}\
         POLYGONS 1 4\n3 0 1 6\nTRIANGLE_STRIPS 2 22\n{}{}CELL_DATA 3\nSCALARS marker int 1\n\
         LOOKUP_TABLE default\n1 2 3\n",
        points.len(),
        rows.concat(),
        row(&strips[1]),
        row(&strips[2]),
    );
    let found = vtk::read_domain(text.as_bytes()).unwrap().domain;
    let polygon = ltbw_domain::Facet::polygon(&[0, 1, 6], 1);
    let strip = |(k, &[a, b, c]): (usize, &[u32; 3])| {
        ltbw_domain::Facet::polygon(&[a, b, c], if k < 16 { 2 } else { 3 })
    };
    let facets = [polygon].into_iter().chain(faces.iter().enumerate().skip(8).map(strip)).collect();
    assert_eq!(triangles(&found), triangles(&Domain { facets, ..Domain::default() }));
    let error = vtk::read_domain(text.replace("10 10 5", "10 99 5").as_bytes()).unwrap_err();
    assert!(error.to_string().contains("strip 0 names point 99"), "{error}");
}

/// Text that a shell or an editor has saved in two bytes a character.
#[test]
fn text_in_utf_16_is_refused_by_that_name() {
    let plain = "solid cube 1 2 3\n0.5 0.5 0.5 and so on, as long as a header of a binary file is\n\
                 or longer, so that there is a count in it";
    for (mark, big) in [(true, false), (true, true), (false, false), (false, true)] {
        let units = mark.then_some(0xfeff).into_iter().chain(plain.encode_utf16());
        let bytes: Vec<u8> = match big {
            true => units.flat_map(u16::to_be_bytes).collect(),
            false => units.flat_map(u16::to_le_bytes).collect(),
        };
        for format in io::Format::ALL {
            let several = matches!(format, io::Format::Node | io::Format::Ele | io::Format::Pvtu);
            let mut errors = Vec::new();
            if format.holds_points() && !matches!(format, io::Format::Npy | io::Format::Npz) {
                errors.extend(io::parse_points("a", format, &bytes).err());
            }
            if format.holds_mesh() && !several {
                errors.extend(io::parse_mesh("a", format, &bytes).err());
            }
            if format.holds_domain() {
                errors.extend(io::parse_domain("a", format, &bytes).err());
            }
            for error in errors {
                let expected = "a: line 1: the text is UTF-16; save the file as UTF-8";
                assert_eq!(error.to_string(), expected, "{format:?} {mark} {big}");
            }
        }
        let text = pvtu::sources(&bytes).unwrap_err().to_string();
        assert_eq!(text, "line 1: the text is UTF-16; save the file as UTF-8");
    }
}

/// A mesh of two tetrahedra with everything that pieces can have.
fn whole() -> TetMesh {
    let Curved { points, .. } = curved();
    TetMesh {
        points: points[..5].to_vec(),
        tets: vec![[0, 1, 2, 3], [0, 2, 1, 4]],
        point_tags: Some(vec![1, 2, 3, 4, 5]),
        tet_tags: Some(vec![7, 8]),
        tet_attributes: Some(vec![0.5, 1.5]),
        faces: vec![
            BoundaryFace { corners: [1, 2, 3], marker: 9, tet: 0 },
            BoundaryFace { corners: [1, 0, 4], marker: 6, tet: 1 },
        ],
    }
}

/// A tetrahedron of a mesh as a piece of its own.
fn piece(mesh: &TetMesh, tet: usize) -> TetMesh {
    let mut used = mesh.tets[tet];
    used.sort_unstable();
    let place = |v: u32| used.iter().position(|&u| u == v).expect("used") as u32;
    let faces = mesh.faces.iter().filter(|face| face.tet == tet);
    TetMesh {
        points: used.iter().map(|&v| mesh.points[v as usize]).collect(),
        tets: vec![mesh.tets[tet].map(place)],
        point_tags: mesh.point_tags.as_ref().map(|t| used.map(|v| t[v as usize]).to_vec()),
        tet_tags: mesh.tet_tags.as_ref().map(|t| vec![t[tet]]),
        tet_attributes: mesh.tet_attributes.as_ref().map(|t| vec![t[tet]]),
        faces: faces
            .map(|f| BoundaryFace { corners: f.corners.map(place), tet: 0, ..*f })
            .collect(),
    }
}

/// The numbers of its points in the whole, of which their tags tell.
fn numbers_of(mesh: &TetMesh) -> Vec<u32> {
    mesh.point_tags.iter().flatten().map(|&tag| tag as u32 - 1).collect()
}

#[test]
fn pieces_are_put_together_at_their_common_vertices() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a&b c.pvtu");
    let mesh = whole();
    let empty = TetMesh {
        point_tags: Some(vec![]),
        tet_tags: Some(vec![]),
        tet_attributes: Some(vec![]),
        ..TetMesh::default()
    };
    let mut second = piece(&mesh, 1);
    // The sign of a zero is no other place.
    second.points.iter_mut().flatten().filter(|c| **c == 0.0).for_each(|c| *c = -0.0);
    let numbered = |mesh: TetMesh| io::Piece { numbers: numbers_of(&mesh), mesh };
    io::write_parts(&path, &[empty, piece(&mesh, 0), second].map(numbered)).unwrap();
    assert_eq!(io::read_mesh(&path).unwrap(), mesh);
    let files = io::mesh_files(&path);
    assert_eq!(files, io::part_files(&path, 3));
    // A piece that is missing or broken is named.
    std::fs::write(&files[2], "<x/>").unwrap();
    let error = io::read_mesh(&path).unwrap_err().to_string();
    assert!(error.contains("a&b c_1.vtu: line 1: not a VTK file"), "{error}");
    std::fs::remove_file(&files[3]).unwrap();
    std::fs::copy(&files[1], &files[2]).unwrap();
    let error = io::read_mesh(&path).unwrap_err().to_string();
    assert!(error.contains("a&b c_2.vtu: cannot read"), "{error}");
    assert!(io::write_mesh(&path, &mesh).is_err() && io::check_mesh_writable(&path).is_err());
}

/// Vertices of one piece that are at one place stay two: a checker has to see them.
#[test]
fn vertices_of_one_piece_stay_apart() {
    let mesh = TetMesh { point_tags: None, ..whole() };
    let mut double = piece(&mesh, 0);
    double.points.push(double.points[0]);
    double.tets.push([4, 1, 2, 3]);
    double.tet_tags = Some(vec![7, 7]);
    double.tet_attributes = Some(vec![0.5, 0.5]);
    let mut all = pvtu::Join::default();
    for mesh in [double.clone(), piece(&mesh, 1)] {
        all.add(MeshFile { mesh, ..MeshFile::default() }).unwrap();
    }
    let found = all.finish().mesh;
    assert_eq!((found.points.len(), found.tets[2]), (6, [0, 2, 1, 5]));
    let mut some = pvtu::Join::default();
    some.add(MeshFile { mesh: double, ..MeshFile::default() }).unwrap();
    let bare = TetMesh { tet_tags: None, ..piece(&mesh, 1) };
    let error = some.add(MeshFile { mesh: bare, ..MeshFile::default() }).unwrap_err();
    assert_eq!(error.to_string(), "end of file: only some pieces have tags");
}

#[test]
fn lists_of_pieces_are_refused_with_a_line() {
    let list = |inside: &str| {
        let text = format!(
            "<VTKFile type='PUnstructuredGrid'>\n<PUnstructuredGrid GhostLevel='0'>\n{inside}\n\
             </PUnstructuredGrid>\n</VTKFile>"
        );
        pvtu::sources(text.as_bytes())
    };
    let sound = list("<Piece Source='a/b&amp;c.vtu'/>\n<Piece Source=\"d.vtu\"></Piece>").unwrap();
    assert_eq!(sound, ["a/b&c.vtu", "d.vtu"]);
    let says = |inside: &str| list(inside).unwrap_err().to_string();
    assert_eq!(says(""), "line 5: no piece is listed");
    assert_eq!(says("<Piece/>"), "line 3: a piece without the attribute `Source`");
    let twice = says("<Piece Source='a'/>\n<Piece Source='a'/>");
    assert_eq!(twice, "line 4: the piece `a` is there twice");
    assert!(says("<Piece Source='a'>").starts_with("line 4: not well-formed XML"));
    let of = |text: &str| pvtu::sources(text.as_bytes()).unwrap_err().to_string();
    assert_eq!(of("<x/>"), "line 1: not a VTK file");
    let other = of("<VTKFile type='UnstructuredGrid'/>");
    assert_eq!(other, "line 1: not supported: a VTK file of type `UnstructuredGrid`");
    let ghosts =
        of("<VTKFile type='PUnstructuredGrid'><PUnstructuredGrid GhostLevel='1'/></VTKFile>");
    assert_eq!(ghosts, "line 1: not supported: pieces with 1 layers of ghost cells");
}
