//! Figures 5 and 7: the shares of the processors' time and of their cavities, and times over
//! processors.

use crate::Failure;
use crate::chart::{Series, lines, stacked};
use crate::estimate::Work;
use crate::machine::SP;
use crate::programs::{Plan, Problem, Programs, number, workers};
use crate::table::{Block, Picture, Table, cells, of_nanos, percent, seconds};
use serde_json::Value;

/// The processors of Figure 5, and those of them that are run, as ranks.
const PROCESSORS: [u32; 5] = [1, 2, 4, 8, 16];
const RANKS: [u32; 2] = [1, 2];
/// The ways to own a tetrahedron, by the paper's names.
const WAYS: [(&str, &str); 2] = [("creator", "LTBW"), ("block", "by blocks (SMGP)")];

/// A simulated run on some processors.
fn run(
    programs: &Programs,
    problem: Problem,
    processors: u32,
    ownership: &str,
) -> Result<Value, Failure> {
    let count = processors.to_string();
    let own = ["--processors", &count, "--ownership", ownership];
    programs.simulated(problem, &[&SP[..], &own].concat())
}

/// Simulated runs of some problems.
fn simulated(runs: usize, problems: &[Problem]) -> Work {
    let all = problems.iter().map(|own| Work::simulated(runs, own.millions()));
    all.fold(Work::default(), |sum, own| sum + own)
}

/// The work of Figure 5.
pub(crate) fn work_over_processors(plan: &Plan) -> Work {
    let millions: f64 = plan.scaling.iter().map(|own| own.millions()).sum();
    let ranks = Work { meshed: RANKS.len() as f64 * millions, ..Work::default() };
    simulated(WAYS.len() * PROCESSORS.len(), plan.scaling) + ranks
}

/// The work of Figure 7.
pub(crate) fn work_of_cavities(plan: &Plan) -> Work {
    simulated(1, plan.tee)
}

/// Shares of the time on 16 processors, and whole times over processors.
pub(crate) fn over_processors(programs: &Programs) -> Result<Vec<Block>, Failure> {
    const PARTS: [(&str, &[&str]); 4] = [
        ("computation", &["meshing"]),
        ("communication", &["communication", "polling"]),
        ("load balancing", &["balancing"]),
        ("idle", &["idle"]),
    ];
    let mut shares: Vec<Series> = PARTS
        .map(|(name, _)| Series { name: name.to_owned(), values: Vec::new() })
        .into_iter()
        .collect();
    let (mut columns, mut rows, mut times) = (Vec::new(), Vec::new(), Vec::new());
    for &problem in programs.plan.scaling {
        for (ownership, name) in WAYS {
            let mut line = Series { name: format!("{}, {name}", problem.size), values: Vec::new() };
            for processors in PROCESSORS {
                let report = run(programs, problem, processors, ownership)?;
                let whole = number(&report, &["simulation", "whole", "makespan"])?;
                line.values.push(whole * 1e-9);
                if processors != 16 || ownership != "creator" {
                    continue;
                }
                let all = number(&report, &["simulation", "makespan"])? * 16.0;
                let mut row = vec![format!("simulated, {}", problem.size)];
                for ((_, names), own) in PARTS.iter().zip(&mut shares) {
                    let of = |name: &&str| number(&report, &["simulation", "times", name]);
                    let sum: f64 = names.iter().map(of).sum::<Result<f64, _>>()?;
                    own.values.push(100.0 * sum / all);
                    row.push(percent(sum / all));
                }
                row.push(of_nanos(all / 16.0));
                row.push(of_nanos(whole));
                columns.push(problem.size.to_owned());
                rows.push(row);
            }
            times.push(line);
        }
    }
    for (size, share) in [("0.5M", "33 %"), ("1M", "31 %"), ("2M", "26 %")] {
        let name = format!("the paper's, {size}");
        rows.push(cells([&name, "-", share, "5 to 6 %", "-", "-", "-"]));
    }
    let head = [
        "16 processors",
        "computation",
        "communication",
        "load balancing",
        "idle",
        "kernel, s",
        "whole, s",
    ];
    let left = Table {
        title: "Figure 5, left: shares of the processors' time".into(),
        head: cells(head),
        rows,
        below:
            "Model problem without rounds, who creates a tetrahedron owns it. Looking for messages \
                is communication. No block moves."
                .into(),
    };
    let picture = Picture {
        title: "Figure 5, left, in percent".into(),
        svg: stacked(&columns, &shares),
        below: "Simulated; 16 processors.".into(),
    };
    let names: Vec<String> = PROCESSORS.map(|p| p.to_string()).to_vec();
    let mut rows: Vec<Vec<String>> = times
        .iter()
        .map(|line| {
            let first = std::iter::once(format!("simulated, {}", line.name));
            first.chain(line.values.iter().map(|own| seconds(*own))).collect()
        })
        .collect();
    for &problem in programs.plan.scaling {
        rows.extend(run_on_ranks(programs, problem)?);
    }
    let right = Table {
        title: "Figure 5, right: whole times over processors".into(),
        head: std::iter::once("seconds".to_owned()).chain(names.iter().cloned()).collect(),
        rows,
        below:
            "Start and end on one processor, distribution and gathering are in them. The paper has \
                a picture alone; it calls its speed-up O(log P). Processors that are run are \
                today's, ranks on this machine, and tetrahedra their new points' blocks'."
                .into(),
    };
    let below = "Simulated; seconds over processors.".into();
    let over = Picture { title: "Figure 5, right".into(), svg: lines(&names, &times), below };
    Ok(vec![Block::Table(left), Block::Picture(picture), Block::Table(right), Block::Picture(over)])
}

