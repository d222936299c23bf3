//! The paper's mode on domains: bad tetrahedra and the boundary split on many processors at once.
//!
//! The sequential engine brings the boundary into the mesh; then workers own parts of it. Every
//! worker's source is the list of its own bad tetrahedra, and of boundary items that others have
//! asked for (`list`). An operation begins at the tetrahedron, or at one that has the boundary
//! item, at its owner. When its closure is locked its home takes the *verdict*, which is that of
//! the rounds (`Survey` of `ltbw_refine`), over what the owners have told of the tetrahedra at
//! which something may be boundary (`closure`); which faces and edges are, the carriers of their
//! vertices tell. A point inside a region that encroaches one, and a point of the boundary that
//! would take another one out of the mesh, is not inserted: the item goes first (of several the
//! nearest), in the list of the owner of a tetrahedron at it, and the other is asked again
//! afterwards. So everything that was in the mesh at the start stays in it, at any time.
//!
//! A tetrahedron looks first whether a subface bars the straight way to its point (`way`), as in
//! rounds: then that goes first, and nothing is locked.
//!
//! An item that waits for one of the same worker is asked again when that is done. A tetrahedron
//! that waits for another worker's item hears from it when that has ended; a boundary item begins
//! again at once, and goes to that worker for its locks. An item that cannot be split bars what it
//! is in the way of, and so does one that is found to wait for itself again and again.
//!
//! Which points are made depends on the timing: the mesh conforms to the domain and keeps the
//! bounds, but it is not the same one twice.

mod bytes;
mod carriers;
mod chosen;
mod closure;
mod decide;
mod describe;
mod list;
mod mesh;
mod redeal;
mod regions;
mod splits;
mod values;
mod waits;
mod way;

pub(super) use describe::{is_beyond_help, is_near};
pub use list::BadItems;
pub use mesh::DomainMesh;
pub(super) use redeal::DomainParcel;
pub use splits::Splits;
pub(super) use values::WallRegion;
pub use values::{DomainCargo, DomainPatch, DomainPiece, DomainPoint};
pub(super) use way::{FarFace, labels_at};

use super::RefineError;
use crate::mesh::start::{Cut, Given};
use crate::mesh::{Blocks, Layout, Prepared, SharedInput, VertexName, Wanted, Weight, given};
use crate::protocol::{BlockId, Config, Rules, Source, Worker, WorkerId};
use ltbw_core::order::{Curve, bounding_box};
use ltbw_core::topology::TetId;
use ltbw_exact::{Mode, PointSet};
use ltbw_refine::{Carrier, Complex, ComplexError, Start};
use std::sync::Arc;

/// A worker that refines a domain without rounds.
pub type DomainNode<'c, C> = Worker<DomainMesh<'c>, BadItems, C>;

/// The workers that refine a domain.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Their number, and the way in which parts are dealt to them.
    pub layout: Layout,
    /// The configuration of each.
    pub config: Config,
}

/// Workers, and all that they share.
pub(super) type Begun<'c, Q, C> = (Vec<Worker<DomainMesh<'c>, Q, C>>, SharedInput);

/// Places whose weights tell where a worker's part of a domain ends, a worker.
const PLACES: usize = 4096;

/// The curve that is cut into the workers' parts: of some the one that divides the fewest
/// tetrahedra.
///
/// Domains end at halves and quarters of their box. If cells of the curve meet there, all vertices
/// on such an end may be in cells outside the domain, and so with one worker: of two unit cubes
/// side by side it had twice the others' work. The other curves have a larger box.
fn curve_for(start: &Start, weights: &[Weight], layout: &Layout) -> Curve {
    let (low, high) = bounding_box(&start.points);
    let larger = |part: f64| [0, 1, 2].map(|k| high[k] + (high[k] - low[k]) * part);
    let divided = |curve: &Curve| {
        let blocks = Blocks::weighted(*curve, &[], weights, layout.workers);
        let parts: Vec<BlockId> = start.points.iter().map(|p| blocks.of_point(p)).collect();
        let is_divided =
            |v: &[u32; 4]| v.iter().any(|&k| parts[k as usize] != parts[v[0] as usize]);
        start.finite().filter(|(v, _)| is_divided(v)).count()
    };
    let curves = [0.0, 1.0 / 1024.0, 1.0 / 16.0].map(|part| Curve::of_box(low, larger(part)));
    curves.into_iter().min_by_key(divided).unwrap_or(curves[0])
}

/// Workers with parts of the mesh at the start, each with the source that it is given for its part.
pub(super) fn prepare<'c, Q: Source<DomainMesh<'c>>, C: Rules>(
    complex: Complex<'c>,
    start: &Start,
    layout: &Layout,
    config: Config,
    source: impl Fn(WorkerId, &mut DomainMesh<'c>) -> Q,
) -> Result<Begun<'c, Q, C>, RefineError> {
    if !start.fits() {
        return Err(ComplexError::Unsupported("a start whose links lead nowhere").into());
    }
    let set = PointSet::new(start.points.clone()).map_err(|_| RefineError::Range)?;
    // The coordinates at the start are those that the kernel computes with.
    if set.mode() != Mode::Normal {
        return Err(RefineError::Range);
    }
    // One worker has all of the work.
    let weights = (layout.workers > 1)
        .then(|| start.weights(&complex, PLACES.saturating_mul(layout.workers as usize)));
    let cut =
        weights.as_ref().map(|weights| Cut { curve: curve_for(start, weights, layout), weights });
    let wanted = Wanted { given: Some(Given { tets: &start.tets, cut }), ..Wanted::default() };
    let prepared = layout.prepare(&set, &wanted)?;
    let Prepared { workers, mut common, slots, .. } = prepared;
    common.mode = start.mode;
    let config = Config { workers: layout.workers, ..config };
    let complex = Arc::new(complex);
    let number = |name: VertexName| given(name).map(|place| common.numbers[place as usize - 1]);
    let carrier = |name| number(name).map_or(Carrier::Free, |k| start.carriers[k as usize]);
    let workers = workers.into_iter().zip(slots).map(|((directory, mesh, _), slots)| {
        let (me, complex) = (directory.me(), Arc::clone(&complex));
        let region = |t: TetId| {
            let there = slots.get(t.index());
            there.map_or(0, |there| start.labels[there.index()])
        };
        let mut mesh = DomainMesh::new(mesh, complex, me, carrier, region);
        // The first one receives all others in the end.
        let parts = if me == WorkerId::default() { 1 } else { layout.workers };
        mesh.expect_tets(start.expected_of(parts));
        let source = source(me, &mut mesh);
        Worker::new(config, directory, mesh, source)
    });
    Ok((workers.collect(), common))
}
