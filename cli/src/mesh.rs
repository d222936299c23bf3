//! `mesh`: read a domain, prepare it, refine, hash, check, write, report.

use crate::args::{Depth, MeshArgs};
use crate::check::{check_json, is_stdout, keep_input, write_json};
use crate::conform::{certificate, plc_of, prepare, print, same_volume, summary};
use crate::console::{self, Progress, Stop};
use crate::outcome::{Exit, Failure, show};
use crate::report::{Input, Insphere, MeshPart, Orient3d, Predicates, Report, Seconds};
use crate::run::{check_outputs, set_threads};
use ltbw::domain::Prepared;
use ltbw::quality::{Histogram, Quality};
use ltbw::refine::{RefineOutcome, Refined, Refiner};
use ltbw::{TetMesh, canonical_hash, io};
use ltbw_verify::{self as verify, Breach, Conformity, Limits};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::time::Instant;

/// Excuses that the report lists.
const LISTED: usize = 100;

/// The bounds asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Asked {
    radius_edge: Option<f64>,
    max_volume: Option<f64>,
}

/// `ltbw mesh`.
pub(crate) fn mesh(args: &MeshArgs) -> Result<Exit, Failure> {
    let start = Instant::now();
    set_threads(args.threads)?;
    let asked = asked(args)?;
    check_outputs(&args.output)?;
    args.json.as_deref().map_or(Ok(()), check_json)?;
    let written = args.output.iter().flat_map(|path| io::mesh_files(path));
    let written = written.chain(args.json.clone()).chain(args.histogram.clone());
    written.into_iter().try_for_each(|path| keep_input(&args.domain, &path))?;
    let stop = Stop::on_signal()?;
    let ready = prepare(&args.domain, args.exact_input, args.local_frame)?;
    let mut seconds = Seconds { read: start.elapsed().as_secs_f64(), ..Seconds::default() };
    print_domain(args, &ready);

    let clock = Instant::now();
    let refined = refine(args, asked, &ready, &stop)?;
    seconds.refine = clock.elapsed().as_secs_f64();
    let inside = refined.to_tet_mesh(false);
    let clock = Instant::now();
    let hash = canonical_hash(&inside.points, &inside.tets)
        .map_err(|e| Failure::Other(e.to_string()))?
        .to_string();
    seconds.hash = clock.elapsed().as_secs_f64();
    let mut report = report_of(&refined, &ready, hash, seconds);
    print_mesh(&refined, &inside);
    if refined.outcome != RefineOutcome::Cancelled {
        stop.inserted();
    }

    if args.check != Depth::Off && refined.outcome != RefineOutcome::Cancelled {
        let clock = Instant::now();
        let mut found = check_own(&inside, &ready, asked);
        let same = same_volume(&ready, &found) || !refined.lost.is_empty();
        report.certificate = Some(certificate(&found, same));
        report.seconds.check = clock.elapsed().as_secs_f64();
        if !(is_explained(&found, &refined) && same) {
            print(&mut found);
            if let Err(failure) = finish(&mut report, args, start) {
                console::people(&format!("note: {failure}"));
            }
            console::people("ltbw: defect in our own output; no mesh was written");
            return Ok(Exit::OwnDefect);
        }
        if found.passed() {
            console::people(&format!("checked   {}", summary(&found)));
        } else {
            console::people("checked   sound; over its bounds only where it was excused");
        }
    }
    report.quality = Quality::of(&inside.points, &inside.tets).map(|q| quality_json(&q));
    write(args, &refined, &inside, &mut report)?;
    finish(&mut report, args, start)?;
    Ok(ending(&refined))
}

