//! Other cuts for a submesh of a domain at rest: its tetrahedra bring their regions along, and
//! their vertices where they live.

use super::mesh::DomainMesh;
use super::values::carriers_bytes;
use crate::mesh::redeal::{Dealt, Parcel, Posted, Turned};
use crate::protocol::{Directory, SubmeshError, WorkerId};
use ltbw_core::topology::TetId;
use ltbw_refine::Carrier;

/// Tetrahedra that go from one worker to another.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct DomainParcel {
    parcel: Parcel,
    /// The regions of its tetrahedra.
    regions: Vec<u32>,
    /// Its vertices on the boundary, by their places.
    bound: Vec<(u32, Carrier)>,
}

impl DomainParcel {
    /// The number of its tetrahedra.
    pub(crate) fn len(&self) -> usize {
        self.parcel.len()
    }

    /// About the bytes that it has in a compact encoding.
    pub(crate) fn bytes(&self) -> u64 {
        let bound: Vec<_> = self.bound.iter().map(|&(k, own)| (u64::from(k), own)).collect();
        self.parcel.bytes() + self.regions.len() as u64 + carriers_bytes(0, &bound)
    }
}

impl DomainMesh<'_> {
    /// Packs what leaves, and has it no more.
    ///
    /// # Errors
    /// [`SubmeshError`] if a word makes no sense, or there is no room.
    pub(crate) fn send_off(
        &mut self,
        dealt: &Dealt,
        words: impl Iterator<Item = Turned>,
    ) -> Result<Vec<(WorkerId, DomainParcel)>, SubmeshError> {
        let posted = self.inner.send_off(dealt, words)?;
        let with = |(Posted { to, parcel, vertices }, tets): (Posted, &Vec<TetId>)| {
            let bound = (0..).zip(vertices).filter(|&(_, v)| self.is_bound(v));
            let bound = bound.map(|(k, v)| (k, self.carrier(v))).collect();
            let regions = tets.iter().map(|&t| self.region(t)).collect();
            (to, DomainParcel { parcel, regions, bound })
        };
        let leaving = dealt.leaving.iter().map(|own| &own.tets);
        Ok(posted.into_iter().zip(leaving).map(with).collect())
    }

    /// Takes in what comes, and says in which slots it is.
    ///
    /// # Errors
    /// [`SubmeshError`] if a parcel makes no sense, or there is no room.
    pub(crate) fn unpack(
        &mut self,
        parcels: &[&DomainParcel],
        directory: &Directory,
    ) -> Result<Vec<Vec<TetId>>, SubmeshError> {
        let inner: Vec<&Parcel> = parcels.iter().map(|own| &own.parcel).collect();
        let unpacked = self.inner.unpack(&inner, directory)?;
        for (parcel, own) in parcels.iter().zip(&unpacked) {
            let regions = parcel.regions.iter().chain(std::iter::repeat(&0));
            for (&t, &region) in own.tets.iter().zip(regions) {
                self.set_region(t, region);
            }
            for &(k, carrier) in &parcel.bound {
                let unknown = SubmeshError::Unknown { what: "a vertex of the parcel", number: k };
                let &v = own.vertices.get(k as usize).ok_or(unknown)?;
                self.set_carrier(v, carrier);
            }
        }
        Ok(unpacked.into_iter().map(|own| own.tets).collect())
    }
}
