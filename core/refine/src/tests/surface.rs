//! Surfaces by formula, for tests.

/// A surface by formula, of single polygons; its type is that of another instance of this crate.
macro_rules! surface {
    ($made:expr) => {{
        let made = $made;
        let polygons = made.facets.iter().flat_map(|f| &f.polygons);
        let facets = polygons.map(|polygon| Facet::polygon(polygon, 0)).collect();
        let domain = Domain { vertices: made.vertices, facets, ..Domain::default() };
        domain.prepare(&PrepareOptions::default()).expect("a sound domain")
    }};
}