/// The bounds of the command line; TetGen's switches as far as they mean something here.
fn asked(args: &MeshArgs) -> Result<Asked, Failure> {
    let Some(switches) = &args.tetgen_switches else {
        let radius_edge = args.radius_edge.or(Some(2.0));
        return Ok(Asked { radius_edge, max_volume: args.max_volume });
    };
    let bad = |why: String| Failure::Usage(format!("--tetgen-switches {switches}: {why}"));
    let mut asked = Asked { radius_edge: None, max_volume: None };
    let mut rest = switches.trim_start_matches('-');
    while let Some(letter) = rest.chars().next() {
        rest = &rest[letter.len_utf8()..];
        // A number, and after a slash a second one (a minimal angle), which has no meaning here.
        let end = rest.find(|c: char| !(c.is_ascii_digit() || ".eE+-/".contains(c)));
        // An `e` that no digit follows is no part of a number.
        let (text, after) = rest.split_at(end.unwrap_or(rest.len()));
        let number = text.split('/').next().unwrap_or_default();
        let value = || number.parse::<f64>().map_err(|e| bad(format!("`{number}`: {e}")));
        match letter {
            'q' if number.is_empty() => asked.radius_edge = Some(2.0),
            'q' => asked.radius_edge = Some(value()?),
            'a' if number.is_empty() => {}
            'a' => asked.max_volume = Some(value()?),
            'p' | 'A' | 'Q' | 'V' | 'C' | 'z' | 'n' | 'f' | 'e' | 'k' => {}
            other => return Err(bad(format!("there is nothing like `{other}`"))),
        }
        if matches!(letter, 'q' | 'a') {
            rest = after;
        }
    }
    Ok(asked)
}

fn refine(
    args: &MeshArgs,
    asked: Asked,
    ready: &Prepared,
    stop: &Stop,
) -> Result<Refined, Failure> {
    let progress = Progress::new();
    let mut refiner = Refiner::new().observer(&progress).cancel(stop.token());
    refiner = match asked.radius_edge {
        Some(bound) => refiner.radius_edge(bound),
        None => refiner.any_shape(),
    };
    if let Some(bound) = asked.max_volume {
        refiner = refiner.max_volume(bound);
    }
    if let Some(count) = args.max_points {
        refiner = refiner.max_points(count);
    }
    let failed = |error| Failure::Refine { path: args.domain.clone(), error };
    refiner.refine(&ready.domain, &ready.lattice).map_err(failed)
}

fn check_own(inside: &TetMesh, ready: &Prepared, asked: Asked) -> Conformity {
    let limits = Limits {
        radius_edge: asked.radius_edge,
        max_volume: asked.max_volume,
        region_volumes: ready.domain.regions.iter().map(|r| r.max_volume).collect(),
    };
    let mesh = verify::Mesh::new(&inside.points, &inside.tets);
    let (plc, tags) = (plc_of(&ready.domain), inside.tet_tags.as_deref());
    verify::conforms(&mesh, &plc, tags, &limits, &verify::Options::default())
}

/// Is everything that the checker found excused? A bound may be exceeded by as many tetrahedra as
/// there are excuses; the boundary may be incomplete only if some of it was given up.
fn is_explained(found: &Conformity, refined: &Refined) -> bool {
    let excused = refined.excuses.len() as u64;
    found.mesh_defect_count == 0
        && found.counts.iter().all(|(breach, &count)| match breach {
            Breach::RatioExceeded | Breach::VolumeExceeded => count <= excused,
            Breach::VertexMissing | Breach::TooFine | Breach::FacetDegenerate => false,
            _ => !refined.lost.is_empty(),
        })
}

fn ending(refined: &Refined) -> Exit {
    match refined.outcome {
        RefineOutcome::Met => Exit::Done,
        RefineOutcome::Excused => {
            let mut reasons: BTreeMap<String, usize> = BTreeMap::new();
            let lost = refined.lost.iter().map(|(_, reason)| reason);
            for reason in refined.excuses.iter().map(|e| &e.reason).chain(lost) {
                *reasons.entry(reason.to_string()).or_default() += 1;
            }
            let text: Vec<String> =
                reasons.iter().take(5).map(|(reason, n)| format!("{n} for {reason}")).collect();
            let more = reasons.len().saturating_sub(5);
            let more = if more > 0 { format!(", and {more} more reasons") } else { String::new() };
            console::people(&format!(
                "ltbw: excused: {} tetrahedra over a bound, {} boundary items not in the mesh: {}{more}",
                refined.excuses.len(),
                refined.lost.len(),
                text.join(", ")
            ));
            Exit::Defect
        }
        RefineOutcome::Cancelled => {
            console::people("ltbw: cancelled: the mesh is Delaunay, but need not meet the bounds");
            Exit::Stopped
        }
    }
}

