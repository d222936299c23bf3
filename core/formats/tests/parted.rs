//! Parts of a mesh, and what they have in common.

use ltbw_core::{BoundaryFace, TetMesh};
use ltbw_formats as io;
use ltbw_formats::{Border, BorderError, PartOf, Piece, borders};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A cube of `n`³ cells, each of six tetrahedra around its diagonal.
fn cube(n: u32) -> TetMesh {
    let side = n + 1;
    let at = |[x, y, z]: [u32; 3]| x + side * (y + side * z);
    let each = |k: u32, n: u32| [k % n, k / n % n, k / n / n];
    let points = (0..side.pow(3)).map(|k| each(k, side).map(f64::from)).collect();
    let mut tets = Vec::new();
    for cell in (0..n.pow(3)).map(|k| each(k, n)) {
        // Up to the far corner, an axis after the other: odd orders are turned.
        for [a, b, c] in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]] {
            let mut corner = cell;
            let mut tet = [at(corner); 4];
            for (k, axis) in [(1, a), (2, b), (3, c)] {
                corner[axis] += 1;
                tet[k] = at(corner);
            }
            if (b + 3 - a) % 3 == 2 {
                tet.swap(1, 2);
            }
            tets.push(tet);
        }
    }
    TetMesh { points, tets, ..TetMesh::default() }
}

/// Some tetrahedra of a mesh as a part; a face is in that of its tetrahedron.
fn part(mesh: &TetMesh, list: &[usize]) -> Piece {
    let mut tets: Vec<[u32; 4]> = list.iter().map(|&t| mesh.tets[t]).collect();
    let numbers: BTreeSet<u32> = tets.iter().flatten().copied().collect();
    let numbers: Vec<u32> = numbers.into_iter().collect();
    let place = |v: u32| numbers.binary_search(&v).unwrap() as u32;
    tets.iter_mut().for_each(|tet| *tet = tet.map(place));
    let faces = mesh.faces.iter().filter_map(|face| {
        let tet = list.iter().position(|&t| t == face.tet)?;
        Some(BoundaryFace { corners: face.corners.map(place), tet, ..*face })
    });
    let of = |tags: &Vec<i64>| list.iter().map(|&t| tags[t]).collect();
    let mesh = TetMesh {
        points: numbers.iter().map(|&v| mesh.points[v as usize]).collect(),
        tets,
        faces: faces.collect(),
        tet_tags: mesh.tet_tags.as_ref().map(of),
        ..TetMesh::default()
    };
    Piece { mesh, numbers }
}

/// A mesh in parts, one of which may be empty: by the part of each tetrahedron.
fn parts(mesh: &TetMesh, of: usize, owner: impl Fn(usize) -> usize) -> Vec<Piece> {
    let list = |k| (0..mesh.tets.len()).filter(|&t| owner(t) == k).collect::<Vec<_>>();
    (0..of).map(|k| part(mesh, &list(k))).collect()
}

/// Corners, in the order of their numbers in the whole.
fn named<const N: usize>(piece: &Piece, corners: [u32; N]) -> Vec<u32> {
    let mut named: Vec<u32> = corners.iter().map(|&v| piece.numbers[v as usize]).collect();
    named.sort_unstable();
    named
}

/// All edges and faces of a tetrahedron, and itself and its corners.
fn simplices(tet: &[u32; 4]) -> Vec<Vec<u32>> {
    let subset = |mask: u32| {
        let mut own: Vec<u32> =
            (0..4).filter(|k| mask >> k & 1 == 1).map(|k| tet[k as usize]).collect();
        own.sort_unstable();
        own
    };
    (1..16).map(subset).collect()
}

