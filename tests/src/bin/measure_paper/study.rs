//! The study that the paper leaves to another one: setbacks as a function of concurrency, of the
//! surface of submeshes, of latency, and of polling; of the order of insertion and of the function
//! that places points (its section 2), too.

use crate::Failure;
use crate::chart::{Series, lines};
use crate::estimate::Work;
use crate::programs::{Plan, Programs, number};
use crate::table::{Block, Picture, Table, cells, of_nanos, percent};

/// A factor, and the values that it takes while all others are as usual.
struct Factor {
    name: &'static str,
    option: &'static str,
    values: &'static [&'static str],
}

const FACTORS: [Factor; 6] = [
    Factor {
        name: "operations at a time",
        option: "--window",
        values: &["1", "2", "4", "16", "64", "256"],
    },
    Factor { name: "processors", option: "--processors", values: &["2", "4", "8", "16", "32"] },
    Factor { name: "latency", option: "--latency", values: &["0", "10us", "100us", "1ms", "10ms"] },
    Factor {
        name: "cavities between two looks for messages",
        option: "--poll-every",
        values: &["1", "2", "4", "8"],
    },
    Factor {
        name: "order of insertion",
        option: "--order",
        values: &["largest", "smallest", "oldest", "newest"],
    },
    Factor {
        name: "place of points from the centre towards the shortest edge",
        option: "--towards",
        values: &["0", "0.1", "0.2", "0.25"],
    },
];

/// The rules for a request that meets a lock.
const RULES: [(&str, &str); 2] = [("wound-wait", "ours"), ("paper", "the paper's rule")];

/// The work of the study.
pub(crate) fn work(plan: &Plan) -> Work {
    let values: usize = FACTORS.iter().map(|factor| factor.values.len()).sum();
    Work::simulated(RULES.len() * values, plan.study.millions())
}

pub(crate) fn tables(programs: &Programs) -> Result<Vec<Block>, Failure> {
    let mut blocks = Vec::new();
    for Factor { name, option, values } in FACTORS {
        let mut rows = Vec::new();
        let mut series = Vec::new();
        for (rule, words) in RULES {
            let mut line = Series { name: words.to_owned(), values: Vec::new() };
            for value in values {
                let mut options = vec!["--machine", "cow", "--rule", rule, option, value];
                if option != "--processors" {
                    options.extend(["--processors", "16"]);
                }
                let report = programs.simulated(programs.plan.study, &options)?;
                let of = |name| number(&report, &["simulation", name]);
                let share = of("setbacks")? / of("operations")?.max(1.0);
                line.values.push(100.0 * share);
                let worst = number(&report, &["simulation", "worst", "lt"]);
                rows.push(vec![
                    format!("simulated, {words}: {value}"),
                    percent(share),
                    format!("{:.0}", of("worst_setbacks")?),
                    worst.map_or("-".to_owned(), |lt| format!("{lt:.3}")),
                    format!("{:.3}", of("surface_to_volume")?),
                    format!("{:.0}", number(&report, &["mesh", "tets"])?),
                    of_nanos(of("makespan")?),
                    percent(of("efficiency")?),
                ]);
            }
            series.push(line);
        }
        let head = [
            name,
            "setbacks per cavity",
            "most of one",
            "LT, worst",
            "surface to volume",
            "tetrahedra",
            "kernel, s",
            "efficiency",
        ];
        blocks.push(Block::Table(Table {
            title: format!("Setbacks by {name}"),
            head: cells(head),
            rows,
            below: format!(
                "Cube-in-cube, {}, without rounds; the paper's machine, 16 processors, 100 µs and \
                 a look after every cavity where nothing else is said.",
                programs.plan.study.size
            ),
        }));
        let columns: Vec<String> = values.iter().map(|value| (*value).to_owned()).collect();
        blocks.push(Block::Picture(Picture {
            title: format!("Setbacks by {name}, percent of the cavities"),
            svg: lines(&columns, &series),
            below: "Simulated.".into(),
        }));
    }
    Ok(blocks)
}
