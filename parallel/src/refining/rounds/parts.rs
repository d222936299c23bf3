//! The end of rounds at which nothing is left that takes the whole mesh: each member of a team
//! keeps its part, under the numbers and in the orders of the whole.

use super::{Late, Left, RoundFigures, counted};
use crate::distributed::{Part, Shared, Side, Unnumbered, first_of_two, number};
use crate::refining::domain::{DomainMesh, Splits};
use crate::team::{Team, TeamError};
use crate::threads::WorkerStats;
use ltbw_core::cavity::OTHERS;
use ltbw_core::topology::{INFINITE, TetId, VertexId, tet_of};
use ltbw_core::{BoundaryFace, PredicateStats, TetMesh, Vertex};
use ltbw_domain::quality::LeastAngles;
use ltbw_exact::{Mode, Point};
use ltbw_formats::Piece;
use ltbw_refine::{
    Carrier, Delegated, Reason, RefineStats, RegionInfo, Start, from_smallest, in_order,
};

/// A tetrahedron of some part with a dihedral angle below the bound.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SliverThere {
    /// Its vertices by number, in order.
    pub tet: [Vertex; 4],
    /// Its smallest dihedral angle in degrees, rounded.
    pub angle: f64,
    /// Its centroid, in the coordinates of the mesh.
    pub at: Point,
    /// A small angle of the domain at one of its corners, which asks for such.
    pub near: Option<Reason>,
}

/// The figures of a whole mesh, of which nobody has all: the same at all members.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RefinedWhole {
    /// Vertices, exterior included.
    pub vertices: u64,
    /// Tetrahedra of the domain.
    pub tets: u64,
    /// Facets of the hull of the Delaunay mesh.
    pub hull_faces: u64,
    /// The regions, the exterior first.
    pub regions: Vec<RegionInfo>,
    /// The slivers that are left, in the order of their vertices: the domain asks for them.
    pub slivers: Vec<SliverThere>,
    /// Figures of the refinement.
    pub stats: RefineStats,
    /// Predicate calls of all members.
    pub predicates: PredicateStats,
    /// By worker.
    pub workers: Vec<WorkerStats>,
    /// The figures of the rounds.
    pub figures: RoundFigures,
    /// The figures of the splits, if there were no rounds.
    pub splits: Option<Splits>,
}

/// Some tetrahedra of a domain that one member has.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct PartMesh {
    /// The tetrahedra, in the order of their vertices' numbers.
    pub part: Part,
    /// Their regions, 0 for the exterior.
    pub regions: Vec<u32>,
    /// The triangles of the domain's facets that this member has, each with the facet's marker.
    pub faces: Vec<BoundaryFace>,
}

impl PartMesh {
    /// These as a piece of the mesh, regions as tags.
    pub fn into_piece(self) -> Piece {
        let Self { part: Part { numbers, points, tets, .. }, regions, faces } = self;
        let tet_tags = Some(regions.into_iter().map(i64::from).collect());
        Piece { mesh: TetMesh { points, tets, tet_tags, faces, ..TetMesh::default() }, numbers }
    }
}

/// One member's part of a refined domain all of whose bounds are met.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RefinedPart {
    /// The tetrahedra of the domain.
    pub inside: PartMesh,
    /// The vertices that tetrahedra outside of the domain alone have: a part without tetrahedra.
    pub outside: Part,
    /// All tetrahedra, if the exterior is asked for.
    pub with_exterior: Option<PartMesh>,
    /// The figures of the whole.
    pub whole: RefinedWhole,
}

/// The mesh of a member at the end of its work.
pub(in crate::refining) struct Ended<'m, 'c> {
    pub(in crate::refining) mesh: &'m DomainMesh<'c>,
    pub(in crate::refining) left: &'m Left,
    /// The start of these rounds.
    pub(in crate::refining) start: &'m Start,
}

