//! Snapshots of meshes, and the feature `serde`: there and back, and refusals.

use ltbw_core::snapshot::StoredVertex;
use ltbw_core::{Budget, BuildError, Builder, Duplicate, Inserted, Mesh, Snapshot, SnapshotError};
use ltbw_exact::{Mode, PointError, PointSet};
use ltbw_generate::{PointKind, generate};

fn build(kind: PointKind) -> Mesh {
    let set = PointSet::new(generate(kind, 300, 5)).expect("finite points");
    Builder::new().build(&set).expect("points of dimension 3").mesh
}

/// Everything that a snapshot promises to keep.
fn assert_same(a: &Mesh, b: &Mesh) {
    assert_eq!(a.hash().expect("a hash"), b.hash().expect("a hash"));
    assert_eq!(a.duplicates(), b.duplicates());
    let sorted = |mesh: &Mesh| {
        let mut all: Vec<_> = mesh.vertices().map(|(v, p)| (v, p.map(f64::to_bits))).collect();
        all.sort_unstable();
        let mut tets: Vec<[u32; 4]> = mesh.tets().collect();
        tets.iter_mut().for_each(|t| t.sort_unstable());
        tets.sort_unstable();
        (all, tets)
    };
    assert_eq!(sorted(a), sorted(b));
}

#[test]
fn snapshots_of_every_kind_restore_the_mesh() {
    for kind in PointKind::ALL {
        let mut mesh = build(kind);
        let mut restored = mesh.snapshot().expect("a hash").restore().expect("a sound snapshot");
        assert_same(&mesh, &restored);
        // Both go on alike, outside the exactness window too.
        for p in [[0.1, 0.2, 0.3], [1e200, -3.0, 1e-200]] {
            let inserted = mesh.insert(p).expect("a finite point");
            assert!(matches!(inserted, Inserted::Vertex(_)));
            assert_eq!(restored.insert(p), Ok(inserted));
            assert_same(&mesh, &restored);
        }
        assert_eq!(mesh.mode(), Mode::Wide);
        let again = mesh.snapshot().expect("a hash").restore().expect("a sound snapshot");
        assert_same(&mesh, &again);
    }
}

#[test]
fn a_mesh_that_a_budget_cut_short_is_restored() {
    let set = PointSet::new(generate(PointKind::Duplicates, 300, 5)).expect("finite points");
    let budget = Budget { max_points: Some(120), ..Budget::default() };
    let mesh = Builder::new().budget(budget).build(&set).expect("points of dimension 3").mesh;
    assert!(mesh.num_vertices() < 121 && !mesh.duplicates().is_empty());
    let restored = mesh.snapshot().expect("a hash").restore().expect("a sound snapshot");
    assert_same(&mesh, &restored);
}

#[test]
fn a_count_without_vertices_is_refused_and_costs_no_memory() {
    let mut mesh = build(PointKind::Duplicates).snapshot().expect("a hash");
    let most = 1 << 20;
    let last = mesh.vertices.last_mut().expect("a vertex");
    let moved = std::mem::replace(&mut last.number, most);
    mesh.duplicates.retain(|d| d.kept != moved);
    assert!(!mesh.duplicates.is_empty());
    mesh.next = most + 1;
    let error = mesh.restore().expect_err("a number out of proportion");
    assert_eq!(error, SnapshotError::Next { next: most + 1, limit: most as usize });
    let trusted = mesh.restore_within(usize::MAX).expect("a sound snapshot");
    let queries = trusted.queries();
    assert!(queries.memory_bytes() < 300 * 16, "{}", queries.memory_bytes());
    for (v, p) in trusted.vertices() {
        assert_eq!((queries.vertex(v), queries.point(v)), (Some(v), Some(p)));
    }
    for &Duplicate { number, kept } in trusted.duplicates() {
        assert_eq!(queries.vertex(number), Some(kept));
    }
    for absent in [moved, most - 1, most + 1, u32::MAX] {
        assert_eq!(queries.vertex(absent), None);
    }
    mesh.next = u32::MAX;
    let error = mesh.restore_within(usize::MAX).expect_err("above every limit");
    assert!(matches!(error, SnapshotError::Next { limit: 0x1000_0000, .. }));
}

