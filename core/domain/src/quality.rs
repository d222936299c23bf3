//! The quality of tetrahedra: histograms and extremes of dihedral angles, circumradius to shortest
//! edge, volume and edge length; as text.
//!
//! Values are rounded: they are for people. Bounds are tested exactly elsewhere.

mod angles;

pub use angles::LeastAngles;
#[doc(hidden)]
pub use angles::{Normals, sharpest};

use crate::vector::{cross, dot, minus};
use ltbw_exact::Point;
use rayon::prelude::*;
use std::fmt::Write as _;
use std::mem::take;

/// A value and the tetrahedron (its place in the list) that has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// The value.
    pub value: f64,
    /// The tetrahedron.
    pub tet: usize,
}

impl Extreme {
    /// Takes another one that is less; the first of equal ones stays.
    fn lower(&mut self, other: Self) {
        if other.value < self.value {
            *self = other;
        }
    }
}

/// Counts of values in bins of equal width.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// The quantity that is counted.
    pub name: &'static str,
    /// Lower end of the first bin.
    pub low: f64,
    /// Upper end of the last bin.
    pub high: f64,
    /// The bins; values outside are in the first or the last one.
    pub counts: Vec<u64>,
    /// The least value.
    pub least: Extreme,
    /// The largest value.
    pub largest: Extreme,
}

/// The quality of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Number of tetrahedra.
    pub tets: usize,
    /// Dihedral angles in degrees, six for each tetrahedron, in bins of 5°.
    pub dihedral: Histogram,
    /// Circumradius to shortest edge.
    pub radius_edge: Histogram,
    /// Volumes.
    pub volume: Histogram,
    /// Edge lengths, six for each tetrahedron.
    pub edge: Histogram,
    /// Tetrahedra by their smallest dihedral angle.
    pub least_angles: LeastAngles,
    /// The smallest scaled Jacobian.
    pub scaled_jacobian: Extreme,
    /// For each of [`SMALL_ANGLES`], the tetrahedra with a smaller dihedral angle.
    pub small: [u64; 2],
}

/// Dihedral angles, in degrees, below which tetrahedra are counted: those that spoil a solution,
/// and those that slow it down.
pub const SMALL_ANGLES: [f64; 2] = [1.0, 5.0];

/// The measures of one tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TetQuality {
    /// Dihedral angles in degrees, at the edges 01, 02, 03, 12, 13, 23.
    pub dihedral: [f64; 6],
    /// Circumradius to shortest edge; infinite for a flat tetrahedron.
    pub radius_edge: f64,
    /// Volume, never negative.
    pub volume: f64,
    /// Edge lengths, in the order of the angles.
    pub edges: [f64; 6],
    /// √2 times six volumes over the largest product of the three edges at a corner: 1 for a
    /// regular tetrahedron, 0 for a flat one, never negative (Knupp 2003).
    pub scaled_jacobian: f64,
}

/// Tetrahedra that one thread measures at a time.
const SHARE: usize = if cfg!(test) { 3 } else { 4096 };

/// The edges by their slots, and the two other slots.
const EDGES: [[usize; 4]; 6] =
    [[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 0, 2], [2, 3, 0, 1]];

/// Lengths of the edges.
fn lengths(corners: [&Point; 4]) -> [f64; 6] {
    EDGES.map(|[i, j, ..]| {
        let d = minus(corners[i], corners[j]);
        dot(&d, &d).sqrt()
    })
}

/// The edges at each corner, by their places in [`EDGES`].
const AT_CORNER: [[usize; 3]; 4] = [[0, 1, 2], [0, 3, 4], [1, 3, 5], [2, 4, 5]];

/// The volume, never negative.
fn volume(corners: [&Point; 4]) -> f64 {
    let [a, b, c] = [0, 1, 2].map(|k| minus(corners[k], corners[3]));
    dot(&a, &cross(&b, &c)).abs() / 6.0
}

