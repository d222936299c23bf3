//! The tetrahedra that a point would make.

use super::bounded::{Bounded, InMesh};
use crate::complex::carrier::Carrier;
use crate::mesh::facet::Change;
use crate::mesh::state::{FACE, Place};
use crate::table::{Map, triangle};
use ltbw_core::topology::{INFINITE, TetId};
use ltbw_exact::Point;

/// A tetrahedron that a point would make in a region.
pub(crate) struct Made {
    pub(crate) corners: [Point; 4],
    pub(crate) region: u32,
}

/// The tetrahedra of the domain that a point in a closure would make, with these changes of the
/// boundary.
pub(crate) fn star<'p, B: Bounded>(
    closure: &'p B,
    place: &'p Place,
    changes: &'p [Change],
) -> impl Iterator<Item = Made> + 'p {
    let relabelled: Map<_, _> = changes.iter().flat_map(|c| c.relabelled.clone()).collect();
    closure.walls().filter_map(move |(t, slot)| {
        let v = closure.vertices(t);
        let [a, b, c] = FACE[slot].map(|k| v[k]);
        let label = || relabelled.get(&triangle(a, b, c)).copied();
        let region = label().unwrap_or_else(|| closure.region(t));
        let is_made = region != 0 && ![a, b, c].contains(&INFINITE);
        is_made.then(|| {
            let corner = |k: usize| if k == slot { place.p } else { closure.at(v[k]) };
            Made { corners: [0, 1, 2, 3].map(corner), region }
        })
    })
}

impl InMesh<'_> {
    /// The star as far as it is known before the changes are, for a point that is to split
    /// tetrahedron `target`: dust that a point inside takes is inside then, too; what the point of
    /// a patch leaves on it is not told.
    pub(crate) fn likely_star<'p>(
        &'p self,
        target: TetId,
        place: &'p Place,
    ) -> impl Iterator<Item = Made> + 'p {
        let state = self.state;
        let patches = state.plc.facets_of(&place.carrier);
        let region = state.marks.region(target);
        let is_free = place.carrier == Carrier::Free;
        self.walls().filter_map(move |(t, slot)| {
            let (v, own) = (state.vertices(t), state.marks.region(t));
            if v[3] == INFINITE || own == 0 && !is_free {
                return None;
            }
            let face = FACE[slot].map(|k| v[k]);
            let on = |f: u32| face.iter().all(|&v| state.lies_on(state.carriers[v.index()], f));
            let is_dust = patches.iter().any(|&f| state.is_patch(f) && on(f));
            (!is_dust).then(|| self.made(t, slot, place, if own == 0 { region } else { own }))
        })
    }

    fn made(&self, t: TetId, slot: usize, place: &Place, region: u32) -> Made {
        let mut corners = self.state.vertices(t).map(|v| self.state.at(v));
        corners[slot] = place.p;
        Made { corners, region }
    }
}
