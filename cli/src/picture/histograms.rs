//! Histograms of quality as one picture.

use ltbw::quality::Quality;
use std::fmt::Write as _;

/// The four histograms as one SVG picture, without anything from outside it.
pub(crate) fn svg(quality: &Quality) -> String {
    const WIDTH: f64 = 420.0;
    const HEIGHT: f64 = 220.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" \
         font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        2.0 * WIDTH,
        2.0 * HEIGHT
    );
    for (k, h) in quality.histograms().into_iter().enumerate() {
        let (x, y) = (WIDTH * (k % 2) as f64, HEIGHT * (k / 2) as f64);
        let most = h.counts.iter().copied().max().unwrap_or(0).max(1) as f64;
        let width = (WIDTH - 60.0) / h.counts.len() as f64;
        let _ = writeln!(svg, "<g transform=\"translate({x} {y})\">");
        let _ = writeln!(svg, "<text x=\"30\" y=\"20\">{}</text>", h.name);
        for (i, &count) in h.counts.iter().enumerate() {
            let height = count as f64 / most * (HEIGHT - 70.0);
            let (left, top) = (30.0 + i as f64 * width, HEIGHT - 30.0 - height);
            let _ = writeln!(
                svg,
                "<rect x=\"{left:.2}\" y=\"{top:.2}\" width=\"{:.2}\" height=\"{height:.2}\" \
                 fill=\"#4477aa\"><title>{count}</title></rect>",
                width * 0.92
            );
        }
        let axis = HEIGHT - 14.0;
        let _ = writeln!(svg, "<text x=\"30\" y=\"{axis}\">{:.3}</text>", h.low);
        let right = WIDTH - 30.0;
        let _ = writeln!(
            svg,
            "<text x=\"{right}\" y=\"{axis}\" text-anchor=\"end\">{:.3e}; \
             least {:.3e}, largest {:.3e}</text>\n</g>",
            h.high, h.least.value, h.largest.value
        );
    }
    svg.push_str("</svg>\n");
    svg
}

#[cfg(test)]
mod tests {
    use super::svg;
    use ltbw::quality::Quality;

    #[test]
    fn a_bar_for_each_bin() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]];
        let all = Quality::of(&points, &[[0, 1, 2, 3], [1, 4, 2, 3]]).expect("two tetrahedra");
        assert_eq!(svg(&all).matches("<rect").count(), 1 + 36 + 3 * 30);
        // A flat tetrahedron does no harm.
        let flat = Quality::of(&points, &[[0, 1, 2, 4]]).expect("a tetrahedron");
        assert!(!svg(&flat).is_empty());
    }
}
