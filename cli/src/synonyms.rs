//! Words of other meshers for options of `mesh` and `refine`: what to say here instead.

use clap::error::{ContextKind, ContextValue};
use std::ffi::OsString;

/// The options for edges.
const EDGES: &str = "--size H (usual edges), --max-edge H (none longer) or --max-volume A";

/// The options that TetGen's `q` and `a` are.
const SWITCHES: &str = "--radius-edge B, --max-volume A, or --tetgen-switches pq1.4a0.1";

/// Words of others, and the options here.
const WORDS: &[(&[&str], &str)] = &[
    (
        &[
            "--max-size",
            "--maxsize",
            "--min-size",
            "--max-length",
            "--edge-length",
            "--edge-size",
            "--mesh-size",
            "--element-size",
            "--lc",
            "--clmax",
            "--hmax",
            "--resolution",
        ],
        EDGES,
    ),
    (&["-a", "-p", "--maxvolume", "--volume"], SWITCHES),
    (&["--quality", "--minratio", "--aspect-ratio", "--ratio"], SWITCHES),
    (&["--mindihedral", "--min-angle", "--angle"], "--min-dihedral D, or --feature-angle A"),
    (&["--gradation", "--hgrad", "--grading", "--growth-rate"], "--growth G"),
    (&["--local-size", "--refine-at", "--refine-near"], "--near X,Y,Z:H or --size-at PART:H"),
    (&["--classify", "--feature", "--features", "--split-angle"], "--feature-angle A"),
];

/// The options that an unknown word means here, if it is one of theirs.
pub(crate) fn meant(error: &clap::Error, words: &[OsString]) -> Option<&'static str> {
    let is_mesh = |word: &OsString| word == "mesh" || word == "refine";
    if !words.iter().any(is_mesh) {
        return None;
    }
    let word = match error.get(ContextKind::InvalidArg)? {
        ContextValue::String(word) => word.as_str(),
        ContextValue::Strings(words) => words.first()?.as_str(),
        _ => return None,
    };
    // `-q` is `--quiet` here, and what follows is no option.
    let is_switches = |word: &OsString| {
        let text = word.to_string_lossy();
        let rest = text.strip_prefix('-').unwrap_or_default().trim_start_matches('p');
        let number = rest.strip_prefix('q').or_else(|| rest.strip_prefix('a')).unwrap_or_default();
        number.starts_with(|c: char| c.is_ascii_digit())
    };
    if words.iter().any(is_switches) {
        return Some(SWITCHES);
    }
    WORDS.iter().find(|(theirs, _)| theirs.contains(&word)).map(|&(_, ours)| ours)
}

#[cfg(test)]
mod tests {
    use crate::Refusal;
    use crate::args::Args;
    use clap::Parser;
    use std::ffi::OsString;

    fn said(words: &[&str]) -> String {
        let all: Vec<_> = ["ltbw"].iter().chain(words).map(OsString::from).collect();
        Refusal::of(&Args::try_parse_from(&all).expect_err("no command"), &all).text
    }

    #[test]
    fn words_of_other_meshers_lead_to_ours() {
        for (word, option) in [
            ("--max-size", "--size H"),
            ("--hgrad", "--growth G"),
            ("-a0.1", "--max-volume A"),
            ("-q1.4", "--radius-edge B"),
            ("-pq1.2a3", "--tetgen-switches"),
            ("--classify", "--feature-angle A"),
        ] {
            let said = said(&["mesh", "a.stl", word, "-o", "m.vtu"]);
            assert!(said.contains(option) && !said.contains("did you"), "{said}");
        }
        assert!(
            said(&["mesh", "a.stl", "--max-volum", "1"]).contains("did you mean `--max-volume`")
        );
        assert!(said(&["check", "m.vtu", "--max-size", "1"]).contains("unexpected argument"));
        assert!(Args::try_parse_from(["ltbw", "mesh", "a.stl", "--edge", "1"]).is_ok());
    }

    #[test]
    fn no_word_of_theirs_is_ours() {
        let command = <Args as clap::CommandFactory>::command();
        let mesh = command.find_subcommand("mesh").expect("a command");
        let ours: Vec<&str> = mesh.get_arguments().filter_map(|a| a.get_long()).collect();
        let theirs = super::WORDS.iter().flat_map(|(words, _)| words.iter());
        for word in theirs.filter_map(|word| word.strip_prefix("--")) {
            assert!(!ours.contains(&word), "{word}");
        }
    }
}
