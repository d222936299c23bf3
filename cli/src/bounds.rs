//! The demands on a mesh of a domain: bounds of the command line, TetGen's switches, sizes.

use crate::args::MeshArgs;
use crate::binding::{Binding, Chosen, Reads, Role, read_beside};
use crate::console;
use crate::outcome::{Failure, show};
use crate::sizes::Given;
use crate::workers::Mode;
use ltbw::domain::Prepared;
use ltbw::refine::{Background, BackgroundError, Refiner};
use ltbw::{Point, TetMesh, io};
use std::path::Path;

/// The bounds asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Asked {
    pub(crate) radius_edge: Option<f64>,
    /// Degrees; 0 for none.
    pub(crate) min_dihedral: f64,
    /// Sweeps of smoothing.
    pub(crate) smooth: u32,
    pub(crate) max_volume: Option<f64>,
    /// An edge length for all places.
    pub(crate) size: Option<f64>,
}

impl Asked {
    /// A refiner with these bounds, but for the edge length.
    pub(crate) fn refiner<'a>(self) -> Refiner<'a> {
        let refiner = match self.radius_edge {
            Some(bound) => Refiner::new().radius_edge(bound),
            None => Refiner::new().any_shape(),
        };
        let refiner = refiner.min_dihedral(self.min_dihedral).smooth(self.smooth);
        match self.max_volume {
            Some(bound) => refiner.max_volume(bound),
            None => refiner,
        }
    }
}

/// The edge length at a place of the prepared domain.
pub(crate) type Field = Box<dyn Fn(Point) -> f64 + Sync>;

/// The sizing field of the command line, if it asks for one; the files that it is read from go to
/// `reads`. Sizes are those at the vertices of the mesh that is gone on with, if one is; else those
/// of a solution are at the points of its own mesh.
pub(crate) fn field(
    args: &MeshArgs,
    ready: &Prepared,
    reads: &Reads,
    own: Option<&TetMesh>,
) -> Result<Option<Field>, Failure> {
    let constant = args.size.unwrap_or(f64::INFINITY);
    let Some(asked) = &args.sizes else {
        return Ok(args.size.map(|_| -> Field { Box::new(move |_| constant) }));
    };
    let Given { sizes, on } = asked.read(reads)?;
    let path = &asked.file;
    let failed = |error| match error {
        BackgroundError::Count { .. } if own.is_some() => {
            Failure::Usage(format!("--sizes {}: {error}", show(path)))
        }
        error => Failure::Sizes { path: path.clone(), error },
    };
    let background = match (&args.background, own.or(on.as_ref())) {
        (Some(mesh), _) => {
            let read = |path: &Path, load: &mut io::Load<'_>| io::read_mesh_by(path, load);
            let file = read_beside(reads, Role::Background, mesh, read)?;
            Background::new(&file.mesh, &sizes).map_err(failed)?
        }
        (None, Some(mesh)) => Background::new(mesh, &sizes).map_err(failed)?,
        (None, None) => Background::at_vertices(ready, &sizes).map_err(failed)?,
    };
    // A background mesh is in the coordinates of the file, the domain perhaps in those of a frame.
    let is_of_file = args.background.is_some() || own.is_some() || on.is_some();
    let offset = if is_of_file { ready.lattice.offset() } else { [0.0; 3] };
    Ok(Some(Box::new(move |p| background.at([0, 1, 2].map(|k| p[k] + offset[k])).min(constant))))
}

/// The thing that a switch of TetGen which is no bound asks for, and who does it here.
fn passed_over(letter: char) -> Option<&'static str> {
    Some(match letter {
        'p' => "a domain is what `ltbw mesh` takes",
        'A' => "regions are always told apart",
        'C' => "every mesh is checked; --check says how deeply",
        'z' => "files are numbered as their formats ask for it",
        'Q' => "--quiet is for less output",
        'V' => "--json has all figures",
        'n' => "neighbours are not written",
        'f' | 'e' | 'v' => "only boundary faces are written, with the mesh",
        'k' => "-o FILE.vtk writes for VTK",
        _ => return None,
    })
}

