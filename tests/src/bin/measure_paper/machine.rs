//! Table III: the partitions that each way leaves.

use crate::Failure;
use crate::estimate::Work;
use crate::programs::{Plan, Programs, number};
use crate::table::{Block, Table, cells};
use crate::traditional::{PARTITIONERS, PARTS};

/// The paper's 16 SP nodes, as near as its figures tell: processors as of its workstations on a
/// switch of 150 MB/s.
pub(crate) const SP: [&str; 6] = ["--machine", "cow", "--bandwidth", "1.2", "--latency", "40us"];

/// Processes of the traditional way.
const RANKS: u32 = 2;

/// The work of this table.
pub(crate) fn work(plan: &Plan) -> Work {
    plan.model.iter().map(|own| own.millions()).fold(Work::default(), |sum, millions| {
        let metis = Work { traditional: millions, meshed: millions, ..Work::default() };
        sum + metis + Work::simulated(2, millions)
    })
}

pub(crate) fn partitions(programs: &Programs) -> Result<Vec<Block>, Failure> {
    let mut rows: Vec<Vec<String>> = Vec::new();
    let row = |name: String, surface: f64, imbalance: f64, tets: f64| {
        vec![name, format!("{surface:.3}"), format!("{imbalance:.0}"), format!("{tets:.0}")]
    };
    for &problem in programs.plan.model {
        if let Some(report) = programs.traditional(problem, RANKS, PARTS)? {
            for by in PARTITIONERS {
                let of = |name| number(&report, &[by, name]);
                let name = format!("run on ranks, {}: {by}", problem.size);
                let tets = number(&report, &["tets"])?;
                rows.push(row(name, of("surface_to_volume")?, of("imbalance_tets")?, tets));
            }
        }
        if let Some(report) = programs.parted_anew(problem, PARTS)? {
            let of = |name| number(&report, &["METIS", name]);
            let name = format!("run, {}: METIS on the mesh of workers with blocks", problem.size);
            let tets = number(&report, &["tets"])?;
            rows.push(row(name, of("surface_to_volume")?, of("imbalance_tets")?, tets));
        }
        for (ownership, what) in [
            ("creator", "who creates a tetrahedron owns it (LTBW)"),
            ("block", "by the block of the curve (as SMGP places elements when they are made)"),
        ] {
            let options = [&SP[..], &["--processors", "16", "--ownership", ownership]].concat();
            let report = programs.simulated(problem, &options)?;
            let of = |name| number(&report, &["simulation", name]);
            let name = format!("simulated, {}: {what}", problem.size);
            let tets = number(&report, &["mesh", "tets"])?;
            rows.push(row(name, of("surface_to_volume")?, of("imbalance_tets")?, tets));
        }
    }
    for (name, one, two) in [
        ("traditional (ParMetis)", [".042", "1298"], [".038", "2009"]),
        ("LTBW", [".101", "11194"], [".090", "23059"]),
        ("SMGP", [".064", "3058"], [".061", "6578"]),
        ("SMGP and ParMetis", [".044", "883"], [".037", "1529"]),
    ] {
        rows.push(cells([&format!("the paper's, 1M: {name}"), one[0], one[1], "-"]));
        rows.push(cells([&format!("the paper's, 2M: {name}"), two[0], two[1], "-"]));
    }
    Ok(vec![Block::Table(Table {
        title: "Table III: partitions into 16 parts".into(),
        head: cells(["", "surface to volume, largest", "imbalance, tetrahedra", "tetrahedra"]),
        rows,
        below: "Surface to volume: faces with another part per tetrahedron. SMGP's method is in \
                another paper; blocks of a space-filling curve have its purpose, not its rule. \
                ParMetis is not free: METIS, which is sequential, and PT-Scotch, on two processes, \
                stand for it; the mesh that they part is that of rounds, or as said."
            .into(),
    })])
}
