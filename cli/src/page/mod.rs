//! Pages to look at: one file of HTML that needs nothing beside it and asks no network.

mod scene;
mod timeline;

use crate::picture::axes::number;
use crate::picture::histograms;
use crate::report::{Measured, Report};
use scene::Encoded;
pub(crate) use scene::Scene;
pub(crate) use timeline::timeline;

/// A page in the making.
pub(crate) struct Page {
    name: String,
    sections: String,
}

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("view.css");
const VIEW: &str = include_str!("view.html");
const VIEW_SCRIPT: &str = concat!(include_str!("measures.js"), include_str!("view.js"));

impl Page {
    /// A page about the domain, the points or the run of this name.
    pub(crate) fn new(name: &str) -> Self {
        Self { name: escape(name), sections: String::new() }
    }

    /// A view of a mesh, to be turned and cut.
    pub(crate) fn view(mut self, scene: &Scene<'_>) -> Self {
        let Encoded { head, data } = scene.encode();
        let places = [("head", &*head), ("data", &data), ("script", VIEW_SCRIPT)];
        self.sections += &filled(VIEW, &places.map(Filling::from));
        self
    }

    /// A table of facts.
    pub(crate) fn facts(mut self, rows: &[Fact<'_>]) -> Self {
        let row = |Fact { name, value }: &Fact<'_>| {
            format!("<tr><td>{name}</td><td>{}</td></tr>\n", escape(value))
        };
        let rows: String = rows.iter().map(row).collect();
        self.sections += &format!("<table class=\"facts\">\n{rows}</table>\n");
        self
    }

    /// The figures of a mesh that one asks for first, and the histograms of its quality.
    pub(crate) fn mesh(self, report: &Report, verdict: &str, measured: &Measured) -> Self {
        let Measured { quality, slivers } = measured;
        let (angle, ratio) = (&quality.dihedral, &quality.radius_edge);
        let degrees = [angle.least.value, angle.largest.value].map(number);
        let below = slivers.text(&quality.least_angles);
        let below = below.map_or(String::new(), |text| format!("; {text}"));
        let rows = [
            ("tetrahedra", report.mesh.tets.to_string()),
            ("vertices", report.mesh.vertices.to_string()),
            ("outcome", report.outcome.to_owned()),
            ("checked", verdict.to_owned()),
            ("dihedral angles", format!("{} to {} degrees{below}", degrees[0], degrees[1])),
            ("circumradius / shortest edge", format!("at most {}", number(ratio.largest.value))),
            ("largest volume", number(quality.volume.largest.value)),
            ("ltbw.mesh/1", report.mesh.hash.clone().unwrap_or_default()),
        ];
        let histograms = histograms::svg(quality, slivers);
        self.facts(&rows.map(Fact::from)).section("Quality", &histograms)
    }

    /// A part with a heading; the contents are HTML.
    pub(crate) fn section(mut self, heading: &str, contents: &str) -> Self {
        self.sections += &format!("<h2>{heading}</h2>\n{contents}");
        self
    }

    /// Text as it is, under a heading.
    pub(crate) fn text(self, heading: &str, text: &str) -> Self {
        self.section(heading, &format!("<pre>{}</pre>\n", escape(text)))
    }

    /// The page; `report` is the JSON of the run.
    pub(crate) fn html(&self, report: &str) -> String {
        let report = escape(report);
        let values = [
            ("name", &*self.name),
            ("style", STYLE),
            ("sections", &self.sections),
            ("report", &report),
        ];
        filled(PAGE, &values.map(Filling::from))
    }
}

/// A row of a table of facts.
pub(crate) struct Fact<'a> {
    pub(crate) name: &'a str,
    pub(crate) value: String,
}

impl<'a> From<(&'a str, String)> for Fact<'a> {
    fn from((name, value): (&'a str, String)) -> Self {
        Self { name, value }
    }
}

/// The text that fills a place of a template.
#[derive(Clone, Copy)]
struct Filling<'a> {
    name: &'a str,
    value: &'a str,
}

impl<'a> From<(&'a str, &'a str)> for Filling<'a> {
    fn from((name, value): (&'a str, &'a str)) -> Self {
        Self { name, value }
    }
}

/// A template with its places `{{name}}` filled. What is filled in is not looked through again.
fn filled(template: &str, values: &[Filling<'_>]) -> String {
    let mut text = String::with_capacity(template.len());
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        text.push_str(before);
        let Some((name, behind)) = after.split_once("}}") else { break };
        text.push_str(
            values.iter().find(|place| place.name == name).map_or("", |place| place.value),
        );
        rest = behind;
    }
    text.push_str(rest);
    text
}

/// Text as HTML shows it.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_stays_text() {
        assert_eq!(escape("a<b>&c"), "a&lt;b&gt;&amp;c");
        assert_eq!(
            filled("a{{x}}b{{y}}", &[("x", "{{y}}"), ("y", "2")].map(Filling::from)),
            "a{{y}}b2"
        );
    }
}