#[test]
fn parts_know_what_they_have_in_common() {
    let mesh = cube(3);
    let tets = mesh.tets.len();
    let owners: [(usize, &dyn Fn(usize) -> usize); 5] = [
        (1, &|_| 0),
        (2, &|t| t * 2 / tets),
        (3, &|t| t % 3),
        (5, &|t| 1 + t * 3 / tets),
        (4, &|t| usize::from(t > 0)),
    ];
    for (of, owner) in owners {
        let all = parts(&mesh, of, owner);
        let found = borders(&all).unwrap();
        let mut who: BTreeMap<Vec<u32>, BTreeSet<u32>> = BTreeMap::new();
        for (t, tet) in mesh.tets.iter().enumerate() {
            for own in simplices(tet) {
                who.entry(own).or_default().insert(owner(t) as u32);
            }
        }
        let shared = |corners: usize, k: usize| -> Vec<(Vec<u32>, Vec<u32>)> {
            let is_here = |parts: &BTreeSet<u32>| parts.len() > 1 && parts.contains(&(k as u32));
            let all = who.iter().filter(|(own, parts)| own.len() == corners && is_here(parts));
            all.map(|(own, parts)| (own.clone(), parts.iter().copied().collect())).collect()
        };
        let mut numbers = BTreeMap::new();
        for (k, (piece, border)) in all.iter().zip(&found).enumerate() {
            let told = |corners| {
                let (vertices, edges, faces) = (&border.vertices, &border.edges, &border.faces);
                let mut all: Vec<(Vec<u32>, Vec<u32>)> = match corners {
                    1 => vertices
                        .iter()
                        .map(|c| (named(piece, c.corners), c.parts.clone()))
                        .collect(),
                    2 => edges.iter().map(|c| (named(piece, c.corners), c.parts.clone())).collect(),
                    _ => faces.iter().map(|c| (named(piece, c.corners), c.parts.clone())).collect(),
                };
                assert!(edges.iter().all(|c| c.corners.is_sorted()), "as the numbers ascend");
                all.sort_unstable();
                all
            };
            for corners in 1..=3 {
                assert_eq!(told(corners), shared(corners, k), "{corners} corners, {k} of {of}");
            }
            // Numbers: those that a part owns follow each other, and those of the parts before.
            let own: BTreeSet<u64> = border.numbers.iter().copied().collect();
            let until = found.get(k + 1).map_or(border.all_points, |next| next.points_before);
            assert!((border.points_before..until).all(|n| own.contains(&n)), "{k} of {of}");
            assert_eq!((border.all_points, border.all_tets), (64, tets as u64));
            let beyond = border.points.iter().map(|p| (p.given, p.number));
            let own = piece.numbers.iter().copied().zip(border.numbers.iter().copied());
            for (given, number) in own.chain(beyond) {
                assert_eq!(*numbers.entry(given).or_insert(number), number, "{k} of {of}");
            }
            ghosts(&mesh, (&all, &found), k, owner);
        }
        let distinct: BTreeSet<u64> = numbers.values().copied().collect();
        assert!(distinct.into_iter().eq(0..64), "each vertex has a number of its own");
        // The hull: twelve triangles a side of the cube times nine cells, all outwards.
        let hull: usize = found.iter().map(|border| border.hull.len()).sum();
        assert_eq!(hull, 6 * 9 * 2, "{of}");
        let volume: f64 = all.iter().zip(&found).map(|(piece, border)| cone(piece, border)).sum();
        assert!((volume - 27.0).abs() < 1e-9, "{volume}: the hull is oriented");
    }
}

/// The volume of cones from the origin to the part's facets of the hull.
fn cone(piece: &Piece, border: &Border) -> f64 {
    let of = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(|v| piece.mesh.points[v as usize]);
        let cross =
            [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0
    };
    border.hull.iter().map(|&face| of(face)).sum()
}

