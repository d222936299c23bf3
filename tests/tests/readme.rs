//! README.md, held to the sources: its Rust example is the doctest of the crate `ltbw`,
//! its commands and links exist. Its demo output is held to the program by `cli/tests/readme.rs`.

use std::path::{Path, PathBuf};

const README: &str = include_str!("../../README.md");
const LIBRARY: &str = include_str!("../../parallel/src/lib.rs");
const XTASK: &str = include_str!("../../xtask/src/commands.rs");
/// The part that a reader sees without scrolling.
const FIRST_SCREEN: usize = 60;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a package of the workspace").into()
}

/// The code blocks of a text that open with "```" and `language`.
fn blocks(text: &str, language: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if let Some(found) = line.strip_prefix("```") {
            let body: Vec<&str> = lines.by_ref().take_while(|&line| line != "```").collect();
            if found == language {
                blocks.push(body.join("\n"));
            }
        }
    }
    blocks
}

/// The crate documentation of `ltbw`, without the comment signs.
fn library_docs() -> String {
    let lines = LIBRARY.lines().map_while(|line| line.strip_prefix("//!"));
    lines.map(|line| line.strip_prefix(' ').unwrap_or(line)).collect::<Vec<_>>().join("\n")
}

/// Everything in backquotes outside code blocks.
fn inline_code() -> Vec<&'static str> {
    let outside: Vec<&str> = README.split("\n```").step_by(2).collect();
    outside.iter().flat_map(|text| text.split('`').skip(1).step_by(2)).collect()
}

#[test]
fn the_example_is_the_doctest_of_the_library() {
    let doctest: Vec<String> = blocks(&library_docs(), "")
        .iter()
        .map(|b| b.lines().filter(|l| !l.starts_with("# ")).collect::<Vec<_>>().join("\n"))
        .collect();
    assert_eq!(blocks(README, "rust"), doctest);
    assert_eq!(doctest.len(), 1);
}

#[test]
fn its_cargo_commands_exist() {
    let in_blocks = README.lines().filter_map(|line| line.strip_prefix("$ "));
    let commands: Vec<&str> =
        in_blocks.chain(inline_code()).filter(|code| code.starts_with("cargo ")).collect();
    for expected in ["cargo run --release -p ltbw-cli -- demo", "cargo test --workspace"] {
        assert!(commands.contains(&expected), "{expected} is not in {commands:?}");
    }
    for command in commands {
        let words: Vec<&str> = command.split(' ').collect();
        let exists = match words[1..] {
            ["run", "--release", "-p", "ltbw-cli", "--", "demo"] => {
                root().join("cli/Cargo.toml").exists()
            }
            ["install" | "add", "--path", folder] => {
                root().join(folder).join("Cargo.toml").exists()
            }
            ["test", "--workspace"] | ["xtask"] => true,
            ["xtask", task] => XTASK.contains(&format!("name: \"{task}\"")),
            ["xtask", task, what] => {
                XTASK.contains(&format!("name: \"{task}\""))
                    && XTASK.contains(&format!("\n{what} "))
            }
            _ => false,
        };
        assert!(exists, "README: {command}");
    }
}

#[test]
fn its_links_lead_to_files() {
    let links = README.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let pictures = README.split("src=\"").skip(1).filter_map(|rest| rest.split('"').next());
    let targets: Vec<&str> = links.chain(pictures).collect();
    assert!(targets.len() >= 8, "{targets:?}");
    for target in targets {
        assert!(root().join(target).exists(), "README links to {target}");
    }
}

#[test]
fn its_first_screen_has_the_essentials() {
    let first: Vec<&str> = README.lines().take(FIRST_SCREEN).collect();
    let first = first.join("\n");
    for word in [
        "ltbw-cli -- demo",
        "cargo test",
        "ltbw mesh part.stl",
        "```python",
        "```rust",
        "Proved",
        "Tested",
        "Trusted",
    ] {
        assert!(first.contains(word), "{word} is below line {FIRST_SCREEN}");
    }
    assert!(
        first.contains("[limitations]") && first.contains("<img src=") && first.contains("CGAL")
    );
}

/// The cells of the table rows that start with `name`.
fn rows(name: &str) -> Vec<Vec<f64>> {
    let start = format!("| {name} |");
    let rows = README.lines().filter_map(|line| line.strip_prefix(start.as_str()));
    let cells = |row: &str| {
        row.split('|').filter_map(|c| c.trim_matches([' ', '*']).parse().ok()).collect()
    };
    rows.map(cells).collect()
}

#[test]
fn its_two_tables_agree() {
    for set in ["uniform", "rounded-sphere", "moment-curve"] {
        let [short, long] = &rows(set)[..] else { panic!("{set} is not in two tables") };
        let (time, memory) = (long[1] / long[2], long[5] / long[6]);
        assert!((short[0] - time).abs() < 0.006 && (long[3] - time).abs() < 0.006, "{set}: {time}");
        assert!((short[1] - memory).abs() < 0.006, "{set}: {memory}");
    }
}
