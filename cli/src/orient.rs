//! The orientation of tetrahedra: which are degenerate, and `convert --orient`.

use ltbw::TetMesh;
use ltbw_verify as verify;

/// Degenerate tetrahedra that people are told of.
const SHOWN: usize = 10;

/// Notes on a mesh that is converted: its degenerate tetrahedra and, if they are to be turned, the
/// number of negative ones, which are positive afterwards. Exact.
pub(crate) fn orientation(mesh: &mut TetMesh, turn: bool) -> Vec<String> {
    let mut notes = Vec::new();
    let signs = verify::signs(&verify::Mesh::new(&mesh.points, &mesh.tets));
    let flat: Vec<usize> = (0..signs.len()).filter(|&t| signs[t] == 0).collect();
    if let Some((first, rest)) = flat.split_first() {
        let others = rest.iter().take(SHOWN - 1).map(|t| format!(", {t}")).collect::<String>();
        let more = if flat.len() > SHOWN { ", ..." } else { "" };
        notes.push(match rest {
            [] => format!("tetrahedron {first} is degenerate: its volume is exactly zero"),
            _ => format!(
                "{} tetrahedra are degenerate, of volume exactly zero: {first}{others}{more}",
                flat.len()
            ),
        });
    }
    let negative = signs.iter().filter(|&&sign| sign < 0).count();
    if turn {
        for (tet, _) in mesh.tets.iter_mut().zip(&signs).filter(|(_, sign)| **sign < 0) {
            tet.swap(2, 3);
        }
        let all = signs.len();
        notes.push(format!("{negative} of {all} tetrahedra are turned to positive orientation"));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::orientation;
    use ltbw::TetMesh;

    #[test]
    fn negative_ones_are_turned_and_flat_ones_named() {
        let points: Vec<[f64; 3]> = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 1.0, 0.0],
        ];
        let tets = vec![[0, 1, 2, 3], [0, 1, 4, 2], [1, 2, 4, 3], [0, 0, 1, 2]];
        let mut mesh = TetMesh { points, tets, ..TetMesh::default() };
        let flat = "2 tetrahedra are degenerate, of volume exactly zero: 1, 3";
        let before = mesh.clone();
        assert_eq!(orientation(&mut mesh, false), [flat]);
        assert_eq!(mesh, before);
        let turned = "1 of 4 tetrahedra are turned to positive orientation";
        assert_eq!(orientation(&mut mesh, true), [flat, turned]);
        assert_eq!(mesh.tets, [[0, 1, 2, 3], [0, 1, 4, 2], [1, 2, 3, 4], [0, 0, 1, 2]]);
        let again = "0 of 4 tetrahedra are turned to positive orientation";
        assert_eq!(orientation(&mut mesh, true), [flat, again]);
    }
}
