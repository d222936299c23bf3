//! The pieces of a grid, compared with what they announce and appended to the mesh.

use super::{Piece, Reason, TETRAHEDRON, TRIANGLE};
use ltbw_core::TetMesh;

/// The mesh that the pieces make.
#[derive(Default)]
pub(crate) struct Grid {
    pub(crate) mesh: TetMesh,
    /// Triangles with their markers.
    pub(crate) triangles: Vec<([u32; 3], i64)>,
    pub(crate) other_cells: bool,
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
        append(&mut self.mesh.tet_tags, regions, first)?;
        let attributes = piece.attributes.map(|a| kept.iter().map(|&cell| a[cell]).collect());
        append(&mut self.mesh.tet_attributes, attributes, first)?;
        self.pieces += 1;
        Ok(())
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
            match kind {
                TETRAHEDRON => {
                    self.mesh.tets.push(simplex(cell, corners, piece.points, base)?);
                    kept.push(cell);
                }
                TRIANGLE => {
                    let marker = piece.markers.as_ref().map_or(0, |markers| markers[cell]);
                    let corners = simplex(cell, corners, piece.points, base)?;
                    self.triangles.push((corners, marker));
                }
                // Vertices, lines, polygons, and their quadratic kinds.
                0..=9 | 21..=23 => self.other_cells = true,
                _ => return Err(Reason::Unsupported(format!("cell {cell} of VTK type {kind}"))),
            }
        }
        if start < piece.connectivity.len() {
            return Err(Reason::Surplus("cell in `connectivity`"));
        }
        Ok(kept)
    }
}

/// The corners of a cell of `points` points, shifted by `base`.
fn simplex<const N: usize>(
    cell: usize,
    corners: &[i64],
    points: u64,
    base: u32,
) -> Result<[u32; N], Reason> {
    let wrong = || Reason::Syntax(format!("cell {cell} has {} corners, not {N}", corners.len()));
    let corners: &[i64; N] = corners.try_into().map_err(|_| wrong())?;
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
fn append<T>(all: &mut Option<Vec<T>>, piece: Option<Vec<T>>, first: bool) -> Result<(), Reason> {
    match (all.as_mut(), piece) {
        (Some(all), Some(piece)) => all.extend(piece),
        (None, piece) if first => *all = piece,
        (None, None) => {}
        _ => return Err(Reason::Syntax("only some pieces have tags".into())),
    }
    Ok(())
}
