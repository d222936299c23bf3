//! The figures of the rounds in the report, and their timeline.

use crate::console;
use crate::json::{name_of, write_json};
use crate::outcome::{Failure, show};
use ltbw::metrics::Trace;
use ltbw::refine::{RefineStats, RoundTimes};
use serde_json::{Value, json};
use std::path::Path;

/// The vertices from which on it refines in rounds, by default.
pub(crate) const START: usize = 4096;

/// The figures of the rounds.
pub(crate) fn json(stats: &RefineStats) -> Value {
    let [segments, facets, tets] = stats.rounds_with;
    json!({
        "rounds": stats.rounds,
        "segment_rounds": segments,
        "facet_rounds": facets,
        "tet_rounds": tets,
        "points": stats.round_points,
        "searches": stats.searches,
        "barred": stats.barred,
        "widest": stats.widest,
        "joint_phases": stats.joint_phases,
        "threads": stats.round_threads,
        "start_seconds": stats.start_seconds,
    })
}

/// The figures of the rounds as a line for people.
pub(crate) fn line(stats: &RefineStats) -> Option<String> {
    let [segments, facets, tets] = stats.rounds_with;
    (stats.rounds > 0).then(|| {
        format!(
            "rounds    {} ({segments} on segments, {facets} on facets, {tets} inside), \
             the widest of {} points, {:.2} searches a point",
            stats.rounds,
            stats.widest,
            stats.searches as f64 / stats.round_points.max(1) as f64
        )
    })
}

/// Writes the timeline of the rounds, if it is asked for: what each chose, and what it inserted.
pub(crate) fn write_trace(path: Option<&Path>, rounds: &[RoundTimes]) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    let name = |what: &str, name: &str| {
        let args = json!({ "name": name });
        json!({ "name": what, "ph": "M", "pid": 0, "tid": 0, "args": args })
    };
    let mut events = vec![name("process_name", "ltbw"), name("thread_name", "rounds")];
    for (number, own) in rounds.iter().enumerate() {
        let mut add = |what: &str, begin: f64, end: f64| {
            events.push(json!({
                "name": format!("{what} {}", own.class), "ph": "X", "pid": 0, "tid": 0,
                "ts": 1e6 * begin, "dur": 1e6 * (end - begin).max(0.0),
                "args": { "round": number, "candidates": own.candidates, "points": own.points },
            }));
        };
        add("choose", own.begin, own.chosen);
        add("insert", own.chosen, own.end);
    }
    let trace = json!({
        "displayTimeUnit": "ns",
        "otherData": { "schema": Trace::SCHEMA, "complete": true },
        "traceEvents": events,
    });
    write_json(path, &trace.to_string())?;
    let path = show(&name_of(path));
    console::people(&format!("wrote     {path}: open it in ui.perfetto.dev"));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_are_told_where_there_were_any() {
        let none = RefineStats::default();
        assert_eq!((&json(&none)["rounds"], line(&none)), (&json!(0), None));
        let stats = RefineStats {
            rounds: 5,
            rounds_with: [1, 2, 3],
            searches: 30,
            round_points: 20,
            widest: 7,
            ..RefineStats::default()
        };
        let line = line(&stats).expect("a line");
        assert!(line.starts_with("rounds    5 (1 on segments, 2 on facets, 3 inside)"), "{line}");
        assert!(line.ends_with("the widest of 7 points, 1.50 searches a point"), "{line}");
        assert_eq!(json(&stats)["rounds"], 5);
    }
}
