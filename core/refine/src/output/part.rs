//! A part of a refined domain, by values: what its vertices, triangles and slivers are in the whole
//! mesh, for workers that keep their parts.

use crate::complex::carrier::Carrier;
use crate::complex::parts::Markers;
use crate::mesh::bounds::Solid;
use crate::mesh::key::{order_key, sorted};
pub use crate::mesh::number::{GivenNumbers, from_smallest, in_order};
use crate::mesh::state::FACE;
use crate::outcome::Reason;
use crate::patches::dust::Flat;
use crate::rules::choice::Corner;
use crate::rules::complex::Complex;
use ltbw_core::topology::TetId;
use ltbw_domain::quality::TetQuality;
use ltbw_exact::Point;
use std::cell::Cell;

/// A tetrahedron with a dihedral angle below the bound, of some part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinTet {
    /// Its smallest dihedral angle in degrees, rounded.
    pub angle: f64,
    /// A small angle of the domain at one of its corners, which asks for such.
    pub near: Option<Reason>,
    /// May a point serve it?
    pub is_open: bool,
}

/// The tetrahedra of a part that are not as asked for.
#[derive(Clone, Debug, Default)]
pub struct Amiss {
    /// Is one over its bounds, or has a sizing function no length for it?
    pub is_over: bool,
    /// The tetrahedra that may have tiny dihedral angles.
    pub thin: Vec<TetId>,
}

impl Complex<'_> {
    /// The numbers that the domain gives vertices.
    pub fn given_numbers(&self) -> GivenNumbers {
        self.plc().given_numbers()
    }

    /// The marker of a subface of a facet, where `given` are markers of the domain's facets in
    /// place of their own.
    pub fn markers<'m>(
        &'m self,
        given: Option<&'m [i32]>,
    ) -> impl Fn(u32, [Point; 3]) -> i32 + use<'m> {
        let markers = Markers::new(self.plc(), given);
        move |facet, corners| markers.of(facet, corners)
    }

    /// Looks at tetrahedra once more when all is done, given with their corners and regions.
    /// `is_flat` tells whether all corners of one are on one patch: then it is over no bound.
    pub fn amiss(
        &self,
        tets: impl Iterator<Item = Solid<TetId>>,
        is_flat: impl Fn(TetId) -> bool,
    ) -> Amiss {
        let (is_unknown, mut thin) = (Cell::new(false), Vec::new());
        let inside = tets.filter(|own| {
            let is_inside = own.region != 0;
            let is_known = !is_inside || self.bounds().has_size_at(own.corners.each_ref());
            is_unknown.set(is_unknown.get() || !is_known && !is_flat(own.tet));
            is_inside
        });
        let is_over = self.over_among(inside, |t| thin.push(t)).any(|t| !is_flat(t));
        Amiss { is_over: is_over || is_unknown.get(), thin }
    }

    /// May a tetrahedron of a region be dust of a patch, which goes to the outer side in the end?
    /// `beyond` tells the regions beyond its faces. Where one is not known, it may be any.
    pub fn may_be_dust(
        &self,
        corners: [Corner; 4],
        region: u32,
        beyond: impl Fn(usize) -> Option<u32>,
    ) -> bool {
        let plc = self.plc();
        if !self.is_flat(|k| corners[k].carrier) {
            return false;
        }
        let [Some(a), Some(b), Some(c), Some(d)] = [0, 1, 2, 3].map(beyond) else {
            return plc.is_inner(corners.map(|own| own.carrier), region);
        };
        let beyond = [a, b, c, d];
        let facet = |slot: usize| {
            let face = FACE[slot].map(|k| corners[k]);
            self.facet(face).or_else(|| plc.patch_at(face, slot, [region, beyond[slot]]))
        };
        let facets = [0, 1, 2, 3].map(facet);
        let is_segment =
            |ends: [usize; 2]| self.segment(ends.map(|k| corners[k].carrier)).is_some();
        plc.settled(&Flat { corners, region, facets, beyond }, is_segment).is_some()
    }

    /// A tetrahedron of a region, if it has a dihedral angle below the bound.
    pub fn thin_tet(&self, corners: [Corner; 4]) -> Option<ThinTet> {
        let points = corners.map(|own| own.point);
        let is_missed = self.bounds().dihedral?.is_missed(points.each_ref());
        is_missed.then(|| {
            let of = |ends: [usize; 2]| self.segment(ends.map(|k| corners[k].carrier));
            let named = || {
                let reason = self.reason_near(corners);
                (reason != Reason::Rounding).then_some(reason)
            };
            let asked = self.angles().beyond_help(self.plc(), &corners, of, self.bounds());
            ThinTet {
                angle: TetQuality::of(sorted(points).each_ref()).least_dihedral(),
                near: asked.or_else(named),
                is_open: self.is_sliver(corners, 1),
            }
        })
    }
}

impl GivenNumbers {
    /// The number of a vertex, if the domain gives it one.
    pub fn of(&self, carrier: Carrier, at: &Point) -> Option<u32> {
        match carrier {
            Carrier::Corner(c) => Some(c),
            _ if self.points.is_empty() => None,
            _ => self.points.get(&order_key(at)).copied(),
        }
    }
}
