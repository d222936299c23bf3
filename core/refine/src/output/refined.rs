//! A refined domain, and its plain arrays: tetrahedra with their regions, boundary triangles with
//! the markers of their facets.

use crate::complex::parts::Markers;
use crate::mesh::item::Item;
use crate::mesh::marks::face_bit;
use crate::mesh::number::{from_smallest, in_order};
use crate::mesh::region::RegionInfo;
use crate::mesh::state::State;
use crate::outcome::{Excuse, Reason, RefineOutcome, RefineStats, Sliver};
use crate::rounds::RoundTimes;
use crate::table::triangle;
use ltbw_core::cavity::OTHERS;
use ltbw_core::mesh::{Mesh, Vertex};
use ltbw_core::tetmesh::{BoundaryFace, TetMesh};
use ltbw_core::topology::{TetId, VertexId, tet_of};
use ltbw_domain::Lattice;
use ltbw_exact::Point;
use rayon::prelude::*;

/// Tetrahedra that one thread copies at a time, at least.
const SHARE: usize = if cfg!(test) { 5 } else { 4096 };

/// A refined domain.
#[derive(Debug)]
pub struct Refined {
    /// Its outcome.
    pub outcome: RefineOutcome,
    /// The tetrahedra over a bound; not looked for if the outcome is [`RefineOutcome::Cancelled`].
    pub excuses: Vec<Excuse>,
    /// The slivers that are left: tetrahedra of the domain with a dihedral angle below
    /// [`Refiner::min_dihedral`](crate::Refiner::min_dihedral) that no point divides without
    /// leaving another one; not looked for if the outcome is [`RefineOutcome::Cancelled`].
    pub slivers: Vec<Sliver>,
    /// Boundary items that are not in the mesh, each with the reason why it could not be split;
    /// none unless the outcome is [`RefineOutcome::Unrecovered`].
    pub lost: Vec<(Item, Reason)>,
    /// The regions, the exterior first.
    pub regions: Vec<RegionInfo>,
    /// Figures.
    pub stats: RefineStats,
    /// The rounds on the clock, if there were any.
    #[doc(hidden)]
    pub rounds: Vec<RoundTimes>,
    /// The lattice of all points.
    pub lattice: Lattice,
    /// Markers of the domain's facets in place of their own.
    pub(crate) markers: Option<Vec<i32>>,
    pub(crate) state: State,
    /// The finite tetrahedra, exterior included, in the order of their vertices' numbers.
    pub(crate) order: Vec<TetId>,
}

/// The attributes of regions, as [`Refined::attributes`] has them.
#[doc(hidden)]
pub fn attributes_of(regions: &[RegionInfo]) -> Option<Vec<f64>> {
    let attribute = |(region, info): (u32, &RegionInfo)| {
        if info.attribute == 0.0 { f64::from(region) } else { info.attribute }
    };
    let all: Vec<f64> = (0..).zip(regions).map(attribute).collect();
    let is_own = (0..).zip(&all).all(|(region, &value)| value == f64::from(region));
    (!is_own).then_some(all)
}

impl Refined {
    /// The Delaunay mesh, exterior included: input vertices keep their indices, the domain's points
    /// follow in their order, then new ones along a Hilbert curve.
    pub fn mesh(&self) -> &Mesh {
        &self.state.mesh
    }

    /// The region of a tetrahedron: an index into [`Refined::regions`], 0 for the exterior.
    pub fn region(&self, t: TetId) -> u32 {
        self.state.marks.region(t)
    }

    /// The attributes of all regions, for their tetrahedra: that which the domain gives a region,
    /// else the region's own number, so that 0 is the exterior alone (files have 0 for no
    /// attribute). `None` where these are the numbers of the regions: they tell nothing more.
    pub fn attributes(&self) -> Option<Vec<f64>> {
        attributes_of(&self.regions)
    }

    /// Gives the boundary triangles markers in place of those of the domain's facets: one for each
    /// facet of the domain that was refined, such as [`Parts::markers`](ltbw_domain::Parts). The
    /// mesh stays what it is; the triangles of facets that are coplanar within the tolerance have
    /// the marker of the largest of these.
    #[must_use]
    pub fn with_markers(mut self, markers: Vec<i32>) -> Self {
        self.markers = Some(markers);
        self
    }

