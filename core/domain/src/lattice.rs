//! The lattice: input vertices on g·Z³, so that every point of the refinement is an exact `f64`.
//!
//! g is the least power of two for which no coordinate exceeds 2^26 steps. Points on segments and
//! facets have parameters that are multiples of 2^-27 on their carrier, so all coordinates are
//! multiples of the fine step g·2^-27 and at most 2^53 of them: exact `f64`s, on their carrier.
//!
//! Far from the origin the bits of the coordinates are spent on the distance: a domain whose size
//! is 2^-k of it keeps 26 - k bits, and as many fewer below. [`Lattice::lost_bits`] says how many;
//! [`Lattice::local`] measures from the middle of the domain instead and loses none.
//!
//! Snapping moves a vertex by at most g/2 in each coordinate. It can make a domain intersect
//! itself or vertices coincide, so the geometric check has to run on what it returns.

use crate::{Domain, DomainError};
use ltbw_exact::Point;
use ltbw_exact::points::{WINDOW_HIGH_EXPONENT, WINDOW_LOW_EXPONENT};
use ltbw_exact::predicates::filter::power_of_two;

/// Bits of an input coordinate: at most 2^26 steps.
pub const INPUT_BITS: i32 = 26;

/// Bits of a parameter on a segment or facet.
pub const PARAMETER_BITS: i32 = 27;

/// The grid g·Z³ about an offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lattice {
    /// g = 2^exponent.
    exponent: i32,
    /// The origin of the lattice, in the coordinates of the input.
    offset: Point,
    /// Bits that the distance from the origin takes.
    lost_bits: u32,
}

impl Lattice {
    /// The lattice of a domain in its own coordinates.
    ///
    /// # Errors
    /// [`DomainError::NotFinite`]; [`DomainError::Range`] if the largest coordinate is zero, or
    /// too small or large for the exactness window; [`DomainError::Empty`] without vertices.
    pub fn of(domain: &Domain) -> Result<Self, DomainError> {
        Self::about(domain, [0.0; 3])
    }

    /// The lattice of a domain in the coordinates from its own middle, its *local frame*.
    ///
    /// # Errors
    /// Those of [`Lattice::of`].
    pub fn local(domain: &Domain) -> Result<Self, DomainError> {
        domain.check_numbers()?;
        let (low, high) = domain.bounds().ok_or(DomainError::Empty)?;
        // Half of each first: the sum may overflow. Adding 0.0 turns -0.0 into 0.0.
        Self::about(domain, [0, 1, 2].map(|k| (low[k] / 2.0 + high[k] / 2.0) + 0.0))
    }

    fn about(domain: &Domain, offset: Point) -> Result<Self, DomainError> {
        domain.check_numbers()?;
        let (low, high) = domain.bounds().ok_or(DomainError::Empty)?;
        let reach = |k: usize| (low[k] - offset[k]).abs().max((high[k] - offset[k]).abs());
        let largest = reach(0).max(reach(1)).max(reach(2));
        // 2^ceiling is the least power of two that is not below the largest coordinate.
        let ceiling = ceiling_exponent(largest).ok_or(DomainError::Range { largest })?;
        let exponent = ceiling - INPUT_BITS;
        if exponent - PARAMETER_BITS < WINDOW_LOW_EXPONENT || ceiling >= WINDOW_HIGH_EXPONENT {
            return Err(DomainError::Range { largest });
        }
        let half = |k: usize| high[k] / 2.0 - low[k] / 2.0;
        let size = half(0).max(half(1)).max(half(2));
        let lost_bits =
            ceiling_exponent(size).map_or(0, |e| u32::try_from(ceiling - e).unwrap_or(0));
        Ok(Self { exponent, offset, lost_bits })
    }

    /// The step g of input vertices.
    #[must_use]
    pub fn step(&self) -> f64 {
        power_of_two(self.exponent)
    }

    /// The exponent of the step: g = 2^exponent.
    #[must_use]
    pub fn exponent(&self) -> i32 {
        self.exponent
    }

    /// The step of all points of a mesh, g·2^-27.
    #[must_use]
    pub fn fine_step(&self) -> f64 {
        power_of_two(self.exponent - PARAMETER_BITS)
    }

    /// The point of the input that is the origin of snapped coordinates.
    #[must_use]
    pub fn offset(&self) -> Point {
        self.offset
    }

    /// The number of the 26 bits of coordinates that the distance from the origin takes.
    #[must_use]
    pub fn lost_bits(&self) -> u32 {
        self.lost_bits
    }

    /// The steps of a point in snapped coordinates, if it is on the grid.
    #[must_use]
    pub fn steps(&self, p: &Point) -> Option<[i64; 3]> {
        grid(p, self.exponent, INPUT_BITS)
    }

    /// The fine steps of a point in snapped coordinates, if it is on the fine grid.
    #[must_use]
    pub fn fine_steps(&self, p: &Point) -> Option<[i64; 3]> {
        grid(p, self.exponent - PARAMETER_BITS, INPUT_BITS + PARAMETER_BITS)
    }

    /// The point that is `steps` steps from the origin.
    #[must_use]
    pub fn point(&self, steps: [i64; 3]) -> Point {
        steps.map(|s| s as f64 * self.step())
    }

    /// The point of the grid nearest to a point of the input, in snapped coordinates; ties go to
    /// even steps, so that mirrored points stay mirrored.
    #[must_use]
    pub fn nearest(&self, p: &Point) -> Point {
        let inverse = power_of_two(-self.exponent);
        let near = |k: usize| ((p[k] - self.offset[k]) * inverse).round_ties_even();
        // Adding 0.0 turns -0.0 into 0.0.
        [0, 1, 2].map(|k| near(k) * self.step() + 0.0)
    }