impl TetQuality {
    /// Measures a tetrahedron.
    #[must_use]
    pub fn of(corners: [&Point; 4]) -> Self {
        let edges = lengths(corners);
        // The angle between the two faces at an edge is that between their normals, both taken
        // from the edge towards the third corner.
        let dihedral = EDGES.map(|[i, j, k, l]| {
            let e = minus(corners[j], corners[i]);
            let m = cross(&e, &minus(corners[k], corners[i]));
            let n = cross(&e, &minus(corners[l], corners[i]));
            let c = cross(&m, &n);
            dot(&c, &c).sqrt().atan2(dot(&m, &n)).to_degrees()
        });
        let [a, b, c] = [0, 1, 2].map(|k| minus(corners[k], corners[3]));
        let (bc, ca, ab) = (cross(&b, &c), cross(&c, &a), cross(&a, &b));
        let (aa, bb, cc) = (dot(&a, &a), dot(&b, &b), dot(&c, &c));
        let n = [0, 1, 2].map(|k| aa * bc[k] + bb * ca[k] + cc * ab[k]);
        let det = dot(&a, &bc).abs();
        let shortest = edges.into_iter().fold(f64::INFINITY, f64::min);
        let ratio = dot(&n, &n).sqrt() / (2.0 * det) / shortest;
        let radius_edge = if ratio.is_nan() { f64::INFINITY } else { ratio };
        let products = AT_CORNER.map(|own| own.map(|k| edges[k]).into_iter().product::<f64>());
        let most = products.into_iter().fold(0.0, f64::max);
        let scaled_jacobian = if most > 0.0 { std::f64::consts::SQRT_2 * det / most } else { 0.0 };
        Self { dihedral, radius_edge, volume: det / 6.0, edges, scaled_jacobian }
    }

    /// Its [`FIGURES`].
    fn figures(&self) -> [f64; 4] {
        let largest = self.dihedral.into_iter().fold(f64::NEG_INFINITY, f64::max);
        [self.radius_edge, self.volume, self.least_dihedral(), largest]
    }

    /// The smallest dihedral angle, in degrees.
    #[must_use]
    pub fn least_dihedral(&self) -> f64 {
        self.dihedral.into_iter().fold(f64::INFINITY, f64::min)
    }
}

impl Histogram {
    fn new(name: &'static str, low: f64, high: f64, bins: usize) -> Self {
        let least = Extreme { value: f64::INFINITY, tet: 0 };
        let largest = Extreme { value: f64::NEG_INFINITY, tet: 0 };
        Self { name, low, high, counts: vec![0; bins], least, largest }
    }

    fn add(&mut self, value: f64, tet: usize) {
        self.least.lower(Extreme { value, tet });
        if value > self.largest.value {
            self.largest = Extreme { value, tet };
        }
        let bins = self.counts.len();
        let place = (value - self.low) / (self.high - self.low) * bins as f64;
        // The conversion saturates: NaN (no width) and values below go to 0.
        self.counts[(place as usize).min(bins - 1)] += 1;
    }

    /// Adds the values of later tetrahedra: as if all had been added in their order.
    fn merge(&mut self, later: &Self) {
        self.least.lower(later.least);
        if later.largest.value > self.largest.value {
            self.largest = later.largest;
        }
        self.counts.iter_mut().zip(&later.counts).for_each(|(own, more)| *own += more);
    }

    /// Bounds of bin `k`.
    #[must_use]
    pub fn bin(&self, k: usize) -> [f64; 2] {
        let width = (self.high - self.low) / self.counts.len() as f64;
        [self.low + k as f64 * width, self.low + (k + 1) as f64 * width]
    }

    fn total(&self) -> u64 {
        self.counts.iter().sum()
    }
}

/// Names of the figures of a tetrahedron under which mesh files carry them; angles in degrees.
pub const FIGURES: [&str; 4] = ["radius_edge", "volume", "dihedral_min", "dihedral_max"];

/// The [`FIGURES`] of tetrahedra, a row for each.
#[cfg(any(feature = "ndarray", feature = "nalgebra"))]
fn figures(points: &[Point], tets: &[[u32; 4]]) -> Vec<[f64; 4]> {
    let row = |tet: &[u32; 4]| TetQuality::of(tet.map(|v| &points[v as usize])).figures();
    tets.par_iter().with_min_len(SHARE).map(row).collect()
}

/// A figure of every tetrahedron of a mesh, as mesh files carry it.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Its name.
    pub name: &'static str,
    /// A value for each tetrahedron.
    pub values: Vec<f64>,
}