fn print_domain(args: &MeshArgs, ready: &Prepared) {
    let (domain, lattice) = (&ready.domain, &ready.lattice);
    console::people(&format!(
        "domain    {}: {} vertices, {} facets, {} holes, {} regions",
        show(&args.domain),
        domain.vertices.len(),
        domain.facets.len(),
        domain.holes.len(),
        domain.regions.len()
    ));
    if let Some(m) = &ready.largest {
        console::people(&format!(
            "note: {} vertices moved to the lattice of step 2^{}, the farthest (vertex {}) by {:.3e}",
            ready.moved,
            lattice.exponent(),
            m.vertex,
            m.distance
        ));
    }
    if lattice.lost_bits() > 0 {
        console::people(&format!(
            "note: {} bits are lost to the distance from the origin (--local-frame keeps them)",
            lattice.lost_bits()
        ));
    }
    if lattice.offset() != [0.0; 3] {
        console::people(&format!("note: coordinates are relative to {:?}", lattice.offset()));
    }
}

fn print_mesh(refined: &Refined, inside: &TetMesh) {
    let stats = &refined.stats;
    console::people(&format!(
        "mesh      {} vertices, {} tetrahedra inside, {} regions",
        refined.mesh().num_vertices(),
        inside.tets.len(),
        refined.regions.len() - 1
    ));
    console::people(&format!(
        "points    {} on segments, {} on facets, {} inside",
        stats.segment_points, stats.facet_points, stats.free_points
    ));
    if let Some(quality) = Quality::of(&inside.points, &inside.tets) {
        let (d, r) = (&quality.dihedral, &quality.radius_edge);
        console::people(&format!(
            "quality   dihedral {:.2} to {:.2} degrees, radius-edge at most {:.4}",
            d.least.value, d.largest.value, r.largest.value
        ));
    }
}

fn report_of(refined: &Refined, ready: &Prepared, hash: String, seconds: Seconds) -> Report {
    let points = ready.vertex_map.len();
    let distinct = ready.domain.vertices.len();
    let p = refined.mesh().predicate_stats();
    Report {
        schema: Report::SCHEMA,
        command: "mesh",
        input: Input { points, distinct, duplicates: points - distinct, duplicate_of: Vec::new() },
        mesh: MeshPart {
            vertices: refined.mesh().num_vertices(),
            tets: refined.num_tets(),
            hull_faces: refined.mesh().num_hull_faces(),
            hash: Some(hash),
        },
        predicates: Predicates {
            orient3d: Orient3d { calls: p.orient3d_calls, exact: p.orient3d_exact },
            insphere: Insphere {
                calls: p.insphere_calls,
                exact: p.insphere_exact,
                perturbed: p.insphere_perturbed,
            },
        },
        seconds,
        threads: rayon::current_num_threads(),
        peak_rss_bytes: None,
        outcome: match refined.outcome {
            RefineOutcome::Met => "met",
            RefineOutcome::Excused => "excused",
            RefineOutcome::Cancelled => "cancelled",
        },
        refinement: Some(refinement_json(refined, ready)),
        quality: None,
        certificate: None,
        outputs: Vec::new(),
        workers: Vec::new(),
        parallel: None,
    }
}

fn refinement_json(refined: &Refined, ready: &Prepared) -> Value {
    let stats = &refined.stats;
    let excuse = |e: &ltbw::refine::Excuse| {
        json!({
            "vertices": refined.mesh().tet(e.tet),
            "reason": e.reason.to_string(),
        })
    };
    let region = |r: &ltbw::refine::RegionInfo| json!({ "seed": r.seed, "attribute": r.attribute, "max_volume": r.max_volume });
    json!({
        "segment_points": stats.segment_points,
        "facet_points": stats.facet_points,
        "free_points": stats.free_points,
        "excused": refined.excuses.len(),
        "excuses": refined.excuses.iter().take(LISTED).map(excuse).collect::<Vec<_>>(),
        "boundary_lost": refined.lost.len(),
        "regions": refined.regions.iter().skip(1).map(region).collect::<Vec<_>>(),
        "lattice": {
            "step": ready.lattice.step(),
            "fine_step": ready.lattice.fine_step(),
            "offset": ready.lattice.offset(),
            "lost_bits": ready.lattice.lost_bits(),
            "moved": ready.moved,
            "largest_move": ready.largest.map(|m| m.distance),
        },
        "recover_seconds": stats.recover_seconds,
        "refine_seconds": stats.refine_seconds,
    })
}

