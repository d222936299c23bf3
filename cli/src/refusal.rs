//! The answer to a command line that is no command: help, or one line with a hint.

use crate::console;
use crate::help;
use crate::outcome::{Exit, Failure};
use crate::synonyms::meant;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::ffi::OsString;
use std::io::{Write, stdout};

/// A command line that is no command: what to say.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// The exit code: 0 for an answer that was asked for, else 2.
    pub exit: u8,
    /// Whether the text is help or the version.
    pub is_help: bool,
    /// The error, in one line without control characters; or the help, without colours.
    pub text: String,
}

impl Refusal {
    pub(crate) fn of(error: &clap::Error, words: &[OsString]) -> Self {
        let (exit, is_help) = match error.kind() {
            ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => (Exit::Done, true),
            ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => (Exit::Usage, true),
            _ => (Exit::Usage, false),
        };
        let text = error.to_string();
        let text = if is_help {
            text
        } else {
            one_line(&text, &tips(error, words), &help::command(words))
        };
        Self { exit: exit as u8, is_help, text }
    }
}

/// The options that words of another mesher mean here; else the suggestions of clap.
fn tips(error: &clap::Error, words: &[OsString]) -> String {
    if let Some(ours) = meant(error, words) {
        return format!("; here it is {ours}");
    }
    let kinds =
        [ContextKind::SuggestedArg, ContextKind::SuggestedSubcommand, ContextKind::SuggestedValue];
    let words = kinds.into_iter().filter_map(|kind| match error.get(kind)? {
        ContextValue::String(word) => Some(vec![word.clone()]),
        ContextValue::Strings(words) => Some(words.clone()),
        _ => None,
    });
    let words: Vec<String> = words.flatten().map(|word| format!("`{word}`")).collect();
    if words.is_empty() { String::new() } else { format!("; did you mean {}?", words.join(" or ")) }
}

/// The first paragraph of clap's message as one line. It repeats the argument, and a terminal obeys
/// control characters that clap leaves in it: they become `?`.
fn one_line(text: &str, tips: &str, command: &str) -> String {
    let first = text.split("\n\n").next().unwrap_or_default();
    let words: Vec<&str> = first.split_whitespace().collect();
    let line = words.join(" ");
    let line = line.strip_prefix("error: ").unwrap_or(&line);
    format!("{line}{tips}; see `{command} --help`").replace(char::is_control, "?")
}

/// Prints help where it was asked for, and what is wrong with the command line in one line.
pub(crate) fn explain(error: &clap::Error, words: &[OsString]) -> Result<Exit, Failure> {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            let is_help = error.kind() == ErrorKind::DisplayHelp;
            match help::long(words).filter(|_| is_help) {
                Some(text) => console::help_with(|| stdout().write_all(text.as_bytes()))?,
                None => console::help_with(|| error.print())?,
            }
            Ok(Exit::Done)
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            // For people, to stderr.
            let _ = error.print();
            Ok(Exit::Usage)
        }
        _ => {
            console::people(&format!("ltbw: {}", Refusal::of(error, words).text));
            Ok(Exit::Usage)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Refusal;
    use crate::args::Args;
    use clap::Parser;
    use std::ffi::OsString;

    fn text(words: &[&str]) -> String {
        let words: Vec<_> = ["ltbw"].iter().chain(words).map(OsString::from).collect();
        let error = Args::try_parse_from(&words).expect_err("no command");
        Refusal::of(&error, &words).text
    }

    /// Control characters of an argument must not come back to the terminal.
    #[test]
    fn a_refusal_repeats_no_control_characters() {
        for word in ["a\u{1b}[2Jb", "x\u{7}", "\u{0}", "one\ntwo", "tab\tbed", "\u{9b}31m"] {
            let words: Vec<_> = ["ltbw", word].iter().map(OsString::from).collect();
            let error = Args::try_parse_from(&words).expect_err("no such command");
            let text = Refusal::of(&error, &words).text;
            assert!(!text.chars().any(char::is_control), "{text:?}");
            assert!(text.contains("unrecognized subcommand"), "{text:?}");
        }
    }

    #[test]
    fn a_refusal_suggests_what_was_meant_and_names_the_right_help() {
        let said = text(&["delaunay", "p.npy", "--thread", "2"]);
        assert!(said.contains("unexpected argument '--thread' found"), "{said}");
        assert!(said.contains("did you mean `--threads`?"), "{said}");
        assert!(said.ends_with("see `ltbw delaunay --help`"), "{said}");
        assert!(text(&["delauny"]).contains("did you mean `delaunay`?"));
    }

    #[test]
    fn a_wrong_value_names_the_help_of_its_command() {
        let cases: [(&[&str], &str); 10] = [
            (&["delaunay", "p.npy", "--check", "fats"], "ltbw delaunay"),
            (&["generate", "unifrm", "10", "-o", "z.npy"], "ltbw generate"),
            (&["generate", "uniform", "-5", "-o", "z.npy"], "ltbw generate"),
            (&["simulate", "--points", "x"], "ltbw simulate"),
            (&["mesh", "p.npy", "--page"], "ltbw mesh"),
            (&["completions", "tcsh"], "ltbw completions"),
            (&["--progress", "mesh", "delaunay", "p.npy", "--threads", "0"], "ltbw delaunay"),
            (&["-q", "--progress=json", "check", "m.vtu", "--radius-edge", "x"], "ltbw check"),
            (&["vectors", "run", "--folder", "x", "--executor", "e"], "ltbw vectors run"),
            (&["mesh", "delaunay", "--radius-edge", "x"], "ltbw mesh"),
        ];
        for (words, command) in cases {
            let said = text(words);
            assert!(said.ends_with(&format!("; see `{command} --help`")), "{words:?}: {said}");
        }
    }

    #[test]
    fn counts_are_told_in_plain_words() {
        let said = text(&["simulate", "--points", "x"]);
        assert!(
            said.starts_with("invalid value 'x' for '--points <N>': expected a whole"),
            "{said}"
        );
        let said = text(&["generate", "uniform", "-5", "-o", "z.npy"]);
        assert!(said.starts_with("invalid value '-5' for '[N]': expected a whole"), "{said}");
    }
}
