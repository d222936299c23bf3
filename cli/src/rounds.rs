//! Refinement in rounds: the choice of the engine, and its figures in the report.

use ltbw::refine::{Engine, InsertOrder, RefineStats};
use serde_json::{Value, json};

/// The vertices up to which queues are used, by default.
pub(crate) const START: usize = 4096;

/// The engine that refines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum EngineArg {
    /// One item after the other
    #[default]
    Queues,
    /// In rounds
    Rounds,
}

impl EngineArg {
    pub(crate) fn engine(self) -> Engine {
        match self {
            Self::Queues => Engine::Queues,
            Self::Rounds => Engine::Rounds { order: InsertOrder::default(), start: START },
        }
    }
}

/// The figures of the rounds; `null` if there were none.
pub(crate) fn json(stats: &RefineStats) -> Value {
    let [segments, facets, tets] = stats.rounds;
    match segments + facets + tets {
        0 => Value::Null,
        all => json!({
            "rounds": all,
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
        }),
    }
}

/// The same as a line for people.
pub(crate) fn line(stats: &RefineStats) -> Option<String> {
    let [segments, facets, tets] = stats.rounds;
    (segments + facets + tets > 0).then(|| {
        format!(
            "rounds    {} ({segments} of segments, {facets} of facets, {tets} inside), \
             the widest of {} points, {:.2} searches a point",
            segments + facets + tets,
            stats.widest,
            stats.searches as f64 / stats.round_points.max(1) as f64
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_are_told_where_there_were_any() {
        assert_eq!(
            (json(&RefineStats::default()), line(&RefineStats::default())),
            (Value::Null, None)
        );
        let stats = RefineStats {
            rounds: [1, 2, 3],
            searches: 30,
            round_points: 20,
            widest: 7,
            ..RefineStats::default()
        };
        let line = line(&stats).expect("a line");
        assert!(line.starts_with("rounds    6 (1 of segments, 2 of facets, 3 inside)"), "{line}");
        assert!(line.ends_with("the widest of 7 points, 1.50 searches a point"), "{line}");
        assert_eq!(json(&stats)["rounds"], 6);
    }
}
