//! The axes of pictures, and the numbers there.

use std::fmt::Write as _;

/// The place of a picture's bars. Writing to a string cannot fail.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) wide: f64,
    pub(super) floor: f64,
}

impl Frame {
    /// A line across the picture, and what it stands for.
    pub(super) fn row(&self, svg: &mut String, y: f64, text: &str) {
        let Self { left, wide, .. } = self;
        let _ = writeln!(
            svg,
            "<line x1=\"{left}\" x2=\"{:.1}\" y1=\"{y:.1}\" y2=\"{y:.1}\" stroke=\"#ddd\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{text}</text>",
            left + wide,
            left - 6.0,
            y + 4.0
        );
    }

    /// The axis below the bars, from one value to another, with about as many numbers as wanted.
    pub(super) fn axis(&self, svg: &mut String, [low, high]: [f64; 2], wanted: usize) {
        let Self { left, wide, floor } = self;
        for value in ticks(low, high, wanted) {
            let x = left + (value - low) / (high - low) * wide;
            let _ = writeln!(
                svg,
                "<line x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{floor}\" y2=\"{:.1}\" stroke=\"#555\"/>\
                 <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                floor + 4.0,
                floor + 17.0,
                number(value)
            );
        }
        let _ = writeln!(
            svg,
            "<line x1=\"{left}\" x2=\"{:.1}\" y1=\"{floor}\" y2=\"{floor}\" stroke=\"#555\"/>",
            left + wide
        );
    }
}

/// Round numbers from `low` to `high`, about as many as wanted; none if the range is none.
pub(super) fn ticks(low: f64, high: f64, wanted: usize) -> Vec<f64> {
    let width = high - low;
    if !(width > 0.0 && width.is_finite()) {
        return Vec::new();
    }
    let rough = width / wanted as f64;
    let power = 10f64.powf(rough.log10().floor());
    let factors = [1.0, 2.0, 5.0, 10.0];
    let step = factors.iter().map(|f| f * power).find(|&s| s >= rough * 0.999).unwrap_or(rough);
    let (first, last) = ((low / step).ceil(), (high / step * (1.0 + 1e-9)).floor());
    (0..=(last - first).max(0.0) as usize).map(|k| (first + k as f64) * step).collect()
}

/// A number as people read it: four digits at most, powers of ten where zeros would be counted.
pub(crate) fn number(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        return "infinite".to_owned();
    }
    if size == 0.0 {
        return "0".to_owned();
    }
    if (1e-3..1e6).contains(&size) {
        let places = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{value:.places$}");
        let text = if text.contains('.') { text.trim_end_matches('0') } else { &text };
        return text.trim_end_matches('.').to_owned();
    }
    let text = format!("{value:.3e}");
    let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
    let raised = |c: char| match c {
        '-' => '⁻',
        '0'..='9' => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][(c as u8 - b'0') as usize],
        other => other,
    };
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    format!("{digits}·10{}", power.chars().map(raised).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::{number, ticks};

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(ticks(0.0, 180.0, 6), [0.0, 50.0, 100.0, 150.0]);
        assert_eq!(ticks(0.0, 9_000.0, 4), [0.0, 5_000.0]);
        assert_eq!(ticks(0.3, 0.7, 4).len(), 5);
        assert_eq!(ticks(1.0, 1.0, 4), [0.0; 0]);
        assert_eq!(ticks(f64::NAN, 1.0, 4), [0.0; 0]);
    }

    #[test]
    fn numbers_are_for_people() {
        let cases = [
            (0.0, "0"),
            (179.4251, "179.4"),
            (0.376_52, "0.3765"),
            (12_000.0, "12000"),
            (1.737_83e-5, "1.738·10⁻⁵"),
            (2e6, "2·10⁶"),
            (f64::INFINITY, "infinite"),
            (-2.5, "-2.5"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
    }
}
