//! Surfaces: what `.off`, `.obj`, `.stl` and `.ply` have in common as domains.
//!
//! A face of three corners or more is a facet of one polygon; one of two corners is a free-standing
//! segment. A facet that is more than a polygon is written as its triangles.

use super::DomainFile;
use super::error::{DataError, Reason, excerpt};
use super::groups::Groups;
use super::text::integer;
use ltbw_domain::{Domain, Facet, triangulate};
use ltbw_exact::Point;
use std::borrow::Cow;

/// The corners of a face on their way into a surface.
pub(super) struct Corners(Vec<u32>);

impl From<&[u32]> for Corners {
    fn from(corners: &[u32]) -> Self {
        Self(corners.to_vec())
    }
}

impl Corners {
    pub(super) fn new(capacity: usize) -> Self {
        Self(Vec::with_capacity(capacity))
    }

    /// Adds the corner that `token` names, counted from `first`, of a face of this number.
    pub(super) fn push(
        &mut self,
        token: &[u8],
        first: i64,
        points: usize,
        face: u64,
    ) -> Result<(), Reason> {
        let index = integer(token).map_err(|_| Reason::NotAnInteger(excerpt(token)))?;
        let last = first + points as i64 - 1;
        if index < first || index > last {
            return Err(Reason::Index { what: "face", number: face, index, first, last });
        }
        self.add((index - first) as usize);
        Ok(())
    }

    /// Adds a corner that is known to be a vertex.
    pub(super) fn add(&mut self, vertex: usize) {
        self.0.push(vertex as u32);
    }
}

/// A surface that is being read.
pub(super) struct Surface(Domain);

/// A surface that has been read, and the groups of its faces.
pub(super) struct Grouped {
    surface: Surface,
    groups: Groups,
}

impl Grouped {
    /// The file of it, the groups being markers.
    pub(super) fn finish(self, mut notes: Vec<String>) -> DomainFile {
        let Self { surface: Surface(mut domain), groups } = self;
        let names = groups.mark(&mut domain, &mut notes);
        DomainFile { domain, oriented: true, names, notes }
    }
}

impl Surface {
    pub(super) fn new(vertices: Vec<Point>) -> Self {
        Self(Domain { vertices, ..Domain::default() })
    }

    pub(super) fn reserve(&mut self, faces: usize) {
        self.0.facets.reserve(faces);
    }

    /// The number of faces so far that bound something.
    pub(super) fn faces(&self) -> usize {
        self.0.facets.len()
    }

    /// The surface with groups of its faces.
    pub(super) fn grouped(self, groups: Groups) -> Grouped {
        Grouped { surface: self, groups }
    }

    /// The number of vertices.
    pub(super) fn points(&self) -> usize {
        self.0.vertices.len()
    }

    pub(super) fn face(&mut self, corners: Corners) -> Result<(), Reason> {
        self.marked_face(corners, 0)
    }

    pub(super) fn marked_face(&mut self, corners: Corners, marker: i32) -> Result<(), Reason> {
        match corners.0.as_slice() {
            [] | [_] => Err(Reason::Syntax(format!("a face of {} corners", corners.0.len()))),
            &[a, b] => {
                self.0.segments.push(([a, b], marker));
                Ok(())
            }
            _ => {
                let polygons = vec![corners.0];
                self.0.facets.push(Facet { polygons, holes: Vec::new(), marker });
                Ok(())
            }
        }
    }

    /// Adds the triangles of a strip: each has a corner more than the last two of the one before,
    /// and all are turned as the first is.
    pub(super) fn strip(&mut self, corners: &[u32], marker: i32) {
        for (k, &[a, b, c]) in corners.array_windows().enumerate() {
            self.triangle(if k % 2 == 0 { [a, b, c] } else { [b, a, c] }, marker);
        }
    }

    /// Adds the triangles of a fan, which have its first corner in common.
    pub(super) fn fan(&mut self, corners: &[u32], marker: i32) {
        let Some((&hub, rim)) = corners.split_first() else { return };
        rim.array_windows().for_each(|&[b, c]| self.triangle([hub, b, c], marker));
    }

    /// Adds a triangle of a strip or fan; one that names a vertex twice is only there to turn a
    /// strip, or to lead it on.
    fn triangle(&mut self, [a, b, c]: [u32; 3], marker: i32) {
        if a != b && b != c && c != a {
            self.0.facets.push(Facet::polygon(&[a, b, c], marker));
        }
    }

    pub(super) fn finish(self, notes: Vec<String>) -> DomainFile {
        DomainFile { domain: self.0, oriented: true, notes, ..DomainFile::default() }
    }
}

/// A face of a surface.
#[derive(Clone, Copy)]
pub(super) struct Face<'a> {
    pub(super) corners: &'a [u32],
    pub(super) marker: i32,
}

/// The content of a surface file to be written: the polygons of a domain, or else their triangles.
pub(super) struct Faces<'a> {
    points: &'a [Point],
    /// Corners and marker of each face.
    faces: Vec<(Cow<'a, [u32]>, i32)>,
}

impl<'a> Faces<'a> {
    /// The faces of a domain, in triangles if there must be no other polygons.
    pub(super) fn of(domain: &'a Domain, triangles_only: bool) -> Result<Self, DataError> {
        let mut faces = Vec::with_capacity(domain.facets.len());
        for (number, facet) in (0..).zip(&domain.facets) {
            if let ([polygon], []) = (facet.polygons.as_slice(), facet.holes.as_slice())
                && (polygon.len() == 3 || polygon.len() > 3 && !triangles_only)
            {
                faces.push((Cow::Borrowed(polygon.as_slice()), facet.marker));
                continue;
            }
            let found = triangulate::facet(&domain.vertices, facet);
            if !found.is_sound() {
                return Err(DataError::Facet { facet: number });
            }
            let triangles = found.triangles.iter();
            faces.extend(triangles.map(|t| (Cow::Owned(t.to_vec()), facet.marker)));
        }
        Ok(Self { points: &domain.vertices, faces })
    }

    /// The vertices.
    pub(super) fn points(&self) -> &'a [Point] {
        self.points
    }

    /// The faces.
    pub(super) fn iter(&self) -> impl Iterator<Item = Face<'_>> {
        self.faces.iter().map(|(corners, marker)| Face { corners, marker: *marker })
    }
}