/// The end of a team's work.
pub(in crate::refining) enum Stays {
    /// The own part.
    Part(Box<RefinedPart>),
    /// Why one member takes over.
    Not(Late),
}

/// The words of a member on its part.
#[derive(serde::Serialize, serde::Deserialize)]
struct Made {
    stats: WorkerStats,
    predicates: PredicateStats,
    tets: u64,
    hull_faces: u64,
    figures: RoundFigures,
    slivers: Vec<SliverThere>,
    before_slivers: Option<LeastAngles>,
    splits: Option<Splits>,
}

impl Ended<'_, '_> {
    /// The slivers of this part, which the domain asks for, of tetrahedra that may be some.
    fn slivers(&self, thin: &[TetId], numbers: &[Vertex], fine_step: f64) -> Vec<SliverThere> {
        if !self.mesh.complex.has_angles() {
            return Vec::new();
        }
        let tets = self.mesh.inner.tets();
        let sliver = |&t: &TetId| {
            let v = tets.vertices(t);
            let found = self.mesh.complex.thin_tet(v.map(|v| self.mesh.corner(v)))?;
            let sum = v.iter().fold([0.0; 3], |sum, &v| {
                let p = self.mesh.point(v);
                [0, 1, 2].map(|k| sum[k] + p[k])
            });
            Some(SliverThere {
                tet: in_order(v.map(|v| numbers[v.index()])),
                angle: found.angle,
                at: sum.map(|c| c / 4.0 * fine_step),
                near: found.near,
            })
        };
        thin.iter().filter_map(sliver).collect()
    }

    /// Lets all members keep their parts, if each may: `look` tells which of its tetrahedra may be
    /// slivers, or why it may not.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed, or has sent what makes no sense.
    pub(in crate::refining) fn stay(
        &self,
        team: &mut Team,
        delegated: &Delegated<'_>,
        mut own: Own<'_>,
        look: impl FnOnce() -> Result<Vec<TetId>, Late>,
    ) -> Result<Stays, TeamError> {
        if !own.ends.in_parts {
            return Ok(Stays::Not(Late::Asked));
        }
        let look = look();
        let all: Vec<Option<Late>> = team.gather_all(&look.as_ref().err().copied())?;
        match (look, all.into_iter().flatten().min()) {
            (Ok(thin), None) => own.thin = thin,
            (_, Some(why)) | (Err(why), None) => return Ok(Stays::Not(why)),
        }
        Ok(Stays::Part(Box::new(self.keep(team, delegated, own)?)))
    }

    /// Makes the part, with the others.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed, or has sent what makes no sense.
    fn keep(
        &self,
        team: &mut Team,
        delegated: &Delegated<'_>,
        own: Own<'_>,
    ) -> Result<RefinedPart, TeamError> {
        let Numbers { of, counts, given } = self.number(team)?;
        let tets = self.mesh.inner.tets();
        let mut made = |kept| self.part_mesh(team, &of, kept, own.ends.markers);
        let inside = made(Kept::Inside)?;
        let with_exterior = own.ends.with_exterior.then(|| made(Kept::All)).transpose()?;
        let outside = self.outside(&of, &inside.part);
        let made = Made {
            stats: own.stats,
            predicates: tets.predicates(),
            tets: inside.part.tets.len() as u64,
            hull_faces: tets.tets().filter(|(_, v)| v[3] == INFINITE).count() as u64,
            figures: self.left.figures,
            slivers: self.slivers(&own.thin, &of, own.ends.fine_step),
            before_slivers: self.left.before_slivers,
            splits: own.splits,
        };
        let all: Vec<Made> = team.gather_all(&made)?;
        let told: Vec<RoundFigures> = all.iter().map(|made| made.figures).collect();
        let mut figures = RoundFigures::summed(&told, own.begin);
        figures.ended += 1;
        let rounds = figures.after(&own.begin, delegated.stats());
        // The first one may have carried out some alone.
        let own = delegated.stats_with(rounds, counts);
        let before_slivers = counted(all.iter().map(|made| made.before_slivers));
        let before_slivers = own.before_slivers.or(before_slivers);
        let stats = RefineStats { before_slivers, ..own };
        let stats = team.tell_value(team.is_first().then_some(stats))?;
        let mut whole = RefinedWhole {
            vertices: counts.iter().fold(u64::from(given), |sum, own| sum.saturating_add(*own)),
            tets: 0,
            hull_faces: 0,
            regions: delegated.regions().to_vec(),
            slivers: Vec::new(),
            stats,
            predicates: PredicateStats::default(),
            workers: Vec::new(),
            figures,
            splits: None,
        };
        for made in all {
            if let Some(splits) = &made.splits {
                whole.splits.get_or_insert_default().add(splits);
            }
            whole.tets = whole.tets.saturating_add(made.tets);
            whole.hull_faces = whole.hull_faces.saturating_add(made.hull_faces);
            whole.predicates += made.predicates;
            whole.workers.push(made.stats);
            whole.slivers.extend(made.slivers);
        }
        whole.slivers.sort_by_key(|own| own.tet);
        Ok(RefinedPart { inside, outside, with_exterior, whole })
    }

