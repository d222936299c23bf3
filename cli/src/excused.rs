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

/// The part of the mesh's volume that the excused fill.
fn share(refined: &Refined, all: &[Excused]) -> f64 {
    let volume: f64 = all.iter().map(|e| e.volume).sum();
    if volume > 0.0 { volume / refined.volume() } else { 0.0 }
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
        "share": share(refined, &all),
        "by_reason": all.iter().take(LISTED).map(each).collect::<Vec<_>>(),
    })
}

/// The excused for people: how many where, and the first reasons.
pub(crate) fn text(refined: &Refined) -> String {
    let all = refined.excused();
    let [corners, segments, elsewhere] = sums(&all);
    let told = |(places, tets, volume): (usize, usize, f64), name: &str| {
        let place = match places {
            0 => return None,
            _ if name.is_empty() => "elsewhere".to_owned(),
            1 => format!("at 1 {name}"),
            _ => format!("at {places} {name}s"),
        };
        Some(format!("{tets} {place} of volume {volume:.3e}"))
    };
    let places = [told(corners, "corner"), told(segments, "segment"), told(elsewhere, "")];
    let places: Vec<String> = places.into_iter().flatten().collect();
    let percent = 100.0 * share(refined, &all);
    let reasons: Vec<String> =
        all.iter().take(SHOWN).map(|e| format!("{} for {}", e.tets, e.reason)).collect();
    let more = all.len().saturating_sub(SHOWN);
    let more = if more > 0 { format!(", and {more} more reasons") } else { String::new() };
    format!(
        "{} tetrahedra over a bound, {}, {percent:.2e} % of all volume: {}{more}",
        refined.excuses.len(),
        places.join(", "),
        reasons.join(", ")
    )
}
