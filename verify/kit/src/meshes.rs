//! `cavity/`, `insert/`, `delaunay/`: one point into a mesh, and whole meshes.

use crate::{Case, File, hex, write};
use ltbw::topology::TetId;
use ltbw::{Builder, Mesh, Point, PointSet, Role};
use ltbw_tests::families::{
    body_centred, grid, mixed_exponents, scaled, signed_zeros, skew_lines, snapped, spheres,
    subnormal_grid, triplicated, uniform,
};
use ltbw_tests::oracle;
use ltbw_verify as verify;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// The largest set for which the definition (all quadruples) is evaluated.
const FEW: usize = 20;

/// The files of the folders.
#[must_use]
pub fn files() -> Vec<File> {
    let mut files = Vec::new();
    for (name, tier, about, insertions) in [
        ("human", 1, "One point into a tetrahedron, beyond it, and into a cut cube.", by_hand()),
        ("degenerate", 2, "One point into grids, spheres and planes.", degenerate()),
        ("range", 3, "One point far away or very near, up to the ends of f64.", extreme()),
    ] {
        let both: Vec<(Case, Case)> = insertions.iter().map(insertion).collect();
        let (cavities, fills) = both.into_iter().unzip();
        files.push(File { folder: "cavity", name, tier, about, cases: cavities });
        files.push(File { folder: "insert", name, tier, about, cases: fills });
    }
    let file = |name, tier, about, cases| File { folder: "delaunay", name, tier, about, cases };
    files.push(file("human", 1, "Meshes of a few points.", whole_by_hand()));
    files.push(file("degenerate", 2, "Grids, spheres, planes, duplicates.", whole_degenerate()));
    files.push(file("range", 3, "Sets whose products leave the range of f64.", whole_extreme()));
    files
}

/// A mesh and a point that comes to it.
struct Insertion {
    name: &'static str,
    flags: Vec<&'static str>,
    points: Vec<Point>,
    at: Point,
}

fn built(points: &[Point]) -> Mesh {
    let set = PointSet::new(points.to_vec()).expect("finite points");
    Builder::new().build(&set).expect("points that span space").mesh
}

/// Ascending, sorted.
fn plain(tets: impl Iterator<Item = [u32; 4]>) -> BTreeSet<[u32; 4]> {
    tets.map(|mut tet| {
        tet.sort_unstable();
        tet
    })
    .collect()
}

/// This facet, its smallest vertex first.
fn turned([a, b, c]: [u32; 3]) -> [u32; 3] {
    [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or([a, b, c])
}

/// The cases of `cavity/` and `insert/` of one insertion.
fn insertion(of: &Insertion) -> (Case, Case) {
    let Insertion { name, flags, points, at } = of;
    let mut mesh = built(points);
    let tets: Vec<(TetId, [u32; 4])> =
        mesh.tet_ids().filter_map(|t| mesh.tet(t).map(|v| (t, v))).collect();
    let ghosts: Vec<TetId> =
        mesh.topology().iter().filter(|(_, t)| t.is_ghost()).map(|(t, _)| t).collect();
    let hull: Vec<[u32; 3]> = mesh.hull_facets().map(turned).collect();
    let old = (plain(mesh.tets()), hull.iter().copied().collect::<BTreeSet<_>>());

    let mut roles: BTreeMap<TetId, Role> = BTreeMap::new();
    let mut record = |t: TetId, role: Role| {
        roles.insert(t, role);
        true
    };
    mesh.insert_with(*at, &mut record).expect("admitted");
    let finite = |role| -> Vec<usize> {
        (0..tets.len()).filter(|&k| roles.get(&tets[k].0) == Some(&role)).collect()
    };
    let infinite = |role| -> Vec<usize> {
        (0..ghosts.len()).filter(|&k| roles.get(&ghosts[k]) == Some(&role)).collect()
    };
    let new = (plain(mesh.tets()), mesh.hull_facets().map(turned).collect::<BTreeSet<_>>());
    let all = [points.clone(), vec![*at]].concat();
    agree(name, &all, &new.0);
    // The tetrahedra that are gone are the cavity, by the meshes before and after.
    let gone: Vec<usize> =
        (0..tets.len()).filter(|&k| plain([tets[k].1].into_iter()).is_disjoint(&new.0)).collect();
    assert_eq!(gone, finite(Role::Cavity), "{name}");

    let ask = |op: &str| {
        let vertices: Vec<[u32; 4]> = tets.iter().map(|(_, v)| *v).collect();
        json!({
            "op": op, "points": write(points), "tets": vertices, "hull": hull,
            "at": at.map(hex::to_hex),
        })
    };
    let case = |ask, flags: Vec<&'static str>, expect: Value| Case {
        name: (*name).to_string(),
        flags,
        ask,
        expect,
    };
    let closure = json!({
        "cavity": finite(Role::Cavity), "cavity_hull": infinite(Role::Cavity),
        "ring": finite(Role::Ring), "ring_hull": infinite(Role::Ring),
    });
    let created = json!({
        "created": new.0.difference(&old.0).collect::<Vec<_>>(),
        "created_hull": new.1.difference(&old.1).collect::<Vec<_>>(),
    });
    let with_ring = [flags.clone(), vec!["ring"]].concat();
    (case(ask("cavity"), with_ring, closure), case(ask("insert"), flags.clone(), created))
}