    /// Numbers all vertices of this part's tetrahedra, exterior included.
    fn number(&self, team: &mut Team) -> Result<Numbers, TeamError> {
        let mesh = &self.mesh.inner;
        let mut is_used = vec![false; mesh.num_vertices() + 1];
        let finite = mesh.tets().tets().map(|(_, v)| v).filter(|v| v[3] != INFINITE);
        finite.flatten().for_each(|v| is_used[v.index()] = true);
        let given = self.mesh.complex.given_numbers();
        let mut of = vec![0; is_used.len()];
        let (mut new, mut unnumbered) = (Vec::new(), Vec::new());
        for v in (1..is_used.len()).filter(|&v| is_used[v]).map(VertexId::at) {
            let (at, carrier) = (self.mesh.point(v), self.mesh.carrier(v));
            match given.of(carrier, &at) {
                Some(number) => of[v.index()] = number,
                None => {
                    let kind = match carrier {
                        Carrier::Segment(..) => 0,
                        Carrier::Facet(_) => 1,
                        Carrier::Free | Carrier::Corner(_) => 2,
                    };
                    new.push(v);
                    unnumbered.push(Unnumbered { at, kind });
                }
            }
        }
        let found = number(team, &unnumbered, given.count)?;
        for (v, number) in new.into_iter().zip(found.numbers) {
            of[v.index()] = number;
        }
        Ok(Numbers { of, counts: found.counts, given: given.count })
    }

    /// The tetrahedra that are kept, with their regions and triangles.
    fn part_mesh(
        &self,
        team: &mut Team,
        of: &[Vertex],
        kept: Kept,
        markers: Option<&[i32]>,
    ) -> Result<PartMesh, TeamError> {
        let (part, list) = self.list(of, kept);
        let faces = self.faces(team, of, (&part, &list, kept), markers)?;
        let regions = list.iter().map(|&t| self.mesh.region(t)).collect();
        Ok(PartMesh { part, regions, faces })
    }

    /// Is a tetrahedron among those that are kept?
    fn is_kept(&self, t: TetId, kept: Kept) -> bool {
        let is_finite = self.mesh.inner.tets().vertices(t)[3] != INFINITE;
        is_finite && (kept == Kept::All || self.mesh.region(t) != 0)
    }