/// Makes sure that a part has copies of all tetrahedra at its vertices that others own.
fn ghosts(
    mesh: &TetMesh,
    (all, found): (&[Piece], &[Border]),
    k: usize,
    owner: &dyn Fn(usize) -> usize,
) {
    let (piece, border) = (&all[k], &found[k]);
    let is_near = |t: &usize| {
        owner(*t) != k && mesh.tets[*t].iter().any(|v| piece.numbers.binary_search(v).is_ok())
    };
    let wanted: BTreeSet<([u32; 4], u32)> =
        (0..mesh.tets.len()).filter(is_near).map(|t| (mesh.tets[t], owner(t) as u32)).collect();
    let place = |v: u32| match piece.numbers.get(v as usize) {
        Some(number) => *number,
        None => border.points[v as usize - piece.numbers.len()].given,
    };
    let copies = border.ghosts.iter().map(|ghost| (ghost.corners.map(place), ghost.owner));
    assert_eq!(copies.collect::<BTreeSet<_>>(), wanted);
    assert_eq!(border.ghosts.len(), wanted.len());
    for ghost in &border.ghosts {
        let own = ghost.number - found[ghost.owner as usize].tets_before;
        let theirs = &all[ghost.owner as usize];
        let tet = theirs.mesh.tets[own as usize].map(|v| theirs.numbers[v as usize]);
        assert_eq!(tet, ghost.corners.map(place), "a number of the tetrahedron");
    }
    for point in &border.points {
        assert_eq!(point.at, mesh.points[point.given as usize]);
    }
}

#[test]
fn what_is_no_part_is_refused_by_its_place() {
    let mesh = cube(1);
    let whole = part(&mesh, &[0, 1, 2, 3, 4, 5]);
    let refused = |all: &[Piece]| -> BorderError { borders(all).unwrap_err() };
    let mut odd = whole.clone();
    odd.numbers.swap(2, 3);
    let error = refused(&[Piece::default(), odd]);
    assert_eq!((error.part, error.what), (1, "numbers of points that do not ascend"));
    let mut odd = whole.clone();
    odd.mesh.tets[4][2] = 8;
    assert_eq!((refused(&[odd.clone()]).at, refused(&[odd]).length), (4, 6));
    // The sixth tetrahedron once more: each of its faces that is shared has three.
    let mut odd = whole.clone();
    odd.mesh.tets.push(odd.mesh.tets[5]);
    let error = refused(&[odd]);
    assert_eq!(error.what, "a third tetrahedron at a face");
    // In parts: one has it, too.
    let two = [part(&mesh, &[0, 1, 2]), part(&mesh, &[2, 3, 4, 5]), part(&mesh, &[2])];
    let error = refused(&two);
    assert_eq!(error.what, "a face that two other parts have, too");
    assert!(error.to_string().starts_with("part 0: a face that two other"), "{error}");
}

#[test]
fn words_that_make_no_sense_are_refused_by_their_sender() {
    let mesh = cube(2);
    let all = parts(&mesh, 2, |t| t % 2);
    let of = 2;
    let place = |part| PartOf { part, of };
    let [(mut one, to), (mut other, back)] =
        [0, 1].map(|k| io::Bordering::begin(&all[k], place(k)).unwrap());
    let first = [to[0].clone(), back[0].clone()];
    let mut cut = first.clone();
    cut[1].pop();
    assert_eq!(one.meet(&cut).unwrap_err().part, 1);
    let met = one.meet(&first).unwrap();
    let theirs = other.meet(&[to[1].clone(), back[1].clone()]).unwrap();
    let answers = [met[0].clone(), theirs[0].clone()];
    let back = [met[1].clone(), theirs[1].clone()];
    for spoil in [|words: &mut Vec<u64>| words.truncate(3), |words: &mut Vec<u64>| words[0] = 9] {
        let mut odd = answers.clone();
        spoil(&mut odd[1]);
        let (mut fresh, _) = io::Bordering::begin(&all[0], place(0)).unwrap();
        assert_eq!(fresh.number(&odd).unwrap_err().part, 1);
    }
    let told = [one.number(&answers).unwrap(), other.number(&back).unwrap()];
    let to = |k: usize| [told[0][k].clone(), told[1][k].clone()];
    let mut odd = to(1);
    odd[0].pop();
    let (mut fresh, _) = io::Bordering::begin(&all[1], place(1)).unwrap();
    fresh.number(&back).unwrap();
    let error = fresh.reach(&odd).unwrap_err();
    assert_eq!((error.part, error.what), (0, "fewer numbers than shared vertices"));
    let sent = [one.reach(&to(0)).unwrap(), other.reach(&to(1)).unwrap()];
    let mut odd = [sent[0][0].clone(), sent[1][0].clone()];
    let last = odd[1].len() - 1;
    odd[1][last] = 1000;
    let error = one.finish(&odd).unwrap_err();
    assert_eq!((error.part, error.at, error.what), (1, last, "a number that is too large"));
    assert!(other.finish(&[sent[0][1].clone(), sent[1][1].clone()]).is_ok());
}

