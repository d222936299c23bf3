//! Figure 6: dihedral angles of the gear, by one thread, by workers in rounds, and by workers
//! without.

use crate::Failure;
use crate::chart::{Series, lines};
use crate::estimate::Work;
use crate::programs::{Plan, Programs, number};
use crate::table::{Block, Picture, Table, cells, percent};
use serde_json::Value;

/// Angles below and above which the shares of dihedral angles are told.
const SMALL: f64 = 20.0;
const LARGE: f64 = 140.0;

/// The work of this figure.
pub(crate) fn work(plan: &Plan) -> Work {
    Work { meshed: 3.0 * plan.gear.millions(), ..Work::default() }
}

pub(crate) fn figure(programs: &Programs) -> Result<Vec<Block>, Failure> {
    let ways: [(&str, &[&str]); 3] = [
        ("one thread", &["--threads", "1"]),
        ("2 workers in rounds", &["--workers", "2"]),
        ("2 workers without rounds", &["--workers", "2", "--mode", "async"]),
    ];
    let (mut series, mut rows, mut hashes) = (Vec::new(), Vec::new(), Vec::new());
    let mut columns = Vec::new();
    for (name, options) in ways {
        let report = programs.meshed(programs.plan.gear, options)?;
        let histogram = report.get("quality").and_then(|own| own.get("dihedral"));
        let histogram = histogram.ok_or("a report has no dihedral angles")?;
        let counts: Vec<f64> = histogram
            .get("counts")
            .and_then(Value::as_array)
            .ok_or("a histogram has no counts")?
            .iter()
            .filter_map(Value::as_f64)
            .collect();
        let (low, high) = (number(histogram, &["low"])?, number(histogram, &["high"])?);
        let step = (high - low) / counts.len().max(1) as f64;
        let all: f64 = counts.iter().sum();
        let share = |is_in: &dyn Fn(f64) -> bool| {
            let own =
                counts.iter().enumerate().filter(|(k, _)| is_in(low + step * (*k as f64 + 0.5)));
            own.map(|(_, count)| count).sum::<f64>() / all.max(1.0)
        };
        rows.push(vec![
            format!("run, {name}"),
            format!("{:.0}", number(&report, &["mesh", "tets"])?),
            format!("{:.2}", number(histogram, &["least", "value"])?),
            percent(share(&|angle| angle < SMALL)),
            percent(share(&|angle| angle > LARGE)),
            format!("{:.2}", number(histogram, &["largest", "value"])?),
        ]);
        columns = (0..counts.len()).map(|k| format!("{:.0}", low + step * k as f64)).collect();
        let values = counts.iter().map(|count| 100.0 * count / all.max(1.0)).collect();
        series.push(Series { name: name.to_owned(), values });
        let hash = report.get("mesh").and_then(|own| own.get("hash")).cloned();
        hashes.push(hash.ok_or("a report has no hash")?);
    }
    if hashes[0] != hashes[1] {
        return Err("workers in rounds have made another mesh than one thread".into());
    }
    let head = ["gear", "tetrahedra", "smallest", "below 20°", "above 140°", "largest"];
    let below = "The paper compares its parallel mesh with a sequential one. In rounds both are \
                 one mesh, hash by hash; without rounds the mesh depends on the timing.";
    let table = Table {
        title: "Figure 6: dihedral angles of the gear".into(),
        head: cells(head),
        rows,
        below: below.into(),
    };
    let picture = Picture {
        title: "Figure 6: dihedral angles, percent by degrees".into(),
        svg: lines(&columns, &series),
        below: "Run on this machine.".into(),
    };
    Ok(vec![Block::Table(table), Block::Picture(picture)])
}
