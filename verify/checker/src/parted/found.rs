//! Defects of a mesh in parts, on their way to all members.

use super::exchange::{Exchange, Record, tell_all_bytes};
use crate::chunks::Partial;
use crate::defect::{Defect, Findings, Kind};
use crate::mesh::Point;
use std::collections::BTreeMap;

/// A vertex of a defect: its number among all points, and its coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    pub(crate) number: u32,
    pub(crate) at: Point,
}

/// Defects with their coordinates: all are counted, and some of each kind are listed.
pub(crate) struct Found {
    limit: usize,
    pub(crate) counts: BTreeMap<Kind, u64>,
    listed: BTreeMap<Kind, Vec<Defect>>,
}

impl Found {
    pub(crate) fn new(limit: usize) -> Self {
        Self { limit, counts: BTreeMap::new(), listed: BTreeMap::new() }
    }

    /// Records one defect.
    pub(crate) fn add(&mut self, kind: Kind, tets: &[u32], corners: &[Corner]) {
        let vertices = corners.iter().map(|corner| corner.number).collect();
        let at = corners.iter().map(|corner| Some(corner.at)).collect();
        self.take(1, Defect { kind, tets: tets.to_vec(), vertices, at });
    }

    fn take(&mut self, count: u64, defect: Defect) {
        *self.counts.entry(defect.kind).or_default() += count;
        let list = self.listed.entry(defect.kind).or_default();
        if list.len() < self.limit {
            list.push(defect);
        }
    }

    /// Records the findings in a part by itself, under the names that it has in the whole.
    pub(crate) fn local(&mut self, found: &Findings, points: &[Point], part: Names<'_>) {
        for mut defect in found.defects(points) {
            // A number of no vertex of the part stays as it is: it is the defect.
            let number = |v: &mut u32| *v = part.numbers.get(*v as usize).copied().unwrap_or(*v);
            defect.vertices.iter_mut().for_each(number);
            defect.tets.iter_mut().for_each(|t| *t = t.saturating_add(part.first));
            self.take(0, defect);
        }
        for (&kind, &count) in &found.counts {
            *self.counts.entry(kind).or_default() += count;
        }
    }

    /// As [`Found::local`], of a sweep; its tests are in what is returned.
    pub(crate) fn sweep(&mut self, part: Partial, points: &[Point], names: Names<'_>) -> Partial {
        self.local(&part.findings, points, names);
        Partial { findings: Findings::new(0), ..part }
    }

    /// The defects that all members have found, in their order: the same at all.
    pub(crate) fn of_all<E: Exchange>(self, team: &mut E) -> Result<Self, E::Error> {
        let all = tell_all_bytes(team, &self.bytes())?;
        let mut sum = Self::new(self.limit);
        for (from, bytes) in all.iter().enumerate() {
            if sum.read(bytes).is_none() {
                return Err(team.nonsense(from, "no list of defects"));
            }
        }
        Ok(sum)
    }

    /// The listed defects, by kind.
    pub(crate) fn into_listed(self) -> Vec<Defect> {
        self.listed.into_values().flatten().collect()
    }

    fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        (self.counts.len() as u32).put(&mut bytes);
        for (&kind, count) in &self.counts {
            let list = self.listed.get(&kind).map_or(&[][..], Vec::as_slice);
            (kind as u32).put(&mut bytes);
            count.put(&mut bytes);
            (list.len() as u32).put(&mut bytes);
            for Defect { tets, vertices, at, .. } in list {
                (tets.len() as u32).put(&mut bytes);
                tets.iter().for_each(|t| t.put(&mut bytes));
                (vertices.len() as u32).put(&mut bytes);
                for (v, at) in vertices.iter().zip(at) {
                    v.put(&mut bytes);
                    u32::from(at.is_some()).put(&mut bytes);
                    at.unwrap_or_default().put(&mut bytes);
                }
            }
        }
        bytes
    }

    /// Adds a list of another member; `None` if it is none.
    fn read(&mut self, bytes: &[u8]) -> Option<()> {
        let mut bytes = Bytes(bytes);
        for _ in 0..bytes.take::<u32>()? {
            let kind = *Kind::EVERY.get(bytes.take::<u32>()? as usize)?;
            let count = self.counts.entry(kind).or_default();
            *count = count.saturating_add(bytes.take::<u64>()?);
            for _ in 0..bytes.take::<u32>()? {
                let (mut tets, mut vertices, mut at) = (Vec::new(), Vec::new(), Vec::new());
                for _ in 0..bytes.take::<u32>()? {
                    tets.push(bytes.take::<u32>()?);
                }
                for _ in 0..bytes.take::<u32>()? {
                    vertices.push(bytes.take::<u32>()?);
                    let is_there = bytes.take::<u32>()? == 1;
                    let place = bytes.take::<Point>()?;
                    at.push(is_there.then_some(place));
                }
                self.take(0, Defect { kind, tets, vertices, at });
            }
        }
        bytes.0.is_empty().then_some(())
    }
}

/// The names of a part's tetrahedra and vertices in the whole mesh.
#[derive(Clone, Copy)]
pub(crate) struct Names<'a> {
    /// The number of the first tetrahedron.
    pub(crate) first: u32,
    /// The numbers of the vertices.
    pub(crate) numbers: &'a [u32],
}

/// Bytes that are read.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take<R: Record>(&mut self) -> Option<R> {
        let (own, rest) = self.0.split_at_checked(R::BYTES)?;
        self.0 = rest;
        Some(R::get(own))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defects_travel_and_nonsense_is_refused() {
        let mut found = Found::new(2);
        let corner = |k: u32| Corner { number: k, at: [f64::from(k), -0.5, 5e-324] };
        for k in 0..5 {
            found.add(Kind::FlatTet, &[k], &[corner(k), corner(9)]);
        }
        found.add(Kind::NotFinite, &[], &[Corner { number: 1, at: [1.0, f64::INFINITY, 0.0] }]);
        let bytes = found.bytes();
        let mut back = Found::new(2);
        back.read(&bytes).unwrap();
        assert_eq!(back.counts, found.counts);
        assert_eq!(back.counts[&Kind::FlatTet], 5);
        assert_eq!(back.listed, found.listed);
        for length in 0..bytes.len() {
            assert!(Found::new(2).read(&bytes[..length]).is_none(), "{length}");
        }
        // Lengths take no memory before what they announce is there.
        let mut garbage = bytes.clone();
        garbage[16..20].fill(0xff);
        assert!(Found::new(2).read(&garbage).is_none());
        assert!(Found::new(2).read(&[[1, 0, 0, 0], [0xff; 4]].concat()).is_none());
    }
}
