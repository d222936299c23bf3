//! Histograms of quality as one picture, with axes.

use super::angles::{self, Slivers};
use super::axes::{Frame, number, ticks};
use ltbw::quality::{Histogram, Quality};
use std::fmt::Write as _;

/// The size of one histogram, and the room around its bars: left, right, top, bottom.
const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 230.0;
const ROOM: [f64; 4] = [52.0, 18.0, 34.0, 40.0];

/// The four histograms, and that of smallest dihedral angles, as one SVG picture, without anything
/// from outside it.
pub(crate) fn svg(quality: &Quality, slivers: &Slivers) -> String {
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" \
         font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        2.0 * WIDTH,
        2.0 * HEIGHT + angles::HEIGHT
    );
    for (k, h) in quality.histograms().into_iter().enumerate() {
        let (x, y) = (WIDTH * (k % 2) as f64, HEIGHT * (k / 2) as f64);
        let _ = writeln!(svg, "<g transform=\"translate({x} {y})\">");
        panel(&mut svg, h);
        svg.push_str("</g>\n");
    }
    let _ = writeln!(svg, "<g transform=\"translate(0 {})\">", 2.0 * HEIGHT);
    angles::panel(&mut svg, &quality.least_angles, slivers);
    svg.push_str("</g>\n</svg>\n");
    svg
}

/// One histogram: title, bars, ticks. Writing to a string cannot fail.
fn panel(svg: &mut String, h: &Histogram) {
    let [left, right, top, bottom] = ROOM;
    let (floor, wide, high) = (HEIGHT - bottom, WIDTH - left - right, HEIGHT - top - bottom);
    let frame = Frame { left, wide, floor };
    let _ = writeln!(
        svg,
        "<text x=\"{left}\" y=\"16\" font-weight=\"bold\">{}</text>\n\
         <text x=\"{left}\" y=\"28\" fill=\"#555\">from {} to {}</text>",
        h.name,
        number(h.least.value),
        number(h.largest.value)
    );
    let counted = h.counts.iter().copied().max().unwrap_or(0).max(1) as f64;
    let rows = ticks(0.0, counted, 4);
    let most = rows.last().copied().unwrap_or(counted).max(counted);
    for value in &rows {
        let y = floor - value / most * high;
        frame.row(svg, y, &number(*value));
    }
    let step = wide / h.counts.len().max(1) as f64;
    for (i, &count) in h.counts.iter().enumerate() {
        let height = count as f64 / most * high;
        let [from, to] = h.bin(i);
        // The last bar counts what is beyond the axis, too.
        let is_open = i + 1 == h.counts.len() && h.largest.value > h.high;
        let range = match is_open {
            true => format!("{} and above", number(from)),
            false => format!("{} to {}", number(from), number(to)),
        };
        if is_open {
            let _ = writeln!(
                svg,
                "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"#555\">{range}</text>",
                left + wide,
                floor - height - 4.0
            );
        }
        let _ = writeln!(
            svg,
            "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{height:.2}\" \
             fill=\"#4477aa\"><title>{range}: {count}</title></rect>",
            left + i as f64 * step,
            floor - height,
            step * 0.92
        );
    }
    frame.axis(svg, [h.low, h.high], 6);
}

#[cfg(test)]
mod tests {
    use super::Slivers;
    use ltbw::quality::Quality;

    #[test]
    fn a_bar_for_each_bin() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]];
        let all = Quality::of(&points, &[[0, 1, 2, 3], [1, 4, 2, 3]]).expect("two tetrahedra");
        let svg = |quality: &Quality| super::svg(quality, &Slivers::default());
        assert_eq!(svg(&all).matches("<rect").count(), 1 + 36 + 3 * 30 + 72);
        // A flat tetrahedron does no harm.
        let flat = Quality::of(&points, &[[0, 1, 2, 4]]).expect("a tetrahedron");
        let flat = svg(&flat);
        assert!(!flat.contains("NaN") && !flat.contains("inf\""), "{flat}");
        // A bar that counts values beyond the axis tells it.
        assert!(flat.contains("\">2.05 and above</text>") && !svg(&all).contains("and above"));
    }
}
