//! Tables I and II: the traditional way beside a mesh that is made where it stays.

use crate::Failure;
use crate::estimate::Work;
use crate::programs::{Plan, Problem, Programs, number};
use crate::table::{Block, Table, cells, seconds};
use ltbw_tests::median;

/// Runs of each, one after the other in turn.
const RUNS: usize = 3;
/// Parts, as the paper's processors.
pub(crate) const PARTS: u32 = 16;
/// The partitioners of the traditional way, as its report names them.
pub(crate) const PARTITIONERS: [&str; 2] = ["METIS", "PT-Scotch"];
/// Workers that share nothing, as many as cores: up to these.
const MOST_WORKERS: usize = 16;

/// The seconds of one problem, medians of runs in turn.
struct Taken {
    problem: Problem,
    tets: f64,
    /// Of the traditional way, what all partitioners share: generate, write, read, graph.
    first: [f64; 4],
    /// Of each partitioner: partition, deal.
    then: [[f64; 2]; PARTITIONERS.len()],
    /// Of workers that make the parts in place, and of ranks of an MPI.
    ours: f64,
    on_ranks: f64,
}

impl Taken {
    /// The whole time of the traditional way with a partitioner.
    fn traditional(&self, then: &[f64; 2]) -> f64 {
        self.first.iter().chain(then).sum()
    }
}

const FIRST: [&str; 4] = ["generate", "write", "read", "graph"];
const THEN: [&str; 2] = ["partition", "deal"];

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
    let ranks = u32::try_from(workers)?;
    // Runs of each step, in the order of the two lists.
    let mut first = FIRST.map(|_| Vec::new());
    let mut then = PARTITIONERS.map(|_| THEN.map(|_| Vec::new()));
    let (mut ours, mut on_ranks, mut tets) = (Vec::new(), Vec::new(), 0.0);
    for _ in 0..RUNS {
        let Some(report) = programs.traditional(problem, ranks, PARTS)? else { return Ok(None) };
        for (name, list) in FIRST.iter().zip(&mut first) {
            list.push(number(&report, &[name])?);
        }
        for (by, lists) in PARTITIONERS.iter().zip(&mut then) {
            for (name, list) in THEN.iter().zip(lists) {
                list.push(number(&report, &[by, name])?);
            }
        }
        tets = number(&report, &["tets"])?;
        let report = programs.meshed(problem, &["--workers", &workers.to_string()])?;
        if number(&report, &["mesh", "tets"])? != tets {
            return Err("workers have made another mesh".into());
        }
        ours.push(number(&report, &["seconds", "refine"])?);
        let Some(report) = programs.on_ranks(problem, ranks, &[])? else { return Ok(None) };
        if number(&report, &["mesh", "tets"])? != tets {
            return Err("ranks have made another mesh".into());
        }
        on_ranks.push(number(&report, &["seconds", "refine"])?);
    }
    let first = first.map(|mut list| median(&mut list));
    let then = then.map(|lists| lists.map(|mut list| median(&mut list)));
    let (ours, on_ranks) = (median(&mut ours), median(&mut on_ranks));
    Ok(Some(Taken { problem, tets, first, then, ours, on_ranks }))
}

fn table_1(all: &[Taken]) -> Table {
    let mut rows: Vec<Vec<String>> = all
        .iter()
        .flat_map(|own| PARTITIONERS.iter().zip(&own.then).map(move |(by, then)| (own, by, then)))
        .map(|(own, by, then)| {
            let [generate, write, read, graph] = own.first;
            let [partition, deal] = *then;
            let name = [format!("run on ranks, {} ({:.0}): {by}", own.problem.size, own.tets)];
            let steps = [generate, graph, write + read, partition, deal, own.traditional(then)];
            name.into_iter().chain(steps.map(seconds)).collect()
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
            "Run on as many ranks as in Table II: cube with an octahedral hole, medians of {RUNS}, \
             seconds of the clock. What is sequential is the first process's, METIS's k-way \
             partition into {PARTS} parts, too; PT-Scotch's is of all processes, with the way of \
             the graph to them in it (the paper: ParMetis on 16 SP processors). Parts go to the \
             processes in turn, which number their vertices anew (data movement)."
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
            let whole = own.then.iter().map(|then| own.traditional(then));
            let by_both = PARTITIONERS.iter().zip(whole);
            by_both.flat_map(move |(by, whole)| {
                let of = |name, ours| row(name, [own.first[0], whole, ours]);
                [
                    of(format!("run, {size} on {workers} workers; {by}"), own.ours),
                    of(format!("run on ranks, {size} on {workers}; {by}"), own.on_ranks),
                ]
            })
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
