//! Teams whose members share nothing but letters: always the sequential mesh, to its hash.

use ltbw::threads::Parallel;
use ltbw::{Builder, PointSet};
use ltbw_tests::families::{Family, Size, all};
use ltbw_tests::teams::on_team;

#[test]
fn families_on_teams_have_the_sequential_hash() {
    let mut messages = 0;
    for Family { name, points } in all(Size::Moderate) {
        let set = PointSet::new(points).expect("finite points");
        let expected = Builder::new().build(&set).expect("a mesh");
        let hash = expected.mesh.hash().expect("a hash");
        for members in [1, 2, 4, 7] {
            let ends = on_team(members, |team| {
                let built = Builder::new().parts().build_on(team, &set).expect("a mesh");
                (built, team.figures())
            });
            messages += ends.iter().map(|(_, figures)| figures.messages).sum::<u64>();
            let mut built = ends.into_iter().filter_map(|(built, _)| built);
            let first = built.next().expect("the first member's mesh");
            assert_eq!(first.mesh.hash().expect("a hash"), hash, "{name} on {members}");
            assert_eq!(first.duplicates, expected.duplicates, "{name} on {members}");
            assert_eq!(first.parts.len(), members as usize, "{name}");
            assert!(built.next().is_none(), "one member has the mesh");
        }
    }
    assert!(messages > 0, "no member ever spoke to another");
}
