//! The parts of many workers put together, for the engine that begins and ends their work.

use super::RefineError;
use super::domain::DomainMesh;
use super::flags::Flags;
use crate::mesh::{LocalMesh, SharedInput, VertexName, gather, given};
use crate::threads::RunError;
use ltbw_core::Mesh;
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_refine::{Carrier, Refined, Start};
use rayon::prelude::*;

/// The owners of tetrahedra: by worker the first slot of its tetrahedra when the workers had ended;
/// of none if one thread has refined all.
#[derive(Clone, Debug, Default)]
pub struct Owners(pub(super) Vec<usize>);

impl Owners {
    /// The worker of each tetrahedron of [`Refined::inside`] or, with the exterior, of
    /// [`Refined::with_exterior`]; 0 if one thread has refined all. What was made when the workers
    /// had ended belongs to the one whose slot it has, or to the last one.
    pub fn of(&self, refined: &Refined, exterior: bool) -> Vec<u32> {
        let owner = |t: TetId| self.0.partition_point(|&first| first <= t.index());
        let listed = refined.listed(exterior).into_iter();
        listed.map(|t| owner(t).saturating_sub(1) as u32).collect()
    }
}

/// A mesh, and what lives in it.
pub(super) struct Whole {
    pub(super) mesh: Mesh,
    /// Where its vertices live, by kernel vertex from 1.
    pub(super) carriers: Vec<Carrier>,
    /// The regions of its finite tetrahedra, by slot.
    pub(super) regions: Vec<u32>,
    /// By worker its first slot: the mesh has all slots of one worker after those of another.
    pub(super) firsts: Vec<usize>,
}

/// One worker's part of the mesh.
pub(super) struct Part {
    pub(super) mesh: LocalMesh,
    /// Where those of its vertices live that workers have made and tetrahedra have.
    pub(super) made: Vec<(VertexName, Carrier)>,
    /// The regions of its finite tetrahedra, by slot.
    pub(super) regions: Vec<u32>,
}

impl Part {
    /// The part that a submesh is.
    pub(super) fn of(mut mesh: DomainMesh<'_>) -> Self {
        let regions = mesh.take_regions();
        let is_used = used_vertices(&mesh.inner);
        let used = VertexId::below(mesh.inner.num_vertices() as u32 + 1)
            .filter(|v| is_used.has(v.index()));
        let named = used.filter(|&v| v != INFINITE).map(|v| (mesh.inner.name(v), mesh.carrier(v)));
        let made = named.filter(|&(name, _)| given(name).is_none()).collect();
        Self { mesh: mesh.inner, made, regions }
    }
}

/// Puts the parts of all workers together, which began with `start`.
///
/// # Errors
/// A defect of the protocol, or too many tetrahedra.
pub(super) fn put_together(
    parts: Vec<Part>,
    common: SharedInput,
    start: &Start,
) -> Result<Whole, RefineError> {
    let mut made: Vec<(VertexName, Carrier)> = Vec::new();
    let (mut regions, mut firsts, mut meshes) = (Vec::new(), Vec::new(), Vec::new());
    for part in parts {
        firsts.push(regions.len());
        match regions.is_empty() {
            true => regions = part.regions,
            false => regions.extend(part.regions),
        }
        made.extend(part.made);
        meshes.push(part.mesh);
    }
    // Vertices that were made have the numbers after those given, in the order of their names.
    made.par_sort_unstable_by_key(|&(name, _)| name);
    made.dedup_by_key(|&mut (name, _)| name);
    let given_carriers = common.numbers.iter().map(|&k| start.carriers[k as usize]);
    let carriers = given_carriers.chain(made.into_iter().map(|(_, carrier)| carrier)).collect();
    let mesh = gather(meshes, common).map_err(RunError::from)?.mesh;
    Ok(Whole { mesh, carriers, regions, firsts })
}

/// Which vertices tetrahedra of a submesh have, by number.
fn used_vertices(mesh: &LocalMesh) -> Flags {
    let tets = mesh.tets();
    let slots = tets.topology().slots() as u32;
    let size = slots.div_ceil(rayon::current_num_threads() as u32).max(1);
    let of_share = |share: u32| {
        let mut is_used = Flags::default();
        let own = (share * size..slots.min((share + 1) * size)).map(TetId::new);
        for t in own.filter(|&t| tets.is_live(t)) {
            tets.vertices(t).into_iter().for_each(|v| is_used.set(v.index(), true));
        }
        is_used
    };
    let shares = (0..slots.div_ceil(size)).into_par_iter();
    shares.map(of_share).reduce_with(Flags::join).unwrap_or_default()
}