    /// The tetrahedra that are kept as plain lists, and their slots.
    fn list(&self, of: &[Vertex], kept: Kept) -> (Part, Vec<TetId>) {
        let mesh = self.mesh.inner.tets();
        let mode: Mode = self.start.mode;
        let all = || mesh.tets().filter(|(t, _)| self.is_kept(*t, kept));
        // First whether a vertex is used, then its place: in the order of numbers.
        let mut places = vec![0_u32; of.len()];
        all().flat_map(|(_, v)| v).for_each(|v| places[v.index()] = 1);
        let used = (1..places.len()).filter(|&v| places[v] > 0).map(VertexId::at);
        let mut used: Vec<(Vertex, VertexId)> = used.map(|v| (of[v.index()], v)).collect();
        used.sort_unstable();
        used.iter().zip(0..).for_each(|(&(_, v), place)| places[v.index()] = place);
        let ordered = |(t, v): (TetId, [VertexId; 4])| (in_order(v.map(|v| places[v.index()])), t);
        let mut tets: Vec<([u32; 4], TetId)> = all().map(ordered).collect();
        tets.sort_unstable();
        let part = Part {
            numbers: used.iter().map(|own| own.0).collect(),
            points: used.iter().map(|own| mode.from_kernel(self.mesh.point(own.1))).collect(),
            tets: tets.iter().map(|own| own.0).collect(),
            hull: Vec::new(),
        };
        (part, tets.into_iter().map(|own| own.1).collect())
    }

    /// The vertices that tetrahedra outside of the domain alone have.
    fn outside(&self, of: &[Vertex], part: &Part) -> Part {
        let (tets, mode) = (self.mesh.inner.tets(), self.start.mode);
        let finite = tets.tets().filter(|(t, v)| v[3] != INFINITE && self.mesh.region(*t) == 0);
        let numbered = finite.flat_map(|(_, v)| v).map(|v| (of[v.index()], v));
        let mut all: Vec<(Vertex, VertexId)> =
            numbered.filter(|own| part.numbers.binary_search(&own.0).is_err()).collect();
        all.sort_unstable();
        all.dedup();
        Part {
            numbers: all.iter().map(|own| own.0).collect(),
            points: all.iter().map(|own| mode.from_kernel(self.mesh.point(own.1))).collect(),
            ..Part::default()
        }
    }

    /// The triangles on facets that this part has: of two tetrahedra at one that of the lower
    /// region, but for the exterior, and of equal ones the first.
    fn faces(
        &self,
        team: &mut Team,
        of: &[Vertex],
        (part, list, kept): (&Part, &[TetId], Kept),
        markers: Option<&[i32]>,
    ) -> Result<Vec<BoundaryFace>, TeamError> {
        let (mesh, complex) = (self.mesh.inner.tets(), &self.mesh.complex);
        let marker = complex.markers(markers);
        let rank = |t: TetId| {
            let [a, b, c, d] = in_order(mesh.vertices(t).map(|v| of[v.index()]));
            // The exterior comes last.
            [self.mesh.region(t).wrapping_sub(1), a, b, c, d]
        };
        let side = |&Bound { t, corners, .. }: &Bound| {
            let mut corners = corners.map(|v| of[v.index()]);
            corners.sort_unstable();
            Side { corners, rank: rank(t) }
        };
        let sides: Vec<Side> =
            self.bound(list).filter(|face| face.is_far).map(|face| side(&face)).collect();
        let mut shared = first_of_two(team, &sides)?.into_iter();
        drop(sides);
        let place = |v: VertexId| part.numbers.partition_point(|&n| n < of[v.index()]) as u32;
        let mut faces: Vec<BoundaryFace> = Vec::new();
        for face in self.bound(list) {
            let Bound { tet, t, slot, corners, .. } = face;
            let told = if face.is_far { shared.next() } else { None };
            let (is_own, beyond) = match told {
                // Of tetrahedra that are not kept nobody tells anything.
                Some(Shared { is_own, beyond }) => {
                    (is_own, beyond.map_or(0, |r| r.wrapping_add(1)))
                }
                None => match tet_of(mesh.neighbours(t)[slot]) {
                    other if self.is_kept(other, kept) => {
                        (rank(t) < rank(other), self.mesh.region(other))
                    }
                    _ => (true, 0),
                },
            };
            if !is_own {
                continue;
            }
            let own = mesh.vertices(t).map(|v| self.mesh.corner(v));
            let labels = || Some([self.mesh.region(t), beyond]);
            let Some(item) = complex.side_of(&own, slot, labels) else { continue };
            let marker = i64::from(marker(item.of(), corners.map(|v| self.mesh.point(v))));
            let corners = from_smallest(corners.map(place));
            faces.push(BoundaryFace { corners, marker, tet });
        }
        // Slots are no function of the mesh.
        faces.chunk_by_mut(|a, b| a.tet == b.tet).for_each(|own| {
            own.sort_unstable_by_key(|face| face.corners);
        });
        Ok(faces)
    }

