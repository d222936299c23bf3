//! The figures of the workers' time in a parallel run: as JSON, as the paper's tables, and as a
//! timeline. The same for threads and for simulated processors.

mod tables;

pub(crate) use tables::{Doing, Run, cost_model, tables};

use crate::console;
use crate::json::{name_of, write_json};
use crate::outcome::{Failure, show};
use ltbw::metrics::{Cavities, Messages, Polls, Summary, Times, Trace, WorkerFigures};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Stretches of time that a trace keeps of each worker: enough for some ten thousand insertions.
pub(crate) const SPANS: usize = 200_000;

/// The figures of a run; times are in nanoseconds. `docs/protocol.md` defines them.
#[derive(Debug, Serialize)]
pub(crate) struct Figures {
    lt: Option<f64>,
    lt_strict: Option<f64>,
    worst: Worst,
    setbacks: u64,
    operations: u64,
    worst_setbacks: u32,
    makespan: u64,
    messages: AllMessages,
    polls: Polls,
    cavities: Cavities,
    share_active: f64,
    times: Times,
    successful: u64,
    local_active: u64,
    interface_active: u64,
    set_back: u64,
    surface_to_volume: f64,
    imbalance_tets: u64,
    workers: Vec<Worker>,
}

/// The lowest latency tolerance of any worker, and whose it is; the lowest strict one.
#[derive(Debug, Serialize)]
struct Worst {
    worker: u32,
    lt: Option<f64>,
    lt_strict: Option<f64>,
}

/// A worker's figures.
#[derive(Debug, Serialize)]
struct Worker {
    lt: Option<f64>,
    lt_strict: Option<f64>,
    #[serde(flatten)]
    figures: WorkerFigures,
}

impl Worker {
    fn new(figures: &WorkerFigures) -> Self {
        Self { lt: figures.lt(), lt_strict: figures.lt_strict(), figures: *figures }
    }
}

#[derive(Debug, Serialize)]
struct AllMessages {
    count: u64,
    bytes: u64,
    per_interface_cavity: f64,
    kinds: BTreeMap<&'static str, Messages>,
}

impl Figures {
    /// The time of the whole run, in nanoseconds.
    pub(crate) fn makespan(&self) -> u64 {
        self.makespan
    }

    /// The figures of a run.
    pub(crate) fn of(s: &Summary) -> Self {
        let all = s.all_messages();
        Self {
            lt: s.lt(),
            lt_strict: s.lt_strict(),
            worst: Worst {
                worker: s.extremes_of_tolerance().map_or(0, |of| of.least.worker.number()),
                lt: s.worst_lt(),
                lt_strict: s.worst_lt_strict(),
            },
            setbacks: s.setbacks(),
            operations: s.operations(),
            worst_setbacks: s.worst_setbacks(),
            makespan: s.makespan,
            messages: AllMessages {
                count: all.count,
                bytes: all.bytes,
                per_interface_cavity: s.messages_per_interface_cavity(),
                kinds: s.messages.clone(),
            },
            polls: s.polls,
            cavities: s.cavities,
            share_active: s.cavities.share_active(),
            times: s.times,
            successful: s.cavity_times.successful,
            local_active: s.cavity_times.local_active,
            interface_active: s.cavity_times.interface_active,
            set_back: s.cavity_times.set_back,
            surface_to_volume: s.surface_to_volume(),
            imbalance_tets: s.imbalance_tets(),
            workers: s.workers.iter().map(Worker::new).collect(),
        }
    }
}

/// Writes a timeline, if there is one.
pub(crate) fn write_trace(path: &Path, trace: Option<Trace>) -> Result<(), Failure> {
    let Some(trace) = trace else { return Ok(()) };
    let mut text = Vec::new();
    trace.write(&mut text).map_err(|e| Failure::Other(e.to_string()))?;
    write_json(path, &String::from_utf8_lossy(&text))?;
    let path = &name_of(path);
    if !trace.is_complete {
        console::people(&format!(
            "note: {}: only the first {SPANS} stretches and messages of each worker",
            show(path)
        ));
    }
    console::people(&format!("wrote     {}: open it in ui.perfetto.dev", show(path)));
    Ok(())
}
