//! The parts of a domain's boundary: the smooth parts of a surface without markers, or what its
//! file names. They are told, and names go to the files that have a place for them.

use crate::console;
use crate::streams::Source;
use ltbw::Point;
use ltbw::domain::{FEATURE_ANGLE, LARGEST_FEATURE_ANGLE, Part, Parts, Prepared};
use ltbw::io::{DomainFile, GroupName};
use ltbw::refine::{Given, Refined};
use serde_json::{Value, json};
use std::borrow::Cow;

/// Parts that people are shown.
const SHOWN: usize = 9;

/// Parts that the report lists.
const LISTED: usize = 1000;

/// Options of `mesh` that say what the parts of a surface are.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct Parting {
    /// Parts that are smooth within A degrees get markers; 0: none
    ///
    /// Markers are 1, 2, ... by area; the mesh does not depend on them. Default: 40 for surfaces.
    /// Markers, solids, groups, materials or colours of a file are its parts instead.
    #[arg(long, value_name = "A", value_parser = feature_angle, allow_negative_numbers = true)]
    pub(crate) feature_angle: Option<f64>,
}

/// An angle between facets that go on into each other.
fn feature_angle(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    let good = (0.0..=LARGEST_FEATURE_ANGLE).contains(&value);
    good.then_some(value)
        .ok_or_else(|| format!("an angle of 0 to {LARGEST_FEATURE_ANGLE} degrees is asked for"))
}

/// The names that a file has for its parts, and whether it is a surface.
pub(crate) struct Told {
    is_surface: bool,
    names: Vec<GroupName>,
}

impl Told {
    /// The names of a mesh that is gone on with.
    pub(crate) fn named(names: Vec<GroupName>) -> Self {
        Self { is_surface: false, names }
    }

    /// Takes the names from a file.
    pub(crate) fn of(file: &mut DomainFile) -> Self {
        Self { is_surface: file.oriented, names: std::mem::take(&mut file.names) }
    }
}

/// The parts of the boundary of a domain that is meshed.
#[derive(Default)]
pub(crate) struct Boundary {
    parts: Parts,
    /// They are smooth parts, not what the file has: their markers are not those of the domain.
    are_smooth: bool,
    pub(crate) names: Vec<GroupName>,
}

impl Parting {
    /// The parts of a domain that is ready, and their names.
    pub(crate) fn boundary(
        &self,
        ready: &Prepared,
        flat_tolerance: f64,
        told: Told,
        source: &Source,
    ) -> Boundary {
        let Told { is_surface, mut names } = told;
        let file = DomainFile { oriented: is_surface, ..DomainFile::default() };
        if let Some(parts) = file.smooth_parts(ready, self.feature_angle, flat_tolerance) {
            let named = |part: &Part| GroupName {
                dimension: 2,
                group: i64::from(part.marker),
                name: format!("part {}", part.marker),
            };
            names.extend(parts.list.iter().map(named));
            return Boundary { parts, are_smooth: true, names };
        }
        if self.feature_angle.is_some_and(|angle| angle > 0.0) {
            let text = "its facets have markers or groups, which are its parts";
            console::people(&format!("note: {}: --feature-angle: {text}", source.show()));
        }
        let is_named = names.iter().any(|name| name.dimension == 2);
        let parts = if is_named { Parts::marked(ready) } else { Parts::default() };
        Boundary { parts, are_smooth: false, names }
    }
}

impl Boundary {
    /// The mesh with the markers of the parts, which are told.
    pub(crate) fn mark(&self, refined: Refined) -> Refined {
        self.tell();
        match self.are_smooth {
            true => refined.with_markers(self.parts.markers.clone()),
            false => refined,
        }
    }

    /// The markers of the domain's facets in place of their own, if there are some.
    #[cfg(feature = "wire")]
    pub(crate) fn markers(&self) -> Option<&[i32]> {
        self.are_smooth.then_some(&self.parts.markers[..])
    }

    /// The marker that a word means: a name of a part, or the marker itself.
    pub(crate) fn marker(&self, word: &str) -> Option<i32> {
        let own = |n: &&GroupName| n.dimension == 2 && n.name == word;
        let named = self.names.iter().find(own).and_then(|n| i32::try_from(n.group).ok());
        named.or_else(|| word.trim().parse().ok())
    }

    /// The smooth parts, also of a domain with markers.
    pub(crate) fn smooth(&self, ready: &Prepared) -> Cow<'_, Parts> {
        match self.are_smooth {
            true => Cow::Borrowed(&self.parts),
            false => Cow::Owned(Parts::smooth(ready, FEATURE_ANGLE, 0.0)),
        }
    }

    /// The marker of a facet of the domain.
    pub(crate) fn marker_of(&self, ready: &Prepared, facet: usize) -> i32 {
        let own = || ready.domain.facets.get(facet).map_or(0, |own| own.marker);
        let smooth = self.parts.markers.get(facet).copied().filter(|_| self.are_smooth);
        smooth.unwrap_or_else(own)
    }

    fn name(&self, marker: i32) -> Option<&str> {
        let own = |n: &&GroupName| n.dimension == 2 && n.group == i64::from(marker);
        self.names.iter().find(own).map(|n| n.name.as_str())
    }

    /// Tells the parts, a line each.
    pub(crate) fn tell(&self) {
        let list = &self.parts.list;
        for part in list.iter().take(SHOWN) {
            let name = self.name(part.marker).filter(|_| !self.are_smooth);
            let name = name.map(|name| format!("\"{name}\": ")).unwrap_or_default();
            let normal =
                part.normal.map_or("round".to_owned(), |n| format!("normal {}", place(&n)));
            console::people(&format!(
                "part {:<5}{name}area {}, {} to {}, {normal}, {} facets",
                part.marker,
                short(part.area),
                place(&part.low),
                place(&part.high),
                part.facets
            ));
        }
        if list.len() > SHOWN {
            console::people(&format!("          and {} more parts", list.len() - SHOWN));
        }
    }

    /// The parts for the JSON report.
    pub(crate) fn json(&self) -> Value {
        let part = |part: &Part| {
            json!({
                "marker": part.marker,
                "name": self.name(part.marker),
                "facets": part.facets,
                "area": part.area,
                "low": part.low,
                "high": part.high,
                "normal": part.normal,
            })
        };
        self.parts.list.iter().take(LISTED).map(part).collect()
    }
}

/// A number for people.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    let plain = text.trim_end_matches('0').trim_end_matches('.');
    let is_plain = value == 0.0 || (1e-2..1e6).contains(&value.abs());
    if is_plain { plain.to_owned() } else { format!("{value:.3e}") }
}

/// A place or direction for people.
fn place(p: &Point) -> String {
    let [x, y, z] = p.map(short);
    format!("({x} {y} {z})")
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_are_short() {
        let all = [0.0, -0.5, 12.0, 1_234.567_89, 1e-9, -2e7].map(short);
        assert_eq!(all, ["0", "-0.5", "12", "1234.5679", "1.000e-9", "-2.000e7"]);
    }
}
