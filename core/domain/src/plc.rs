//! [`Domain`]: a piecewise linear complex (PLC) as plain data, and the check of its structure.

use crate::{DomainError, Element};
use ltbw_exact::Point;
use ltbw_exact::points::MAX_POINTS;

/// A piecewise linear complex.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Domain {
    /// Vertices. Facets and segments name them by index.
    pub vertices: Vec<Point>,
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
    /// Checks what every later step relies on: there is something to mesh, all numbers are finite,
    /// every index names a vertex, every polygon has two vertices at least.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check_structure(&self) -> Result<(), DomainError> {
        if self.facets.iter().all(|f| f.polygons.is_empty()) {
            return Err(DomainError::Empty);
        }
        if self.vertices.len() > MAX_POINTS {
            return Err(DomainError::TooManyVertices { count: self.vertices.len() });
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
}