    /// The faces of some tetrahedra all of whose corners are on the boundary: these may be on
    /// facets.
    fn bound<'l>(&'l self, list: &'l [TetId]) -> impl Iterator<Item = Bound> + 'l {
        let mesh = self.mesh.inner.tets();
        let of_tet = move |(tet, &t): (usize, &TetId)| {
            let v = mesh.vertices(t);
            let is_bound = v.map(|v| self.mesh.is_bound(v));
            let are_bound = move |slot: &usize| OTHERS[*slot].into_iter().all(|k| is_bound[k]);
            (0..4).filter(are_bound).map(move |slot| {
                let is_far = mesh.far(tet_of(mesh.neighbours(t)[slot])).is_some();
                Bound { tet, t, slot, corners: OTHERS[slot].map(|k| v[k]), is_far }
            })
        };
        list.iter().enumerate().flat_map(of_tet)
    }
}

/// A face of a tetrahedron all of whose corners are on the boundary.
struct Bound {
    /// The place of the tetrahedron in its list.
    tet: usize,
    t: TetId,
    /// The slot that it is opposite of.
    slot: usize,
    corners: [VertexId; 3],
    /// Has another part the tetrahedron beyond?
    is_far: bool,
}

/// The numbers of a part's vertices.
struct Numbers {
    /// By vertex of the submesh.
    of: Vec<Vertex>,
    /// All new ones, on segments, on facets and inside.
    counts: [u64; 3],
    /// The number of those that the domain says.
    given: Vertex,
}

/// The tetrahedra that are made plain lists of.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kept {
    /// Tetrahedra of the domain.
    Inside,
    /// All, the exterior among them.
    All,
}

/// The way in which a refinement is to end.
#[derive(Clone, Copy)]
pub(in crate::refining) struct Ends<'p> {
    /// Each member keeps its part, if it may.
    pub(in crate::refining) in_parts: bool,
    /// A part is wanted with the exterior, too.
    pub(in crate::refining) with_exterior: bool,
    /// Markers of the domain's facets in place of their own.
    pub(in crate::refining) markers: Option<&'p [i32]>,
    pub(in crate::refining) fine_step: f64,
}

/// The things beside the mesh that a member makes its part of.
pub(in crate::refining) struct Own<'p> {
    stats: WorkerStats,
    /// The figures when these rounds began.
    begin: RoundFigures,
    ends: Ends<'p>,
    /// The tetrahedra that may be slivers.
    thin: Vec<TetId>,
    /// The figures of a worker without rounds.
    splits: Option<Splits>,
}

impl<'p> Own<'p> {
    /// The things of a member, without rounds before.
    pub(in crate::refining) fn new(stats: WorkerStats, ends: Ends<'p>) -> Self {
        Self { stats, begin: RoundFigures::default(), ends, thin: Vec::new(), splits: None }
    }

    /// These, of a worker whose rounds had these figures when they began.
    pub(super) fn after(self, begin: RoundFigures) -> Self {
        Self { begin, ..self }
    }

    /// These, of a worker that has split without rounds.
    pub(in crate::refining) fn without_rounds(self, splits: Splits) -> Self {
        Self { splits: Some(splits), ..self }
    }
}
