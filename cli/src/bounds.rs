//! The demands on a mesh of a domain: bounds of the command line, TetGen's switches, sizes.

use crate::args::MeshArgs;
use crate::binding::{Binding, Chosen, Reads};
use crate::console;
use crate::outcome::Failure;
use crate::workers::Mode;
use ltbw::refine::Refiner;

/// The bounds asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Asked {
    pub(crate) radius_edge: Option<f64>,
    /// Degrees; 0 for none.
    pub(crate) min_dihedral: f64,
    /// Sweeps of smoothing.
    pub(crate) smooth: u32,
    pub(crate) max_volume: Option<f64>,
    /// The longest edge.
    pub(crate) max_edge: Option<f64>,
}

impl Asked {
    /// A refiner with these bounds.
    pub(crate) fn refiner<'a>(self) -> Refiner<'a> {
        let refiner = match self.radius_edge {
            Some(bound) => Refiner::new().radius_edge(bound),
            None => Refiner::new().any_shape(),
        };
        let mut refiner = refiner.min_dihedral(self.min_dihedral).smooth(self.smooth);
        if let Some(bound) = self.max_edge {
            refiner = refiner.max_edge(bound);
        }
        match self.max_volume {
            Some(bound) => refiner.max_volume(bound),
            None => refiner,
        }
    }
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
            max_edge: args.sizing.max_edge,
        });
    };
    let (asked, over) = switched(switches)?;
    let (min_dihedral, max_edge) = (args.min_dihedral, args.sizing.max_edge);
    let asked = Asked { min_dihedral, max_edge, smooth: args.smooth, ..asked };
    for (letter, why) in over {
        console::people(&format!("note: --tetgen-switches: `{letter}` is passed over: {why}"));
    }
    Ok(asked)
}

/// Switches that are passed over, and why.
type PassedOver = Vec<(char, &'static str)>;

/// The bounds that TetGen's switches ask for, and those that are passed over, each once.
fn switched(switches: &str) -> Result<(Asked, PassedOver), Failure> {
    let mut over = PassedOver::new();
    let bad = |why: String| Failure::Usage(format!("--tetgen-switches {switches}: {why}"));
    let mut asked = Asked::default();
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
        .number("max_volume", asked.max_volume);
    let options = args
        .sizing
        .bind(options)
        .with("max_points", args.max_points)
        .number("flat_tolerance", Some(flat_tolerance))
        .number("repair", preparation.repair)
        .number("simplify", preparation.simplify)
        .with("fill", preparation.fill)
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
        let (_, over) = switched("-VVpQvkefnzCAq1.2").expect("bounds");
        let letters: String = over.iter().map(|&(letter, _)| letter).collect();
        assert_eq!(letters, "VpQvkefnzCA");
        for letter in "YimrwOR".chars() {
            let error = switched(&format!("pq{letter}")).expect_err("no bound").to_string();
            let named = format!("`{letter}`: ");
            assert!(error.contains(&named) && !error.contains("no such"), "{error}");
        }
        for switches in ["pq1.4X", "pqa1..2", "ö"] {
            assert!(asked_by(&["--tetgen-switches", switches]).is_err(), "{switches}");
        }
    }
}