/// The [`FIGURES`] of every tetrahedron, measured on all threads. All vertices have to be points.
#[must_use]
pub fn arrays(points: &[Point], tets: &[[u32; 4]]) -> Vec<Array> {
    let of_share = |list: &[[u32; 4]]| {
        let all = list.iter().map(|tet| TetQuality::of(tet.map(|v| &points[v as usize])));
        let mut own = Columns::default();
        all.for_each(|tet| own.add(&tet));
        own
    };
    joined(tets.par_chunks(SHARE).map(of_share).collect())
}

/// The [`FIGURES`] of some tetrahedra one after the other, by figure.
#[derive(Default)]
struct Columns([Vec<f64>; 4]);

impl Columns {
    fn add(&mut self, tet: &TetQuality) {
        self.0.iter_mut().zip(tet.figures()).for_each(|(own, value)| own.push(value));
    }
}

/// Shares one after the other as arrays.
fn joined(mut shares: Vec<Columns>) -> Vec<Array> {
    let mut values = |k: usize| shares.iter_mut().flat_map(|own| take(&mut own.0[k])).collect();
    FIGURES.into_iter().enumerate().map(|(k, name)| Array { name, values: values(k) }).collect()
}

/// The quality of a mesh and, if asked for, the [`arrays`] of its tetrahedra.
#[derive(Clone, Debug, PartialEq)]
pub struct Measures {
    /// The quality.
    pub quality: Quality,
    /// The arrays, of which there are none if nobody has asked.
    pub arrays: Vec<Array>,
}

impl Measures {
    /// Measures all tetrahedra once for both. `None` as [`Quality::of`].
    #[must_use]
    pub fn of(points: &[Point], tets: &[[u32; 4]], with_arrays: bool) -> Option<Self> {
        let widths = Quality::known(points, tets).then(|| Quality::widths(points, tets))?;
        Some(Self::within(points, tets, widths, with_arrays))
    }

    fn within(points: &[Point], tets: &[[u32; 4]], widths: [f64; 2], with_arrays: bool) -> Self {
        let none = Quality::none(tets.len(), widths);
        let share = |(k, list): (usize, &[[u32; 4]])| {
            let (mut own, mut columns) = (none.clone(), Columns::default());
            for (t, tet) in (k * SHARE..).zip(list) {
                let corners = tet.map(|v| &points[v as usize]);
                let tet = TetQuality::of(corners);
                own.add(t, &tet);
                own.least_angles.add(corners);
                if with_arrays {
                    columns.add(&tet);
                }
            }
            (own, columns)
        };
        let shares: (Vec<Quality>, Vec<Columns>) =
            tets.par_chunks(SHARE).enumerate().map(share).unzip();
        let mut quality = none;
        shares.0.iter().for_each(|later| quality.merge(later));
        let arrays = if with_arrays { joined(shares.1) } else { Vec::new() };
        Self { quality, arrays }
    }
}

/// The [`FIGURES`] as an array of shape (m, 4), a row for each tetrahedron (feature `ndarray`). All
/// vertices have to be points.
///
/// ```
/// use ltbw_domain::quality::{FIGURES, to_ndarray};
///
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let all = to_ndarray(&points, &[[0, 1, 2, 3], [0, 1, 2, 3]]);
/// assert_eq!(all.dim(), (2, FIGURES.len()));
/// assert_eq!(all[[1, 1]], 1.0 / 6.0);
/// ```
#[cfg(feature = "ndarray")]
#[must_use]
pub fn to_ndarray(points: &[Point], tets: &[[u32; 4]]) -> ndarray::Array2<f64> {
    ltbw_exact::interop::to_ndarray(figures(points, tets))
}

/// The [`FIGURES`] as a matrix with a row for each tetrahedron (feature `nalgebra`). All vertices
/// have to be points.
///
/// ```
/// use ltbw_domain::quality::{FIGURES, to_nalgebra};
///
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let all = to_nalgebra(&points, &[[0, 1, 2, 3], [0, 1, 2, 3]]);
/// assert_eq!(all.shape(), (2, FIGURES.len()));
/// assert_eq!(all[(1, 1)], 1.0 / 6.0);
/// ```
#[cfg(feature = "nalgebra")]
#[must_use]
pub fn to_nalgebra(points: &[Point], tets: &[[u32; 4]]) -> nalgebra::MatrixXx4<f64> {
    let values: Vec<f64> = figures(points, tets).into_iter().flatten().collect();
    nalgebra::MatrixXx4::from_row_slice(&values)
}

