//! Tables of numbers in pages: each stands in a section that names the command which prints it.
//! Decisions are records of their time, and so is the list of changes.

use super::source::Tree;

#[path = "../../../xtask/src/figures/table.rs"]
mod table;

use table::{FIGURES, Figures, PARTS, Place};

/// Pages whose figures are those of a day.
const RECORDS: &[&str] = &["docs/decisions/", "CHANGELOG.md"];

/// A heading of a page with the lines up to the next one.
struct Section<'p> {
    heading: &'p str,
    lines: Vec<&'p str>,
}

fn sections(text: &str) -> Vec<Section<'_>> {
    let (mut all, mut is_code) = (vec![Section { heading: "", lines: Vec::new() }], false);
    for line in text.lines() {
        is_code ^= line.starts_with("```");
        match line.strip_prefix('#').filter(|_| !is_code) {
            Some(rest) => {
                let heading = rest.trim_start_matches('#').trim();
                all.push(Section { heading, lines: Vec::new() });
            }
            None => all.last_mut().expect("one section").lines.push(line),
        }
    }
    all
}

/// Is this a number, perhaps with its unit?
fn is_number(cell: &str) -> bool {
    let cell = cell.trim_matches(|c: char| c.is_whitespace() || "*~<≤≥".contains(c));
    let words = cell.split_whitespace().filter(|word| word.contains(char::is_alphabetic));
    cell.starts_with(|c: char| c.is_ascii_digit()) && words.count() <= 1
}

/// Has one of the tables among these lines a column of numbers, by its rule or by what it holds?
fn has_numbers(lines: &[&str]) -> bool {
    let tables = lines.split(|line| !line.starts_with('|')).filter(|table| table.len() > 2);
    let cells = |line: &'_ str| -> Vec<String> {
        line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect()
    };
    tables.into_iter().any(|table| {
        let rule = cells(table[1]);
        let rows: Vec<Vec<String>> = table[2..].iter().map(|row| cells(row)).collect();
        let numbers = |k: usize| {
            rows.iter().filter(|row| row.get(k).is_some_and(|cell| is_number(cell))).count()
        };
        (0..rule.len()).any(|k| match rule[k].ends_with("-:") {
            true => numbers(k) > 0,
            false => k > 0 && 2 * numbers(k) > rows.len(),
        })
    })
}

/// Is `code` the command, perhaps with fewer words? A word in capitals stands for any.
fn is_short_for(code: &str, command: &str) -> bool {
    let least = if command.starts_with("ltbw ") { 2 } else { 3 };
    let mut rest = command.split_whitespace();
    let mut matched = code.split_whitespace().enumerate().map(|(k, word)| {
        let is_any = |word: &str| word.bytes().all(|c| c.is_ascii_uppercase());
        match k < least {
            true => rest.next() == Some(word),
            false => rest.any(|own| own == word || is_any(word)),
        }
    });
    code.split_whitespace().count() >= least && matched.all(|is_it| is_it)
}

/// The commands of the list that a place names, in short or with more options.
fn named<'f>(tree: &Tree, place: &Place, own: &'f Figures) -> Option<Vec<&'f str>> {
    let page = tree.0.get(place.page)?;
    let all = sections(page);
    let at = all.iter().filter(|own| place.heading.is_empty() || own.heading == place.heading);
    let lines: Vec<&str> = at.flat_map(|own| own.lines.iter().copied()).collect();
    let has_heading = place.heading.is_empty() || all.iter().any(|s| s.heading == place.heading);
    let text = lines.join(" ");
    let codes: Vec<&str> = text.split('`').skip(1).step_by(2).collect();
    let is_it = |code: &str, line: &str| is_short_for(code, line) || is_short_for(line, code);
    let is_named = |line: &&&str| codes.iter().any(|code| is_it(code, line));
    has_heading.then(|| own.commands.iter().filter(is_named).copied().collect())
}