    /// The point of the fine grid nearest to a point of the input, in snapped coordinates.
    #[must_use]
    pub fn nearest_fine(&self, p: &Point) -> Point {
        let inverse = power_of_two(PARAMETER_BITS - self.exponent);
        let near = |k: usize| ((p[k] - self.offset[k]) * inverse).round_ties_even();
        [0, 1, 2].map(|k| near(k) * self.fine_step() + 0.0)
    }
}

/// The coordinates of `p` in steps of 2^exponent, if they are whole and below 2^bits or equal.
fn grid(p: &Point, exponent: i32, bits: i32) -> Option<[i64; 3]> {
    let inverse = power_of_two(-exponent);
    let steps = p.map(|c| c * inverse);
    // The product is exact: it neither overflows into infinity nor vanishes without notice.
    let whole = (0..3).all(|k| {
        steps[k].fract() == 0.0
            && steps[k].abs() <= power_of_two(bits)
            && (steps[k] == 0.0) == (p[k] == 0.0)
    });
    whole.then(|| steps.map(|s| s as i64))
}

/// The least e with `magnitude` ≤ 2^e; `None` for zero, subnormal and not finite numbers.
fn ceiling_exponent(magnitude: f64) -> Option<i32> {
    if !magnitude.is_normal() {
        return None;
    }
    let bits = magnitude.to_bits();
    let floor = ((bits >> 52) & 0x7ff) as i32 - 1023;
    let power = bits & ((1 << 52) - 1) == 0;
    Some(if power { floor } else { floor + 1 })
}

/// The move of a vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// The vertex.
    pub vertex: u32,
    /// Its place before, in the coordinates of the input.
    pub from: Point,
    /// Its place after, in snapped coordinates (those of the input, but for a local frame).
    pub to: Point,
    /// The distance (rounded).
    pub distance: f64,
}

/// A domain on its lattice.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapped {
    /// The domain, every vertex on the grid. In a local frame all its points are relative to
    /// [`Lattice::offset`]. Points of holes and regions are not snapped, and those that are to be
    /// vertices only to the grid of all points of a mesh.
    pub domain: Domain,
    /// The lattice.
    pub lattice: Lattice,
    /// The number of vertices that moved.
    pub moved: usize,
    /// The farthest move, if any vertex moved.
    pub largest: Option<Move>,
    /// The diagonal of the box of the vertices before any moved, rounded: far from the origin all
    /// of them may become one.
    pub diagonal: f64,
}

impl Snapped {
    /// The snapped domain, if no vertex had to move.
    ///
    /// # Errors
    /// [`DomainError::OffLattice`] names the vertex that moved farthest.
    pub fn exact(self) -> Result<Self, DomainError> {
        match self.largest {
            None => Ok(self),
            Some(Move { vertex, from, distance, .. }) => Err(DomainError::OffLattice {
                vertex,
                at: from,
                distance,
                step: self.lattice.step(),
                moved: self.moved,
            }),
        }
    }
}

impl Domain {
    /// Moves every vertex to the nearest point of the domain's lattice.
    ///
    /// # Errors
    /// Those of [`Domain::check_structure`] and [`Lattice::of`].
    pub fn snap(&self) -> Result<Snapped, DomainError> {
        self.check_structure()?;
        Ok(self.snap_to(Lattice::of(self)?))
    }

    /// Moves every vertex to the nearest point of a lattice in the local frame of the domain.
    ///
    /// # Errors
    /// Those of [`Domain::check_structure`] and [`Lattice::local`].
    pub fn snap_local(&self) -> Result<Snapped, DomainError> {
        self.check_structure()?;
        Ok(self.snap_to(Lattice::local(self)?))
    }

    fn snap_to(&self, lattice: Lattice) -> Snapped {
        let relative = |p: &Point| [0, 1, 2].map(|k| p[k] - lattice.offset[k] + 0.0);
        let mut domain = self.clone();
        let (mut moved, mut largest) = (0, None::<Move>);
        for ((vertex, p), from) in (0..).zip(&mut domain.vertices).zip(&self.vertices) {
            let (before, to) = (relative(from), lattice.nearest(from));
            *p = to;
            let step = [0, 1, 2].map(|k| to[k] - before[k]);
            // A subtraction that was rounded moved the vertex, too: the offset must lead back.
            let exact = (0..3).all(|k| step[k] == 0.0 && to[k] + lattice.offset[k] == from[k]);
            if exact {
                continue;
            }
            moved += 1;
            // Scaled by the lattice step, so that squares neither overflow nor vanish.
            let s = step.map(|c| c / lattice.step());
            let distance = (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]).sqrt() * lattice.step();
            if largest.is_none_or(|m| distance > m.distance) {
                largest = Some(Move { vertex, from: *from, to, distance });
            }
        }
        let seeds = domain.holes.iter_mut().chain(domain.regions.iter_mut().map(|r| &mut r.seed));
        let facet_holes = domain.facets.iter_mut().flat_map(|f| &mut f.holes);
        seeds.chain(facet_holes).for_each(|p| *p = relative(p));
        domain.points.iter_mut().for_each(|p| *p = lattice.nearest_fine(p));
        Snapped { domain, lattice, moved, largest, diagonal: self.diagonal() }
    }
}
