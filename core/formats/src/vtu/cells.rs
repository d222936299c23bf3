//! The pieces of a grid, compared with what they announce and appended to the mesh.

use super::{Piece, Reason, TETRAHEDRON, TRIANGLE};
use crate::curved::Curved;
use crate::faces::{Marked, owned};
use ltbw_core::TetMesh;

/// The mesh that the pieces make.
#[derive(Default)]
pub(crate) struct Grid {
    mesh: TetMesh,
    /// The field of its points that was asked for.
    pub(super) field: Option<Vec<f64>>,
    /// Triangles with their markers.
    triangles: Vec<Marked>,
    other_cells: bool,
    curved: Curved,
    pieces: usize,
}

impl Grid {
    /// Checks a piece and appends it to the mesh.
    pub(crate) fn add(&mut self, piece: Piece) -> Result<(), Reason> {
        let (points, cells) = (piece.points, piece.cells);
        let (coordinates, rest) = piece.coordinates.as_chunks::<3>();
        same("points", points, coordinates.len() + usize::from(!rest.is_empty()))?;
        same("values in `offsets`", cells, piece.offsets.len())?;
        same("values in `types`", cells, piece.types.len())?;
        if let Some(tags) = &piece.tags {
            same("values in `tag`", points, tags.len())?;
        }
        if let Some(regions) = &piece.regions {
            same("values in `region`", cells, regions.len())?;
        }
        if let Some(attributes) = &piece.attributes {
            same("values in `attribute`", cells, attributes.len())?;
        }
        if let Some(markers) = &piece.markers {
            same("values in `marker`", cells, markers.len())?;
        }
        if let Some(field) = &piece.field {
            same("values of the field", points, field.len())?;
        }
        let base = self.mesh.points.len();
        let total = (base + coordinates.len()) as u64;
        let base = u32::try_from(base).map_err(|_| Reason::TooManyPoints(total))?;
        u32::try_from(total).map_err(|_| Reason::TooManyPoints(total))?;
        if !rest.is_empty() {
            return Err(Reason::TooFewValues { expected: 3, found: rest.len() });
        }
        let kept = self.add_cells(&piece, base)?;
        self.mesh.points.extend_from_slice(coordinates);
        let regions = piece.regions.map(|r| kept.iter().map(|&cell| r[cell]).collect());
        let first = self.pieces == 0;
        append(&mut self.mesh.point_tags, piece.tags, first)?;
        append(&mut self.field, piece.field, first)?;
        append(&mut self.mesh.tet_tags, regions, first)?;
        let attributes = piece.attributes.map(|a| kept.iter().map(|&cell| a[cell]).collect());
        append(&mut self.mesh.tet_attributes, attributes, first)?;
        self.pieces += 1;
        Ok(())
    }

    /// The mesh with its boundary triangles, and notes on what was not read.
    pub(crate) fn finish(self) -> (TetMesh, Vec<String>) {
        let Self { mut mesh, triangles, other_cells, curved, .. } = self;
        let mut notes = Vec::new();
        if other_cells {
            notes.push("cells that are neither tetrahedra nor triangles are not read".to_owned());
        }
        notes.extend(curved.note());
        let note;
        (mesh.faces, note) = owned(&mesh, &triangles);
        notes.extend(note);
        (mesh, notes)
    }

    /// Appends the tetrahedra of a piece whose points start at `base`; returns which cells they
    /// are.
    fn add_cells(&mut self, piece: &Piece, base: u32) -> Result<Vec<usize>, Reason> {
        let mut kept = Vec::with_capacity(piece.types.len());
        let mut start = 0;
        for (cell, (&kind, &end)) in piece.types.iter().zip(&piece.offsets).enumerate() {
            let end = usize::try_from(end).unwrap_or(0);
            let corners = piece.connectivity.get(start..end).ok_or_else(|| {
                let (offsets, length) = ((start, end), piece.connectivity.len());
                Reason::Syntax(format!(
                    "cell {cell} has the offsets {offsets:?} in a connectivity of {length} values"
                ))
            })?;
            start = end;
            let curved = usize::from(!matches!(kind, TETRAHEDRON | TRIANGLE));
            match kind {
                TETRAHEDRON | 24 | 71 => {
                    self.curved.tets += curved;
                    self.mesh.tets.push(simplex(cell, kind, corners, piece.points, base)?);
                    kept.push(cell);
                }
                TRIANGLE | 22 | 34 | 69 => {
                    self.curved.triangles += curved;
                    let marker = piece.markers.as_ref().map_or(0, |markers| markers[cell]);
                    let corners = simplex(cell, kind, corners, piece.points, base)?;
                    self.triangles.push(Marked { corners, marker });
                }
                // Vertices, lines, polygons, and those of higher order.
                0..=9 | 21 | 23 | 28 | 30 | 35 | 36 | 68 | 70 => self.other_cells = true,
                _ => return Err(Reason::Unsupported(format!("cell {cell} of VTK type {kind}"))),
            }
        }
        if start < piece.connectivity.len() {
            return Err(Reason::Surplus("cell in `connectivity`"));
        }
        Ok(kept)
    }
}

/// The corners of a cell of this VTK type in a piece of `points` points, shifted by `base`. In
/// cells of higher order other points follow them.
fn simplex<const N: usize>(
    cell: usize,
    kind: i64,
    corners: &[i64],
    points: u64,
    base: u32,
) -> Result<[u32; N], Reason> {
    let wanted = if kind == 24 {
        10
    } else if kind == 22 {
        6
    } else {
        N
    };
    let is_whole = match kind {
        TETRAHEDRON | TRIANGLE | 22 | 24 => corners.len() == wanted,
        _ => corners.len() >= wanted,
    };
    let wrong =
        || Reason::Syntax(format!("cell {cell} has {} corners, not {wanted}", corners.len()));
    let corners = corners.first_chunk::<N>().filter(|_| is_whole).ok_or_else(wrong)?;
    let last = points as i64 - 1;
    match corners.iter().find(|&&v| v < 0 || v > last) {
        Some(&index) => {
            Err(Reason::Index { what: "cell", number: cell as u64, index, first: 0, last })
        }
        None => Ok(corners.map(|v| base + v as u32)),
    }
}

fn same(what: &'static str, announced: u64, found: usize) -> Result<(), Reason> {
    let found = found as u64;
    if found == announced {
        Ok(())
    } else if found < announced {
        Err(Reason::Truncated { what, announced, found })
    } else {
        Err(Reason::Syntax(format!("{found} {what}, where {announced} are announced")))
    }
}

/// Appends the tags of a piece; either all pieces have them or none.
pub(crate) fn append<T>(
    all: &mut Option<Vec<T>>,
    piece: Option<Vec<T>>,
    first: bool,
) -> Result<(), Reason> {
    match (all.as_mut(), piece) {
        (Some(all), Some(piece)) => all.extend(piece),
        (None, piece) if first => *all = piece,
        (None, None) => {}
        _ => return Err(Reason::Syntax("only some pieces have tags".into())),
    }
    Ok(())
}