/// Tables of numbers without a command, and entries of the list that no page has.
pub(crate) fn faults(tree: &Tree, list: &[Figures]) -> Vec<String> {
    let mut found = Vec::new();
    let is_record = |page: &str| RECORDS.iter().any(|start| page.starts_with(start));
    let pages = tree.0.iter().filter(|(page, _)| page.ends_with(".md") && !is_record(page));
    for (page, text) in pages {
        for own in sections(text).iter().filter(|own| has_numbers(&own.lines)) {
            let is_it =
                |place: &Place| place.page == page && ["", own.heading].contains(&place.heading);
            if !list.iter().any(|figures| figures.places.iter().any(is_it)) {
                found.push(format!("{page}: {}: `cargo xtask figures` has no table", own.heading));
            }
        }
    }
    for own in list {
        let mut all = Vec::new();
        for place in own.places {
            let place_is = format!("{}: {}: {}", own.name, place.page, place.heading);
            match named(tree, place, own).as_deref() {
                None => found.push(format!("{place_is}: no such section")),
                Some([]) => found.push(format!("{place_is}: no command is named")),
                Some(some) => all.extend_from_slice(some),
            }
        }
        let missing = own.commands.iter().filter(|line| !all.contains(*line));
        found.extend(missing.map(|line| format!("{}: no page names {line}", own.name)));
    }
    found
}

/// Faults of the real list.
pub(crate) fn faults_of_pages(tree: &Tree) -> Vec<String> {
    faults(tree, FIGURES)
}

#[test]
fn tables_without_a_command_are_found() {
    let numbers = "| a | s |\n|---|--:|\n| b | 1.5 |\n";
    let plain = "| a | b |\n|---|---|\n| 1 | two |\n";
    let own = |commands: &'static [&'static str]| Figures {
        name: "own",
        places: &[Place { page: "docs/a.md", heading: "A" }],
        commands,
    };
    let faults_of = |page: &str, list: &[Figures]| faults(&Tree::of(&[("docs/a.md", page)]), list);
    let by = "`cargo xtask\nbench` and more";
    assert_eq!(faults_of(&format!("# A\n{plain}"), &[]), [""; 0]);
    let found = ["docs/a.md: A: `cargo xtask figures` has no table"];
    assert_eq!(faults_of(&format!("# A\n{by}\n\n{numbers}"), &[]), found);
    let list = [own(&["cargo xtask bench quality"])];
    assert_eq!(faults_of(&format!("# A\n{by}\n\n{numbers}"), &list), [""; 0]);
    let more = format!("# A\n`cargo xtask bench quality --write`\n\n{numbers}");
    assert_eq!(faults_of(&more, &list), [""; 0]);
    let found = [
        "own: docs/a.md: A: no command is named",
        "own: no page names \
                 cargo xtask bench quality",
    ];
    assert_eq!(faults_of(&format!("# B\n{by}\n# A\n{numbers}"), &list), found);
    let text = format!("# A\n{by}\n# B\n{numbers}");
    assert_eq!(faults_of(&text, &list), ["docs/a.md: B: `cargo xtask figures` has no table"]);
    let found = [
        "own: docs/a.md: A: no such section",
        "own: no page names \
                 cargo xtask bench quality",
    ];
    assert_eq!(faults_of("# B\n", &list), found);
    let record = Tree::of(&[("docs/decisions/01-a.md", numbers), ("CHANGELOG.md", numbers)]);
    assert_eq!(faults(&record, &[]), [""; 0]);
}

#[test]
fn numbers_are_found_whatever_the_rule_says() {
    let has = |table: &str| has_numbers(&table.lines().collect::<Vec<_>>());
    for table in ["| 3 – 4 |", "| **1.2** |", "| 17 ms |", "| 8° |", "| < 5 % |"] {
        assert!(has(&format!("| a |\n|--:|\n{table}")), "{table}");
        assert!(has(&format!("| a | b |\n|---|---|\n| x {table}")), "{table}");
    }
    for table in ["| none |", "| 5 bits and sign |", "| R19 |", "| – |"] {
        assert!(!has(&format!("| a |\n|--:|\n{table}")), "{table}");
    }
    assert!(!has("| step | what |\n|---|---|\n| 1 | begin |"), "numbers of rows");
}

#[test]
fn commands_are_named_in_short() {
    let command = "cargo xtask parts DIR --twins --only x";
    assert_eq!(PARTS, "DIR");
    for code in [command, "cargo xtask parts", "cargo xtask parts DIR --twins"] {
        assert!(is_short_for(code, command), "{code}");
    }
    for code in ["cargo xtask", "cargo xtask bench", "cargo xtask parts --only --twins"] {
        assert!(!is_short_for(code, command), "{code}");
    }
    assert!(is_short_for("ltbw simulate --points N", "ltbw simulate --machine cow --points 5"));
    assert!(!is_short_for("ltbw mesh --points N", "ltbw simulate --machine cow --points 5"));
}
