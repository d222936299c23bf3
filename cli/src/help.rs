//! The help of `--help` and `ltbw help COMMAND`: what `-h` says, with the rarer options, then what
//! some options mean in detail, examples, and the exit codes that the command has.
//!
//! Clap's own long help gives every option three lines, which nobody reads to its end.

use crate::args::Args;
use clap::{Arg, Command, CommandFactory as _};
use std::ffi::OsString;

const PROGRAM: &str = "ltbw";
/// Values of an option that are told in one paragraph.
const FEW: usize = 6;

/// All exit codes, in words.
const EXITS: [&str; 8] = [
    "done and checked (a little may be over a bound: a warning says where)",
    "`check` found a defect in the file it was given; too much is over a bound",
    "usage: the command line makes no sense",
    "input rejected: one line on stderr names the file, the place and the reason",
    "cancelled (Ctrl-C), or the budget of points was used up; the mesh so far, if any, was written",
    "the checker found a defect in our own output; nothing was written",
    "an output could not be written; nothing is left under its name",
    "the machine lacks memory or threads; nothing was written",
];

/// The exit codes that a command has, and what they mean for it where that is not what they mean
/// for all.
fn exits(command: &str) -> &'static [(usize, &'static str)] {
    match command {
        PROGRAM => &[(0, ""), (1, ""), (2, ""), (3, ""), (4, ""), (5, ""), (6, ""), (7, "")],
        "delaunay" => &[(0, ""), (2, ""), (3, ""), (4, ""), (5, ""), (6, ""), (7, "")],
        "mesh" | "refine" | "demo" => &[
            (0, ""),
            (1, "more is over a bound than may be: the report says where and why"),
            (2, ""),
            (3, ""),
            (4, ""),
            (5, ""),
            (6, ""),
            (7, ""),
        ],
        "check" => &[
            (0, "no defect"),
            (1, "a defect in the file, or an angle below --min-dihedral"),
            (2, ""),
            (3, "the file cannot be read"),
            (4, "stopped (Ctrl-C)"),
            (6, ""),
            (7, ""),
        ],
        "convert" => &[
            (0, "done"),
            (2, ""),
            (3, ""),
            (4, "cancelled (Ctrl-C); nothing was written"),
            (6, ""),
            (7, ""),
        ],
        "generate" => &[
            (0, "done"),
            (2, ""),
            (4, "cancelled (Ctrl-C); nothing was written"),
            (6, ""),
            (7, ""),
        ],
        "simulate" => &[
            (0, "done, with the sequential kernel's mesh"),
            (2, ""),
            (3, "the domain is rejected"),
            (4, "stopped (Ctrl-C)"),
            (5, "another mesh than the sequential kernel's"),
            (6, ""),
            (7, ""),
        ],
        "run" => &[(0, "no wrong answer"), (1, "a wrong answer"), (2, ""), (6, "")],
        _ => &[(0, "done"), (2, ""), (6, "")],
    }
}

/// The words of a command line that ask for long help: those of its command.
fn asked(words: &[OsString]) -> Option<Vec<&str>> {
    let words: Vec<&str> = words.iter().skip(1).map_while(|word| word.to_str()).collect();
    // `-h` asks for the short one.
    let is_help = |word: &&str| *word == "--help" || *word == "help" || *word == "-h";
    let asks = words.iter().find(|word| is_help(word))?;
    (*asks != "-h").then(|| words.iter().copied().filter(|w| !w.starts_with('-')).collect())
}

/// The long help that a command line asks for.
pub(crate) fn long(words: &[OsString]) -> Option<String> {
    let names = asked(words)?;
    let mut program = Args::command();
    program.build();
    let mut command = &program;
    for name in names.iter().filter(|name| **name != "help") {
        // A word that is no command is an argument or an option's value.
        command = command.find_subcommand(name).unwrap_or(command);
    }
    Some(of(command))
}

/// The command that a command line names, as far as it names one: `ltbw mesh`, say.
pub(crate) fn command(words: &[OsString]) -> String {
    let mut program = Args::command();
    program.build();
    let (mut command, mut path) = (&program, PROGRAM.to_owned());
    let mut words = words.iter().skip(1).filter_map(|word| word.to_str());
    while let Some(word) = words.next() {
        if let Some(option) = word.strip_prefix("--") {
            let takes_value =
                |arg: &Arg| arg.get_long() == Some(option) && arg.get_action().takes_values();
            if command.get_arguments().any(takes_value) {
                words.next();
            }
            continue;
        }
        if word.starts_with('-') {
            continue;
        }
        // The next word is an argument, or a mistake.
        let Some(next) = command.find_subcommand(word).filter(|_| word != "help") else { break };
        (command, path) = (next, format!("{path} {word}"));
    }
    path
}

