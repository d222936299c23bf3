//! The changes of a repair in words.

use super::Repairs;

impl Repairs {
    /// The changes, a line for each kind.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let count =
            |n: usize, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
        let first = |facets: &[u32]| {
            facets.first().map_or(String::new(), |f| format!(" (first: facet {f})"))
        };
        let mut notes = Vec::new();
        if self.welded > 0 {
            let vertices = count(self.welded, "vertex was", "vertices were");
            let by = self.welded_by_tolerance;
            let by =
                if by > 0 { format!(", {by} of them by the tolerance") } else { String::new() };
            notes.push(format!(
                "{vertices} welded to others, the farthest over {:.3e}{by}",
                self.farthest_weld
            ));
        }
        if !self.degenerate.is_empty() {
            let facets = count(self.degenerate.len(), "facet", "facets");
            notes.push(format!("{facets} without area dropped{}", first(&self.degenerate)));
        }
        if self.spliced > 0 {
            let vertices = count(self.spliced, "vertex", "vertices");
            notes.push(format!("{vertices} of dropped facets put into the edges that they are on"));
        }
        if !self.doubled.is_empty() {
            let facets = count(self.doubled.len(), "facet", "facets");
            notes.push(format!("{facets} given before dropped{}", first(&self.doubled)));
        }
        if !self.inner.is_empty() {
            let facets = count(self.inner.len(), "facet", "facets");
            notes.push(format!(
                "{facets} given once from either side: one inner facet each{}",
                first(&self.inner)
            ));
        }
        if self.seams > 0 {
            let vertices = count(self.seams, "vertex", "vertices");
            notes.push(format!("{vertices} put into open edges near them: seams closed"));
        }
        if let Some(most) = self.filled.iter().max() {
            let holes = match self.filled.len() {
                1 => format!("1 hole of {most} edges"),
                n => format!("{n} holes of up to {most} edges"),
            };
            let triangles = count(self.filling, "triangle", "triangles");
            notes.push(format!("{holes} closed by {triangles}"));
        }
        notes.extend(self.left_out());
        notes
    }

    /// A line for each kind of what was left out.
    fn left_out(&self) -> Vec<String> {
        let facets = |facets: &[u32], why: &str| {
            let first = facets.first()?;
            let s = if facets.len() == 1 { "" } else { "s" };
            Some(format!("{} facet{s} left out: {why} (first: facet {first})", facets.len()))
        };
        let others = |count: usize, one: &str, why: &str| {
            let name = match one {
                _ if count == 1 => one.to_owned(),
                "vertex" => "vertices".to_owned(),
                one => format!("{one}s"),
            };
            (count > 0).then(|| format!("{count} {name} left out: {why}"))
        };
        let around = "nothing but exterior around";
        let unused = "outside, and of nothing that is kept";
        let notes = [
            facets(&self.flaps, "given from either side, and nothing between"),
            facets(&self.ends, "ends in the exterior"),
            facets(&self.exterior, around),
            others(self.exterior_segments, "segment", around),
            others(self.exterior_vertices, "vertex", unused),
            others(self.exterior_points, "point", "outside"),
            others(self.exterior_holes, "hole point", "outside without these"),
        ];
        notes.into_iter().flatten().collect()
    }
}