/// The row of a problem that is run on ranks, without rounds; none where there is no MPI.
fn run_on_ranks(programs: &Programs, problem: Problem) -> Result<Option<Vec<String>>, Failure> {
    let mut row = vec![format!("run on ranks, {}", problem.size)];
    for ranks in PROCESSORS {
        if !RANKS.contains(&ranks) {
            row.push("-".to_owned());
            continue;
        }
        let Some(report) = programs.on_ranks(problem, ranks, &["--mode", "async"])? else {
            return Ok(None);
        };
        row.push(seconds(number(&report, &["seconds", "refine"])?));
    }
    Ok(Some(row))
}

/// Shares of cavities by kind, with setbacks and services, of the tee on 16 processors.
pub(crate) fn of_cavities(programs: &Programs) -> Result<Vec<Block>, Failure> {
    const KINDS: [(&str, &[&str]); 6] = [
        ("local, none active", &["cavities", "local"]),
        ("local, some active", &["cavities", "local_active"]),
        ("interface, none other", &["cavities", "interface"]),
        ("interface, some active", &["cavities", "interface_active"]),
        ("setbacks", &["setbacks"]),
        ("services to others", &["services"]),
    ];
    let mut blocks = Vec::new();
    for &problem in programs.plan.tee {
        let report = run(programs, problem, 16, "creator")?;
        let all = workers(&report)?;
        let mut series: Vec<Series> = KINDS
            .iter()
            .map(|(name, _)| Series { name: (*name).to_owned(), values: Vec::new() })
            .collect();
        let mut sums = [0.0; KINDS.len()];
        for worker in all {
            let mut counts = [0.0; KINDS.len()];
            for ((_, way), count) in KINDS.iter().zip(&mut counts) {
                *count = number(worker, way)?;
            }
            let whole: f64 = counts.iter().sum();
            for ((own, count), sum) in series.iter_mut().zip(counts).zip(&mut sums) {
                own.values.push(100.0 * count / whole.max(1.0));
                *sum += count;
            }
        }
        let columns: Vec<String> = (0..all.len()).map(|k| k.to_string()).collect();
        let whole: f64 = sums.iter().sum();
        let mut row = vec![format!("simulated, {}, all 16", problem.size)];
        row.extend(sums.map(|sum| percent(sum / whole.max(1.0))));
        blocks.push(Block::Table(Table {
            title: format!("Figure 7: cavities, setbacks and services, tee, {}", problem.size),
            head: std::iter::once(String::new())
                .chain(KINDS.iter().map(|(name, _)| (*name).to_owned()))
                .collect(),
            rows: vec![row],
            below: "The picture is on the page, by processor; the paper has a picture alone."
                .into(),
        }));
        blocks.push(Block::Picture(Picture {
            title: format!("Figure 7, tee, {}, in percent", problem.size),
            svg: stacked(&columns, &series),
            below: "Simulated; each of 16 processors.".into(),
        }));
    }
    Ok(blocks)
}
