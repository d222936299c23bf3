//! Pictures: bars that are stacked, and lines.

use crate::table::escaped;
use std::fmt::Write as _;

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 300.0;
/// The room for axes: left, right, top, bottom.
const ROOM: [f64; 4] = [56.0, 170.0, 16.0, 36.0];
const COLOURS: [&str; 6] = ["#3366aa", "#77aadd", "#cc5533", "#eeaa66", "#555555", "#bbbbbb"];

/// A row of values with a name.
pub(crate) struct Series {
    pub(crate) name: String,
    /// One for each column, or pairs' second halves along the axis of a line.
    pub(crate) values: Vec<f64>,
}

/// Columns, each with the values of all series on top of each other.
pub(crate) fn stacked(columns: &[String], series: &[Series]) -> String {
    let sums = (0..columns.len()).map(|k| series.iter().map(|own| at(own, k)).sum::<f64>());
    let frame = Frame::new(sums.fold(0.0, f64::max));
    let step = frame.wide / columns.len().max(1) as f64;
    let mut svg = frame.begin(series);
    for (k, name) in columns.iter().enumerate() {
        let x = ROOM[0] + step * k as f64;
        let mut below = 0.0;
        for (own, colour) in series.iter().zip(COLOURS.iter().cycle()) {
            let (y, height) = (frame.y(below + at(own, k)), frame.height(at(own, k)));
            let _ = writeln!(
                svg,
                "<rect x=\"{:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{height:.1}\" \
                 fill=\"{colour}\"/>",
                x + 0.1 * step,
                0.8 * step
            );
            below += at(own, k);
        }
        svg.push_str(&frame.below(x + 0.5 * step, name));
    }
    svg.push_str("</svg>");
    svg
}

/// Lines over evenly spaced columns.
pub(crate) fn lines(columns: &[String], series: &[Series]) -> String {
    let all = series.iter().flat_map(|own| own.values.iter().copied());
    let frame = Frame::new(all.fold(0.0, f64::max));
    let step = frame.wide / columns.len().max(1) as f64;
    let mut svg = frame.begin(series);
    for (own, colour) in series.iter().zip(COLOURS.iter().cycle()) {
        let points = own.values.iter().enumerate().map(|(k, &value)| {
            format!("{:.1},{:.1}", ROOM[0] + step * (k as f64 + 0.5), frame.y(value))
        });
        let points = points.collect::<Vec<_>>().join(" ");
        let _ = writeln!(
            svg,
            "<polyline points=\"{points}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>"
        );
    }
    // Names of many columns would lie over each other.
    let every = columns.len().div_ceil(18).max(1);
    for (k, name) in columns.iter().enumerate().step_by(every) {
        svg.push_str(&frame.below(ROOM[0] + step * (k as f64 + 0.5), name));
    }
    svg.push_str("</svg>");
    svg
}

fn at(series: &Series, column: usize) -> f64 {
    series.values.get(column).copied().unwrap_or(0.0)
}

/// The place of the values.
struct Frame {
    most: f64,
    wide: f64,
    high: f64,
}

impl Frame {
    fn new(most: f64) -> Self {
        let [left, right, top, bottom] = ROOM;
        Self { most: most.max(1e-300), wide: WIDTH - left - right, high: HEIGHT - top - bottom }
    }

    fn height(&self, value: f64) -> f64 {
        self.high * value / self.most
    }

    fn y(&self, value: f64) -> f64 {
        ROOM[2] + self.high - self.height(value)
    }

    /// The picture with its axis and the names of its series.
    fn begin(&self, series: &[Series]) -> String {
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
             width=\"{WIDTH}\" font-family=\"sans-serif\" font-size=\"12\">\n"
        );
        for part in 0..=4 {
            let value = self.most * f64::from(part) / 4.0;
            let y = self.y(value);
            let _ = writeln!(
                svg,
                "<line x1=\"{}\" x2=\"{:.1}\" y1=\"{y:.1}\" y2=\"{y:.1}\" stroke=\"#ddd\"/>\
                 <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                ROOM[0],
                ROOM[0] + self.wide,
                ROOM[0] - 6.0,
                y + 4.0,
                short(value)
            );
        }
        for (k, (own, colour)) in series.iter().zip(COLOURS.iter().cycle()).enumerate() {
            let (x, y) = (ROOM[0] + self.wide + 16.0, ROOM[2] + 18.0 * k as f64);
            let _ = writeln!(
                svg,
                "<rect x=\"{x}\" y=\"{y}\" width=\"12\" height=\"12\" fill=\"{colour}\"/>\
                 <text x=\"{}\" y=\"{}\">{}</text>",
                x + 18.0,
                y + 11.0,
                escaped(&own.name)
            );
        }
        svg
    }

    fn below(&self, x: f64, name: &str) -> String {
        let y = ROOM[2] + self.high + 18.0;
        format!("<text x=\"{x:.1}\" y=\"{y}\" text-anchor=\"middle\">{}</text>\n", escaped(name))
    }
}

fn short(value: f64) -> String {
    if value >= 10.0 { format!("{value:.0}") } else { format!("{value:.2}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series() -> [Series; 2] {
        let own =
            |name: &str, values: &[f64]| Series { name: name.into(), values: values.to_vec() };
        [own("a", &[1.0, 3.0]), own("b", &[1.0, 1.0])]
    }

    #[test]
    fn a_bar_for_each_value_and_as_high_as_their_sum() {
        let svg = stacked(&["x".into(), "y".into()], &series());
        // Four bars, two in the legend.
        assert_eq!(svg.matches("<rect").count(), 6);
        let high = HEIGHT - ROOM[2] - ROOM[3];
        assert!(svg.contains(&format!("height=\"{:.1}\"", high * 0.75)), "{svg}");
    }

    #[test]
    fn a_line_for_each_series() {
        let svg = lines(&["x".into(), "y".into()], &series());
        assert_eq!(svg.matches("<polyline").count(), 2);
        assert!(svg.ends_with("</svg>"));
    }
}
