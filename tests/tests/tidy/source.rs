//! The sources as `tidy` reads them: files by path, their code and their comments apart, tokens.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The text of every Rust source and manifest of the workspace, by path from its root. A test
/// plants a violation by writing such a tree by hand.
#[derive(Default)]
pub(crate) struct Tree(pub(crate) BTreeMap<String, String>);

impl Tree {
    /// Reads all crates below `root`, build folders left out.
    pub(crate) fn read(root: &Path) -> Self {
        let mut tree = Self::default();
        let mut folders = vec![root.to_path_buf()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(&folder).expect("a folder of the workspace").flatten() {
                let path = entry.path();
                let name = entry.file_name().to_string_lossy().into_owned();
                if path.is_dir() {
                    if !name.starts_with('.') && name != "target" && name != "corpus" {
                        folders.push(path);
                    }
                } else if name.ends_with(".rs") || name == "Cargo.toml" || name.ends_with(".md") {
                    let relative = path.strip_prefix(root).expect("a path below the root");
                    let text = fs::read_to_string(&path).expect("a text file");
                    tree.0.insert(relative.to_string_lossy().replace('\\', "/"), text);
                }
            }
        }
        tree
    }

    /// A tree of these files.
    pub(crate) fn of(files: &[(&str, &str)]) -> Self {
        Self(files.iter().map(|&(path, text)| (path.into(), text.into())).collect())
    }

    /// The shipped sources of the crate in `folder`, by path: tests have files of their own.
    pub(crate) fn shipped<'a>(
        &'a self,
        folder: &'a str,
    ) -> impl Iterator<Item = (&'a str, &'a str)> {
        let is_test = |part: &str| part == "tests" || part == "tests.rs";
        let src = move |path: &str| {
            let rest = path.strip_prefix(folder).and_then(|rest| rest.strip_prefix("/src/"));
            rest.is_some_and(|rest| !rest.split('/').any(is_test))
        };
        self.rust(folder).filter(move |&(path, _)| src(path))
    }

    /// The Rust sources in `folder`, by path.
    pub(crate) fn rust<'a>(&'a self, folder: &'a str) -> impl Iterator<Item = (&'a str, &'a str)> {
        let inside = move |path: &str| {
            path.strip_prefix(folder).is_some_and(|rest| folder.is_empty() || rest.starts_with('/'))
        };
        let files = self.0.iter().map(|(path, text)| (path.as_str(), text.as_str()));
        files.filter(move |&(path, _)| path.ends_with(".rs") && inside(path))
    }
}

/// A comment: the number of its first line, and its text. Lines that follow each other are one.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Comment {
    pub(crate) line: usize,
    pub(crate) text: String,
}

/// Code with comments and the contents of literals blanked, line by line as before, and the
/// comments.
pub(crate) fn split(text: &str) -> (String, Vec<Comment>) {
    let chars: Vec<char> = text.chars().collect();
    let at = |k: usize| chars.get(k).copied().unwrap_or('\0');
    let (mut code, mut comments) = (String::with_capacity(text.len()), Vec::<Comment>::new());
    let (mut k, mut line) = (0, 1);
    // The line after the last comment, if nothing but blanks has come since.
    let mut open = 0;
    while k < chars.len() {
        if at(k) == '/' && at(k + 1) == '/' {
            let end = (k..chars.len()).find(|&e| chars[e] == '\n').unwrap_or(chars.len());
            let text: String = chars[k..end].iter().collect();
            let text = text.trim_start_matches(['/', '!']).trim();
            match comments.last_mut() {
                Some(last) if open == line && !text.is_empty() => {
                    last.text.push(' ');
                    last.text.push_str(text);
                }
                _ if text.is_empty() => {}
                _ => comments.push(Comment { line, text: text.into() }),
            }
            open = if text.is_empty() { 0 } else { line + 1 };
            k = end;
            continue;
        }
        if at(k) == '/' && at(k + 1) == '*' {
            let mut depth = 0;
            loop {
                match (at(k), at(k + 1)) {
                    ('/', '*') => (depth, k) = (depth + 1, k + 2),
                    ('*', '/') => (depth, k) = (depth - 1, k + 2),
                    ('\n', _) => {
                        code.push('\n');
                        (line, k) = (line + 1, k + 1);
                    }
                    _ => k += 1,
                }
                if depth == 0 || k >= chars.len() {
                    break;
                }
            }
            continue;
        }
        let start = k;
        k = end_of_literal(&chars, k);
        if k > start {
            let lines = chars[start..k].iter().filter(|&&c| c == '\n').count();
            code.push('"');
            // A sign on every line: each is code.
            code.extend(std::iter::repeat_n("\n\"", lines));
            code.push_str(if lines == 0 { "\"" } else { "" });
            line += lines;
            open = 0;
            continue;
        }
        let c = at(k);
        if c == '\n' {
            line += 1;
        } else if !c.is_whitespace() {
            open = 0;
        }
        code.push(c);
        k += 1;
    }
    (code, comments)
}