impl Quality {
    /// Measures all tetrahedra, on all threads, whose number changes nothing; `None` if there are
    /// none or if one names a point that is not there.
    #[must_use]
    pub fn of(points: &[Point], tets: &[[u32; 4]]) -> Option<Self> {
        Measures::of(points, tets, false).map(|all| all.quality)
    }

    /// Are there tetrahedra, all of whose vertices are points?
    fn known(points: &[Point], tets: &[[u32; 4]]) -> bool {
        let known = |tet: &[u32; 4]| tet.iter().all(|&v| (v as usize) < points.len());
        !tets.is_empty() && tets.par_iter().with_min_len(SHARE).all(known)
    }

    /// The largest volume and the longest edge, which are the widths of histograms. All vertices
    /// have to be points.
    #[must_use]
    pub fn widths(points: &[Point], tets: &[[u32; 4]]) -> [f64; 2] {
        // They need no angles, which are what costs time.
        let larger = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|k| a[k].max(b[k]));
        let widest = |list: &[[u32; 4]]| {
            list.iter().map(|tet| tet.map(|v| &points[v as usize])).fold([0.0; 2], |most, tet| {
                larger(most, [volume(tet), lengths(tet).into_iter().fold(0.0, f64::max)])
            })
        };
        tets.par_chunks(SHARE).map(widest).reduce(|| [0.0; 2], larger)
    }

    /// The measures of tetrahedra of a mesh with these widths, or of none. All vertices have to be
    /// points.
    #[must_use]
    pub fn within(points: &[Point], tets: &[[u32; 4]], widths: [f64; 2]) -> Self {
        Measures::within(points, tets, widths, false).quality
    }

    /// Nothing measured, of a number of tetrahedra.
    fn none(tets: usize, [largest, edge]: [f64; 2]) -> Self {
        Self {
            tets,
            dihedral: Histogram::new("dihedral angle, degrees", 0.0, 180.0, 36),
            radius_edge: Histogram::new("circumradius / shortest edge", 0.6, 2.1, 30),
            volume: Histogram::new("volume", 0.0, largest, 30),
            edge: Histogram::new("edge length", 0.0, edge, 30),
            least_angles: LeastAngles::default(),
            scaled_jacobian: Extreme { value: f64::INFINITY, tet: 0 },
            small: [0; 2],
        }
    }

    fn add(&mut self, t: usize, tet: &TetQuality) {
        tet.dihedral.into_iter().for_each(|angle| self.dihedral.add(angle, t));
        tet.edges.into_iter().for_each(|length| self.edge.add(length, t));
        self.radius_edge.add(tet.radius_edge, t);
        self.volume.add(tet.volume, t);
        self.scaled_jacobian.lower(Extreme { value: tet.scaled_jacobian, tet: t });
        let least = tet.least_dihedral();
        self.small.iter_mut().zip(SMALL_ANGLES).for_each(|(n, a)| *n += u64::from(least < a));
    }

    fn merge(&mut self, later: &Self) {
        self.dihedral.merge(&later.dihedral);
        self.edge.merge(&later.edge);
        self.least_angles = self.least_angles.merged(later.least_angles);
        self.radius_edge.merge(&later.radius_edge);
        self.volume.merge(&later.volume);
        self.scaled_jacobian.lower(later.scaled_jacobian);
        self.small.iter_mut().zip(later.small).for_each(|(own, more)| *own += more);
    }

    /// The four histograms.
    #[must_use]
    pub fn histograms(&self) -> [&Histogram; 4] {
        [&self.dihedral, &self.radius_edge, &self.volume, &self.edge]
    }

    /// Extremes and the histogram of dihedral angles, as text for people.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        for h in self.histograms() {
            let (least, largest) = (h.least, h.largest);
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{:<28} {:.6e} (tet {}) to {:.6e} (tet {})",
                h.name, least.value, least.tet, largest.value, largest.tet
            );
        }
        let h = &self.dihedral;
        let most = h.counts.iter().copied().max().unwrap_or(0).max(1);
        for (k, &count) in h.counts.iter().enumerate() {
            let [low, high] = h.bin(k);
            let bar = "#".repeat((count * 50 / most) as usize);
            let share = 100.0 * count as f64 / h.total().max(1) as f64;
            let _ = writeln!(text, "{low:>4.0}-{high:<4.0} {share:>6.2} % {bar}");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_regular_tetrahedron_and_a_corner() {
        let regular = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let [a, b, c, d] = &regular;
        let q = TetQuality::of([a, b, c, d]);
        let angle = (1.0f64 / 3.0).acos().to_degrees();
        assert!(q.dihedral.iter().all(|x| (x - angle).abs() < 1e-12), "{:?}", q.dihedral);
        assert!((q.radius_edge - 0.375f64.sqrt()).abs() < 1e-15);
        assert!((q.scaled_jacobian - 1.0).abs() < 1e-15);
        assert!((q.volume - 8.0 / 3.0).abs() < 1e-15);
        assert!(q.edges.iter().all(|x| (x - 8f64.sqrt()).abs() < 1e-15));
        let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let [a, b, c, d] = &corner;
        let q = TetQuality::of([a, b, c, d]);
        assert!(q.dihedral[..3].iter().all(|x| (x - 90.0).abs() < 1e-12));
        assert!((q.dihedral[3] - (1.0f64 / 3f64.sqrt()).acos().to_degrees()).abs() < 1e-12);
        // At the right angles √2, at the other corners √2 / 2: the smallest counts.
        assert!((q.scaled_jacobian - 0.5f64.sqrt()).abs() < 1e-15);
        let points = [regular, corner].concat();
        let all = Quality::of(&points, &[[0, 1, 2, 3], [4, 5, 6, 7]]).expect("two tetrahedra");
        assert_eq!(all.dihedral.total(), 12);
        assert_eq!(
            (all.dihedral.counts[14], all.dihedral.counts[18], all.dihedral.counts[10]),
            (6, 3, 3)
        );
        assert_eq!((all.volume.largest.tet, all.volume.least.tet), (0, 1));
        assert!(all.text().contains("70-75"));
        // A flat one, and slivers of some 0.5 and 4 degrees.
        let slivers = [0.0, 0.005, 0.04]
            .map(|h| vec![[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, h], [0.0, 1.0, h]]);
        let tets: Vec<[u32; 4]> = (0..3).map(|t| [0, 1, 2, 3].map(|k| 4 * t + k)).collect();
        let small = Quality::of(&slivers.concat(), &tets).expect("three tetrahedra").small;
        assert_eq!(small, [2, 3]);
        assert!(
            Quality::of(&points, &[]).is_none() && Quality::of(&points, &[[0, 1, 2, 9]]).is_none()
        );
    }

    #[test]
    fn shares_are_put_together_in_the_order_of_the_tetrahedra() {
        // Tetrahedra that come again: of equal values the first counts, whatever its share.
        let points: Vec<Point> = (0..20)
            .map(|k| [f64::from(k), f64::from(k * k % 7), f64::from(k * k * k % 11)])
            .collect();
        let tets: Vec<[u32; 4]> = (0..40u32).map(|k| [0, 1, 2, 3].map(|j| k % 13 + j)).collect();
        assert!(tets.len() > 3 * SHARE);
        let whole = Quality::of(&points, &tets).expect("tetrahedra");
        let mut all = whole.clone();
        for h in [&mut all.dihedral, &mut all.radius_edge, &mut all.volume, &mut all.edge] {
            *h = Histogram::new(h.name, h.low, h.high, h.counts.len());
        }
        all.scaled_jacobian = Extreme { value: f64::INFINITY, tet: 0 };
        for (t, tet) in tets.iter().enumerate() {
            all.add(t, &TetQuality::of(tet.map(|v| &points[v as usize])));
        }
        assert_eq!(whole, all);
        let volumes = tets.iter().map(|tet| volume(tet.map(|v| &points[v as usize])));
        assert_eq!(whole.volume.high, volumes.fold(0.0, f64::max));
        assert!(whole.scaled_jacobian.tet < 13);
        assert!(whole.volume.largest.tet < 13 && whole.edge.least.tet < 13, "{whole:?}");
    }

    #[test]
    fn a_flat_tetrahedron_does_no_harm() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let all = Quality::of(&points, &[[0, 1, 2, 3]]).expect("a tetrahedron");
        assert!(all.radius_edge.largest.value.is_infinite());
        assert_eq!(all.scaled_jacobian, Extreme { value: 0.0, tet: 0 });
        assert_eq!(all.volume.counts.iter().sum::<u64>(), 1);
    }
}