    /// The tetrahedra of the domain, by their vertices' numbers: an order that is a function of the
    /// mesh alone, as those of all arrays are.
    pub fn tets(&self) -> impl Iterator<Item = TetId> + '_ {
        self.order.iter().copied().filter(|&t| self.region(t) != 0)
    }

    /// The tetrahedra of [`Refined::inside`], in their order; with the exterior those of
    /// [`Refined::with_exterior`].
    #[doc(hidden)]
    pub fn listed(&self, exterior: bool) -> Vec<TetId> {
        let kept = |t: &TetId| exterior || self.region(*t) != 0;
        self.order.iter().copied().filter(kept).collect()
    }

    /// The vertices of a tetrahedron, positively oriented: the smallest number, then the next; as
    /// [`Refined::inside`] has them. `None` if `t` is not one.
    pub fn tet(&self, t: TetId) -> Option<[Vertex; 4]> {
        self.state.mesh.tet(t).map(in_order)
    }

    /// Number of tetrahedra of the domain.
    pub fn num_tets(&self) -> usize {
        self.tets().count()
    }

    /// The middle of an item in the coordinates of the domain: for messages.
    pub fn middle(&self, item: &Item) -> Point {
        let middle = |corners: &[VertexId]| {
            let all = corners.iter().map(|&v| self.state.at(v));
            let sum = all.fold([0.0; 3], |sum, p| [0, 1, 2].map(|k| sum[k] + p[k]));
            sum.map(|c| c / corners.len() as f64 * self.lattice.fine_step())
        };
        match item {
            Item::Segment(s) => middle(s),
            Item::Subface(s) => middle(s),
            Item::Tet(_, v) => middle(v),
        }
    }

    /// Bytes held by the large arrays.
    pub fn memory_bytes(&self) -> usize {
        self.state.memory_bytes()
    }
}

impl Refined {
    /// The mesh of the domain as plain arrays: tetrahedra tagged with their regions and, where the
    /// domain gives some, with the attributes of these, and the boundary faces of
    /// [`Refined::boundary`].
    pub fn inside(&self) -> TetMesh {
        self.plain(false)
    }

    /// The mesh with all tetrahedra, those of the exterior tagged with 0; its faces are those of
    /// the domain's facets that stand free in the exterior, too.
    pub fn with_exterior(&self) -> TetMesh {
        self.plain(true)
    }

    fn plain(&self, exterior: bool) -> TetMesh {
        let kept = self.listed(exterior);
        let (numbers, topology) = (self.state.mesh.numbers(), self.state.mesh.topology());
        let corners = |t| in_order(topology.at(t).vertices().map(|v| numbers[v.index()]));
        let all = kept.par_iter().with_min_len(SHARE);
        let mut mesh = TetMesh { points: self.state.mesh.points(), ..TetMesh::default() };
        let tags: Vec<i64>;
        (mesh.tets, tags) = all.map(|&t| (corners(t), i64::from(self.region(t)))).unzip();
        mesh.tet_attributes = self.attributes().and_then(|of| {
            tags.iter().map(|&region| of.get(usize::try_from(region).ok()?).copied()).collect()
        });
        mesh.tet_tags = Some(tags);
        mesh.faces = self.faces(exterior);
        mesh
    }

    /// The triangles that the mesh has of the domain's facets, with the facets' markers; each
    /// belongs to a tetrahedron of [`Refined::inside`], and points out of it. A triangle between
    /// two regions belongs to one of them; one that stands free in the exterior is left out.
    pub fn boundary(&self) -> Vec<BoundaryFace> {
        self.faces(false)
    }

    fn faces(&self, exterior: bool) -> Vec<BoundaryFace> {
        let (state, topology) = (&self.state, self.state.mesh.topology());
        let markers = Markers::new(&state.plc, self.markers.as_deref());
        let mut faces = Vec::new();
        let mut place = 0;
        let kept = |t| exterior || self.region(t) != 0;
        for t in self.order.iter().copied().filter(|&t| kept(t)) {
            let (word, tet, first) = (state.marks.of(t), topology.at(t), faces.len());
            for slot in (0..4).filter(|&slot| word & face_bit(slot) != 0) {
                let other = tet_of(tet.neighbours()[slot]);
                // Of two tetrahedra at a triangle, that of the lower region has it, but for the
                // exterior; of equal ones the first.
                let rank = |t| (self.region(t) == 0, self.region(t), self.tet(t));
                let shared = kept(other) && !topology.at(other).is_ghost();
                if shared && rank(other) < rank(t) {
                    continue;
                }
                let corners = OTHERS[slot].map(|k| tet.vertices()[k]);
                let [a, b, c] = corners;
                let facet = state.subfaces.get(&triangle(a, b, c));
                let marker = facet.map_or(0, |&f| markers.of(f, corners.map(|v| state.at(v))));
                let corners = from_smallest(corners.map(|v| state.mesh.numbers()[v.index()]));
                faces.push(BoundaryFace { corners, marker: i64::from(marker), tet: place });
            }
            // Slots are no function of the mesh.
            faces[first..].sort_unstable_by_key(|face: &BoundaryFace| face.corners);
            place += 1;
        }
        faces
    }

    /// The subfaces that the mesh has: corners as vertex numbers, ascending.
    pub fn subfaces(&self) -> Vec<[Vertex; 3]> {
        let state = &self.state;
        let present = state.subfaces.keys().filter(|s| !state.missing.contains(*s));
        let number = |v: &VertexId| state.mesh.numbers()[v.index()];
        let mut all: Vec<[Vertex; 3]> = present
            .map(|s| {
                let mut corners = [number(&s[0]), number(&s[1]), number(&s[2])];
                corners.sort_unstable();
                corners
            })
            .collect();
        all.sort_unstable();
        all
    }
}
