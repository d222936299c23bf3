//! A curve over a few settings, as a picture with axes.

use super::axes::{number, ticks};
use std::fmt::Write as _;

const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 230.0;
const LEFT: f64 = 52.0;
const TOP: f64 = 34.0;
const FLOOR: f64 = HEIGHT - 40.0;

/// Values over settings, which lie at equal distances, and a second, thin curve beside them to
/// compare with; values are from 0 on. One SVG picture without anything from outside it.
pub(crate) fn svg(title: &str, settings: &[String], values: &[f64], beside: &[f64]) -> String {
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
         width=\"{WIDTH}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"{LEFT}\" y=\"16\" font-weight=\"bold\">{title}</text>\n"
    );
    let finite = values.iter().chain(beside).copied().filter(|v| v.is_finite());
    let largest = finite.fold(0.0, f64::max);
    let largest = if largest > 0.0 { largest } else { 1.0 };
    let mut rows = ticks(0.0, largest, 4);
    // The axis ends with a number that is told: at 1 for what is below it.
    if let [.., before, last] = rows[..]
        && last < largest
    {
        rows.push(2.0 * last - before);
    }
    let most = rows.last().copied().unwrap_or(largest).max(largest) * 1.04;
    let x = |k: usize| {
        let gaps = settings.len().saturating_sub(1).max(1);
        LEFT + 14.0 + k as f64 / gaps as f64 * (WIDTH - LEFT - 42.0)
    };
    let y = |value: f64| FLOOR - value.max(0.0).min(most) / most * (FLOOR - TOP);
    // Writing to a string cannot fail.
    for value in rows {
        let _ = writeln!(
            svg,
            "<line x1=\"{LEFT}\" x2=\"{:.1}\" y1=\"{1:.1}\" y2=\"{1:.1}\" stroke=\"#ddd\"/>\
             <text x=\"{2:.1}\" y=\"{3:.1}\" text-anchor=\"end\">{4}</text>",
            WIDTH - 14.0,
            y(value),
            LEFT - 6.0,
            y(value) + 4.0,
            number(value)
        );
    }
    for (k, setting) in settings.iter().enumerate() {
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{setting}</text>",
            x(k),
            FLOOR + 17.0
        );
    }
    for (list, colour, width) in [(beside, "#999", 1.0), (values, "#4477aa", 2.0)] {
        let corner = |(k, v): (usize, &f64)| format!("{:.1},{:.1}", x(k), y(*v));
        let line: Vec<String> = list.iter().enumerate().map(corner).collect();
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"/>",
            line.join(" ")
        );
    }
    for ((k, value), setting) in values.iter().enumerate().zip(settings) {
        let _ = writeln!(
            svg,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3.5\" fill=\"#4477aa\">\
             <title>{setting}: {}</title></circle>",
            x(k),
            y(*value),
            number(*value)
        );
    }
    svg + "</svg>\n"
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_mark_for_each_value() {
        let settings = ["1".to_owned(), "2".to_owned(), "4".to_owned()];
        let picture = super::svg("speed-up", &settings, &[1.0, 1.9, 3.4], &[1.0, 2.0, 4.0]);
        assert_eq!(picture.matches("<circle").count(), 3);
        assert_eq!(picture.matches("<polyline").count(), 2);
        let below = super::svg("LT", &settings, &[0.98, 0.9, 0.6], &[0.9, 0.8, 0.5]);
        assert!(below.contains("text-anchor=\"end\">1</text>"), "{below}");
        for list in [&[][..], &[0.0], &[f64::NAN]] {
            let picture = super::svg("nothing", &[], list, &[]);
            assert!(!picture.contains("NaN") && !picture.contains("inf"), "{picture}");
        }
    }
}