fn quality_json(quality: &Quality) -> Value {
    let extreme = |e: ltbw::quality::Extreme| json!({ "value": e.value, "tet": e.tet });
    let histogram = |h: &Histogram| {
        json!({
            "name": h.name,
            "low": h.low,
            "high": h.high,
            "counts": h.counts,
            "least": extreme(h.least),
            "largest": extreme(h.largest),
        })
    };
    json!({
        "dihedral": histogram(&quality.dihedral),
        "radius_edge": histogram(&quality.radius_edge),
        "volume": histogram(&quality.volume),
        "edge": histogram(&quality.edge),
    })
}

fn write(
    args: &MeshArgs,
    refined: &Refined,
    inside: &TetMesh,
    report: &mut Report,
) -> Result<(), Failure> {
    let clock = Instant::now();
    let whole = args.keep_exterior.then(|| refined.to_tet_mesh(true));
    for path in &args.output {
        io::write_mesh(path, whole.as_ref().unwrap_or(inside)).map_err(Failure::Write)?;
        report.outputs.push(path.to_string_lossy().into_owned());
        console::people(&format!("wrote     {}", show(path)));
    }
    if let (Some(path), Some(quality)) =
        (&args.histogram, Quality::of(&inside.points, &inside.tets))
    {
        io::write_bytes(path, quality.svg().as_bytes()).map_err(Failure::Write)?;
        console::people(&format!("wrote     {}", show(path)));
    }
    report.seconds.write = clock.elapsed().as_secs_f64();
    Ok(())
}

/// Tells how long it took, prints the hash and writes the report.
fn finish(report: &mut Report, args: &MeshArgs, start: Instant) -> Result<(), Failure> {
    report.peak_rss_bytes = crate::report::peak_rss_bytes();
    report.seconds.total = start.elapsed().as_secs_f64();
    let s = &report.seconds;
    console::people(&format!(
        "seconds   {:.2}: read {:.2}, refine {:.2}, hash {:.2}, check {:.2}, write {:.2}",
        s.total, s.read, s.refine, s.hash, s.check, s.write
    ));
    if let Some(path) = &args.json {
        let text = report.to_json().map_err(|e| Failure::Other(e.to_string()))?;
        write_json(path, &text)?;
    }
    if let Some(hash) = report.mesh.hash.as_ref()
        && !args.json.as_deref().is_some_and(is_stdout)
    {
        console::data(&format!("ltbw.mesh/1 {hash}\n"))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Args, Command};
    use clap::Parser;

    fn asked_by(words: &[&str]) -> Result<Asked, Failure> {
        let all = ["ltbw", "mesh", "x.poly"].iter().chain(words);
        let Command::Mesh(args) = Args::try_parse_from(all).expect("arguments").command else {
            panic!("another command");
        };
        asked(&args)
    }

    #[test]
    fn bounds_come_from_options_or_from_tetgens_switches() {
        let both = |q, a| Asked { radius_edge: q, max_volume: a };
        assert_eq!(asked_by(&[]).expect("bounds"), both(Some(2.0), None));
        let cases = [
            ("pq1.4a0.1", both(Some(1.4), Some(0.1))),
            ("-pqa1e-5Q", both(Some(2.0), Some(1e-5))),
            ("pa2", both(None, Some(2.0))),
            ("pq1.5/10A", both(Some(1.5), None)),
        ];
        for (switches, expected) in cases {
            let found = asked_by(&["--tetgen-switches", switches]).expect("bounds");
            assert_eq!(found, expected, "{switches}");
        }
        for switches in ["pq1.4X", "pqa1..2", "ö"] {
            assert!(asked_by(&["--tetgen-switches", switches]).is_err(), "{switches}");
        }
    }
}
