//! The JSON report of `simulate`: `ltbw.simulation/1`, as `docs/schema/simulation.json` has it.

use super::Simulate;
use crate::figures::Figures;
use crate::outcome::show;
use crate::workers::Redeals;
use ltbw::Mesh;
use ltbw::mesh::Layout;
use ltbw::metrics::Summary;
use ltbw::protocol::Config;
use ltbw::refining::RoundFigures;
use ltbw::simulate::{CostModel, Meshed, Options, Whole};
use serde::Serialize;

/// The options of the run.
#[derive(Clone, Copy)]
pub(super) struct Run<'a> {
    pub(super) args: &'a Simulate,
    pub(super) layout: &'a Layout,
    pub(super) config: &'a Config,
    pub(super) options: &'a Options,
}

/// The report. All times are in nanoseconds of virtual time.
#[derive(Serialize)]
pub(super) struct Report {
    schema: &'static str,
    command: &'static str,
    input: Input,
    mesh: MeshFigures,
    simulation: Simulation,
    outcome: &'static str,
}

#[derive(Serialize)]
struct Input {
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    domain: Option<String>,
    points: usize,
    duplicates: usize,
}

#[derive(Serialize)]
struct MeshFigures {
    tets: usize,
    hull_faces: usize,
    hash: String,
}

#[derive(Serialize)]
struct Simulation {
    #[serde(flatten)]
    figures: Figures,
    efficiency: f64,
    one_processor: u64,
    whole: Option<Whole>,
    events: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    rounds: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    redeals: Option<Redeals>,
    #[serde(skip_serializing_if = "Option::is_none")]
    start: Option<usize>,
    cost_model: CostModel,
    settings: Settings,
}

#[derive(Serialize)]
struct Settings {
    processors: u32,
    rule: String,
    closure: String,
    machine: &'static str,
    ownership: &'static str,
    order: &'static str,
    towards: f64,
    poll_every: u32,
    letters: bool,
    latency: u64,
    distribution: &'static str,
    byte: f64,
    seed: u64,
    window: usize,
    cursors: usize,
    abreast: usize,
    own_curves: bool,
    blocks_per_worker: u32,
    sample: usize,
    slow: Option<f64>,
    storm: Option<u64>,
    balance: bool,
}

/// The run of one processor that a run is compared with.
pub(super) struct Compared {
    /// The time of one processor that does the same work.
    pub(super) one_processor: u64,
    /// The whole run, where there is more than the simulated part.
    pub(super) whole: Option<Whole>,
}

/// The result of a run.
#[derive(Clone, Copy)]
pub(super) struct Made<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) duplicates: usize,
    pub(super) summary: &'a Summary,
    pub(super) events: u64,
}

impl<'a> Made<'a> {
    pub(super) fn of(meshed: &'a Meshed) -> Self {
        let Meshed { gathered, summary, events, .. } = meshed;
        let duplicates = gathered.duplicates.len();
        Self { mesh: &gathered.mesh, duplicates, summary, events: *events }
    }
}

impl Report {
    pub(super) fn new(
        run: Run<'_>,
        made: &Made<'_>,
        Compared { one_processor, whole }: Compared,
        hash: &str,
        points: usize,
    ) -> Self {
        let Made { mesh, duplicates, summary: s, events } = *made;
        Self {
            schema: "ltbw.simulation/1",
            command: "simulate",
            input: Input {
                kind: run.args.domain.as_ref().map_or(run.args.kind.name(), |_| "domain"),
                domain: run.args.domain.as_deref().map(show),
                points,
                duplicates,
            },
            mesh: MeshFigures {
                tets: mesh.num_tets(),
                hull_faces: mesh.num_hull_faces(),
                hash: hash.to_owned(),
            },
            simulation: Simulation {
                figures: Figures::of(s),
                efficiency: s.efficiency(one_processor),
                one_processor,
                whole,
                events,
                rounds: None,
                redeals: None,
                start: None,
                cost_model: run.options.costs,
                settings: Settings::new(run),
            },
            outcome: "complete",
        }
    }

    /// The report of a run in rounds.
    pub(super) fn in_rounds(mut self, figures: &RoundFigures) -> Self {
        self.simulation.rounds = Some(figures.rounds[0]);
        self.simulation.redeals = Redeals::of(figures);
        self
    }

    /// The report of a run that began with a mesh of as many vertices.
    pub(super) fn from(mut self, start: usize) -> Self {
        self.simulation.start = Some(start);
        self
    }

    /// The report as JSON text.
    pub(super) fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }
}

impl Settings {
    fn new(run: Run<'_>) -> Self {
        let Run { args, layout, config, options } = run;
        Self {
            processors: layout.workers,
            rule: config.rule.to_string(),
            closure: config.closure.to_string(),
            machine: args.machine.name(),
            ownership: layout.ownership.name(),
            order: args.order.name(),
            towards: args.towards,
            poll_every: options.poll_every,
            letters: options.letters,
            latency: options.network.latency,
            distribution: options.network.distribution.name(),
            byte: options.network.byte,
            seed: options.seed,
            window: config.window,
            cursors: layout.cursors,
            abreast: layout.max_in_flight,
            own_curves: layout.own_curves,
            blocks_per_worker: layout.blocks_per_worker,
            sample: layout.sample,
            slow: args.slow,
            storm: args.storm,
            balance: options.balance.is_some(),
        }
    }
}
