//! The carriers of a submesh's vertices.

use crate::mesh::probe::TETS_PER_VERTEX;
use crate::refining::flags::Flags;
use ltbw_core::expect;
use ltbw_core::topology::VertexId;
use ltbw_refine::Carrier;

/// The carriers by vertex number.
#[derive(Debug)]
pub(super) struct Carriers {
    all: Vec<Carrier>,
    /// The vertices on the boundary.
    bound: Flags,
}

impl Carriers {
    /// The carriers of the vertices from number 1 on; the vertex at infinity is free.
    pub(super) fn of(all: impl Iterator<Item = Carrier>) -> Self {
        let mut own = Self { all: vec![Carrier::Free], bound: Flags::default() };
        (1..).zip(all).for_each(|(v, carrier)| own.set(VertexId::at(v), carrier));
        own
    }

    /// Takes memory for about this many tetrahedra. A hint.
    pub(super) fn expect_tets(&mut self, tets: usize) {
        expect(&mut self.all, tets / TETS_PER_VERTEX);
    }

    /// The carrier of a vertex: free if none was entered.
    pub(super) fn at(&self, v: VertexId) -> Carrier {
        self.all.get(v.index()).copied().unwrap_or(Carrier::Free)
    }

    /// Is a vertex on the boundary?
    pub(super) fn is_bound(&self, v: VertexId) -> bool {
        self.bound.has(v.index())
    }

    /// Enters the carrier of a vertex.
    pub(super) fn set(&mut self, v: VertexId, carrier: Carrier) {
        if self.all.len() <= v.index() {
            self.all.resize(v.index() + 1, Carrier::Free);
        }
        self.all[v.index()] = carrier;
        self.bound.set(v.index(), carrier != Carrier::Free);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_is_bound_where_its_carrier_is_not_free() {
        let mut own = Carriers::of([Carrier::Corner(3), Carrier::Free].into_iter());
        let v = VertexId::new;
        assert_eq!([0, 1, 2, 200].map(|k| own.is_bound(v(k))), [false, true, false, false]);
        own.set(v(130), Carrier::Facet(1));
        own.set(v(1), Carrier::Free);
        assert_eq!(
            [1, 2, 129, 130, 131].map(|k| own.is_bound(v(k))),
            [false, false, false, true, false]
        );
        assert_eq!(
            [1, 130, 131].map(|k| own.at(v(k))),
            [Carrier::Free, Carrier::Facet(1), Carrier::Free]
        );
    }
}
