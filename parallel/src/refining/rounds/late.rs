//! Why processors that share nothing cannot keep their parts at the end of a domain's rounds: what
//! is left takes the whole mesh.

use super::{Ending, Left};
use crate::refining::domain::{DomainMesh, labels_at};
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_refine::{Delegated, Solid};

/// Why one member has the mesh in the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum Late {
    /// It was asked for as a whole.
    Asked,
    /// The members have refined nothing.
    Alone,
    /// The run was stopped, or its workers do not know how to go on.
    Stopped,
    /// Flat tetrahedra at facets that are coplanar within a tolerance go to their other side.
    Dust,
    /// Vertices inside are moved.
    Smoothing,
    /// Something could not be split, and is asked again, or relieved.
    Refused,
    /// Slivers are left, which are relieved.
    Slivers,
}

impl std::fmt::Display for Late {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Asked => "what is written takes the whole mesh",
            Self::Alone => "one process has refined it",
            Self::Stopped => "the workers have stopped early",
            Self::Dust => "flat tetrahedra are on the inner side of facets",
            Self::Smoothing => "vertices are moved",
            Self::Refused => "something cannot be split",
            Self::Slivers => "slivers are left",
        })
    }
}

/// Looks at a worker's part once more at the end of its rounds. If it can keep it these tetrahedra
/// may be slivers, which the domain asks for.
///
/// # Errors
/// Why it cannot.
pub(in crate::refining) fn look(
    mesh: &DomainMesh<'_>,
    left: &Left,
    delegated: &Delegated<'_>,
) -> Result<Vec<TetId>, Late> {
    let Left { asked, refused, refused_tets, ending, .. } = left;
    let complex = &mesh.complex;
    match () {
        () if *ending != Some(Ending::Done) => return Err(Late::Stopped),
        () if !delegated.may_stay() => return Err(Late::Smoothing),
        () if !(asked.is_empty() && refused.is_empty() && refused_tets.is_empty()) => {
            return Err(Late::Refused);
        }
        () => {}
    }
    let tets = mesh.inner.tets();
    let finite = || tets.tets().filter(|(_, v)| v[3] != INFINITE);
    let all = finite().map(|(t, v)| {
        let corners = v.map(|v| mesh.point(v));
        Solid { tet: t, corners, region: mesh.region(t) }
    });
    let is_flat = |t: TetId| complex.is_flat(|k| mesh.carrier(tets.vertices(t)[k]));
    let amiss = complex.amiss(all, is_flat);
    let is_dust = |(t, v): (TetId, [VertexId; 4])| {
        let beyond = |slot: usize| labels_at(mesh, t, slot).map(|[_, beyond]| beyond);
        complex.may_be_dust(v.map(|v| mesh.corner(v)), mesh.region(t), beyond)
    };
    let is_open = |&t: &TetId| {
        let corners = tets.vertices(t).map(|v| mesh.corner(v));
        complex.is_sliver(corners, mesh.region(t))
    };
    match () {
        () if amiss.is_over => Err(Late::Refused),
        () if complex.has_patches() && finite().any(is_dust) => Err(Late::Dust),
        () if amiss.thin.iter().any(is_open) => Err(Late::Slivers),
        () => Ok(amiss.thin),
    }
}
