//! Tables I and II: the traditional way beside a mesh that is made where it stays.

use crate::Failure;
use crate::estimate::Work;
use crate::programs::{Plan, Problem, Programs, number};
use crate::table::{Block, Table, cells, seconds};
use ltbw_tests::median;
use serde_json::Value;

/// Runs of each, one after the other in turn.
const RUNS: usize = 3;
/// Parts, as the paper's processors.
const PARTS: u32 = 16;
/// Workers that share nothing, as many as cores: up to these.
const MOST_WORKERS: usize = 16;

/// The seconds of one problem, medians of runs in turn.
struct Taken {
    problem: Problem,
    tets: f64,
    /// Of the traditional way: generate, write, read, graph, partition, deal.
    steps: [f64; 6],
    /// Of workers that make the parts in place, and of ranks of an MPI, if one is here.
    ours: f64,
    on_ranks: Option<f64>,
}

impl Taken {
    fn traditional(&self) -> f64 {
        self.steps.iter().sum()
    }
}

const STEPS: [&str; 6] = ["generate", "write", "read", "graph", "partition", "deal"];

/// The work of these tables.
pub(crate) fn work(plan: &Plan) -> Work {
    let millions: f64 = plan.model.iter().map(|own| own.millions()).sum();
    let own = RUNS as f64 * millions;
    Work { traditional: own, meshed: 2.0 * own, ..Work::default() }
}

pub(crate) fn tables(programs: &Programs) -> Result<Vec<Block>, Failure> {
    let workers = std::thread::available_parallelism()?.get().clamp(2, MOST_WORKERS);
    let mut all = Vec::new();
    for &problem in programs.plan.model {
        match taken(programs, problem, workers)? {
            Some(taken) => all.push(taken),
            None => return Ok(Vec::new()),
        }
    }
    Ok(vec![Block::Table(table_1(&all)), Block::Table(table_2(&all, workers))])
}

fn taken(programs: &Programs, problem: Problem, workers: usize) -> Result<Option<Taken>, Failure> {
    let (mut steps, mut tets) = (vec![Vec::new(); STEPS.len()], 0.0);
    let (mut ours, mut on_ranks) = (Vec::new(), Vec::new());
    for _ in 0..RUNS {
        let Some(report) = programs.traditional(problem, PARTS)? else { return Ok(None) };
        for (name, list) in STEPS.iter().zip(&mut steps) {
            list.push(clock(&report, name)?);
        }
        tets = number(&report, &["tets"])?;
        let report = programs.meshed(problem, &["--workers", &workers.to_string()])?;
        if number(&report, &["mesh", "tets"])? != tets {
            return Err("workers have made another mesh".into());
        }
        ours.push(number(&report, &["seconds", "refine"])?);
        let Some(report) = programs.on_ranks(problem, workers as u32)? else { continue };
        if number(&report, &["mesh", "tets"])? != tets {
            return Err("ranks have made another mesh".into());
        }
        on_ranks.push(number(&report, &["seconds", "refine"])?);
    }
    let mut medians = [0.0; 6];
    for (value, list) in medians.iter_mut().zip(&mut steps) {
        *value = median(list);
    }
    let on_ranks = (!on_ranks.is_empty()).then(|| median(&mut on_ranks));
    Ok(Some(Taken { problem, tets, steps: medians, ours: median(&mut ours), on_ranks }))
}

/// The seconds of a step on the clock.
fn clock(report: &Value, name: &str) -> Result<f64, Failure> {
    let steps = report.get("steps").and_then(Value::as_array).ok_or("a report without steps")?;
    let step = steps.iter().find(|step| step.get("name").is_some_and(|own| own == name));
    number(step.ok_or_else(|| format!("a report without {name}"))?, &["clock"])
}

fn table_1(all: &[Taken]) -> Table {
    let mut rows: Vec<Vec<String>> = all
        .iter()
        .map(|own| {
            let [generate, write, read, graph, partition, deal] = own.steps;
            let first = [format!("run, {} ({:.0})", own.problem.size, own.tets)];
            let steps = [generate, graph, write + read, partition, deal, own.traditional()];
            first.into_iter().chain(steps.map(seconds)).collect()
        })
        .collect();
    rows.push(cells(["the paper's, 1M", "255.9", "24.28", "217.8", "5.46", "85.0", "588.5"]));
    rows.push(cells(["the paper's, 2M", "461.8", "50.53", "471.0", "8.58", "173.3", "1165.2"]));
    let head = [
        "seconds",
        "sequential generation",
        "graph",
        "write and read",
        "partition",
        "data movement",
        "total",
    ];
    Table {
        title: "Table I: the traditional way".into(),
        head: cells(head),
        rows,
        below: format!(
            "Run: cube with an octahedral hole, one thread, medians of {RUNS}, seconds of the \
             clock; METIS k-way into {PARTS} parts (the paper: ParMetis on 16 SP processors), a \
             thread for each part, which numbers its vertices anew (data movement)."
        ),
    }
}

fn table_2(all: &[Taken], workers: usize) -> Table {
    let row = |name: String, [alone, whole, ours]: [f64; 3]| {
        let times = format!("{:.1}", whole / ours);
        vec![name, seconds(alone), seconds(whole), seconds(ours), times]
    };
    let mut rows: Vec<Vec<String>> = all
        .iter()
        .flat_map(|own| {
            let size = own.problem.size;
            let by = |name, ours| row(name, [own.steps[0], own.traditional(), ours]);
            let ranks =
                own.on_ranks.map(|ours| by(format!("run on ranks, {size} on {workers}"), ours));
            [by(format!("run, {size} on {workers} workers"), own.ours)].into_iter().chain(ranks)
        })
        .collect();
    let paper = [
        ("LTBW, 1M", [255.9, 588.5, 38.63]),
        ("SMGP, 1M", [255.9, 588.5, 71.10]),
        ("LTBW, 2M", [461.8, 1165.2, 85.15]),
        ("SMGP, 2M", [461.8, 1165.2, 87.46]),
    ];
    rows.extend(paper.map(|(name, times)| row(format!("the paper's {name} on 16"), times)));
    Table {
        title: "Table II: whole times".into(),
        head: cells(["seconds", "sequential", "traditional", "in place", "traditional / in place"]),
        rows,
        below:
            "In place: from the domain to parts that stay where they are, by workers that share \
                nothing, threads of one program or processes of an MPI on this machine (ranks); \
                the start and the end are in it. The paper has 16 processors: with fewer the \
                sequential part, which is most of the traditional way, counts for less."
                .into(),
    }
}