#[test]
fn corrupt_snapshots_are_refused_with_the_reason() {
    let sound = build(PointKind::Duplicates).snapshot().expect("a hash");
    let refused = |change: &dyn Fn(&mut Snapshot)| {
        let mut snapshot = sound.clone();
        change(&mut snapshot);
        snapshot.restore().expect_err("a corrupt snapshot")
    };
    let error = refused(&|s| s.schema = "ltbw.snapshot/9".into());
    assert_eq!(error, SnapshotError::Schema { found: "ltbw.snapshot/9".into() });
    let error = refused(&|s| s.vertices[7].bits[1] = f64::NAN.to_bits());
    assert!(matches!(
        error,
        SnapshotError::Point(PointError::NotFinite { index: 7, axis: 'y', .. })
    ));
    assert!(matches!(refused(&|s| s.vertices.swap(3, 4)), SnapshotError::Number { index: 4, .. }));
    let error = refused(&|s| s.vertices[4] = s.vertices[3]);
    assert!(matches!(error, SnapshotError::Number { index: 4, .. }));
    assert!(matches!(refused(&|s| s.next = 50), SnapshotError::Number { next: 50, .. }));
    assert!(matches!(refused(&|s| s.next = u32::MAX), SnapshotError::Next { next: u32::MAX, .. }));
    for change in [(299, 298), (0, 0), (5, 200), (300, 0)] {
        let error = refused(&|s| s.duplicates[1] = change.into());
        assert!(matches!(error, SnapshotError::Duplicate { .. }), "{change:?}: {error}");
    }
    let (first, second) = (sound.vertices[10].number, sound.vertices[12].number);
    let error = refused(&|s| s.vertices[12].bits = s.vertices[10].bits);
    assert_eq!(error, SnapshotError::SamePlace { first, second });
    for error in [
        refused(&|s| s.vertices[20].bits[2] ^= 1),
        refused(&|s| s.hash.0[31] ^= 128),
        refused(&|s| {
            s.duplicates.clear();
            s.vertices.truncate(90);
        }),
    ] {
        let stored_is_not_found =
            matches!(&error, SnapshotError::OtherMesh { stored, found } if stored != found);
        assert!(stored_is_not_found, "{error}");
    }
    let error = refused(&|s| {
        s.duplicates.clear();
        s.vertices.truncate(3);
    });
    assert_eq!(error, SnapshotError::Build(BuildError::TooFewPoints { distinct: 3 }));
    let error = refused(&|s| {
        s.duplicates.clear();
        s.vertices.iter_mut().for_each(|v: &mut StoredVertex| v.bits[0] = 0);
    });
    assert!(matches!(error, SnapshotError::Build(BuildError::Coplanar { .. })), "{error}");
}

#[cfg(feature = "serde")]
mod with_serde {
    use super::*;
    use ltbw_core::query::Location;
    use ltbw_core::topology::TetId;
    use ltbw_core::{MeshHash, Order, Outcome, Role, Stats, TetMesh};
    use ltbw_exact::Sign;
    use serde::{Serialize, de::DeserializeOwned};

    fn there_and_back<T: Serialize + DeserializeOwned>(value: &T) -> T {
        let text = serde_json::to_string(value).expect("a value that can be written");
        serde_json::from_str(&text).expect("what was written")
    }

    #[test]
    fn meshes_survive() {
        for kind in PointKind::ALL {
            let mesh = build(kind);
            assert_same(&mesh, &there_and_back(&mesh));
            let plain = TetMesh { point_tags: Some(vec![i64::MIN; 300]), ..mesh.to_tet_mesh() };
            assert_eq!(there_and_back(&plain), plain);
        }
    }

