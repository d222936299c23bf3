//! [`Domain`]: a piecewise linear complex (PLC) as plain data, and the check of its structure.

use crate::vector::distance2;
use crate::{DomainError, Element};
use ltbw_exact::Point;
use ltbw_exact::points::MAX_POINTS;

/// A piecewise linear complex.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Domain {
    /// Vertices. Facets and segments name them by index.
    pub vertices: Vec<Point>,
    /// Points that are to be vertices of the mesh, too: inside, on facets, on segments.
    pub points: Vec<Point>,
    /// Facets.
    pub facets: Vec<Facet>,
    /// Free-standing segments, each with its marker.
    pub segments: Vec<([u32; 2], i32)>,
    /// One point in each void: what is connected to it is not meshed.
    pub holes: Vec<Point>,
    /// One point in each region that has an attribute or a volume bound of its own.
    pub regions: Vec<Region>,
}

/// A facet: polygons in one plane, together with the holes in them.
///
/// A polygon of two vertices is a segment in the facet; it may stand free inside. The polygons
/// divide the plane; the pieces that a hole point lies in, and the outside, are not of the facet.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Facet {
    /// Corners of each polygon, as indices of vertices.
    pub polygons: Vec<Vec<u32>>,
    /// One point in each hole of the facet.
    pub holes: Vec<Point>,
    /// Boundary marker.
    pub marker: i32,
}

/// A region with properties of its own.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Region {
    /// A point inside.
    pub seed: Point,
    /// The attribute of its tetrahedra.
    pub attribute: f64,
    /// The largest volume that a tetrahedron in it may have.
    pub max_volume: Option<f64>,
}

impl Facet {
    /// A facet that is one polygon.
    #[must_use]
    pub fn polygon(corners: &[u32], marker: i32) -> Self {
        Self { polygons: vec![corners.to_vec()], holes: Vec::new(), marker }
    }
}

