//! The tetrahedra that are excused: in the report and for people, by corner and segment.

use ltbw::refine::{Excused, Reason, Refined};
use serde_json::{Value, json};

/// Corners and segments that the report lists.
const LISTED: usize = 100;
/// Reasons that people are shown.
const SHOWN: usize = 5;

/// The sum over the excused that `is` chooses: places, tetrahedra, volume.
fn sum(all: &[Excused], is: impl Fn(&Reason) -> bool) -> (usize, usize, f64) {
    let chosen = all.iter().filter(|e| is(&e.reason));
    chosen.fold((0, 0, 0.0), |(n, tets, volume), e| (n + 1, tets + e.tets, volume + e.volume))
}

/// At corners, at segments, and elsewhere.
fn sums(all: &[Excused]) -> [(usize, usize, f64); 3] {
    let elsewhere = |reason: &Reason| !reason.is_corner() && !reason.is_segment();
    [sum(all, Reason::is_corner), sum(all, Reason::is_segment), sum(all, elsewhere)]
}

/// The excused for the report.
pub(crate) fn json(refined: &Refined) -> Value {
    let all = refined.excused();
    let of = |(places, tets, volume)| json!({ "places": places, "tets": tets, "volume": volume });
    let each =
        |e: &Excused| json!({ "reason": e.reason.to_string(), "tets": e.tets, "volume": e.volume });
    let [corners, segments, elsewhere] = sums(&all).map(of);
    json!({
        "corners": corners,
        "segments": segments,
        "elsewhere": elsewhere,
        "by_reason": all.iter().take(LISTED).map(each).collect::<Vec<_>>(),
    })
}

/// The excused for people: how many where, and the first reasons.
pub(crate) fn text(refined: &Refined) -> String {
    let all = refined.excused();
    let [corners, segments, elsewhere] = sums(&all);
    let count = |(places, tets, _), name: &str| match places {
        0 => None,
        1 => Some(format!("{tets} at 1 {name}")),
        _ => Some(format!("{tets} at {places} {name}s")),
    };
    let elsewhere = (elsewhere.1 > 0).then(|| format!("{} elsewhere", elsewhere.1));
    let places = [count(corners, "corner"), count(segments, "segment"), elsewhere];
    let places: Vec<String> = places.into_iter().flatten().collect();
    let volume: f64 = all.iter().map(|e| e.volume).sum();
    let reasons: Vec<String> =
        all.iter().take(SHOWN).map(|e| format!("{} for {}", e.tets, e.reason)).collect();
    let more = all.len().saturating_sub(SHOWN);
    let more = if more > 0 { format!(", and {more} more reasons") } else { String::new() };
    format!(
        "{} tetrahedra over a bound, {}, of volume {volume:.3e}: {}{more}",
        refined.excuses.len(),
        places.join(", "),
        reasons.join(", ")
    )
}
