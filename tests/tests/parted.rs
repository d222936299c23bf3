//! Meshes of points that stay in parts: hash, check and files by teams whose members share nothing
//! but letters, and none of which ever has the mesh.

use ltbw::distributed::{self, Hashed, Part, Slice};
use ltbw::io::{self, Arrays, Border, PartOf, Piece};
use ltbw::team::Team;
use ltbw::{Builder, CancelToken, Point, PointSet, TetMesh, canonical_hash};
use ltbw_cli::ranks::Judge;
use ltbw_generate::{PointKind, generate};
use ltbw_tests::families::{Family, Size, all};
use ltbw_tests::teams::{on_team, slice_of};
use ltbw_verify as verify;

/// The tetrahedra of a mesh by the input's numbers, in one order whatever the parts.
fn ordered(tets: impl Iterator<Item = [u32; 4]>) -> Vec<[u32; 4]> {
    let sorted = |mut tet: [u32; 4]| {
        tet.sort_unstable();
        tet
    };
    let mut tets: Vec<[u32; 4]> = tets.map(sorted).collect();
    tets.sort_unstable();
    tets
}

/// Nothing is put together: each member has its part, and all of them the hash of the whole.
#[test]
fn families_on_teams_have_the_sequential_hash() {
    let mut messages = 0;
    for Family { name, points } in all(Size::Moderate) {
        let set = PointSet::new(points).expect("finite points");
        let expected = Builder::new().build(&set).expect("a mesh");
        let mesh = &expected.mesh;
        let hash = mesh.hash().expect("a hash");
        let (vertices, tets) = (mesh.num_vertices() as u64, mesh.num_tets() as u64);
        for members in [1, 2, 3, 5, 8] {
            let ends = on_team(members, |team| {
                let slice = slice_of(team, set.points());
                let built = Builder::new().build_on(team, &slice).expect("a mesh");
                let hashed = distributed::hash(team, &built.part).expect("a hash");
                let report = judged(team, &built.part, &slice);
                assert!(report.passed(), "{name} on {members}: {:?}", report.defects);
                assert_eq!(report.hash, verify::Hash::Value(hash.to_string()), "{name}");
                (built, hashed, team.figures())
            });
            let mut all = Vec::new();
            for (built, hashed, figures) in &ends {
                messages += figures.messages;
                assert_eq!(*hashed, Hashed { hash, vertices, tets }, "{name} on {members}");
                assert_eq!(built.num_duplicates, expected.duplicates.len() as u64, "{name}");
                assert_eq!((built.tets, built.hull_faces), (tets, mesh.num_hull_faces() as u64));
                assert_eq!(built.workers.len(), members as usize);
                let Part { numbers, points, .. } = &built.part;
                assert!(numbers.is_sorted(), "{name} on {members}");
                assert!(numbers.iter().zip(points).all(|(&v, p)| set.points()[v as usize] == *p));
                all.extend(built.part.numbered());
            }
            assert_eq!(ends[0].0.duplicates, expected.duplicates, "{name} on {members}");
            assert!(ordered(all.into_iter()) == ordered(mesh.tets()), "{name} on {members}");
        }
    }
    assert!(messages > 0, "no member ever spoke to another");
}

/// The checker's report on a mesh in parts.
fn judged(team: &mut Team, part: &Part, slice: &Slice) -> verify::Report {
    let Part { numbers, points, tets, .. } = part;
    let own = verify::Part { points, numbers, tets, given: slice.points() };
    let options = verify::Options { all_points: true, ..verify::Options::default() };
    verify::check_parted(&mut Judge(team), &own, &options).expect("a report")
}

/// Each member writes its part, and nobody has the mesh before it is read.
#[test]
fn parts_that_members_write_are_the_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    for (kind, members) in [(PointKind::Uniform, 1), (PointKind::Clusters, 3), (PointKind::Grid, 5)]
    {
        let set = PointSet::new(generate(kind, 700, 3)).expect("points");
        let mesh = Builder::new().build(&set).expect("a mesh").mesh;
        let path = folder.path().join(format!("{kind:?}.pvtu"));
        let tags: Vec<i64> = (0..set.len() as i64).map(|k| k * k).collect();
        let parts = on_team(members, |team| {
            let slice = slice_of(team, set.points());
            let Part { numbers, points, tets, .. } =
                Builder::new().build_on(team, &slice).expect("a mesh").part;
            let own = &tags[slice.first() as usize..][..slice.points().len()];
            let point_tags = distributed::tags(team, &slice, Some(own), &numbers).expect("tags");
            let mesh = TetMesh { points, tets, point_tags, ..TetMesh::default() };
            let place = PartOf { part: team.me().index(), of: members as usize };
            let piece = Piece { mesh, numbers };
            let border = distributed::border(team, &piece).expect("a border");
            let token = CancelToken::new();
            let file = io::write_part(&path, place, &piece, &border, &token).expect("a part");
            assert!(!path.exists(), "no file has its name before all are there");
            file.publish().expect("its name");
            (piece, border)
        });
        let (parts, borders): (Vec<Piece>, Vec<Border>) = parts.into_iter().unzip();
        assert!(borders == io::borders(&parts).expect("the same"), "{kind:?} on {members}");
        let arrays = Arrays { tags: true, ..Arrays::default() };
        io::write_list(&path, members as usize, arrays)
            .and_then(io::Unnamed::publish)
            .expect("a list");
        let read = io::read_mesh(&path).expect("the mesh");
        let hash = canonical_hash(&read.points, &read.tets).expect("a hash");
        assert_eq!(hash, mesh.hash().expect("a hash"), "{kind:?} on {members}");
        let of_point =
            |p: &Point| set.points().iter().position(|q| p == q).expect("a point") as i64;
        let told = read.point_tags.expect("tags");
        assert!(read.points.iter().zip(told).all(|(p, tag)| tag == of_point(p).pow(2)), "{kind:?}");
        // The files are those that one who has all parts writes.
        let whole = folder.path().join("whole").with_extension("pvtu");
        io::write_parts(&whole, &parts).expect("written");
        for (one, other) in io::part_files(&path, parts.len())
            .iter()
            .zip(io::part_files(&whole, parts.len()))
            .skip(1)
        {
            let bytes =
                [one.as_path(), other.as_path()].map(|file| std::fs::read(file).expect("a file"));
            assert!(bytes[0] == bytes[1], "{kind:?} on {members}");
        }
    }
}

