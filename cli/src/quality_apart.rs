//! The quality of a mesh in parts: counts are sums, and extremes are those of the whole, under the
//! numbers that their tetrahedra have in its order.

use crate::others::Apart;
use crate::outcome::Failure;
use ltbw::distributed::Part;
use ltbw::quality::{Extreme, LeastAngles, Quality};
use serde::{Deserialize, Serialize};

/// The figures of one part, or of several.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Figures {
    tets: u64,
    /// Of each histogram.
    counts: [Vec<u64>; 4],
    least_angles: LeastAngles,
    /// Values, each with its tetrahedron by numbers: of each histogram the least and the largest
    /// one, then the smallest scaled Jacobian.
    extremes: [(f64, [u32; 4]); 9],
    small: [u64; 2],
}

impl Figures {
    fn of(own: &Quality, tet: impl Fn(usize) -> [u32; 4]) -> Self {
        let extreme = |own: &Extreme| (own.value, tet(own.tet));
        Self {
            tets: own.tets as u64,
            counts: own.histograms().map(|own| own.counts.clone()),
            least_angles: own.least_angles,
            extremes: extremes(&mut own.clone()).map(|own| extreme(own)),
            small: own.small,
        }
    }

    /// Adds those of another part. Of equal extremes that of the first tetrahedron counts.
    fn add(&mut self, other: &Self) {
        self.tets = self.tets.saturating_add(other.tets);
        for (own, other) in self.counts.iter_mut().zip(&other.counts) {
            own.iter_mut().zip(other).for_each(|(own, more)| *own = own.saturating_add(*more));
        }
        self.least_angles = self.least_angles.merged(other.least_angles);
        for (k, (own, other)) in self.extremes.iter_mut().zip(&other.extremes).enumerate() {
            let is_further = match IS_LARGEST[k] {
                true => other.0 > own.0,
                false => other.0 < own.0,
            };
            let is_earlier = other.0.total_cmp(&own.0).is_eq() && other.1 < own.1;
            if is_further || is_earlier {
                *own = *other;
            }
        }
        self.small
            .iter_mut()
            .zip(other.small)
            .for_each(|(own, more)| *own = own.saturating_add(more));
    }
}

/// The extremes: of each histogram the least and the largest one, then the smallest scaled
/// Jacobian.
fn extremes(own: &mut Quality) -> [&mut Extreme; 9] {
    let Quality { dihedral, radius_edge, volume, edge, scaled_jacobian, .. } = own;
    [
        &mut dihedral.least,
        &mut dihedral.largest,
        &mut radius_edge.least,
        &mut radius_edge.largest,
        &mut volume.least,
        &mut volume.largest,
        &mut edge.least,
        &mut edge.largest,
        scaled_jacobian,
    ]
}

/// Which of the extremes are the largest ones.
const IS_LARGEST: [bool; 9] = [false, true, false, true, false, true, false, true, false];

/// The quality of the mesh that the parts of all are, whose tetrahedra are in order; `None` if
/// there are none.
pub(crate) fn quality(others: &dyn Apart, part: &Part) -> Result<Option<Quality>, Failure> {
    let widths = others.all(&Quality::widths(&part.points, &part.tets))?;
    let larger = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|k| a[k].max(b[k]));
    let widths = widths.into_iter().fold([0.0; 2], larger);
    let numbered = |tet: &[u32; 4]| tet.map(|v| part.numbers[v as usize]);
    let own = Quality::within(&part.points, &part.tets, widths);
    let own = Figures::of(&own, |k| part.tets.get(k).map(numbered).unwrap_or_default());
    let all: Vec<Figures> = others.all(&own)?;
    let mut all = all.into_iter().filter(|own| own.tets > 0);
    let Some(mut sum) = all.next() else { return Ok(None) };
    all.for_each(|own| sum.add(&own));
    // The place of a tetrahedron is the number of those before it.
    let before =
        |(_, tet): &(f64, [u32; 4])| part.tets.partition_point(|own| numbered(own) < *tet) as u64;
    let places: Vec<Vec<u64>> = others.all(&sum.extremes.iter().map(before).collect())?;
    let mut whole = Quality::within(&[], &[], widths);
    (whole.tets, whole.small) = (sum.tets as usize, sum.small);
    whole.least_angles = sum.least_angles;
    let Quality { dihedral, radius_edge, volume, edge, .. } = &mut whole;
    for (own, counts) in [dihedral, radius_edge, volume, edge].into_iter().zip(sum.counts) {
        own.counts = counts;
    }
    for (k, extreme) in extremes(&mut whole).into_iter().enumerate() {
        let place = places.iter().filter_map(|own| own.get(k)).sum::<u64>();
        let value = sum.extremes.get(k).map_or(extreme.value, |own| own.0);
        *extreme = Extreme { value, tet: place as usize };
    }
    Ok(Some(whole))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However tetrahedra are divided, some of which are equal: the figures of all.
    #[test]
    fn figures_of_parts_are_those_of_the_whole() {
        let coordinate = |k: u32, by: u32| f64::from(k * by % 7);
        let points: Vec<_> =
            (0..12).map(|k| [coordinate(k, 1), coordinate(k, 3), coordinate(k, 5)]).collect();
        let tets: Vec<[u32; 4]> = (0..9).map(|k| [k, k + 1, k + 2, k + 3]).collect();
        let widths = Quality::widths(&points, &tets);
        let figures = |own: &[[u32; 4]]| {
            Figures::of(&Quality::within(&points, own, widths), |k| {
                own.get(k).copied().unwrap_or_default()
            })
        };
        let whole = figures(&tets);
        for parts in 2..5 {
            for first in 0..parts {
                let of = |part: usize| -> Vec<[u32; 4]> {
                    tets.iter().copied().skip((part + first) % parts).step_by(parts).collect()
                };
                let mut sum = figures(&of(0));
                (1..parts).for_each(|part| sum.add(&figures(&of(part))));
                assert_eq!(sum, whole, "{parts} parts from {first}");
            }
        }
    }
}
