//! A page to look at: a cut through the mesh, histograms, the report. One file of HTML that needs
//! nothing beside it, and no script.

use crate::picture::{cut, histograms};
use crate::report::Report;
use ltbw::TetMesh;
use ltbw::quality::Quality;

/// The contents of a page.
pub(crate) struct Page<'a> {
    /// The name of the domain.
    pub(crate) name: &'a str,
    /// The report of the run.
    pub(crate) report: &'a Report,
    /// The checker's verdict.
    pub(crate) verdict: &'a str,
    /// Measured of the mesh.
    pub(crate) quality: &'a Quality,
}

/// Width of the cut, in pixels.
const WIDTH: f64 = 640.0;

const STYLE: &str = "body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em}\
    svg{max-width:100%;height:auto}.cut{max-width:640px}\
    td{padding:.1em 1em .1em 0;vertical-align:top}.key span{padding:.1em .6em;margin-right:.2em}\
    code,pre{font-size:13px;overflow-x:auto}";

impl Page<'_> {
    /// The page. The cut is through the middle of the mesh, across its z axis.
    pub(crate) fn html(&self, mesh: &TetMesh) -> String {
        let z = || mesh.tets.iter().flatten().map(|&v| mesh.points[v as usize][2]);
        let low = z().fold(f64::INFINITY, f64::min);
        let middle = (low + z().fold(f64::NEG_INFINITY, f64::max)) / 2.0;
        let name = escape(self.name);
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
             <title>ltbw: {name}</title>\n<style>{STYLE}</style>\n<h1>{name}</h1>\n\
             <table>\n{}</table>\n\
             <h2>Cut at z = {middle}</h2>\n<p>Tetrahedra by their least dihedral angle:</p>\n\
             <p class=\"key\">{}</p>\n<div class=\"cut\">\n{}</div>\n\
             <h2>Quality</h2>\n{}<h2>Report</h2>\n<details><summary>ltbw.report/1</summary>\n\
             <pre>{}</pre></details>\n</html>\n",
            self.table(),
            key(),
            cut::svg(&mesh.points, &mesh.tets, 2, middle, WIDTH),
            histograms::svg(self.quality),
            escape(&self.report.to_json().unwrap_or_default()),
        )
    }

    /// The figures that one asks for first.
    fn table(&self) -> String {
        let (report, quality) = (self.report, self.quality);
        let (angle, ratio) = (&quality.dihedral, &quality.radius_edge);
        let rows = [
            ("tetrahedra", report.mesh.tets.to_string()),
            ("vertices", report.mesh.vertices.to_string()),
            ("outcome", report.outcome.to_owned()),
            ("checked", self.verdict.to_owned()),
            (
                "dihedral angles",
                format!("{:.2} to {:.2} degrees", angle.least.value, angle.largest.value),
            ),
            ("circumradius / shortest edge", format!("at most {:.4}", ratio.largest.value)),
            ("largest volume", format!("{:.6e}", quality.volume.largest.value)),
            ("ltbw.mesh/1", report.mesh.hash.clone().unwrap_or_default()),
        ];
        let row = |(name, value): &(&str, String)| {
            format!("<tr><td>{name}</td><td>{}</td></tr>\n", escape(value))
        };
        rows.iter().map(row).collect()
    }
}

/// The colours of the cut and what they mean.
fn key() -> String {
    let last = cut::COLOURS.len() - 1;
    let entry = |(k, colour): (usize, &&str)| {
        let end = if k == last { "90".to_owned() } else { (10 * k + 10).to_string() };
        format!("<span style=\"background:{colour}\">{}&ndash;{end}&deg;</span>", 10 * k)
    };
    cut::COLOURS.iter().enumerate().map(entry).collect()
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
        assert_eq!(key().matches("<span").count(), cut::COLOURS.len());
    }
}
