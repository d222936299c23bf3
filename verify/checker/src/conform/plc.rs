//! Domains as the checker takes them.

use crate::mesh::Point;

/// A facet of a domain: polygons in one plane, and points in its holes.
#[derive(Debug, Clone, Default)]
pub struct PlcFacet {
    /// Corners of each polygon; polygons may be nested but must not cross. Two corners: a segment.
    pub polygons: Vec<Vec<u32>>,
    /// A point in each hole.
    pub holes: Vec<Point>,
    /// Facets of different markers are in different patches.
    pub marker: i32,
}

/// A domain (a piecewise linear complex) in the coordinates of the mesh.
#[derive(Debug, Clone, Default)]
pub struct Plc {
    /// Its vertices.
    pub vertices: Vec<Point>,
    /// Its facets.
    pub facets: Vec<PlcFacet>,
    /// Segments that stand free.
    pub segments: Vec<[u32; 2]>,
    /// A point in each hole.
    pub holes: Vec<Point>,
    /// A point in each region.
    pub regions: Vec<Point>,
    /// The distance within which facets may be taken for coplanar (`flat`); 0: not at all.
    pub flat_tolerance: f64,
}