/// The mesh is the one of the definition (a few points) or of the independent checker (many).
fn agree(name: &str, points: &[Point], tets: &BTreeSet<[u32; 4]>) {
    if points.len() <= FEW {
        let expected: BTreeSet<[u32; 4]> = oracle::brute_force(points).into_iter().collect();
        assert_eq!(tets, &expected, "{name}");
    }
    let list: Vec<[u32; 4]> = tets.iter().copied().collect();
    let options = verify::Options {
        vertex_order: verify::VertexOrder::Any,
        all_points: true,
        ..verify::Options::default()
    };
    let report = verify::check(&verify::Mesh::new(points, &list), &options);
    assert!(report.passed(), "{name}: {:?}", report.defects);
}

fn by_hand() -> Vec<Insertion> {
    let corner = vec![[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    let new = |name, flags: &[&'static str], points: &[Point], at| Insertion {
        name,
        flags: flags.to_vec(),
        points: points.to_vec(),
        at,
    };
    vec![
        new("inside a tetrahedron", &["sign-convention"], &corner, [1.0; 3]),
        new("beyond one facet", &["hull"], &corner, [1.0, 1.0, -1.0]),
        new("beyond three facets", &["hull"], &corner, [-1.0; 3]),
        new("on a hull facet", &["hull-plane"], &corner, [1.0, 1.0, 0.0]),
        new("in a facet's plane, outside it", &["hull-plane"], &corner, [4.0, 4.0, 0.0]),
        new("on a hull edge", &["hull-plane"], &corner, [2.0, 0.0, 0.0]),
        new("the middle of a cube", &["tie"], &grid(2), [0.5; 3]),
        new("a cube's eighth corner", &["tie", "tie-order"], &grid(2)[..7], [1.0; 3]),
    ]
}

fn degenerate() -> Vec<Insertion> {
    let sphere = spheres(&[9]);
    let new =
        |name, flag, points: Vec<Point>, at| Insertion { name, flags: vec![flag], points, at };
    let mut missing = grid(3);
    let middle = missing.remove(13);
    let mut face = grid(3);
    let side = face.remove(4);
    let (rest, last) = sphere.split_at(sphere.len() - 1);
    vec![
        new("the middle of a grid", "tie", missing, middle),
        new("the middle of a grid's side", "hull-plane", face, side),
        new("the centre of a grid's cell", "tie", grid(3), [0.5; 3]),
        new("on an edge of a grid", "tie", grid(3), [0.5, 1.0, 1.0]),
        new("the last point of a sphere", "tie", rest.to_vec(), last[0]),
        new("the centre of a sphere", "tie", sphere.clone(), [0.0; 3]),
        new("beyond a grid, in a side's plane", "hull-plane", grid(3), [3.0, 1.0, 2.0]),
        new("beyond a grid's corner", "hull", grid(3), [5.0; 3]),
        new("into random points", "sign-convention", uniform(40, 1), [0.5; 3]),
        new("into a body-centred grid", "tie", body_centred(2), [1.0, 2.0, 2.0]),
        new("between skew lines", "rounded", skew_lines(6), [1.5, 1.5, 0.5]),
    ]
}

fn extreme() -> Vec<Insertion> {
    let new =
        |name, flag, points: Vec<Point>, at| Insertion { name, flags: vec![flag], points, at };
    let tiny = f64::from_bits(1);
    vec![
        new("a grid of subnormals", "range", subnormal_grid(3), [tiny, tiny, 4.0 * tiny]),
        new("a far point", "range", grid(2), [1e300; 3]),
        new("a grid times 2^600", "range", scaled(&grid(2), 600), scaled(&[[0.5; 3]], 600)[0]),
        new("one unit off a hull plane", "rounded", grid(2), [0.5, 0.5, -tiny]),
        new(
            "one unit off a sphere",
            "rounded",
            grid(2)[..7].to_vec(),
            [1.0, 1.0, 1.0f64.next_up()],
        ),
        new("one unit inside it", "rounded", grid(2)[..7].to_vec(), [1.0, 1.0, 1.0f64.next_down()]),
    ]
}

/// A whole mesh. Small ones give the tetrahedra, too.
fn whole(name: &str, flags: &[&'static str], points: &[Point]) -> Case {
    let mesh = built(points);
    let tets = plain(mesh.tets());
    agree(name, points, &tets);
    let list: Vec<[u32; 4]> = tets.iter().copied().collect();
    let hash = mesh.hash().expect("a hash").to_string();
    let mut reversed = points.to_vec();
    reversed.reverse();
    assert_eq!(built(&reversed).hash().expect("a hash").to_string(), hash, "{name}");
    Case {
        name: name.to_string(),
        flags: [flags, &["hash"]].concat(),
        ask: json!({"op": "delaunay", "points": write(points)}),
        expect: json!({
            "tets": list.len(), "hull": mesh.num_hull_faces(),
            "hash": hash, "list": (list.len() <= 40).then_some(list),
        }),
    }
}

fn whole_by_hand() -> Vec<Case> {
    let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut five = corner.to_vec();
    five.push([1.0; 3]);
    let mut twice = corner.to_vec();
    twice.extend([[-0.0, 0.0, -0.0], [0.0, 1.0, 0.0]]);
    let mut centred = grid(2);
    centred.push([0.5; 3]);
    vec![
        whole("one tetrahedron", &["sign-convention"], &corner),
        whole("two that share a face", &["tie"], &five),
        whole("equal points, zeros of both signs", &["duplicate", "negative-zero"], &twice),
        whole("a cube", &["tie", "tie-order"], &grid(2)),
        whole("a cube and its centre", &["tie"], &centred),
    ]
}

fn whole_degenerate() -> Vec<Case> {
    let mut cases = vec![
        whole("grid 3 x 3 x 3", &["tie", "hull-plane"], &grid(3)),
        whole("integer points of a sphere", &["tie", "second-round"], &spheres(&[9])),
        whole("body-centred grid", &["tie"], &body_centred(2)),
        whole("skew lines", &["rounded"], &skew_lines(8)),
        whole("signed zeros", &["negative-zero", "duplicate"], &signed_zeros(3, 1)),
        whole("every point three times", &["duplicate"], &triplicated(&uniform(20, 2), 3)),
        whole("uniform", &["sign-convention"], &uniform(60, 4)),
    ];
    let sets = (1u64..).map(snapped).filter(|points| {
        PointSet::new(points.clone()).is_ok_and(|set| Builder::new().build(&set).is_ok())
    });
    cases.extend(sets.take(16).map(|points| whole("snapped", &["tie", "rounded"], &points)));
    cases
}

fn whole_extreme() -> Vec<Case> {
    let mut both = scaled(&grid(2), 600);
    both.extend(subnormal_grid(2));
    vec![
        whole("subnormal grid", &["range", "tie"], &subnormal_grid(3)),
        whole("grid times 2^600", &["range", "tie"], &scaled(&grid(3), 600)),
        whole("both together", &["range"], &both),
        whole("exponents +-300", &["range"], &mixed_exponents(20, 300, 1)),
        whole("exponents +-1000", &["range"], &mixed_exponents(20, 1000, 2)),
    ]
}
