//! The checker's findings that excuses explain.

use ltbw::TetMesh;
use ltbw::refine::{Excuse, Refined};
use ltbw_verify::{Conformity, ConformityDefect, Finding};
use std::collections::{HashMap, HashSet};

/// Is everything that the checker found excused? A bound may be exceeded by the tetrahedra that
/// have an excuse, and by no others.
pub(crate) fn is_explained(found: &Conformity, inside: &TetMesh, excused: &Excused) -> bool {
    let is_excused = |f: &Finding| {
        let tet = f.ids.first().and_then(|&t| inside.tets.get(t as usize));
        tet.is_some_and(|tet| excused.contains(tet))
    };
    found.mesh_defect_count == 0
        && found.counts.iter().all(|(&breach, &count)| match breach {
            ConformityDefect::RatioExceeded
            | ConformityDefect::VolumeExceeded
            | ConformityDefect::EdgeExceeded => {
                let listed = found.findings.iter().filter(|f| f.breach == breach);
                // A tetrahedron that is not listed cannot be told to be excused.
                listed.clone().count() as u64 == count && listed.clone().all(is_excused)
            }
            _ => false,
        })
}

/// Tetrahedra that have an excuse, by their vertices.
pub(crate) type Excused = HashSet<[u32; 4]>;

/// The tetrahedra of a mesh that have an excuse.
pub(crate) fn excused(refined: &Refined) -> Excused {
    refined.excuses.iter().filter_map(|excuse| refined.tet(excuse.tet)).collect()
}

/// The tetrahedra that have an excuse, by their numbers in the mesh, each with the reason.
pub(crate) fn reasons(refined: &Refined) -> Vec<(u32, String)> {
    let numbers: HashMap<_, u32> = refined.tets().zip(0..).collect();
    let own = |e: &Excuse| numbers.get(&e.tet).map(|&number| (number, e.reason.to_string()));
    refined.excuses.iter().filter_map(own).collect()
}

#[cfg(test)]
mod tests {
    use super::{Excused, is_explained};
    use ltbw::TetMesh;
    use ltbw_verify::{self as verify, ConformityDefect, Limits, Plc, PlcFacet};

    /// Two tetrahedra on one triangle, of volumes 1/6 and 1/3, of which the second is too large.
    #[test]
    fn an_excuse_is_for_its_own_tetrahedron() {
        let points = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.25, 0.25, -2.0],
        ];
        let (small, large) = ([0, 1, 2, 3], [0, 2, 1, 4]);
        let inside = TetMesh { points, tets: vec![small, large], ..TetMesh::default() };
        let facets = [[0, 2, 3], [0, 3, 1], [1, 3, 2], [0, 1, 4], [1, 2, 4], [2, 0, 4]];
        let facet = |f: [u32; 3]| PlcFacet { polygons: vec![f.to_vec()], ..PlcFacet::default() };
        let plc = Plc {
            vertices: inside.points.clone(),
            facets: facets.map(facet).to_vec(),
            ..Plc::default()
        };
        let limits = Limits { max_volume: Some(0.25), ..Limits::default() };
        let mesh = verify::Mesh::new(&inside.points, &inside.tets);
        let found = verify::conforms(&mesh, &plc, None, &limits, &verify::Options::default());
        assert_eq!(found.mesh_defect_count, 0, "{:?}", found.mesh_defects);
        assert_eq!(
            found.counts.iter().collect::<Vec<_>>(),
            [(&ConformityDefect::VolumeExceeded, &1)]
        );
        let explained = |tet| is_explained(&found, &inside, &Excused::from([tet]));
        assert!(explained(large));
        assert!(!explained(small), "as many excuses as breaches, but for another tetrahedron");
    }
}
