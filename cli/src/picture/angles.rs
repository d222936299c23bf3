//! Tetrahedra by their smallest dihedral angle, before slivers are split and after.

use super::axes::{Frame, number};
use ltbw::quality::LeastAngles;
use std::fmt::Write as _;

/// The size of the picture, and the room around its bars: left, right, top, bottom.
pub(super) const WIDTH: f64 = 840.0;
pub(super) const HEIGHT: f64 = 250.0;
const ROOM: [f64; 4] = [52.0, 18.0, 48.0, 40.0];

/// The height of a single tetrahedron, beside that of ten times as many: a few that are left are to
/// be seen.
const ONE: f64 = 0.3;

/// Angles of a mesh before slivers were split, if they were counted, and the degrees below which
/// tetrahedra are slivers; 0 if none are.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Slivers {
    pub(crate) below: f64,
    pub(crate) before: Option<LeastAngles>,
}

impl Slivers {
    /// The numbers below the bound, before and after, in words.
    pub(crate) fn text(&self, after: &LeastAngles) -> Option<String> {
        let left = after.below(self.below);
        match self.before {
            Some(before) => split_text(self.below, before.below(self.below), left),
            None => {
                (self.below >= 1.0).then(|| format!("below {} degrees: {left}", self.below.floor()))
            }
        }
    }
}

/// The numbers of tetrahedra below whole degrees before slivers were split and after, in words.
pub(crate) fn split_text(below: f64, before: u64, left: u64) -> Option<String> {
    let whole = below.floor();
    (whole >= 1.0)
        .then(|| format!("below {whole} degrees: {before} before slivers were split, {left} left"))
}

/// A row of the picture of histograms. Writing to a string cannot fail.
pub(super) fn panel(svg: &mut String, after: &LeastAngles, slivers: &Slivers) {
    let [left, right, top, bottom] = ROOM;
    let (floor, wide, high) = (HEIGHT - bottom, WIDTH - left - right, HEIGHT - top - bottom);
    let frame = Frame { left, wide, floor };
    let text = slivers.text(after).map_or(String::new(), |text| format!("; {text}"));
    let _ = writeln!(
        svg,
        "<text x=\"{left}\" y=\"16\" font-weight=\"bold\">tetrahedra by smallest dihedral angle, \
         degrees</text>\n<text x=\"{left}\" y=\"30\" fill=\"#555\">from {}{text}</text>",
        number(after.least())
    );
    let none = LeastAngles::default();
    let before = slivers.before.as_ref();
    let all = after.counts().iter().chain(before.unwrap_or(&none).counts());
    let most = all.copied().max().unwrap_or(0).max(10) as f64;
    let height = |count: u64| match count {
        0 => 0.0,
        count => (ONE + (count as f64).log10()) / (ONE + most.log10()) * high,
    };
    for power in 0..=most.log10() as u32 {
        let count = 10u64.pow(power);
        let y = floor - height(count);
        frame.row(svg, y, &count.to_string());
    }
    let step = wide / LeastAngles::HIGH;
    for (k, &count) in after.counts().iter().enumerate() {
        let told = before.map_or(String::new(), |own| format!(", before {}", own.counts()[k]));
        let colour = if (k as f64) < slivers.below { "#cc3311" } else { "#4477aa" };
        let _ = writeln!(
            svg,
            "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\" fill=\"{colour}\">\
             <title>{k} to {}: {count}{told}</title></rect>",
            left + k as f64 * step,
            floor - height(count),
            step * 0.92,
            height(count),
            k + 1
        );
    }
    if let Some(before) = before {
        outline(svg, before, |k, count| [left + k as f64 * step, floor - height(count)]);
    }
    frame.axis(svg, [0.0, LeastAngles::HIGH], 12);
}

/// A line along the tops of the bars that were there before, and what it is.
fn outline(svg: &mut String, before: &LeastAngles, place: impl Fn(usize, u64) -> [f64; 2]) {
    let mut path = String::new();
    for (k, &count) in before.counts().iter().enumerate() {
        let ([x, y], [end, _]) = (place(k, count), place(k + 1, count));
        let word = if k == 0 { 'M' } else { 'L' };
        let _ = write!(path, "{word}{x:.2} {y:.2}L{end:.2} {y:.2}");
    }
    let _ = writeln!(
        svg,
        "<path d=\"{path}\" fill=\"none\" stroke=\"#222\" stroke-width=\"1.2\"/>\n\
         <text x=\"{:.1}\" y=\"30\" text-anchor=\"end\" fill=\"#555\">line: before slivers were \
         split</text>",
        WIDTH - ROOM[1]
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_red_beside_what_was() {
        let regular = [[0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [2.0, 0.0, 2.0], [0.0, 2.0, 2.0]];
        let flat = |h| [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, h], [0.0, 1.0, h]];
        let mut after = LeastAngles::default();
        after.add(regular.each_ref());
        after.add(flat(0.05).each_ref());
        let mut before = after;
        before.add(flat(0.04).each_ref());
        let picture = |slivers| {
            let mut svg = String::new();
            panel(&mut svg, &after, &slivers);
            svg
        };
        let both = picture(Slivers { below: 8.0, before: Some(before) });
        assert_eq!((both.matches("#cc3311").count(), both.matches("<path").count()), (8, 1));
        assert!(both.contains("below 8 degrees: 2 before slivers were split, 1 left"), "{both}");
        assert!(both.contains("<title>4 to 5: 0, before 1</title>"), "{both}");
        let one = picture(Slivers { below: 7.5, before: None });
        assert!(one.contains("below 7 degrees: 1</text>") && !one.contains("<path"), "{one}");
        let none = picture(Slivers::default());
        assert!(!none.contains("#cc3311") && !none.contains("below"), "{none}");
    }
}
