//! Cells of higher order, of which the corners alone are read: the mesh has straight edges.

/// The numbers of such cells in a file.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
pub(crate) struct Curved {
    pub(crate) tets: usize,
    pub(crate) triangles: usize,
}

impl Curved {
    /// A note on them, if there are any.
    pub(crate) fn note(self) -> Option<String> {
        let counts = [(self.tets, "tetrahedra"), (self.triangles, "triangles")];
        let counts = counts.into_iter().filter(|&(count, _)| count > 0);
        let counts: Vec<String> = counts.map(|(count, what)| format!("{count} {what}")).collect();
        (!counts.is_empty())
            .then(|| format!("of {} of higher order the corners alone are read", counts.join(", ")))
    }
}