/// A part whose numbers make no sense ends all members, with its name.
#[test]
fn a_part_that_is_none_has_no_border() {
    let points = generate(PointKind::Uniform, 300, 7);
    let set = PointSet::new(points).expect("points");
    let ends = on_team(3, |team| {
        let slice = slice_of(team, set.points());
        let Part { mut numbers, points, tets, .. } =
            Builder::new().build_on(team, &slice).expect("a mesh").part;
        if team.me().index() == 1 {
            numbers.reverse();
        }
        let mesh = TetMesh { points, tets, ..TetMesh::default() };
        let piece = Piece { mesh, numbers };
        distributed::border(team, &piece).expect_err("no border").to_string()
    });
    assert!(ends[1].contains("numbers of points that do not ascend"), "{}", ends[1]);
    for end in [&ends[0], &ends[2]] {
        assert_eq!(end, "worker 1 has failed");
    }
}

/// One member is told all tetrahedra, and all facets of the hull.
#[test]
fn tetrahedra_alone_come_to_the_first_member() {
    let points = generate(PointKind::Uniform, 900, 5);
    let set = PointSet::new(points).expect("points");
    let mesh = Builder::new().build(&set).expect("a mesh").mesh;
    for members in [1, 2, 5] {
        let ends = on_team(members, |team| {
            let slice = slice_of(team, set.points());
            let part = Builder::new().build_on(team, &slice).expect("a mesh").part;
            distributed::gather(team, &part, set.len()).expect("all of them")
        });
        let mut ends = ends.into_iter();
        let first = ends.next().flatten().expect("the first member's");
        assert!(ends.all(|end| end.is_none()), "one member has them");
        assert_eq!(first.tets.len(), members as usize);
        assert!(ordered(first.tets.into_iter().flatten()) == ordered(mesh.tets()), "{members}");
        let hull = |facets: Vec<[u32; 3]>| {
            let mut facets: Vec<[u32; 3]> = facets
                .into_iter()
                .map(|mut facet| {
                    facet.sort_unstable();
                    facet
                })
                .collect();
            facets.sort_unstable();
            facets
        };
        assert_eq!(hull(first.hull), hull(mesh.hull_facets().collect()), "{members}");
    }
}

/// Any division into parts has the hash: a part may be empty, and the sign of zero is none.
#[test]
fn the_hash_does_not_depend_on_the_parts() {
    let kinds = [PointKind::Uniform, PointKind::Grid, PointKind::Clusters];
    for (kind, members) in kinds.into_iter().flat_map(|kind| [2, 3, 8].map(|m| (kind, m))) {
        let points = generate(kind, 300, 11);
        let points = points.into_iter().map(|p| p.map(|c| c - 0.5)).collect();
        let set = PointSet::new(points).expect("finite points");
        let mesh = Builder::new().build(&set).expect("a mesh").mesh;
        let hash = mesh.hash().expect("a hash");
        let tets: Vec<[u32; 4]> = mesh.tets().collect();
        // In turn; all at the last one; in stretches, the first of which is empty.
        let owners: [&(dyn Fn(usize) -> u32 + Sync); 3] =
            [&|k| k as u32 % members, &|_| members - 1, &|k| {
                1 + (k * (members as usize - 1) / tets.len()) as u32
            }];
        for owner in owners {
            let hashes = on_team(members, |team| {
                let me = team.me().number();
                let own = (0..tets.len()).filter(|&k| owner(k) == me).map(|k| tets[k]);
                let part = part_of(
                    own.collect(),
                    |p| match me % 2 {
                        0 => p.map(|c| if c == 0.0 { -0.0 } else { c }),
                        _ => *p,
                    },
                    set.points(),
                );
                distributed::hash(team, &part).expect("a hash").hash
            });
            assert!(hashes.iter().all(|other| *other == hash), "{kind:?} on {members}");
        }
    }
}

/// Some tetrahedra of a mesh as a part, whose points are changed.
fn part_of(mut tets: Vec<[u32; 4]>, change: impl Fn(&Point) -> Point, points: &[Point]) -> Part {
    let mut numbers: Vec<u32> = tets.iter().flatten().copied().collect();
    numbers.sort_unstable();
    numbers.dedup();
    let place = |v: u32| numbers.binary_search(&v).expect("a corner") as u32;
    tets.iter_mut().for_each(|tet| *tet = tet.map(place));
    let points = numbers.iter().map(|&v| change(&points[v as usize])).collect();
    Part { numbers, points, tets, hull: Vec::new() }
}