    #[test]
    fn corrupt_text_is_an_error_that_says_what_is_wrong() {
        let text = serde_json::to_string(&build(PointKind::Grid)).expect("a mesh");
        let refused =
            |text: &str| serde_json::from_str::<Mesh>(text).expect_err("corrupt text").to_string();
        let wrong = text.replacen("\"hash\":\"", "\"hash\":\"x", 1);
        assert!(refused(&wrong).contains("hexadecimal"));
        let bits = format!("[{},0,0]", 1f64.to_bits());
        assert!(text.contains(&bits));
        let moved = text.replacen(&bits, &format!("[{},0,0]", 1.5f64.to_bits()), 1);
        assert!(refused(&moved).contains("the mesh of the stored vertices has the hash"));
        let version = text.replacen("ltbw.snapshot/1", "ltbw.snapshot/2", 1);
        assert!(refused(&version).contains("the schema is `ltbw.snapshot/2`"));
        assert!(refused(&text.replacen("\"next\"", "\"more\"", 1)).contains("unknown field"));
        assert!(!refused(&text[..text.len() / 2]).is_empty());
    }

    #[test]
    fn point_sets_survive_and_are_validated() {
        let set = PointSet::new(generate(PointKind::Ulps, 100, 5)).expect("finite points");
        assert_eq!(there_and_back(&set), set);
        // JSON knows no infinity, but a number that overflows.
        let error = serde_json::from_str::<PointSet>("[[0,0,0],[0,1e999,0]]");
        assert!(error.is_err());
        let infinite = serde::de::value::SeqDeserializer::<_, serde_json::Error>::new(
            [[0.0, 0.0, 0.0], [0.0, f64::NAN, 0.0]].into_iter().map(Triple),
        );
        let error = <PointSet as serde::Deserialize>::deserialize(infinite);
        let error = error.expect_err("a coordinate that is not finite").to_string();
        assert!(error.starts_with("point 1: coordinate y is NaN"), "{error}");
    }

    /// A list of three numbers as a deserialiser: a format that knows NaN.
    struct Triple([f64; 3]);

    impl<'de> serde::de::IntoDeserializer<'de, serde_json::Error> for Triple {
        type Deserializer =
            serde::de::value::SeqDeserializer<std::array::IntoIter<f64, 3>, serde_json::Error>;

        fn into_deserializer(self) -> Self::Deserializer {
            serde::de::value::SeqDeserializer::new(self.0.into_iter())
        }
    }

    #[test]
    fn figures_and_enums_survive() {
        let set = PointSet::new(generate(PointKind::Grid, 300, 5)).expect("finite points");
        let built = Builder::new().build(&set).expect("points of dimension 3");
        assert_eq!(there_and_back(&built.stats.predicates), built.stats.predicates);
        let stats: Stats = there_and_back(&built.stats);
        assert_eq!(stats.insert_seconds.to_bits(), built.stats.insert_seconds.to_bits());
        let hash: MeshHash = built.mesh.hash().expect("a hash");
        assert_eq!(there_and_back(&hash), hash);
        assert_eq!(serde_json::to_string(&hash).expect("a hash"), format!("\"{hash}\""));
        for mode in [Mode::Normal, Mode::Rescaled { exponent: -7 }, Mode::Wide] {
            assert_eq!(there_and_back(&mode), mode);
        }
        for sign in [Sign::Negative, Sign::Zero, Sign::Positive] {
            assert_eq!(there_and_back(&sign), sign);
        }
        for outcome in
            [Outcome::Complete, Outcome::Cancelled, Outcome::Budget, Outcome::TooManyTets]
        {
            assert_eq!(there_and_back(&outcome), outcome);
        }
        for order in [Order::Brio, Order::Input] {
            assert_eq!(there_and_back(&order), order);
        }
        for role in [Role::Cavity, Role::Ring] {
            assert_eq!(there_and_back(&role), role);
        }
        for inserted in [Inserted::Vertex(3), Inserted::Duplicate(4)] {
            assert_eq!(there_and_back(&inserted), inserted);
        }
        for location in [
            Location::Vertex(1),
            Location::Edge { ends: [1, 2], tet: TetId::new(3) },
            Location::Facet { corners: [1, 2, 3], tet: TetId::new(4) },
            Location::Tet(TetId::new(5)),
            Location::OutsideHull { facet: [1, 2, 3], ghost: TetId::new(9) },
        ] {
            assert_eq!(there_and_back(&location), location);
        }
        let budget = Budget { max_points: Some(7), max_tets: None };
        assert_eq!(there_and_back(&budget), budget);
    }
}
