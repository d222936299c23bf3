//! The defects that a mesh can have, and the bounded list in which it is collected.

use crate::mesh::Point;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;

/// The levels of the check; each one presumes those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Level {
    /// Indices, repeated and duplicated things, finite coordinates.
    Structure,
    /// The faces at which tetrahedra meet, without coordinates.
    Topology,
    /// Exact orientation of every tetrahedron; no fold at a shared face.
    Orientation,
    /// Exact local in-sphere test at every interior face; convex hull.
    Delaunay,
    /// The symbolic perturbation decides every tie as the canonical mesh has it.
    Canonical,
    /// Tetrahedra meet in whole faces, edges and vertices alone: asked of finite element meshes
    /// ([`check_elements`](crate::check_elements)), where it comes before Delaunay.
    Overlap,
}

impl Level {
    /// The levels of [`check`](crate::check), in order.
    pub const ALL: [Self; 5] =
        [Self::Structure, Self::Topology, Self::Orientation, Self::Delaunay, Self::Canonical];

    /// The levels of [`check_elements`](crate::check_elements), in order.
    pub const ELEMENTS: [Self; 6] = [
        Self::Structure,
        Self::Topology,
        Self::Orientation,
        Self::Overlap,
        Self::Delaunay,
        Self::Canonical,
    ];

