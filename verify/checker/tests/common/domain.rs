//! Meshes of domains, judged whole and in parts.

use super::team::{Lost, on_team};
use ltbw_verify::{
    Conformity, DomainPart, Exchange, Limits, Mesh, Options, Plc, conforms, conforms_parted,
};

/// A division: the member that has a tetrahedron, whatever the number of members.
type Division = fn(usize) -> usize;

/// Ways to divide: in turn, in stretches, at random, and none at the first.
const DIVISIONS: [Division; 4] = [|t| t, |t| t / 3, |t| t * 7919 % 97 / 5, |t| t % 3 + 1];

/// A mesh with the domain and the tags that it is judged by.
#[derive(Clone, Copy)]
pub(crate) struct Judged<'a> {
    pub(crate) mesh: &'a Mesh<'a>,
    pub(crate) plc: &'a Plc,
    pub(crate) tags: Option<&'a [i64]>,
    pub(crate) limits: &'a Limits,
    pub(crate) options: &'a Options,
}

impl Judged<'_> {
    /// The findings, which are those in parts, however the mesh is divided.
    pub(crate) fn conforms(&self) -> Conformity {
        let Self { mesh, plc, tags, limits, options } = *self;
        let whole = conforms(mesh, plc, tags, limits, options);
        for members in [1, 2, 3, 5] {
            for (k, division) in DIVISIONS.into_iter().enumerate() {
                let name = format!("{members} members, division {k}");
                let found = self.in_parts(members, division).expect("findings");
                assert_eq!(found.parts, Some(members as u64));
                let has_defect = [&whole, &found].map(|found| found.mesh_defect_count > 0);
                assert_eq!(has_defect[0], has_defect[1], "{name}: {:?}", found.mesh_defects);
                if has_defect[0] {
                    continue;
                }
                assert_eq!(found.counts, whole.counts, "{name}: {:?}", found.findings);
                let counts = |own: &Conformity| (own.subfaces, own.tets, own.cells);
                assert_eq!(counts(&found), counts(&whole), "{name}");
                assert_eq!(found.volume, whole.volume, "{name}");
                let small = |own: &Conformity| own.below_dihedral.as_ref().map(|own| own.count);
                assert_eq!(small(&found), small(&whole), "{name}");
                assert_eq!(found.findings.len(), whole.findings.len(), "{name}");
                // The places of the domain have the same numbers, and those of the mesh others.
                let mut listed: Vec<_> = whole.findings.iter().collect();
                listed.sort_by_key(|finding| finding.breach);
                for (own, other) in found.findings.iter().zip(listed) {
                    assert_eq!((own.breach, own.ids.len()), (other.breach, other.ids.len()));
                }
            }
        }
        whole
    }

    /// The findings of all members, which are the same.
    pub(crate) fn in_parts(&self, members: usize, division: Division) -> Result<Conformity, Lost> {
        let Self { mesh, plc, tags, limits, options } = *self;
        let mut all = on_team(members, |team| {
            let me = team.me();
            let own: Vec<usize> =
                (0..mesh.tets.len()).filter(|&t| division(t) % members == me).collect();
            let mut tets: Vec<[u32; 4]> = own.iter().map(|&t| mesh.tets[t]).collect();
            let mut numbers: Vec<u32> = tets.iter().flatten().copied().collect();
            // Not in the order of the mesh.
            numbers.sort_unstable_by_key(|&v| (v % 3, v));
            numbers.dedup();
            let place = |v: u32| numbers.iter().position(|&w| w == v).unwrap_or_default() as u32;
            tets.iter_mut().for_each(|tet| *tet = tet.map(place));
            let points: Vec<_> = numbers.iter().map(|&v| mesh.points[v as usize]).collect();
            let tags: Option<Vec<i64>> = tags.map(|tags| own.iter().map(|&t| tags[t]).collect());
            let part = DomainPart {
                points: &points,
                numbers: &numbers,
                tets: &tets,
                tags: tags.as_deref(),
            };
            conforms_parted(team, &part, plc, limits, options)
        });
        let first = all.remove(0)?;
        for other in all {
            assert_eq!(format!("{:?}", other?), format!("{first:?}"), "different findings");
        }
        Ok(first)
    }
}
