//! Dihedral angles below `--min-dihedral`: what `check` tells of them.

use ltbw::TetMesh;
use ltbw::quality::LeastAngles;
use ltbw_verify::SmallAngles;

/// Tetrahedra that people are shown.
const SHOWN: usize = 5;

/// The degrees of `--min-dihedral`.
pub(crate) fn degrees(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    let good = value > 0.0 && value <= 90.0;
    good.then_some(value).ok_or_else(|| "an angle above 0 and of at most 90 degrees".to_owned())
}

/// The number of tetrahedra below, the first of them, and the place of the least angle.
pub(crate) fn line(found: &SmallAngles, mesh: &TetMesh) -> String {
    let first: Vec<String> = found.tets.iter().take(SHOWN).map(u32::to_string).collect();
    let more = if found.count > SHOWN as u64 { ", ..." } else { "" };
    let first = match first.is_empty() {
        true => String::new(),
        false => format!(" ({}{more})", first.join(", ")),
    };
    let least = found.least.map_or_else(String::new, |least| {
        let centre = centre(mesh, least.tet as usize);
        format!("; least {:.4e} in tetrahedron {}, around {centre:?}", least.value, least.tet)
    });
    format!("angles    below {} degrees: {} tetrahedra{first}{least}", found.bound, found.count)
}

/// Degrees in a bin that people are shown.
const SHOWN_TOGETHER: usize = 5;

/// The tetrahedra by their smallest dihedral angle, as far as there are some.
pub(crate) fn by_smallest(angles: &LeastAngles) -> String {
    let bins = angles.counts().chunks(SHOWN_TOGETHER).map(|bin| bin.iter().sum::<u64>());
    let told = bins.enumerate().filter(|(_, count)| *count > 0).map(|(k, count)| {
        let from = k * SHOWN_TOGETHER;
        format!("{from}-{}: {count}", from + SHOWN_TOGETHER)
    });
    format!("          by smallest angle: {}", told.collect::<Vec<_>>().join(", "))
}

/// The failure of the bound, if an angle is below.
pub(crate) fn failure(found: &SmallAngles) -> Option<String> {
    let SmallAngles { bound, count, .. } = found;
    let plural = if *count == 1 { "tetrahedron has" } else { "tetrahedra have" };
    (*count > 0).then(|| format!("{count} {plural} a dihedral angle below {bound} degrees"))
}

/// The middle of a tetrahedron.
pub(crate) fn centre(mesh: &TetMesh, t: usize) -> [f64; 3] {
    let tet = mesh.tets.get(t).copied().unwrap_or_default();
    let corners = tet.map(|v| mesh.points.get(v as usize).copied().unwrap_or_default());
    [0, 1, 2].map(|k| corners.iter().map(|c| c[k] / 4.0).sum::<f64>())
}