/// The long help of a command.
fn of(command: &Command) -> String {
    let examples = command.get_after_long_help().map(ToString::to_string).unwrap_or_default();
    let about = command.get_long_about().or(command.get_about()).cloned().unwrap_or_default();
    let short = command
        .clone()
        .mut_args(|arg| arg.hide_short_help(false))
        .about(about)
        .after_help(String::new())
        .render_help()
        .to_string()
        .replace(" (see more with '--help')", "");
    let mut text = short.trim_end().to_owned() + "\n";
    let details = details(command);
    if !details.is_empty() {
        text += &format!("\nIn detail:\n{details}");
    }
    if !examples.trim().is_empty() {
        text += &format!("\n{}\n", examples.trim_end());
    }
    // A command of commands ends as they do.
    if command.has_subcommands() && command.get_name() != PROGRAM {
        return text;
    }
    text + "\n" + &exit_codes(command.get_name())
}

/// The exit codes of a command, in lines.
pub(crate) fn exit_codes(command: &str) -> String {
    let mut text = String::from("Exit codes:\n");
    for &(code, meaning) in exits(command) {
        let meaning = if meaning.is_empty() { EXITS[code] } else { meaning };
        text += &format!("  {code}  {meaning}\n");
    }
    text
}

/// The meaning of options that one line does not tell, and of their values.
fn details(command: &Command) -> String {
    let mut text = String::new();
    let is_told =
        |arg: &&Arg| !arg.is_hide_set() && (!arg.is_global_set() || command.get_name() == PROGRAM);
    for arg in command.get_arguments().filter(is_told) {
        let long = arg.get_long().map(|name| format!("--{name}"));
        let name = long.unwrap_or_else(|| format!("<{}>", arg.get_id().as_str().to_uppercase()));
        let long = arg.get_long_help().map(ToString::to_string).unwrap_or_default();
        if let Some((_, more)) = long.split_once("\n\n") {
            text += &wrapped(&format!("{name}: {}", more.replace('\n', " ")));
        }
        let values: Vec<String> = arg
            .get_possible_values()
            .iter()
            .filter_map(|value| Some(format!("{}: {}", value.get_name(), value.get_help()?)))
            .collect();
        if values.len() > FEW {
            text += &format!("  {name}:\n");
            values.iter().for_each(|value| text += &wrapped(&format!("  {value}")));
        } else if !values.is_empty() {
            text += &wrapped(&format!("{name}: {}", values.join("; ")));
        }
    }
    text
}

/// A paragraph in lines of at most 100 columns, the first of which stands out.
fn wrapped(paragraph: &str) -> String {
    let (mut text, mut line) = (String::new(), String::from("  "));
    for word in paragraph.split_whitespace() {
        if line.chars().count() + 1 + word.chars().count() > 100 {
            text += line.trim_end();
            text.push('\n');
            line = String::from("      ");
        }
        line += word;
        line.push(' ');
    }
    text + line.trim_end() + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<OsString> {
        line.split(' ').map(OsString::from).collect()
    }

    #[test]
    fn long_help_is_found_however_it_is_asked_for() {
        let mesh = long(&words("ltbw mesh --help")).expect("help");
        assert_eq!(long(&words("ltbw help mesh")), Some(mesh.clone()));
        assert_eq!(long(&words("ltbw mesh part.stl --help -q")), Some(mesh.clone()));
        assert!(mesh.contains("--write-unrecovered") && mesh.contains("In detail:"), "{mesh}");
        let run = long(&words("ltbw vectors run --help")).expect("help");
        assert!(run.contains("a wrong answer") && !run.contains("rejected"), "{run}");
        for short in ["ltbw", "ltbw mesh -h", "ltbw -h mesh --help"] {
            assert_eq!(long(&words(short)), None, "{short}");
        }
    }

    /// Every command, by its words.
    fn commands(command: &Command, path: &str, found: &mut Vec<(String, Command)>) {
        found.push((path.to_owned(), command.clone()));
        for sub in command.get_subcommands().filter(|sub| sub.get_name() != "help") {
            commands(sub, &format!("{path} {}", sub.get_name()), found);
        }
    }

    #[test]
    fn help_is_short_enough_to_be_read() {
        let mut program = Args::command();
        program.build();
        let mut all = Vec::new();
        commands(&program, "ltbw", &mut all);
        assert!(all.len() > 10);
        for (path, mut command) in all {
            let short = command.render_help().to_string();
            assert!(short.lines().count() <= 40, "{path} -h: {}", short.lines().count());
            let long = of(&command);
            assert!(long.lines().count() <= 95, "{path}: {}\n{long}", long.lines().count());
            assert!(long.lines().all(|line| line.chars().count() <= 100), "{long}");
            let codes = long.split("Exit codes:\n").nth(1).unwrap_or_default().lines().count();
            assert_eq!(
                codes == 8,
                ["ltbw", "ltbw mesh", "ltbw refine", "ltbw demo"].contains(&&*path),
                "{path}"
            );
            assert!(codes > 0 || path == "ltbw vectors", "{path}");
        }
    }
}
