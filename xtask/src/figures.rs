//! `figures`: all that pages quote, printed by the commands that the pages name.

mod table;

use crate::require;
use crate::shell::{self, cargo, command, program};
use table::{FIGURES, Figures, PARTS};

/// Prints the figures of these names, or all; with `--list` it tells which there are.
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    if args == ["--list"] {
        FIGURES.iter().for_each(|own| println!("{}", own.told()));
        return Ok(());
    }
    let named = |name: &String| FIGURES.iter().find(|own| own.name == name);
    let wanted: Option<Vec<&Figures>> = args.iter().map(named).collect();
    let names = || FIGURES.iter().map(|own| own.name).collect::<Vec<_>>().join(", ");
    let wanted = wanted.ok_or_else(|| format!("no such figures; there are {}", names()))?;
    let all = || FIGURES.iter().collect();
    let mut failures = Vec::new();
    for own in if wanted.is_empty() { all() } else { wanted } {
        println!("\n{}", own.told());
        for line in own.commands {
            println!("\n$ {line}\n");
            if let Err(failure) = execute(line) {
                eprintln!("xtask: {failure}");
                failures.push(*line);
            }
        }
    }
    match failures[..] {
        [] => Ok(()),
        _ => Err(format!("failed:\n{}", failures.join("\n"))),
    }
}

impl Figures {
    /// The name, the sections, the commands.
    fn told(&self) -> String {
        let places = self.places.iter().map(|place| match place.heading {
            "" => place.page.to_owned(),
            heading => format!("{}, \"{heading}\"", place.page),
        });
        let places = places.collect::<Vec<_>>().join("; ");
        format!("{}: {places}\n    {}", self.name, self.commands.join("\n    "))
    }
}

/// The words of a line, with the folder of surfaces in place of its name; none if there is no
/// folder.
fn words_of(line: &str, parts: Option<&str>) -> Option<Vec<String>> {
    let word = |word: &str| match word {
        PARTS => parts.map(str::to_owned),
        word => Some(word.to_owned()),
    };
    line.split_whitespace().map(word).collect()
}

/// Carries out a command as one types it.
fn execute(line: &str) -> Result<(), String> {
    let parts = std::env::var("LTBW_PARTS").ok();
    let Some(words) = words_of(line, parts.as_deref()) else {
        return require::skip(line, "parts", "LTBW_PARTS names no folder of surfaces");
    };
    let settings = words.iter().map_while(|word| word.split_once('='));
    let rest = &words[settings.clone().count()..];
    let plain: Vec<&str> = rest.iter().map(String::as_str).collect();
    let (mut ready, rest) = match plain[..] {
        ["cargo", "xtask", ref rest @ ..] => {
            let own = std::env::current_exe().map_err(|e| format!("this program: {e}"))?;
            (command(&own.to_string_lossy()), rest)
        }
        ["cargo", ref rest @ ..] => (cargo(), rest),
        ["ltbw", ref rest @ ..] => (command(&program()?.to_string_lossy()), rest),
        _ => return Err(format!("neither cargo nor ltbw: {line}")),
    };
    shell::run(ready.args(rest).envs(settings))
}

#[cfg(test)]
mod tests {
    use super::{FIGURES, words_of};
    use crate::commands::Command;

    #[test]
    fn commands_of_figures_exist_and_names_are_given_once() {
        for own in FIGURES {
            let same = FIGURES.iter().filter(|other| other.name == own.name).count();
            assert_eq!(same, 1, "{}", own.name);
            assert!(!own.commands.is_empty() && !own.places.is_empty(), "{}", own.name);
            for line in own.commands {
                let words = words_of(line, Some("parts")).expect("a folder");
                let words: Vec<&str> = words.iter().map(String::as_str).collect();
                let words: Vec<&str> =
                    words.into_iter().skip_while(|word| word.contains('=')).collect();
                match words[..] {
                    ["cargo", "xtask", name, ..] => {
                        assert!(Command::named(name).is_some(), "{line}");
                        assert_ne!(name, "figures", "it would call itself");
                    }
                    ["cargo", "run" | "test", ..] | ["ltbw", "simulate", ..] => {}
                    _ => panic!("{line}"),
                }
            }
        }
    }

    #[test]
    fn a_folder_of_surfaces_takes_the_place_of_its_name() {
        assert_eq!(
            words_of("a DIR  b", Some("x y")),
            Some(vec!["a".into(), "x y".into(), "b".into()])
        );
        assert_eq!(words_of("a DIR", None), None);
        assert_eq!(words_of("a", None), Some(vec!["a".into()]));
    }
}
