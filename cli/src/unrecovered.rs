//! A domain whose boundary could not be recovered: what is missing is told, and the Delaunay mesh
//! of all points is written only on request, without regions.

use crate::args::Depth;
use crate::console;
use crate::outcome::{Failure, show};
use crate::streams::name_of;
use crate::task::Task;
use ltbw::TetMesh;
use ltbw::io::MeshWriter;
use ltbw::refine::Refined;
use ltbw_verify as verify;

/// Missing boundary items that people are shown.
const SHOWN: usize = 10;

/// Says what is missing, where and why.
pub(crate) fn tell(refined: &Refined) {
    for (item, reason) in refined.lost.iter().take(SHOWN) {
        let (name, at) = (item.kind(), refined.middle(item));
        console::people(&format!("missing   {name} at {at:?}: {reason}"));
    }
    if let Some(more) = refined.lost.len().checked_sub(SHOWN).filter(|&more| more > 0) {
        console::people(&format!("          and {more} more"));
    }
}

/// Writes the mesh, judged for structure and Delaunay alone if it is to be checked; the files
/// written, or `None` if the mesh has a defect.
pub(crate) fn write(task: &Task<'_>, mesh: &TetMesh) -> Result<Option<Vec<String>>, Failure> {
    let mut written = Vec::new();
    let outputs = &task.outputs.whole;
    if outputs.is_empty() {
        return Ok(Some(written));
    }
    if task.check != Depth::Off {
        let options = verify::Options { depth: verify::Depth::Fast, ..verify::Options::default() };
        let view = verify::Mesh::new(&mesh.points, &mesh.tets);
        if !verify::check(&view, &options).passed() {
            console::people("ltbw: defect in our own output; no mesh was written");
            return Ok(None);
        }
        console::people(
            "checked   structure, orientation, delaunay: no defect; no more is claimed",
        );
    }
    for path in outputs {
        task.outputs.formats.write_mesh(path, MeshWriter::new(mesh))?;
        let path = &name_of(path);
        written.push(path.to_string_lossy().into_owned());
        console::people(&format!("wrote     {}, without regions", show(path)));
    }
    Ok(Some(written))
}

/// The last line.
pub(crate) fn end(refined: &Refined, written: bool) {
    let files = match written {
        false => "no mesh was written (--write-unrecovered writes it)",
        true => "what was written is a Delaunay mesh, not one of the domain",
    };
    let count = refined.lost.len();
    console::people(&format!(
        "ltbw: unrecovered: {count} boundary items are not in the mesh; {files}"
    ));
}