/// A mesh in two regions, with its hull as boundary: of markers 0 and 4.
fn regions() -> TetMesh {
    let mut mesh = cube(3);
    let all = borders(&[part(&mesh, &(0..mesh.tets.len()).collect::<Vec<_>>())]).unwrap();
    let face = |corners: &[u32; 3]| {
        let has = |tet: &[u32; 4]| corners.iter().all(|v| tet.contains(v));
        let tet = mesh.tets.iter().position(has).unwrap();
        let marker = if tet.is_multiple_of(2) { 0 } else { 4 };
        BoundaryFace { corners: *corners, marker, tet }
    };
    let faces = all[0].hull.iter().map(face).collect();
    let region = |t: usize| if t < 70 { 3 } else { 8 };
    mesh.tet_tags = Some((0..mesh.tets.len()).map(region).collect());
    TetMesh { faces, ..mesh }
}

/// The tetrahedra by the coordinates of their corners, with regions; triangles with markers.
fn sorted(mesh: &TetMesh) -> (Vec<String>, Vec<String>) {
    let at = |v: u32| mesh.points[v as usize];
    let lines = |mut lines: Vec<String>| {
        lines.sort_unstable();
        lines
    };
    let tet = |(t, tet): (usize, &[u32; 4])| {
        format!("{:?} {:?}", tet.map(at), mesh.tet_tags.as_ref().map(|tags| tags[t]))
    };
    let face = |face: &BoundaryFace| format!("{:?} {}", face.corners.map(at), face.marker);
    let tets = mesh.tets.iter().enumerate().map(tet).collect();
    (lines(tets), lines(mesh.faces.iter().map(face).collect()))
}

#[test]
fn partitions_of_gmsh_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m_%.msh");
    for mesh in [cube(3), regions()] {
        for of in [1, 2, 5] {
            // The last part is empty where there are five.
            let all = parts(&mesh, of, |t| t % of.min(4));
            io::write_parts(&path, &all).unwrap();
            let read = io::read_mesh_file(&path).unwrap();
            assert_eq!(sorted(&read.mesh), sorted(&mesh), "{of}");
            assert_eq!((read.mesh.points.len(), read.notes), (64, vec![]), "{of}");
            let files = io::part_files(&path, of);
            assert!(io::mesh_files(&path).starts_with(&files), "{of}");
            for (file, piece) in files.iter().zip(&all) {
                let own = io::read_mesh_file(file).unwrap();
                assert_eq!(sorted(&own.mesh).0, sorted(&piece.mesh).0, "{}", file.display());
                assert_eq!(own.mesh.points, piece.mesh.points, "no node of a copy is left");
            }
        }
        std::fs::remove_file(folder.path().join("m_3.msh")).unwrap();
        let error = io::read_mesh(&path).unwrap_err().to_string();
        assert!(error.contains("m_3.msh: cannot read"), "{error}");
    }
}

#[test]
fn what_solvers_have_no_number_for_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, change: &dyn Fn(&mut TetMesh)| {
        let mut mesh = regions();
        change(&mut mesh);
        let error = io::write_parts(folder.path().join(name), &parts(&mesh, 2, |t| t % 2));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is written");
        error.unwrap_err().to_string()
    };
    let region = |mesh: &mut TetMesh| mesh.tet_tags.as_mut().unwrap()[5] = 0;
    let error = refused("m_%.msh", &region);
    assert!(
        error.ends_with(
            "m_1.msh: cannot write: there is the region 0, which this format \
         has no number for"
        ),
        "{error}"
    );
    assert!(refused("m.mfem", &region).contains("m.000000: cannot write: there is the region 0"));
    let error = refused("m.mfem", &|mesh| mesh.faces[3].marker = -1);
    assert!(error.contains("there is the marker -1"), "{error}");
}

