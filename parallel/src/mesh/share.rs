//! A submesh at its end as a value that travels to whoever puts all together.

use super::{LocalMesh, Place, SharedInput, VertexName, WireVertex, given};
use crate::protocol::{Handle, Name, SubmeshError, WorkerId};
use ltbw_core::submesh::MeshParams;
use ltbw_core::topology::{FaceId, INFINITE, MAX_TETS, TetId, VertexId, slot_of, tet_of};
use ltbw_exact::Mode;
use rayon::prelude::*;
use std::ops::Range;

/// One worker's tetrahedra, numbered from 0 without gaps, with their vertices.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Share {
    me: WorkerId,
    /// The stretch of the curve whose points are the vertices from 1 on.
    own: Range<Place>,
    /// The vertices after these.
    others: Vec<WireVertex>,
    /// The tetrahedra by their vertices.
    tets: Vec<[u32; 4]>,
    /// The other sides of their faces.
    beyond: Vec<[Beyond; 4]>,
    /// The tetrahedra that have names.
    names: Vec<(Name, u32)>,
    duplicates: Vec<(VertexName, VertexName)>,
}

/// The other side of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
enum Beyond {
    /// A face of the same share: four times the tetrahedron, and the slot.
    Near(u32),
    /// A tetrahedron of another worker.
    Far(Handle),
}

/// A share that is none of a mesh with these points.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ShareError {
    /// A number in it is one of nothing.
    #[error("the share of worker {worker}: {what} {number} is not there")]
    Missing {
        /// The worker.
        worker: WorkerId,
        /// The kind of the missing thing.
        what: &'static str,
        /// Its number.
        number: u64,
    },
    /// It does not fit.
    #[error("the share of worker {worker}: {error}")]
    Submesh {
        /// The worker.
        worker: WorkerId,
        /// Why.
        error: SubmeshError,
    },
}

/// A submesh as a share, and the slot of each of its tetrahedra there.
pub(crate) fn share_of(mesh: &LocalMesh) -> (Share, Vec<TetId>) {
    let slots: Vec<TetId> = mesh.tets.tets().map(|(t, _)| t).collect();
    let mut number = vec![0_u32; mesh.tets.topology().slots()];
    slots.iter().zip(0..).for_each(|(t, k)| number[t.index()] = k);
    let (first, _) = mesh.vertices.all();
    let run = mesh.vertices.run().number();
    let beyond = |face: FaceId| match mesh.tets.far(tet_of(face)) {
        Some(far) => Beyond::Far(far),
        None => Beyond::Near(4 * number[tet_of(face).index()] + slot_of(face) as u32),
    };
    let others = mesh.vertices.after_run().number()..mesh.vertices.next().number();
    let named = mesh.names.iter().filter(|(_, t)| mesh.tets.is_live(**t));
    let mut names: Vec<(Name, u32)> = named.map(|(&name, t)| (name, number[t.index()])).collect();
    names.sort_unstable();
    let share = Share {
        me: mesh.me,
        own: first..first + run,
        others: others.map(|v| mesh.wire_vertex(VertexId::new(v))).collect(),
        tets: slots.iter().map(|&t| mesh.tets.vertices(t).map(VertexId::number)).collect(),
        beyond: slots.iter().map(|&t| mesh.tets.neighbours(t).map(beyond)).collect(),
        names,
        duplicates: mesh.duplicates.clone(),
    };
    (share, slots)
}

impl LocalMesh {
    /// The facets of the hull whose ghosts are here, of given vertices alone, by their places.
    pub(crate) fn given_ghosts(&self) -> impl Iterator<Item = [Place; 3]> + '_ {
        self.tets.tets().filter(|(_, v)| v[3] == INFINITE).filter_map(|(_, [a, b, c, _])| {
            let [a, b, c] = [a, b, c].map(|v| given(self.vertices.name(v)));
            Some([a?, b?, c?])
        })
    }
}

/// The submeshes that shares are of; `like` is one of the same mesh, whose points are computed with
/// in this mode.
///
/// # Errors
/// [`ShareError`] names what is not there.
pub(crate) fn put_back(
    shares: Vec<Share>,
    like: &LocalMesh,
    common: &SharedInput,
    mode: Mode,
) -> Result<Vec<LocalMesh>, ShareError> {
    let params = MeshParams::of(&common.points, mode).at_most(MAX_TETS);
    shares.into_par_iter().map(|share| share.submesh(like, common, &params)).collect()
}

impl Share {
    /// Makes sure that it is this worker's.
    ///
    /// # Errors
    /// [`ShareError`] if it is another one's.
    pub(crate) fn is_of(&self, worker: WorkerId) -> Result<(), ShareError> {
        let number = self.me.number().into();
        let found = ShareError::Missing { worker, what: "worker", number };
        if self.me == worker { Ok(()) } else { Err(found) }
    }