    /// The name used in certificates.
    pub fn name(self) -> &'static str {
        match self {
            Self::Structure => "structure",
            Self::Topology => "topology",
            Self::Orientation => "orientation",
            Self::Delaunay => "delaunay",
            Self::Canonical => "canonical",
            Self::Overlap => "overlap",
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

macro_rules! kinds {
    ($($(#[doc = $doc:literal])+ $kind:ident, $level:ident, $name:literal, $text:literal;)+) => {
        /// Kinds of defects. The documentation of each says what its `tets` and `vertices` are.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
        #[non_exhaustive]
        pub enum Kind { $($(#[doc = $doc])+ #[serde(rename = $name)] $kind,)+ }

        impl Kind {
            /// All of them, in order.
            pub(crate) const EVERY: &'static [Self] = &[$(Self::$kind),+];

            /// The level that the defect belongs to.
            pub fn level(self) -> Level {
                match self { $(Self::$kind => Level::$level,)+ }
            }

            /// The name used in certificates.
            pub fn name(self) -> &'static str {
                match self { $(Self::$kind => $name,)+ }
            }

            /// The defect in words, for people.
            pub fn text(self) -> &'static str {
                match self { $(Self::$kind => $text,)+ }
            }
        }
    };
}

kinds! {
    /// The mesh has no tetrahedra.
    Empty, Structure, "empty", "there are no tetrahedra";
    /// More tetrahedra than the checker can number (2^30 - 1) or more points than 2^32 - 1.
    TooLarge, Structure, "too_large", "the mesh is larger than this checker can number";
    /// A tetrahedron names a point that does not exist. `tets`: it; `vertices`: its four.
    IndexOutOfRange, Structure, "index_out_of_range", "it names a point that does not exist";
    /// A tetrahedron names a point twice. `tets`: it; `vertices`: its four.
    RepeatedVertex, Structure, "repeated_vertex", "it names a point twice";
    /// A used point has a coordinate that is NaN or infinite. `vertices`: the point.
    NotFinite, Structure, "not_finite", "its coordinates are not all finite";
    /// Two tetrahedra have the same four vertices. `tets`: both; `vertices`: the four.
    DuplicateTet, Structure, "duplicate_tet", "both have the same four vertices";
    /// Two used points lie at the same place. `vertices`: both.
    EqualVertices, Structure, "equal_vertices", "both are used and lie at the same place";
    /// A place that no tetrahedron uses (option `all_points`). `vertices`: the point.
    PointLeftOut, Structure, "point_left_out", "no tetrahedron uses this place";
    /// A face of three or more tetrahedra. `tets`: them; `vertices`: the face.
    FaceOverused, Topology, "face_overused", "more than two tetrahedra share this face";
    /// Two tetrahedra lie combinatorially on the same side of the face that they share, as their
    /// vertex orders have it. `tets`: both; `vertices`: the face.
    SameSide, Topology, "same_side", "their vertex orders put both on one side of this face";
    /// The adjacency list has another length than the list of tetrahedra.
    AdjacencyLength, Topology, "adjacency_length", "the adjacency list has the wrong length";
    /// The claimed neighbour across a face is not the real one. `tets`: the tetrahedron, the
    /// claimed neighbour, the real one (4294967295 for none); `vertices`: the face.
    WrongNeighbour, Topology, "wrong_neighbour", "the claimed neighbour across this face is wrong";
    /// A facet of the hull that the claimed hull lacks. `tets`: its owner; `vertices`: the facet.
    HullFacetMissing, Topology, "hull_facet_missing", "the claimed hull lacks this facet";
    /// A claimed hull facet that is none, or is claimed twice. `vertices`: the facet.
    HullFacetExtra, Topology, "hull_facet_extra", "this claimed hull facet is none";
    /// A hull edge without exactly two hull facets. `tets`: their owners; `vertices`: the edge.
    HullEdge, Topology, "hull_edge", "this hull edge has not exactly two hull facets";
    /// A set of tetrahedra that no shared face connects to the first one. `tets`: its first.
    Disconnected, Topology, "disconnected", "no chain of shared faces leads here from the first";
    /// A part of the hull surface apart from the first one. `tets`: owner of a facet of it.
    HullDisconnected, Topology, "hull_disconnected", "the hull has another, separate surface";
    /// The hull surface is no sphere: its V - E + F is not 2.
    HullEuler, Topology, "hull_euler", "the hull is no sphere: V - E + F is not 2";
    /// The mesh is no ball: its V - E + F - T is not 1.
    Euler, Topology, "euler", "the mesh is no ball: V - E + F - T is not 1";
    /// The tetrahedra around a vertex form neither a ball nor a half ball. `vertices`: it.
    VertexLink, Topology, "vertex_link", "the tetrahedra around it form no ball or half ball";
    /// A tetrahedron of volume exactly zero. `tets`: it; `vertices`: its four.
    FlatTet, Orientation, "flat_tet", "its volume is exactly zero";
    /// A negatively oriented tetrahedron. `tets`: it; `vertices`: its four.
    InvertedTet, Orientation, "inverted_tet", "it is negatively oriented";
    /// Two tetrahedra overlap: their apexes lie in space on the same side of the face that they
    /// share. `tets`: both; `vertices`: the face and the two apexes.
    FoldedFace, Orientation, "folded_face", "both lie on one side of the face that they share";
    /// The apex of one tetrahedron is inside the circumsphere of its neighbour. `tets`: both;
    /// `vertices`: the shared face (or hull edge) and the two apexes.
    NotDelaunay, Delaunay, "not_delaunay", "one's apex lies inside the other's circumsphere";
    /// The hull is concave at an edge. `tets`: the owners of both facets; `vertices`: the edge
    /// and the two other vertices.
    ConcaveHull, Delaunay, "concave_hull", "the hull is concave at this edge";
    /// A hull facet whose outer side faces the first tetrahedron: the hull does not surround it.
    /// `tets`: its owner; `vertices`: the facet.
    HullTurnedAway, Delaunay, "hull_turned_away", "a part of the mesh lies beyond this hull facet";
    /// The hull winds around the mesh more than once: a ray from the first tetrahedron leaves it
    /// through both facets. `tets`: their owners; `vertices`: the second facet.
    HullWoundTwice, Delaunay, "hull_wound_twice", "the hull is wound around the mesh twice here";
    /// Five points on one sphere, and the canonical mesh has other tetrahedra there. `tets`:
    /// both; `vertices`: the shared face and the two apexes.
    NotCanonical, Canonical, "not_canonical", "the canonical mesh resolves this tie differently";
    /// Four points of the hull on one circle, and the canonical mesh has the other diagonal.
    /// `tets`: the owners of both facets; `vertices`: the edge and the two other vertices.
    HullNotCanonical, Canonical, "hull_not_canonical", "the canonical mesh has the other diagonal";
    /// Two tetrahedra have inner points in common. `tets`: both; `vertices`: the four of the first.
    Overlap, Overlap, "overlap", "both have inner points in common";
    /// A vertex lies inside an edge or a face of a tetrahedron that does not have it. `tets`: that
    /// tetrahedron; `vertices`: the vertex, then the two of the edge or the three of the face.
    HangingVertex, Overlap, "hanging_node", "the first is inside this edge or face of a cell";
    /// Two edges meet in a point that is inside both. `tets`: one at each edge; `vertices`: the two
    /// of each.
    CrossingEdges, Overlap, "crossing_edges", "these two edges cross without a common vertex";
}

impl Kind {
    /// The kinds that a body of any shape may have, but no convex one that is tiled face to face.
    pub const SHAPE: [Self; 10] = [
        Self::EqualVertices,
        Self::HullEdge,
        Self::Disconnected,
        Self::HullDisconnected,
        Self::HullEuler,
        Self::Euler,
        Self::VertexLink,
        Self::ConcaveHull,
        Self::HullTurnedAway,
        Self::HullWoundTwice,
    ];
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One defect: its kind, its tetrahedra and vertices, its place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Defect {
    /// The kind; see [`Kind`] for the meaning of the ids.
    pub kind: Kind,
    /// Tetrahedra concerned, as indices into the checked list.
    pub tets: Vec<u32>,
    /// Points concerned, as indices into the checked list.
    pub vertices: Vec<u32>,
    /// Coordinates of `vertices`, one for one; `None` where there is no such point.
    #[serde(serialize_with = "coordinates")]
    pub at: Vec<Option<Point>>,
}

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.kind)?;
        if !self.tets.is_empty() {
            write!(f, "tets {:?}, ", self.tets)?;
        }
        for (v, at) in self.vertices.iter().zip(&self.at) {
            match at {
                Some([x, y, z]) => write!(f, "{v} at ({x:?}, {y:?}, {z:?}), ")?,
                None => write!(f, "{v}, ")?,
            }
        }
        f.write_str(self.kind.text())
    }
}

/// Finite coordinates as numbers (shortest text that reads back to the same f64), others as the
/// strings `NaN`, `inf`, `-inf`: JSON has no number for them.
fn coordinates<S: Serializer>(at: &[Option<Point>], s: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    #[serde(untagged)]
    enum Value {
        Number(f64),
        Text(String),
    }
    let value = |c: f64| match c.is_finite() {
        true => Value::Number(c),
        false => Value::Text(c.to_string()),
    };
    s.collect_seq(at.iter().map(|p| p.map(|p| p.map(value))))
}

/// A bounded list of defects with the full count of every kind. Merging partial lists in the
/// order of a sweep keeps the first defects of that sweep, so the result does not depend on how
/// the sweep was divided among threads.
#[derive(Debug, Clone)]
pub(crate) struct Findings {
    limit: usize,
    pub(crate) counts: BTreeMap<Kind, u64>,
    listed: BTreeMap<Kind, Vec<Ids>>,
}

/// The tetrahedra and the vertices of a defect.
type Ids = (Vec<u32>, Vec<u32>);

impl Findings {
    pub(crate) fn new(limit: usize) -> Self {
        Self { limit, counts: BTreeMap::new(), listed: BTreeMap::new() }
    }

    /// Records one defect.
    pub(crate) fn add(&mut self, kind: Kind, tets: &[u32], vertices: &[u32]) {
        *self.counts.entry(kind).or_default() += 1;
        let list = self.listed.entry(kind).or_default();
        if list.len() < self.limit {
            list.push((tets.to_vec(), vertices.to_vec()));
        }
    }

    /// Appends what a later part of the sweep found.
    pub(crate) fn merge(&mut self, later: Self) {
        for (kind, count) in later.counts {
            *self.counts.entry(kind).or_default() += count;
        }
        for (kind, list) in later.listed {
            let mine = self.listed.entry(kind).or_default();
            let room = self.limit.saturating_sub(mine.len());
            mine.extend(list.into_iter().take(room));
        }
    }

    /// Takes out the findings of some kinds.
    pub(crate) fn take(&mut self, is_wanted: impl Fn(Kind) -> bool) -> Self {
        let mut taken = Self::new(self.limit);
        taken.counts = self.counts.extract_if(.., |kind, _| is_wanted(*kind)).collect();
        taken.listed = self.listed.extract_if(.., |kind, _| is_wanted(*kind)).collect();
        taken
    }

    /// Number of defects of `level`, listed or not.
    pub(crate) fn count(&self, level: Level) -> u64 {
        self.counts.iter().filter(|(k, _)| k.level() == level).map(|(_, n)| n).sum()
    }

    /// The listed defects with their coordinates, by kind.
    pub(crate) fn defects(&self, points: &[Point]) -> Vec<Defect> {
        let at = |v: &u32| points.get(*v as usize).copied();
        let all = self.listed.iter().flat_map(|(&kind, list)| list.iter().map(move |d| (kind, d)));
        all.map(|(kind, (tets, vertices))| Defect {
            kind,
            tets: tets.clone(),
            vertices: vertices.clone(),
            at: vertices.iter().map(at).collect(),
        })
        .collect()
    }
}
