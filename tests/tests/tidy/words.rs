//! Words that comments do without: a reader with English as a second language stumbles over them.

use super::source::{Tree, split, tokens};
use std::collections::BTreeSet;

/// Phrases, as words and signs apart. `^` is the start of a sentence.
pub(crate) const BANNED: &[(&str, &str)] = &[
    ("so many", "name the number: `count`, `most`, `the given number of`"),
    ("hang together", "connected"),
    ("hangs together", "connected"),
    ("^ who", "a noun: the worker, the request, the caller"),
    ("only who", "a noun"),
    ("those who", "those that; or a noun"),
    ("all who", "all that; or a noun"),
    ("^ of it", "name the thing"),
    (", of it", "name the thing"),
    ("and of it", "name the thing"),
    ("what of it", "name the thing"),
    ("nothing of it", "name the thing"),
    ("more is not known of it", "name the thing"),
    ("what is left of it", "name the thing"),
    ("^ of these ,", "a noun first"),
    ("^ of those ,", "a noun first"),
    ("had better", "should"),
    ("is to have", "say what is written where"),
    ("has no say", "is not asked"),
    ("have no say", "are not asked"),
];

/// Words that a comment does not open with: its first sentence has a noun as its subject.
const OPENINGS: &[&str] = &["what", "who", "whose", "whoever", "how", "those"];

/// The words and signs of a text in lower case, with `^` at the start of each sentence. Code in
/// backquotes is one word.
fn words(text: &str) -> Vec<String> {
    let mut words = vec!["^".to_owned()];
    for (k, part) in text.split('`').enumerate() {
        if k % 2 == 1 {
            words.push("`".into());
            continue;
        }
        let mut word = String::new();
        for c in part.chars().chain([' ']) {
            if c.is_alphanumeric() || c == '\'' || c == '-' {
                word.extend(c.to_lowercase());
                continue;
            }
            if !word.is_empty() {
                words.push(std::mem::take(&mut word));
            }
            if ".:;?!".contains(c) {
                words.extend([c.to_string(), "^".into()]);
            } else if !c.is_whitespace() {
                words.push(c.into());
            }
        }
    }
    words
}

/// The banned phrases of a comment, each with words that serve instead. A question may start with
/// "who".
pub(crate) fn found_in(text: &str) -> Vec<(&'static str, &'static str)> {
    let words = words(text);
    let is_at = |phrase: &[&str], k: usize| {
        phrase.iter().enumerate().all(|(n, word)| words.get(k + n).is_some_and(|w| w == word))
    };
    let asks = |k: usize| {
        words[k + 1..].iter().find(|w| ".:;?!".contains(w.as_str())).is_some_and(|w| w == "?")
    };
    let has = |phrase: &str| {
        let parts: Vec<&str> = phrase.split(' ').collect();
        (0..words.len()).any(|k| is_at(&parts, k) && !(phrase == "^ who" && asks(k)))
    };
    let opening = OPENINGS.iter().filter(|&&word| words.get(1).is_some_and(|w| w == word));
    let opening = opening.filter(|_| !asks(0)).map(|&word| (word, "a noun as subject"));
    opening.chain(BANNED.iter().copied().filter(|(phrase, _)| has(phrase))).collect()
}

/// All banned phrases in comments of the tree: `file:line: phrase (instead)`.
pub(crate) fn banned(tree: &Tree) -> Vec<String> {
    let mut all = Vec::new();
    for (file, text) in tree.rust("") {
        for comment in split(text).1 {
            for (phrase, instead) in found_in(&comment.text) {
                all.push(format!("{file}:{}: \"{phrase}\" ({instead})", comment.line));
            }
        }
    }
    all
}

/// Doc comments that lean on the one before: each stands alone where it is read, so it says what
/// its item is. `file:line`.
pub(crate) fn leaning(tree: &Tree) -> Vec<String> {
    let doc = |line: &'_ str| line.trim_start().starts_with("///");
    let mut all = Vec::new();
    for (file, text) in tree.rust("") {
        let mut before = "";
        for (line, number) in text.lines().zip(1..) {
            let rest = line.trim_start().strip_prefix("/// The same");
            let leans = rest.is_some_and(|rest| !rest.starts_with(char::is_alphanumeric));
            if leans && !doc(before) {
                all.push(format!("{file}:{number}"));
            }
            before = line;
        }
    }
    all
}

/// Names on a page that no source has: `page: name`. A name is made of identifiers, joined by `::`;
/// anything else in backquotes is not looked at, nor are words of a figure without `::`.
pub(crate) fn unknown_names(tree: &Tree, page: &str) -> Vec<String> {
    let code = tree.rust("").flat_map(|(_, text)| tokens(&split(text).0));
    let folders = tree.0.keys().flat_map(|path| path.split(['/', '.']).map(str::to_owned));
    let known: BTreeSet<String> = code.map(|token| token.text).chain(folders).collect();
    let text = tree.0.get(page).map_or("", String::as_str);
    let outside: String = text.split("\n```").step_by(2).collect();
    let figures = text.split("\n```").skip(1).step_by(2);
    let is_sign = |c: char| !c.is_ascii_alphanumeric() && c != '_' && c != ':';
    let in_figures = figures.flat_map(|figure| figure.split(is_sign));
    let in_figures = in_figures.map(|name| name.trim_end_matches(':')).filter(|n| n.contains("::"));
    let is_word = |part: &str| {
        part.starts_with(|c: char| c.is_ascii_alphabetic())
            && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    let names = outside.split('`').skip(1).step_by(2).chain(in_figures);
    let names = names.filter(|name| name.split("::").all(is_word));
    let unknown = names.filter(|name| !name.split("::").all(|part| known.contains(part)));
    unknown.map(|name| format!("{page}: {name}")).collect()
}

#[test]
fn a_name_that_no_source_has_is_found() {
    let page = "`Cavity::fill` `gone` `Cavity::gone` `4 * t` `a/b.rs`\n\
                ```\n`x` Cavity::fill: here, Cavity::drawn\n```\n";
    let tree =
        Tree::of(&[("a.md", page), ("cli/src/lib.rs", "impl Cavity { fn fill() {} } // gone")]);
    let expected = ["gone", "Cavity::gone", "Cavity::drawn"].map(|name| format!("a.md: {name}"));
    assert_eq!(unknown_names(&tree, "a.md"), expected);
}

#[test]
fn doc_comments_that_lean_on_others_are_found() {
    let text =
        "/// The same for b.\nfn f() {}\n/// A lake.\n/// The same one.\n// The same here.\n";
    assert_eq!(leaning(&Tree::of(&[("cli/src/lib.rs", text)])), ["cli/src/lib.rs:1"]);
}

#[test]
fn every_banned_phrase_is_found_in_comments_and_nowhere_else() {
    for &(phrase, _) in BANNED {
        let said = format!("First. {} things.", phrase.replace("^ ", ""));
        assert!(found_in(&said).iter().any(|found| found.0 == phrase), "{phrase}");
    }
    for fine in [
        "All of it.",
        "It is the same.",
        "So few; many so.",
        "Who is older?",
        "the worker who asks",
        "`so many`",
    ] {
        assert_eq!(found_in(fine), [("", ""); 0], "{fine}");
    }
    let tree = |text| Tree::of(&[("cli/src/lib.rs", text)]);
    let found = banned(&tree("/// At most so\n/// many.\nfn f() {}"));
    assert!(found.len() == 1 && found[0].starts_with("cli/src/lib.rs:1: \"so many\""), "{found:?}");
    assert_eq!(banned(&tree("const SO: &str = \"so many\";")), [""; 0]);
}