    /// The submesh, in whose slots the tetrahedra are by number; `like` is one of the same mesh.
    ///
    /// # Errors
    /// [`ShareError`] names what is not there.
    fn submesh(
        self,
        like: &LocalMesh,
        common: &SharedInput,
        params: &MeshParams,
    ) -> Result<LocalMesh, ShareError> {
        let Self { me, own, others, tets, beyond, names, duplicates } = self;
        let missing = |what, number: u64| ShareError::Missing { worker: me, what, number };
        // The first place is 1.
        let [start, end] = [own.start, own.end].map(|place| (place as usize).checked_sub(1));
        let places = start.zip(end).and_then(|(start, end)| common.points.get(start..end));
        let Some(points) = places else {
            return Err(missing("vertex", own.end.into()));
        };
        let mut mesh = LocalMesh::new(me, params, like.blocks.clone(), own);
        mesh.fixed = like.fixed;
        mesh.tets.reserve(tets.len() + tets.len() / 4 + 64);
        mesh.tets.set_points(VertexId::new(1), points);
        for vertex in &others {
            mesh.take_vertex(vertex);
        }
        for v in &tets {
            let [.., d] = *v;
            let lost =
                v.iter().find(|&&w| !(mesh.tets.is_vertex(VertexId::new(w)) || w == 0 && d == 0));
            if let Some(&lost) = lost.or(v[..3].iter().find(|&&w| w == 0)) {
                return Err(missing("vertex", lost.into()));
            }
            if mesh.tets.create(v.map(VertexId::new)).is_none() {
                return Err(ShareError::Submesh { worker: me, error: mesh.no_room() });
            }
        }
        let count = tets.len();
        drop(tets);
        for (k, faces) in beyond.iter().enumerate() {
            for (slot, beyond) in faces.iter().enumerate() {
                let face = FaceId::new(TetId::at(k), slot);
                match *beyond {
                    Beyond::Near(other) if other as usize / 4 >= count => {
                        return Err(missing("face", other.into()));
                    }
                    // Both ways at once.
                    Beyond::Near(other) if other as usize / 4 < k => {}
                    Beyond::Near(other) => {
                        let there = TetId::new(other / 4);
                        mesh.tets.link(face, FaceId::new(there, (other % 4) as usize));
                    }
                    Beyond::Far(far) => {
                        if mesh.tets.link_far(face, far).is_none() {
                            return Err(ShareError::Submesh { worker: me, error: mesh.no_room() });
                        }
                    }
                }
            }
        }
        for (name, k) in names {
            if k as usize >= count {
                return Err(missing("tetrahedron", k.into()));
            }
            mesh.names.insert(name, TetId::new(k));
        }
        mesh.duplicates = duplicates;
        let (first, end) = (VertexId::new(1), mesh.vertices.after_run());
        mesh.tets.set_own_range(first..end);
        Ok(mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Layout, Ownership, Prepared, gather};
    use crate::wire::{bytes_of, value_of};
    use ltbw_core::Builder;
    use ltbw_exact::PointSet;
    use ltbw_generate::{PointKind, generate};

    fn start() -> (PointSet, Prepared) {
        let set = PointSet::new(generate(PointKind::Uniform, 400, 3)).unwrap();
        let (ownership, sample) = (Ownership::Newest, set.len());
        let layout = Layout { ownership, sample, ..Layout::new(set.len(), 3) };
        let prepared = layout.distribute(&set).unwrap();
        (set, prepared)
    }

    #[test]
    fn a_mesh_of_shares_is_the_mesh() {
        let (set, Prepared { workers, common, .. }) = start();
        let mut meshes: Vec<LocalMesh> = workers.into_iter().map(|(_, mesh, _)| mesh).collect();
        let travel = |mesh: &LocalMesh| {
            let bytes = bytes_of(&share_of(mesh).0, mesh.me).unwrap();
            value_of(mesh.me, &bytes).unwrap()
        };
        let shares = meshes[1..].iter().map(travel).collect();
        let others = put_back(shares, &meshes[0], &common, common.mode).unwrap();
        for (other, mesh) in others.iter().zip(&meshes[1..]) {
            assert_eq!(share_of(other).0, share_of(mesh).0);
        }
        meshes.splice(1.., others);
        let whole = gather(meshes, common).unwrap().mesh;
        assert_eq!(whole.hash(), Builder::new().build(&set).unwrap().mesh.hash());
    }

    #[test]
    fn numbers_of_nothing_are_refused_by_name() {
        let (_, Prepared { workers, common, .. }) = start();
        let mesh = &workers[1].1;
        let put = |share| put_back(vec![share], mesh, &common, common.mode).map(|_| ());
        let (good, _) = share_of(mesh);
        assert_eq!(put(good.clone()), Ok(()));
        assert_eq!(good.is_of(mesh.me), Ok(()));
        assert!(good.is_of(WorkerId::new(7)).is_err());
        let most = u32::MAX;
        let mut bad = [(); 6].map(|()| good.clone());
        bad[0].tets[3][1] = most;
        bad[1].tets[3][0] = 0;
        bad[2].beyond[2][1] = Beyond::Near(most);
        bad[3].names.push((Name { by: mesh.me, number: 9 }, most));
        bad[4].own.end = most;
        bad[5].own.start = 0;
        let kinds = ["vertex", "vertex", "face", "tetrahedron", "vertex", "vertex"];
        for (share, kind) in bad.into_iter().zip(kinds) {
            match put(share) {
                Err(ShareError::Missing { worker, what, .. }) => {
                    assert_eq!((worker, what), (mesh.me, kind));
                }
                other => panic!("{kind}: {other:?}"),
            }
        }
    }
}
