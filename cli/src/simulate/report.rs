//! The JSON report of `simulate`, in the schema `ltbw.report/1`.

use super::Simulate;
use ltbw::mesh::Plan;
use ltbw::metrics::{Cavities, Messages, Polls, Times, WorkerFigures};
use ltbw::protocol::Config;
use ltbw::simulate::{CostModel, Meshed, Options};
use serde::Serialize;
use std::collections::BTreeMap;

/// What was asked for.
#[derive(Clone, Copy)]
pub(super) struct Run<'a> {
    pub(super) args: &'a Simulate,
    pub(super) plan: &'a Plan,
    pub(super) config: &'a Config,
    pub(super) options: &'a Options,
}

/// The report. All times are in nanoseconds of virtual time.
#[derive(Serialize)]
pub(super) struct Report {
    schema: &'static str,
    command: &'static str,
    input: Input,
    mesh: Mesh,
    simulation: Simulation,
    outcome: &'static str,
}

#[derive(Serialize)]
struct Input {
    kind: &'static str,
    points: usize,
    duplicates: usize,
}

#[derive(Serialize)]
struct Mesh {
    tets: usize,
    hull_faces: usize,
    hash: String,
}

#[derive(Serialize)]
struct Simulation {
    lt: f64,
    lt_strict: f64,
    setbacks: u64,
    operations: u64,
    worst_setbacks: u32,
    efficiency: f64,
    makespan: u64,
    one_processor: u64,
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
    events: u64,
    workers: Vec<WorkerFigures>,
    cost_model: CostModel,
    settings: Settings,
}

#[derive(Serialize)]
struct AllMessages {
    count: u64,
    bytes: u64,
    per_interface_cavity: f64,
    kinds: BTreeMap<&'static str, Messages>,
}

#[derive(Serialize)]
struct Settings {
    processors: u32,
    rule: String,
    latency: u64,
    distribution: &'static str,
    byte: f64,
    seed: u64,
    window: usize,
    cursors: usize,
    blocks_per_worker: u32,
    sample: usize,
    slow: Option<f64>,
    storm: Option<u64>,
    balance: bool,
}

impl Report {
    pub(super) fn new(
        run: Run<'_>,
        meshed: &Meshed,
        one_processor: u64,
        hash: &str,
        points: usize,
    ) -> Self {
        let s = &meshed.summary;
        let all = s.all_messages();
        let mesh = &meshed.gathered.mesh;
        Self {
            schema: crate::report::Report::SCHEMA,
            command: "simulate",
            input: Input {
                kind: run.args.kind.name(),
                points,
                duplicates: meshed.gathered.duplicates.len(),
            },
            mesh: Mesh {
                tets: mesh.num_tets(),
                hull_faces: mesh.num_hull_faces(),
                hash: hash.to_owned(),
            },
            simulation: Simulation {
                lt: s.lt(),
                lt_strict: s.lt_strict(),
                setbacks: s.setbacks(),
                operations: s.operations(),
                worst_setbacks: s.worst_setbacks(),
                efficiency: s.efficiency(one_processor),
                makespan: s.makespan,
                one_processor,
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
                successful: s.successful,
                local_active: s.local_active,
                interface_active: s.interface_active,
                set_back: s.set_back,
                surface_to_volume: s.surface_to_volume(),
                imbalance_tets: s.imbalance_tets(),
                events: meshed.events,
                workers: s.workers.clone(),
                cost_model: run.options.costs,
                settings: Settings::new(run),
            },
            outcome: "complete",
        }
    }

    /// The report as JSON text.
    pub(super) fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }
}

impl Settings {
    fn new(run: Run<'_>) -> Self {
        let Run { args, plan, config, options } = run;
        Self {
            processors: plan.workers,
            rule: config.rule.to_string(),
            latency: options.network.latency,
            distribution: options.network.distribution.name(),
            byte: options.network.byte,
            seed: options.seed,
            window: config.window,
            cursors: plan.cursors,
            blocks_per_worker: plan.blocks_per_worker,
            sample: plan.sample,
            slow: args.slow,
            storm: args.storm,
            balance: options.balance.is_some(),
        }
    }
}