/// A file of MFEM, as its numbers: elements, boundary, vertices; groups; what each has in common.
#[derive(Debug, Default)]
struct Mfem {
    elements: Vec<Vec<i64>>,
    boundary: Vec<Vec<i64>>,
    vertices: Vec<[f64; 3]>,
    groups: Vec<Vec<u32>>,
    shared: Vec<[Vec<Vec<u32>>; 3]>,
}

fn read_mfem(path: &Path) -> Mfem {
    let text = std::fs::read_to_string(path).unwrap();
    let lines = text.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    let mut lines = lines.map(|line| line.split(' ').collect::<Vec<_>>());
    let mut next = || lines.next().unwrap();
    fn numbers<T: std::str::FromStr>(line: &[&str]) -> Vec<T> {
        line.iter().map(|word| word.parse().ok().unwrap()).collect()
    }
    let count = |line: Vec<&str>| line[line.len() - 1].parse::<usize>().unwrap();
    assert_eq!(next(), ["MFEM", "mesh", "v1.2"]);
    assert_eq!([next(), next(), next()], [["dimension"], ["3"], ["elements"]]);
    let elements = (0..count(next())).map(|_| numbers(&next())).collect();
    assert_eq!(next(), ["boundary"]);
    let boundary = (0..count(next())).map(|_| numbers(&next())).collect();
    assert_eq!(next(), ["vertices"]);
    let points = count(next());
    assert_eq!(next(), ["3"]);
    let vertices = (0..points).map(|_| numbers(&next()).try_into().unwrap()).collect();
    assert_eq!([next(), next()], [["mfem_serial_mesh_end"], ["communication_groups"]]);
    let groups: Vec<Vec<u32>> = (0..count(next())).map(|_| numbers(&next()[1..])).collect();
    let totals: Vec<usize> = (0..3).map(|_| count(next())).collect();
    let mut shared = Vec::new();
    for _ in 1..groups.len() {
        let all = ["shared_vertices", "shared_edges", "shared_faces"].map(|word| {
            let head = next();
            assert_eq!(head[0], word);
            (0..count(head)).map(|_| numbers(&next())).collect()
        });
        shared.push(all);
    }
    for (k, total) in totals.into_iter().enumerate() {
        let found: usize = shared.iter().map(|all: &[Vec<Vec<u32>>; 3]| all[k].len()).sum();
        assert_eq!(found, total);
    }
    assert_eq!(next(), ["mfem_mesh_end"]);
    Mfem { elements, boundary, vertices, groups, shared }
}