impl Domain {
    /// A box with sides parallel to the axes. Their markers are 1 and 2 at the low and the high end
    /// of x, 3 and 4 of y, 5 and 6 of z.
    ///
    /// ```
    /// use ltbw_domain::Domain;
    /// let hole = Domain { holes: vec![[0.5; 3]], ..Domain::cuboid([0.25; 3], [0.75; 3]) };
    /// let domain = Domain::cuboid([0.0; 3], [2.0, 1.0, 1.0]).join(hole);
    /// assert_eq!((domain.vertices.len(), domain.facets.len()), (16, 12));
    /// assert_eq!(domain.bounds(), Some(([0.0; 3], [2.0, 1.0, 1.0])));
    /// ```
    #[must_use]
    pub fn cuboid(low: Point, high: Point) -> Self {
        let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] });
        let sides =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let facets = (1..).zip(&sides).map(|(marker, side)| Facet::polygon(side, marker)).collect();
        Self { vertices: (0..8).map(corner).collect(), facets, ..Self::default() }
    }

    /// This domain and `other` as one: its numbers of vertices go on where these end. Equal
    /// vertices stay two until the domain is prepared.
    #[must_use]
    pub fn join(mut self, other: Self) -> Self {
        let first = self.vertices.len() as u32;
        // Beyond the last index no vertex is named, as the check of the structure says.
        let shift = |v: &mut u32| *v = v.saturating_add(first);
        self.vertices.extend(other.vertices);
        self.points.extend(other.points);
        self.facets.extend(other.facets.into_iter().map(|mut facet| {
            facet.polygons.iter_mut().flatten().for_each(shift);
            facet
        }));
        self.segments.extend(other.segments.into_iter().map(|(mut ends, marker)| {
            ends.iter_mut().for_each(shift);
            (ends, marker)
        }));
        self.holes.extend(other.holes);
        self.regions.extend(other.regions);
        self
    }

    /// Checks what every later step relies on: there is something to mesh, all numbers are finite,
    /// every index names a vertex, every polygon has two vertices at least.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check_structure(&self) -> Result<(), DomainError> {
        if self.facets.iter().all(|f| f.polygons.is_empty()) {
            return Err(DomainError::Empty);
        }
        let count = self.vertices.len() + self.points.len();
        if count > MAX_POINTS {
            return Err(DomainError::TooManyVertices { count });
        }
        self.check_numbers()?;
        for (f, facet) in (0..).zip(&self.facets) {
            for (polygon, corners) in (0..).zip(&facet.polygons) {
                let element = Element::Polygon { facet: f, polygon };
                if corners.len() < 2 {
                    return Err(DomainError::ShortPolygon { element, corners: corners.len() });
                }
                self.check_corners(element, corners)?;
            }
        }
        for (s, (ends, _)) in (0..).zip(&self.segments) {
            self.check_corners(Element::Segment(s), ends)?;
        }
        Ok(())
    }

    /// Are all numbers finite?
    pub(crate) fn check_numbers(&self) -> Result<(), DomainError> {
        let finite = |element: Element, at: Point| {
            if at.iter().all(|c| c.is_finite()) {
                Ok(())
            } else {
                Err(DomainError::NotFinite { element, at })
            }
        };
        for (v, &p) in (0..).zip(&self.vertices) {
            finite(Element::Vertex(v), p)?;
        }
        for (n, &p) in (0..).zip(&self.points) {
            finite(Element::Point(n), p)?;
        }
        for (facet, f) in (0..).zip(&self.facets) {
            for (hole, &p) in (0..).zip(&f.holes) {
                finite(Element::FacetHole { facet, hole }, p)?;
            }
        }
        for (h, &p) in (0..).zip(&self.holes) {
            finite(Element::Hole(h), p)?;
        }
        for (r, region) in (0..).zip(&self.regions) {
            finite(Element::Region(r), region.seed)?;
            let bound = region.max_volume.unwrap_or(1.0);
            if !(region.attribute.is_finite() && bound.is_finite() && bound > 0.0) {
                let (attribute, max_volume) = (region.attribute, region.max_volume);
                return Err(DomainError::RegionValue { region: r, attribute, max_volume });
            }
        }
        Ok(())
    }

    fn check_corners(&self, element: Element, corners: &[u32]) -> Result<(), DomainError> {
        let vertices = self.vertices.len();
        match corners.iter().find(|&&v| v as usize >= vertices) {
            Some(&vertex) => Err(DomainError::Index { element, vertex, vertices }),
            None => Ok(()),
        }
    }

    /// Turns the facets of these numbers round, for example
    /// [`inward`](crate::DomainReport::inward).
    pub fn turn_round(&mut self, facets: &[u32]) {
        for &f in facets {
            if let Some(facet) = self.facets.get_mut(f as usize) {
                facet.polygons.iter_mut().for_each(|polygon| polygon.reverse());
            }
        }
    }

    /// The number of polygons of all facets.
    #[must_use]
    pub fn polygon_count(&self) -> usize {
        self.facets.iter().map(|f| f.polygons.len()).sum()
    }

    /// The least and the largest coordinates of the vertices; `None` without vertices.
    #[must_use]
    pub fn bounds(&self) -> Option<(Point, Point)> {
        let first = *self.vertices.first()?;
        Some(self.vertices.iter().fold((first, first), |(low, high), p| {
            ([0, 1, 2].map(|k| low[k].min(p[k])), [0, 1, 2].map(|k| high[k].max(p[k])))
        }))
    }

    /// The diagonal of the box of the vertices, rounded; 0 without vertices.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        let (low, high) = self.bounds().unwrap_or_default();
        distance2(&low, &high).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_domains_keep_all_that_they_had() {
        let region = Region { seed: [0.1; 3], attribute: 7.0, max_volume: Some(0.5) };
        let other = Domain {
            segments: vec![([0, 7], 9)],
            holes: vec![[0.5; 3]],
            regions: vec![region],
            ..Domain::cuboid([0.25; 3], [0.75; 3])
        };
        let joined = Domain::cuboid([0.0; 3], [1.0; 3]).join(other.clone());
        assert_eq!(joined.segments, [([8, 15], 9)]);
        assert_eq!((&joined.holes, &joined.regions), (&other.holes, &other.regions));
        assert_eq!(joined.vertices[8..], other.vertices);
        for (facet, before) in joined.facets[6..].iter().zip(&other.facets) {
            assert_eq!(facet.marker, before.marker);
            let back = facet.polygons[0].iter().map(|v| v - 8);
            assert!(back.eq(before.polygons[0].iter().copied()));
        }
        joined.check_structure().expect("a sound structure");
        // Indices that name nothing stay such.
        let facet = Facet::polygon(&[u32::MAX; 3], 0);
        let wrong = Domain { facets: vec![facet], ..Domain::default() };
        let error = joined.join(wrong).check_structure().expect_err("no such vertex");
        assert!(matches!(error, DomainError::Index { vertex: u32::MAX, .. }), "{error}");
    }

    #[test]
    fn the_sides_of_a_box_have_markers_and_face_outwards() {
        let (low, high) = ([1.0, 2.0, 3.0], [2.0, 4.0, 6.0]);
        let cuboid = Domain::cuboid(low, high);
        for facet in &cuboid.facets {
            let corners: Vec<Point> =
                facet.polygons[0].iter().map(|&v| cuboid.vertices[v as usize]).collect();
            let (axis, end) = ((facet.marker - 1) as usize / 2, (facet.marker - 1) % 2);
            let place = if end == 0 { low[axis] } else { high[axis] };
            assert!(corners.iter().all(|p| p[axis] == place), "{}", facet.marker);
            let [u, v] = [1, 2].map(|k| [0, 1, 2].map(|i| corners[k][i] - corners[0][i]));
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            let normal = u[i] * v[j] - u[j] * v[i];
            assert!((normal > 0.0) == (end == 1), "{}: {normal}", facet.marker);
        }
    }
}
