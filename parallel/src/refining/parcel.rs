//! The parts of a team's members on their way to the first one.

use super::RefineError;
use super::whole::Part;
use crate::mesh::share::{Share, put_back, share_of};
use crate::mesh::{SharedInput, VertexName};
use crate::team::{Team, TeamError};
use crate::threads::{RunError, WorkerStats};
use ltbw_core::topology::TetId;
use ltbw_exact::Mode;
use ltbw_refine::Carrier;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// An error of a team, among those of a refinement.
pub(super) fn of_team(error: impl Into<TeamError>) -> RefineError {
    RunError::from(error.into()).into()
}

/// A worker's part and the work that it leaves, as they travel.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct Parcel<L> {
    share: Share,
    made: Vec<(VertexName, Carrier)>,
    /// By tetrahedron of the share.
    regions: Vec<u32>,
    /// Tetrahedra have their numbers in the share.
    left: L,
    stats: WorkerStats,
}

impl<L> Parcel<L> {
    /// The parcel of a part; `left` is given the numbers that tetrahedra have in it.
    pub(super) fn of(
        part: Part,
        stats: WorkerStats,
        left: impl FnOnce(&dyn Fn(TetId) -> Option<TetId>) -> L,
    ) -> Self {
        let (share, slots) = share_of(&part.mesh);
        let region = |t: &TetId| part.regions.get(t.index()).copied().unwrap_or_default();
        let regions = slots.iter().map(region).collect();
        let left = left(&|t| slots.binary_search(&t).ok().map(TetId::at));
        Self { share, made: part.made, regions, left, stats }
    }
}

/// The parts of all members, each with the work that it leaves, and the figures of all.
pub(super) struct Collected<L> {
    pub(super) parts: Vec<(Part, L)>,
    pub(super) stats: Vec<WorkerStats>,
}

impl<L: Serialize + DeserializeOwned> Collected<L> {
    /// Collects them at the first member, whose own part is given, with the work that it leaves.
    ///
    /// # Errors
    /// [`RefineError`] if a member has failed, or has sent what makes no sense.
    pub(super) fn at_first(
        team: &mut Team,
        own: Part,
        left: L,
        own_stats: WorkerStats,
        common: &SharedInput,
    ) -> Result<Self, RefineError> {
        let (mut stats, mut shares, mut rest) = (vec![own_stats], Vec::new(), Vec::new());
        for (from, parcel) in team.parcels::<Parcel<L>>().map_err(of_team)? {
            parcel.share.is_of(from).map_err(RunError::from)?;
            stats.push(parcel.stats);
            shares.push(parcel.share);
            rest.push((parcel.made, parcel.regions, parcel.left));
        }
        // The coordinates at the start are those that the kernel computes with.
        let meshes = put_back(shares, &own.mesh, common, Mode::Normal).map_err(RunError::from)?;
        let mut parts = vec![(own, left)];
        for (mesh, (made, mut regions, left)) in meshes.into_iter().zip(rest) {
            regions.resize(mesh.tets().topology().slots(), 0);
            parts.push((Part { mesh, made, regions }, left));
        }
        Ok(Self { parts, stats })
    }
}