/// Processes find what they have in common at one place of their lists.
#[test]
fn parts_of_mfem_agree() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.mfem");
    for (mesh, of) in [(cube(3), 1), (cube(3), 4), (regions(), 3), (regions(), 5)] {
        let all = parts(&mesh, of, |t| t % of.min(4));
        let found = borders(&all).unwrap();
        io::write_parts(&path, &all).unwrap();
        let files: Vec<Mfem> = io::part_files(&path, of).iter().map(|f| read_mfem(f)).collect();
        let mut lists: BTreeMap<Vec<u32>, Vec<Vec<String>>> = BTreeMap::new();
        let (mut elements, mut boundary) = (Vec::new(), 0);
        for (k, (file, piece)) in files.iter().zip(&all).enumerate() {
            assert_eq!(file.vertices, piece.mesh.points);
            assert_eq!(file.groups[0], [k as u32]);
            for (group, shared) in file.groups[1..].iter().zip(&file.shared) {
                assert!(group.contains(&(k as u32)) && group.is_sorted() && group.len() > 1);
                let at = |v: &u32| file.vertices[*v as usize];
                let name = |own: &Vec<u32>| match own.len() {
                    4 => format!("{} {:?}", own[0], own[1..].iter().map(at).collect::<Vec<_>>()),
                    _ => format!("{:?}", own.iter().map(at).collect::<Vec<_>>()),
                };
                let own = shared.iter().flatten().map(name).collect();
                lists.entry(group.clone()).or_default().push(own);
            }
            for row in &file.elements {
                let tet = [row[2], row[3], row[4], row[5]].map(|v| file.vertices[v as usize]);
                assert_eq!(row[1], 4);
                elements.push(format!("{tet:?} {:?}", (row[0] != 1).then_some(row[0])));
            }
            for row in &file.boundary {
                assert_eq!(row[1], 2);
                // Markers 0 and 4 are one more.
                let is_known = [1, 5].contains(&row[0]) && (mesh.faces.len() > 1 || row[0] == 1);
                assert!(is_known, "{row:?}");
                boundary += 1;
            }
        }
        for (group, lists) in &lists {
            assert_eq!(lists.len(), group.len(), "each of {group:?} knows the group");
            assert!(lists.iter().all(|list| *list == lists[0]), "{group:?}: one order");
        }
        elements.sort_unstable();
        assert_eq!(elements, sorted(&mesh).0);
        assert_eq!(boundary, 6 * 9 * 2);
        let pairs: usize = found.iter().map(|border| border.faces.len()).sum();
        let told: usize = files.iter().flat_map(|f| &f.shared).map(|all| all[2].len()).sum();
        assert_eq!(told, pairs);
    }
}

/// One who has all parts writes the file that each part's slabs are, whatever their order.
#[test]
fn slabs_are_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut mesh = regions();
    mesh.tet_attributes = Some((0..mesh.tets.len()).map(|t| t as f64 / 3.0).collect());
    for (mesh, of) in [(cube(3), 1), (cube(2), 5), (mesh, 3)] {
        let mut all = parts(&mesh, of, |t| t % of.min(4));
        if let Some(attributes) = &mesh.tet_attributes {
            for (k, piece) in all.iter_mut().enumerate() {
                let own = attributes.iter().enumerate().filter(|(t, _)| t % of == k);
                piece.mesh.tet_attributes = Some(own.map(|(_, value)| *value).collect());
            }
        }
        let path = folder.path().join("m.vtkhdf");
        io::write_parts(&path, &all).unwrap();
        let whole = std::fs::read(&path).unwrap();
        let (has_regions, has_markers) = (mesh.tet_tags.is_some(), !mesh.faces.is_empty());
        let arrays = io::Arrays {
            tags: false,
            regions: has_regions,
            markers: has_markers,
            attributes: mesh.tet_attributes.is_some(),
        };
        let slabs = io::Slabs::new(all.iter().map(io::PartSizes::of).collect(), arrays);
        let begun = io::begin_slabs(&path, &slabs).unwrap();
        for (part, border) in borders(&all).unwrap().iter().enumerate().rev() {
            let own = io::Bordered { piece: &all[part], border };
            io::write_slabs(&path, begun.aside(), &slabs, part, own).unwrap();
        }
        assert_eq!(std::fs::read(&path).unwrap(), whole, "the file has its name yet");
        begun.publish().unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert!(bytes == whole, "{of}");
        assert_eq!(bytes[..8], *b"\x89HDF\r\n\x1a\n");
        for name in ["region", "marker", "attribute"] {
            let is_there =
                bytes[..8192.min(bytes.len())].windows(name.len()).any(|w| w == name.as_bytes());
            assert_eq!(is_there, has_regions, "{name}");
        }
    }
    // A part that is none is refused, and leaves nothing.
    let slabs = io::Slabs::new(vec![io::PartSizes::default()], io::Arrays::default());
    let path = folder.path().join("other.vtkhdf");
    let begun = io::begin_slabs(&path, &slabs).unwrap();
    let piece = Piece { numbers: vec![1], ..Piece::default() };
    let own = io::Bordered { piece: &piece, border: &Border::default() };
    let error = io::write_slabs(&path, begun.aside(), &slabs, 0, own).unwrap_err().to_string();
    assert!(error.contains("1 tags for 0 points"), "{error}");
    drop(begun);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