/// The property that a switch of TetGen asks for, and a mesh here would not have.
fn refused(letter: char) -> &'static str {
    match letter {
        'Y' => "the boundary is split where the mesh must be Delaunay",
        'i' => "points are given by --points FILE",
        'm' => "edge lengths are given by --sizes FILE",
        'r' => "`ltbw refine` goes on with a mesh",
        'w' => "weighted meshes are not made",
        'O' => "a mesh is exactly Delaunay, and not optimised",
        'R' => "a mesh is not coarsened",
        _ => "there is no such switch",
    }
}

/// The bounds of the command line; TetGen's switches as far as they mean something here. A note
/// tells each that means nothing.
pub(crate) fn asked(args: &MeshArgs) -> Result<Asked, Failure> {
    let Some(switches) = &args.tetgen_switches else {
        let radius_edge = args.radius_edge.or(Some(2.0));
        return Ok(Asked {
            radius_edge,
            min_dihedral: args.min_dihedral,
            smooth: args.smooth,
            max_volume: args.max_volume,
            size: args.size,
        });
    };
    let (asked, over) = switched(switches, args.size)?;
    let asked = Asked { min_dihedral: args.min_dihedral, smooth: args.smooth, ..asked };
    for (letter, why) in over {
        console::people(&format!("note: --tetgen-switches: `{letter}` is passed over: {why}"));
    }
    Ok(asked)
}

/// Switches that are passed over, and why.
type PassedOver = Vec<(char, &'static str)>;

/// The bounds that TetGen's switches ask for, and those that are passed over, each once.
fn switched(switches: &str, size: Option<f64>) -> Result<(Asked, PassedOver), Failure> {
    let mut over = PassedOver::new();
    let bad = |why: String| Failure::Usage(format!("--tetgen-switches {switches}: {why}"));
    let mut asked = Asked { size, ..Asked::default() };
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
            other => match passed_over(other) {
                Some(why) if over.iter().all(|&(letter, _)| letter != other) => {
                    over.push((other, why));
                }
                Some(_) => {}
                None => return Err(bad(format!("`{other}`: {}", refused(other)))),
            },
        }
        if matches!(letter, 'q' | 'a') {
            rest = after;
        }
    }
    Ok((asked, over))
}

/// The input and the options of `mesh` that the mesh and its judgement depend on.
pub(crate) fn binding(
    args: &MeshArgs,
    asked: Asked,
    flat_tolerance: f64,
    reads: &Reads,
) -> Binding {
    let preparation = &args.preparation;
    let options = Chosen::default()
        .number("radius_edge", asked.radius_edge)
        .number("min_dihedral", Some(asked.min_dihedral))
        .with("smooth", (asked.smooth > 0).then_some(asked.smooth))
        .number("max_volume", asked.max_volume)
        .number("size", asked.size)
        .with("sizes_field", args.sizes.as_ref().and_then(|sizes| sizes.field.as_ref()))
        .with("max_points", args.max_points)
        .number("flat_tolerance", Some(flat_tolerance))
        .number("repair", preparation.repair)
        .number("simplify", preparation.simplify)
        .flag("exact_input", preparation.exact_input)
        .flag("local_frame", preparation.local_frame)
        .flag("own_frame", preparation.own_frame)
        .with("holes", preparation.holes.as_ref())
        .flag("strict", preparation.strict)
        .number("excused_share", Some(args.lenience.share(preparation.strict)))
        // Rounds make one mesh, whoever carries them out.
        .with("mode", (args.mode == Mode::Async).then_some("async"));
    Binding { inputs: reads.list(), options }
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
        let both =
            |q, a| Asked { radius_edge: q, min_dihedral: 8.0, max_volume: a, ..Asked::default() };
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
        let (_, over) = switched("-VVpQvkefnzCAq1.2", None).expect("bounds");
        let letters: String = over.iter().map(|&(letter, _)| letter).collect();
        assert_eq!(letters, "VpQvkefnzCA");
        for letter in "YimrwOR".chars() {
            let error = switched(&format!("pq{letter}"), None).expect_err("no bound").to_string();
            let named = format!("`{letter}`: ");
            assert!(error.contains(&named) && !error.contains("no such"), "{error}");
        }
        for switches in ["pq1.4X", "pqa1..2", "ö"] {
            assert!(asked_by(&["--tetgen-switches", switches]).is_err(), "{switches}");
        }
    }
}
