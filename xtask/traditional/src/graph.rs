//! The graph of tetrahedra that share faces, its partition by METIS, and the figures of any.

use crate::Failure;
use metis::{Graph, Idx};
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;

/// Tetrahedra and their neighbours across faces, as compressed rows.
pub(crate) struct Dual {
    starts: Vec<Idx>,
    others: Vec<Idx>,
}

/// Figures of a partition, as Table III has them.
pub(crate) struct Figures {
    /// The largest share of faces with another part per tetrahedron of any part.
    pub(crate) surface_to_volume: f64,
    /// The most tetrahedra of a part less the fewest.
    pub(crate) imbalance: usize,
    /// Faces between parts.
    pub(crate) cut: usize,
    /// The most parts that one part touches.
    pub(crate) neighbours: usize,
}

/// The graph of a mesh: faces meet by their corners.
pub(crate) fn dual(tets: &[[u32; 4]]) -> Result<Dual, Failure> {
    let mut open: FxHashMap<[u32; 3], usize> = FxHashMap::default();
    open.reserve(tets.len() / 2);
    let mut beside: Vec<[Option<usize>; 4]> = vec![[None; 4]; tets.len()];
    for (t, corners) in tets.iter().enumerate() {
        for slot in 0..4 {
            let mut face = [0, 1, 2].map(|k| corners[(slot + 1 + k) % 4]);
            face.sort_unstable();
            let Some(place) = open.remove(&face) else {
                open.insert(face, 4 * t + slot);
                continue;
            };
            beside[t][slot] = Some(place / 4);
            beside[place / 4][place % 4] = Some(t);
        }
    }
    let (mut starts, mut others) = (vec![0], Vec::with_capacity(tets.len() * 4));
    for all in beside {
        for other in all.into_iter().flatten() {
            others.push(Idx::try_from(other)?);
        }
        starts.push(Idx::try_from(others.len())?);
    }
    Ok(Dual { starts, others })
}

impl Dual {
    /// Tetrahedra.
    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The places in [`Dual::others`] where the neighbours of each tetrahedron begin, and the end.
    pub(crate) fn starts(&self) -> &[Idx] {
        &self.starts
    }

    /// The neighbours of all tetrahedra.
    pub(crate) fn others(&self) -> &[Idx] {
        &self.others
    }

    /// The part of each tetrahedron, by METIS's k-way partitioning as it comes.
    pub(crate) fn metis(&self, parts: usize) -> Result<Vec<Idx>, Failure> {
        let mut part: Vec<Idx> = vec![0; self.len()];
        Graph::new(1, Idx::try_from(parts)?, &self.starts, &self.others)?.part_kway(&mut part)?;
        Ok(part)
    }

    pub(crate) fn figures(&self, part: &[Idx], parts: usize) -> Figures {
        let (mut tets, mut faces) = (vec![0usize; parts], vec![0usize; parts]);
        let mut beside: Vec<BTreeSet<Idx>> = vec![BTreeSet::new(); parts];
        for (t, &own) in part.iter().enumerate() {
            let me = own as usize;
            tets[me] += 1;
            for &other in &self.others[self.starts[t] as usize..self.starts[t + 1] as usize] {
                let its = part[other as usize];
                if its != own {
                    faces[me] += 1;
                    beside[me].insert(its);
                }
            }
        }
        let share = |(&faces, &tets): (&usize, &usize)| faces as f64 / tets.max(1) as f64;
        let least = tets.iter().min().copied().unwrap_or(0);
        let most = tets.iter().max().copied().unwrap_or(0);
        Figures {
            surface_to_volume: faces.iter().zip(&tets).map(share).fold(0.0, f64::max),
            imbalance: most - least,
            cut: faces.iter().sum::<usize>() / 2,
            neighbours: beside.iter().map(BTreeSet::len).max().unwrap_or(0),
        }
    }
}
