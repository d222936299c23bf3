//! Tables IV to VI: cavities, latency tolerance, polling; for the processors that the paper shows.

use crate::Failure;
use crate::estimate::Work;
use crate::programs::{Plan, Programs, number, workers};
use crate::table::{Block, Table, cells, of_nanos, percent, seconds};
use serde_json::Value;

/// The rules for a request that meets a lock: ours, and the paper's.
const RULES: [(&str, &str); 2] = [("wound-wait", "ours"), ("paper", "the paper's rule")];

/// Processes that are run.
const RANKS: u32 = 2;

/// A simulated run.
struct Run {
    name: String,
    report: Value,
}

/// The times of a run, in nanoseconds.
#[derive(Clone, Copy)]
struct Spent {
    /// The kernel's.
    makespan: f64,
    /// With the start and the end, on one processor, and the ways there and back.
    whole: f64,
}

/// A figure of a worker in a run.
type Figure = fn(&Value, Spent) -> Result<String, Failure>;

/// A row: what it is, the figure of a worker, and the paper's figures.
struct Row<const N: usize> {
    name: &'static str,
    figure: Figure,
    paper: [&'static str; N],
}

/// The work of these tables.
pub(crate) fn work(plan: &Plan) -> Work {
    let runs = plan.cubes.iter().map(|own| Work::simulated(RULES.len(), own.millions()));
    let ranked = Work { meshed: plan.ranked.millions(), ..Work::default() };
    runs.fold(ranked, |sum, own| sum + own)
}

pub(crate) fn tables(programs: &Programs) -> Result<Vec<Block>, Failure> {
    let mut runs = Vec::new();
    for &problem in programs.plan.cubes {
        for (rule, words) in RULES {
            let options = ["--machine", "cow", "--processors", "32", "--rule", rule];
            let report = programs.simulated(problem, &options)?;
            let name = format!("{}, {words}", problem.size);
            runs.push(Run { name, report });
        }
    }
    let machine = "Simulated: cube-in-cube without rounds on 32 processors of the paper's machine \
                   (2.4 ms a cavity, 33 µs a look for messages, also while there is nothing to \
                   do, 146 µs a message, 100 Mbit/s, and 100 µs of latency, which the paper does \
                   not give).";
    let simulated = [table_4(&runs, machine)?, table_5(&runs, machine)?, table_6(&runs, machine)?];
    Ok(simulated.into_iter().chain(on_ranks(programs)?).map(Block::Table).collect())
}

/// The figures of ranks on this machine; none where there is no MPI.
fn on_ranks(programs: &Programs) -> Result<Option<Table>, Failure> {
    let problem = programs.plan.ranked;
    let report = programs.on_ranks(problem, RANKS, &["--mode", "async"])?;
    let Some(report) = report else { return Ok(None) };
    let whole = number(&report, &["seconds", "refine"])?;
    let workers = report.get("workers").and_then(Value::as_array).ok_or("no workers")?;
    let mut rows = Vec::new();
    for (rank, worker) in workers.iter().enumerate() {
        let of = |name| number(worker, &[name]);
        let polls = worker.get("polls").ok_or("no polls")?;
        let polls = |k: usize| polls.get(k).and_then(Value::as_f64).ok_or("no polls");
        let (all, interface) = (of("local")? + of("operations")?, of("interface")?);
        rows.push(vec![
            format!("run on ranks, {}: rank {rank}", problem.size),
            format!("{:.0}", all - interface),
            format!("{interface:.0}"),
            format!("{:.0}", of("setbacks")?),
            percent(of("setbacks")? / all.max(1.0)),
            format!("{:.0}", polls(0)?),
            percent(polls(1)? / polls(0)?.max(1.0)),
            format!("{:.0}", of("messages")?),
            seconds(whole),
        ]);
    }
    let name = format!("{RANKS} ranks");
    let head = [
        &name,
        "local cavities",
        "at the interface",
        "set back",
        "per cavity",
        "polls",
        "of them useful",
        "messages",
        "whole, s",
    ];
    Ok(Some(Table {
        title: "Tables IV to VI on ranks".into(),
        head: cells(head),
        rows,
        below: "Run: cube-in-cube without rounds, our rule; start and end are in the time. Shares \
                of time are simulated alone: on a machine that others use a clock tells little."
            .into(),
    }))
}

/// The workers with the smallest and the largest of a figure.
fn extremes(run: &Run, by: impl Fn(&Value) -> Option<f64>) -> Result<[&Value; 2], Failure> {
    let mut known: Vec<(f64, &Value)> =
        workers(&run.report)?.iter().filter_map(|own| Some((by(own)?, own))).collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    match (known.first(), known.last()) {
        (Some(least), Some(most)) => Ok([least.1, most.1]),
        _ => Err(format!("{}: no worker has the figure", run.name).into()),
    }
}

/// A table of some rows, for two workers of each run.
fn table<const N: usize>(
    runs: &[Run],
    words: [&str; 2],
    by: fn(&Value) -> Option<f64>,
    rows: &[Row<N>],
    paper: [&str; N],
) -> Result<(Vec<String>, Vec<Vec<String>>), Failure> {
    let mut head = vec![String::new()];
    let mut body: Vec<Vec<String>> = rows.iter().map(|row| vec![row.name.to_owned()]).collect();
    for run in runs {
        let spent = Spent {
            makespan: number(&run.report, &["simulation", "makespan"])?,
            whole: number(&run.report, &["simulation", "whole", "makespan"])?,
        };
        for (worker, word) in extremes(run, by)?.into_iter().zip(words) {
            head.push(format!("simulated, {}: {word}", run.name));
            for (row, own) in rows.iter().zip(&mut body) {
                own.push((row.figure)(worker, spent)?);
            }
        }
    }
    head.extend(paper.map(|name| format!("the paper's, {name}")));
    for (row, own) in rows.iter().zip(&mut body) {
        own.extend(row.paper.map(str::to_owned));
    }
    Ok((head, body))
}

fn lt(worker: &Value) -> Option<f64> {
    worker.get("lt").and_then(Value::as_f64)
}

fn useful_share(worker: &Value) -> Option<f64> {
    let of = |name| worker.get("polls")?.get(name)?.as_f64();
    Some(of("useful_time")? / of("total_time")?.max(1.0))
}

macro_rules! count {
    ($($way:literal).+) => {
        |worker, _| Ok(format!("{:.0}", number(worker, &[$($way),+])?))
    };
}

macro_rules! time {
    ($($way:literal).+) => {
        |worker, _| Ok(of_nanos(number(worker, &[$($way),+])?))
    };
}

fn table_4(runs: &[Run], machine: &str) -> Result<Table, Failure> {
    let rows = [
        Row {
            name: "local, none active",
            figure: count!("cavities"."local"),
            paper: ["32840", "29826"],
        },
        Row {
            name: "local, some active",
            figure: count!("cavities"."local_active"),
            paper: ["44800", "43444"],
        },
        Row {
            name: "interface, none other active",
            figure: count!("cavities"."interface"),
            paper: ["2893", "2907"],
        },
        Row {
            name: "interface, some active",
            figure: count!("cavities"."interface_active"),
            paper: ["17684", "17588"],
        },
        Row {
            name: "share while some active",
            figure: |worker, _| {
                let of = |name| number(worker, &["cavities", name]);
                let active = of("local_active")? + of("interface_active")?;
                Ok(percent(active / (active + of("local")? + of("interface")?).max(1.0)))
            },
            paper: ["63.6 %", "65.1 %"],
        },
    ];
    let paper = ["16M: lowest LT", "16M: highest LT"];
    let (head, rows) = table(runs, ["lowest LT", "highest LT"], lt, &rows, paper)?;
    let below = format!("{machine} Of the processors that tolerate latency least and best.");
    Ok(Table { title: "Table IV: completed cavities".into(), head, rows, below })
}

fn table_5(runs: &[Run], machine: &str) -> Result<Table, Failure> {
    let rows = [
        Row {
            name: "run time, s",
            figure: |_, spent| Ok(of_nanos(spent.makespan)),
            paper: ["201.30", "388.36"],
        },
        Row {
            name: "whole, with start and end, s",
            figure: |_, spent| Ok(of_nanos(spent.whole)),
            paper: ["-", "-"],
        },
        Row {
            name: "M, in cavities that succeeded, s",
            figure: time!("cavity_times"."successful"),
            paper: ["107.37", "235.45"],
        },
        Row {
            name: "A, of it local, while a cavity was active, s",
            figure: time!("cavity_times"."local_active"),
            paper: ["54.78", "107.40"],
        },
        Row {
            name: "I, of it interface, while one was active, s",
            figure: time!("cavity_times"."interface_active"),
            paper: ["41.43", "42.39"],
        },
        Row {
            name: "S, in cavities that were set back, s",
            figure: time!("cavity_times"."set_back"),
            paper: ["4.18", "9.98"],
        },
        Row {
            name: "latency tolerance, (A + I) / (A + I + S)",
            figure: |worker, _| Ok(format!("{:.3}", number(worker, &["lt"])?)),
            paper: ["0.96", "0.94"],
        },
        Row {
            name: "the same with time counted in which nothing could be done",
            figure: |worker, _| Ok(format!("{:.3}", number(worker, &["lt_strict"])?)),
            paper: ["-", "-"],
        },
    ];
    let paper = ["8M: lowest LT", "16M: lowest LT"];
    let (head, rows) = table(runs, ["lowest LT", "highest LT"], lt, &rows, paper)?;
    let below = format!(
        "{machine} Run times are the kernel's, without the start and the end, and with them: those \
         are one processor's."
    );
    Ok(Table { title: "Table V: latency tolerance".into(), head, rows, below })
}

fn table_6(runs: &[Run], machine: &str) -> Result<Table, Failure> {
    let rows = [
        Row {
            name: "run time, s",
            figure: |_, spent| Ok(of_nanos(spent.makespan)),
            paper: ["201.30", "201.30", "388.26", "388.35"],
        },
        Row {
            name: "nothing to do after the last insertion, s",
            figure: time!("times"."idle_at_end"),
            paper: ["33.95", "2.51", "49.38", "4.93"],
        },
        Row {
            name: "polling, s",
            figure: time!("polls"."total_time"),
            paper: ["58.63", "57.75", "93.15", "102.30"],
        },
        Row {
            name: "of it useful, s",
            figure: time!("polls"."useful_time"),
            paper: ["30.11", "53.95", "51.19", "94.10"],
        },
        Row {
            name: "in vain, of the run time",
            figure: |worker, spent| {
                let of = |name| number(worker, &["polls", name]);
                Ok(percent((of("total_time")? - of("useful_time")?) / spent.makespan.max(1.0)))
            },
            paper: ["14.2 %", "1.9 %", "10.8 %", "2.1 %"],
        },
        Row {
            name: "polls",
            figure: count!("polls"."total"),
            paper: ["861388", "157744", "1330290", "289530"],
        },
        Row {
            name: "of them useful",
            figure: count!("polls"."useful"),
            paper: ["43292", "50546", "71205", "91451"],
        },
        Row {
            name: "messages taken",
            figure: count!("received"),
            paper: ["200684", "380254", "343375", "643776"],
        },
    ];
    let paper = ["8M: least useful", "8M: most useful", "16M: least useful", "16M: most useful"];
    let words = ["least useful", "most useful"];
    let (head, rows) = table(runs, words, useful_share, &rows, paper)?;
    let below = format!(
        "{machine} The time of a useful look here is that of the look alone; the paper's has the \
         handling of what was found in it, and a poll of the paper may take several messages."
    );
    Ok(Table { title: "Table VI: polling".into(), head, rows, below })
}
