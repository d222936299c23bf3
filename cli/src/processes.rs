//! The times and the memory of a job's processes, for its report.

use crate::others::Apart;
use crate::outcome::Failure;
use crate::report::{Report, Seconds, peak_rss_bytes};
use serde_json::{Map, Value, json};

/// The stages that processes go through together.
const STAGES: [&str; 7] = ["read", "order", "insert", "refine", "check", "hash", "write"];

/// Tells the report what all have taken so far: from here on the first one may go on alone.
pub(crate) fn tell(others: &dyn Apart, report: &mut Report) -> Result<(), Failure> {
    let Seconds { read, order, insert, refine, check, hash, write, .. } = report.seconds;
    let own = [read, order, insert, refine, check, hash, write];
    let all: Vec<([f64; STAGES.len()], Option<u64>)> = others.all(&(own, peak_rss_bytes()))?;
    let of = |k: usize| spread(&all.iter().map(|(seconds, _)| seconds[k]).collect::<Vec<f64>>());
    let stages = STAGES.into_iter().enumerate();
    let seconds: Map<String, Value> = stages.map(|(k, name)| (name.to_owned(), of(k))).collect();
    let peaks: Option<Vec<f64>> = all.iter().map(|own| Some(own.1? as f64)).collect();
    report.ranks = Some(json!({
        "count": all.len(), "seconds": seconds, "peak_rss_bytes": peaks.map(|all| spread(&all)),
    }));
    Ok(())
}

/// The least, the mean and the largest of some figures.
fn spread(all: &[f64]) -> Value {
    let (min, max) = (f64::min, f64::max);
    json!({
        "min": all.iter().copied().fold(f64::INFINITY, min),
        "mean": all.iter().sum::<f64>() / all.len() as f64,
        "max": all.iter().copied().fold(0.0, max),
    })
}
