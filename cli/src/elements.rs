//! Information of `check` on a mesh beside its defects: quality, pieces, shape.

use crate::angles::{by_smallest, centre};
use crate::console;
use crate::report::{quality_json, quality_line};
use ltbw::TetMesh;
use ltbw::quality::Quality;
use ltbw_verify as verify;
use serde::Serialize;
use serde_json::Value;
use verify::{Certificate, Information, Kind, Report, SmallAngles};

/// The certificate with the quality of the mesh.
#[derive(Serialize)]
struct Told<'a> {
    #[serde(flatten)]
    certificate: Certificate<'a>,
    quality: Option<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    below_dihedral: Option<&'a SmallAngles>,
}

/// The JSON of a check.
pub(crate) fn json(
    report: &Report,
    quality: Option<&Quality>,
    below_dihedral: Option<&SmallAngles>,
) -> serde_json::Result<String> {
    let (certificate, quality) = (report.certificate(), quality.map(quality_json));
    serde_json::to_string_pretty(&Told { certificate, quality, below_dihedral })
}

/// Tells what is no defect.
pub(crate) fn tell(report: &Report, mesh: &TetMesh, quality: Option<&Quality>) {
    lines(report, mesh, quality).iter().for_each(|line| console::people(line));
}

fn lines(report: &Report, mesh: &TetMesh, quality: Option<&Quality>) -> Vec<String> {
    let none = Information::default();
    let information = report.information.as_ref().unwrap_or(&none);
    let counts = &report.counts;
    let mut lines = vec![format!(
        "mesh      {} vertices, {} tetrahedra, {} boundary faces",
        counts.vertices, counts.tets, counts.hull_facets
    )];
    if counts.unused_points > 0 {
        lines.push(format!("note: {} points are in no tetrahedron", counts.unused_points));
    }
    if report.mirrored {
        let text = "note: all tetrahedra are negatively oriented, which was allowed for; `ltbw \
                    convert --orient` turns them";
        lines.push(text.to_owned());
    }
    if counts.components > 1 {
        lines.push(format!("pieces    {}, which no shared face joins", counts.components));
    }
    let doubled = information.count(Kind::EqualVertices);
    if doubled > 0 {
        let place = place(information, Kind::EqualVertices);
        lines.push(format!("doubled   {doubled} vertices have the place of another{place}"));
    }
    let pinched = [(Kind::HullEdge, "edges"), (Kind::VertexLink, "vertices")];
    for (kind, name) in pinched.into_iter().filter(|(kind, _)| information.count(*kind) > 0) {
        let (count, place) = (information.count(kind), place(information, kind));
        lines.push(format!("pinched   {count} {name}: the body touches itself there{place}"));
    }
    lines.extend(quality.map(|quality| measures(quality, mesh)).unwrap_or_default());
    if report.passed() {
        lines.push(format!("shape     {}", shape(information)));
    }
    lines
}

/// The first place of a kind.
fn place(information: &Information, kind: Kind) -> String {
    let first = information.listed.iter().find(|found| found.kind == kind);
    let at = first.and_then(|found| found.at.first().copied().flatten());
    at.map(|at| format!("; the first at {at:?}")).unwrap_or_default()
}

/// The figures of quality, as `mesh` prints them, and where the worst are.
fn measures(quality: &Quality, mesh: &TetMesh) -> Vec<String> {
    let (angle, volume) = (quality.dihedral.least, &quality.volume);
    let [below_1, below_5] = quality.small;
    vec![
        quality_line(quality),
        format!(
            "          least dihedral {:.4e} degrees in tetrahedron {}, around {:?}",
            angle.value,
            angle.tet,
            centre(mesh, angle.tet)
        ),
        format!("          below 1 degree: {below_1} tetrahedra, below 5 degrees: {below_5}"),
        by_smallest(&quality.least_angles),
        format!(
            "          volumes {:.4e} (tetrahedron {}) to {:.4e} (tetrahedron {})",
            volume.least.value, volume.least.tet, volume.largest.value, volume.largest.tet
        ),
    ]
}

/// Is a sound mesh Delaunay, and convex?
fn shape(information: &Information) -> String {
    let sum = |kinds: &[Kind]| kinds.iter().map(|&kind| information.count(kind)).sum::<u64>();
    let concave = information.count(Kind::ConcaveHull);
    let is_convex = sum(&Kind::SHAPE) == 0;
    let delaunay = match information.count(Kind::NotDelaunay) {
        0 => "Delaunay".to_owned(),
        faces => format!("not Delaunay at {faces} faces"),
    };
    let body = match concave {
        _ if is_convex => "convex".to_owned(),
        0 => "not convex".to_owned(),
        edges => format!("not convex at {edges} edges"),
    };
    let tied = match sum(&[Kind::NotCanonical, Kind::HullNotCanonical]) {
        ties if ties > 0 && is_convex && delaunay == "Delaunay" => {
            format!(" (not the canonical Delaunay mesh of its vertices: {ties} ties)")
        }
        _ => String::new(),
    };
    format!("{delaunay}, {body}{tied}")
}