/// The end of the string or character literal that starts at `k`; `k` if none does.
fn end_of_literal(chars: &[char], k: usize) -> usize {
    let at = |k: usize| chars.get(k).copied().unwrap_or('\0');
    let inside_word = k > 0 && (at(k - 1).is_alphanumeric() || at(k - 1) == '_');
    // r"..", r#".."#, br".."
    if !inside_word && (at(k) == 'r' || (at(k) == 'b' && at(k + 1) == 'r')) {
        let mut e = k + if at(k) == 'b' { 2 } else { 1 };
        let hashes = (e..).take_while(|&h| at(h) == '#').count();
        e += hashes;
        if at(e) == '"' {
            let closes = |e: usize| at(e) == '"' && (1..=hashes).all(|h| at(e + h) == '#');
            let end = (e + 1..chars.len()).find(|&e| closes(e)).unwrap_or(chars.len());
            return (end + 1 + hashes).min(chars.len());
        }
    }
    let quote = at(k);
    // A lifetime has no quote after its first letter.
    let is_char = quote == '\'' && (at(k + 1) == '\\' || at(k + 2) == '\'');
    if quote != '"' && !is_char {
        return k;
    }
    let mut e = k + 1;
    while e < chars.len() && chars[e] != quote {
        e += if chars[e] == '\\' { 2 } else { 1 };
    }
    (e + 1).min(chars.len())
}

/// A word or a sign of code, and its line. `::` is one sign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Token {
    pub(crate) text: String,
    pub(crate) line: usize,
}

/// The tokens of code without comments.
pub(crate) fn tokens(code: &str) -> Vec<Token> {
    let mut tokens: Vec<Token> = Vec::new();
    let (mut line, mut word) = (1, String::new());
    for c in code.chars().chain(['\n']) {
        if c.is_alphanumeric() || c == '_' {
            word.push(c);
            continue;
        }
        if !word.is_empty() {
            tokens.push(Token { text: std::mem::take(&mut word), line });
        }
        match tokens.last_mut() {
            Some(last) if c == ':' && last.text == ":" && last.line == line => last.text.push(':'),
            _ if !c.is_whitespace() => tokens.push(Token { text: c.into(), line }),
            _ => {}
        }
        line += usize::from(c == '\n');
    }
    tokens
}

/// The tokens of shipped code: without what follows `#[cfg(test)]` or another condition on `test`.
pub(crate) fn shipped(tokens: &[Token]) -> Vec<Token> {
    let text = |k: usize| tokens.get(k).map_or("", |token| token.text.as_str());
    let (mut kept, mut k) = (Vec::new(), 0);
    while k < tokens.len() {
        if text(k) == "#" && text(k + 1) == "[" && text(k + 2) == "cfg" {
            let end = end_of_group(tokens, k + 1);
            // `not(test)` is shipped; `all(test, not(..))` is not.
            let is_asked_for = |&place: &usize| text(place) == "test" && text(place - 2) != "not";
            if (k + 3..end).any(|place| is_asked_for(&place)) {
                k = end_of_item(tokens, end);
                continue;
            }
        }
        kept.push(tokens[k].clone());
        k += 1;
    }
    kept
}

/// The place after the bracket that closes the one at `k`.
fn end_of_group(tokens: &[Token], k: usize) -> usize {
    let mut depth = 0;
    for (place, token) in tokens.iter().enumerate().skip(k) {
        match token.text.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return place + 1;
        }
    }
    tokens.len()
}

/// The place after the item at `k`: after its block or its semicolon; attributes belong to it.
fn end_of_item(tokens: &[Token], mut k: usize) -> usize {
    while let Some(token) = tokens.get(k) {
        match token.text.as_str() {
            ";" => return k + 1,
            "{" => return end_of_group(tokens, k),
            "(" | "[" => k = end_of_group(tokens, k),
            _ => k += 1,
        }
    }
    k
}

#[test]
fn comments_and_literals_are_told_from_code() {
    let text = "let a = \"// no\"; // so many\n// lines\nlet b = 'x'; /* gone\n */ fn f<'a>() {}\n";
    let (code, comments) = split(text);
    assert_eq!(code, "let a = \"\"; \n\nlet b = \"\"; \n fn f<'a>() {}\n");
    assert_eq!(comments, [Comment { line: 1, text: "so many lines".into() }]);
    let (code, _) = split("r#\"use \"crate::a\" \"# + b\"x\\\"\" + c");
    assert_eq!(code, "\"\" + b\"\" + c");
}

/// The number of lines of shipped code: without blank lines, comments and tests.
pub(crate) fn lines_of_code(text: &str) -> usize {
    let lines: BTreeSet<usize> =
        shipped(&tokens(&split(text).0)).iter().map(|token| token.line).collect();
    lines.len()
}

#[test]
fn lines_of_code_are_counted() {
    let text = "//! Page.\n\nfn f() {\n    /* a\n b */ let s = \"a\n// b\n\"; // c\n}\n\
                #[cfg(all(test, not(any(loom, shuttle))))]\nmod tests {\n    fn g() {}\n}\n";
    assert_eq!(lines_of_code(text), 5); // f, both ends of the literal, and its middle; the brace
    assert_eq!(lines_of_code("#[cfg(not(test))]\nfn f() {}\n"), 2);
}

#[test]
fn code_for_tests_is_left_out() {
    let code =
        "use a::b; #[cfg(test)] #[x] mod tests { use c::{d}; } #[cfg(test)] use e; fn f() {}";
    let left: Vec<String> = shipped(&tokens(code)).into_iter().map(|t| t.text).collect();
    assert_eq!(left.concat(), "usea::b;fnf(){}");
}
