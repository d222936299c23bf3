//! Signatures of shipped functions: the number of their parameters, and tuples among these and in
//! results.

use super::arrows::CRATES;
use super::source::{Token, Tree, shipped, split, tokens};

/// The most parameters of a function, `self` not counted.
const PARAMETERS: usize = 5;

/// The signature of a function with a name.
struct Signature<'t> {
    name: &'t str,
    /// May other crates call it?
    is_public: bool,
    /// The types of its parameters, without `self`.
    types: Vec<&'t [Token]>,
    /// The type of its result, if it has one.
    result: &'t [Token],
}

/// Folders of crates whose functions nobody but other crates of the workspace calls.
const TOOLS: &[&str] = &["tests/", "verify/models/", "verify/kit/", "fuzz/", "xtask/"];

/// Functions with more parameters than allowed: `file: name`.
pub(crate) fn many_parameters(tree: &Tree) -> Vec<String> {
    let is_one = |function: &Signature<'_>| function.types.len() > PARAMETERS;
    found(tree, |file, function| is_one(function).then(|| format!("{file}: {}", function.name)))
}

/// Functions with a tuple among the types of their parameters, whose members want names:
/// `file: name`. The function `from` of a conversion has the tuple to whose members it gives
/// names.
pub(crate) fn tuples(tree: &Tree) -> Vec<String> {
    let is_one = |function: &Signature<'_>| {
        function.name != "from" && function.types.iter().any(|tokens| has_tuple(tokens))
    };
    found(tree, |file, function| is_one(function).then(|| format!("{file}: {}", function.name)))
}

/// Public functions with a tuple in the type of their result: `file: name`. The entries of an
/// iterator, a key and its value, are none.
pub(crate) fn tuples_in_results(tree: &Tree) -> Vec<String> {
    let is_one = |function: &Signature<'_>| {
        function.is_public && has_tuple(&without_entries(function.result))
    };
    let of_tool = |file: &str| TOOLS.iter().any(|folder| file.starts_with(folder));
    found(tree, |file, function| {
        (!of_tool(file) && is_one(function)).then(|| format!("{file}: {}", function.name))
    })
}

/// A type without the pairs that iterators in it have for items.
fn without_entries(tokens: &[Token]) -> Vec<Token> {
    let text = |k: usize| tokens.get(k).map_or("", |token| token.text.as_str());
    let (mut kept, mut k) = (Vec::new(), 0);
    while k < tokens.len() {
        kept.push(tokens[k].clone());
        k += 1;
        if text(k) == "(" && text(k - 1) == "=" && k > 1 && text(k - 2) == "Item" {
            let end = closing(tokens, k);
            let entry = &tokens[k + 1..end];
            if parted(entry).len() == 2 && !has_tuple(entry) {
                k = end + 1;
            }
        }
    }
    kept
}

fn found(tree: &Tree, told: impl Fn(&str, &Signature<'_>) -> Option<String>) -> Vec<String> {
    let of_file = |(file, text): (&str, &str)| {
        let tokens = shipped(&tokens(&split(text).0));
        let starts = (0..tokens.len()).filter(|&k| tokens[k].text == "fn");
        let functions = starts.filter_map(|k| signature(&tokens, k));
        functions.filter_map(|function| told(file, &function)).collect::<Vec<_>>()
    };
    CRATES.iter().flat_map(|krate| tree.shipped(krate.folder)).flat_map(of_file).collect()
}

/// The signature of the function whose `fn` is at `k`; `None` if it is a type, as `fn(u8)` is.
fn signature(tokens: &[Token], k: usize) -> Option<Signature<'_>> {
    let name = tokens.get(k + 1)?;
    let open = match tokens.get(k + 2)?.text.as_str() {
        "<" => closing(tokens, k + 2) + 1,
        _ => k + 2,
    };
    if name.text == "(" || tokens.get(open)?.text != "(" {
        return None;
    }
    // Without a colon it is `self`, by reference or by value.
    let type_of = |part: &'_ [Token]| {
        let colon = part.iter().position(|token| token.text == ":")?;
        (part[colon - 1].text != "self").then_some(colon + 1)
    };
    let close = closing(tokens, open);
    let parts = parted(&tokens[open + 1..close]);
    let types = parts.into_iter().filter_map(|part| part.get(type_of(part)?..)).collect();
    let (is_public, result) = (is_public(tokens, k), result(&tokens[close + 1..]));
    Some(Signature { name: &name.text, is_public, types, result })
}

/// Has the function whose `fn` is at `k` a bare `pub`?
fn is_public(tokens: &[Token], k: usize) -> bool {
    let is_between =
        |token: &&Token| ["const", "unsafe", "async", "extern"].contains(&&*token.text);
    let before = tokens[..k].iter().rev().find(|token| !is_between(token));
    before.is_some_and(|token| token.text == "pub")
}

/// The type behind the arrow, if one is next.
fn result(tokens: &[Token]) -> &[Token] {
    let is_arrow = tokens.len() > 2 && tokens[0].text == "-" && tokens[1].text == ">";
    let tokens = if is_arrow { &tokens[2..] } else { &[] };
    let mut depth = 0;
    let mut is_end = |k: usize| {
        let is_end = depth == 0 && ["{", ";", "where"].contains(&&*tokens[k].text);
        depth += step(tokens, k);
        is_end
    };
    let end = (0..tokens.len()).find(|&k| is_end(k));
    &tokens[..end.unwrap_or(tokens.len())]
}

/// Is there a tuple of two or more in a type? The parameters of a closure are none.
fn has_tuple(tokens: &[Token]) -> bool {
    let is_name = |text: &str| text == "fn" || text.starts_with(char::is_uppercase);
    (0..tokens.len()).any(|k| {
        tokens[k].text == "("
            && !(k > 0 && is_name(&tokens[k - 1].text))
            && parted(&tokens[k + 1..closing(tokens, k)]).len() > 1
    })
}

/// The parts between commas outside brackets; behind a comma at the end there is none.
fn parted(tokens: &[Token]) -> Vec<&[Token]> {
    let (mut parts, mut start, mut depth) = (Vec::new(), 0, 0);
    for k in 0..tokens.len() {
        depth += step(tokens, k);
        if depth == 0 && tokens[k].text == "," {
            parts.push(&tokens[start..k]);
            start = k + 1;
        }
    }
    parts.extend((start < tokens.len()).then(|| &tokens[start..]));
    parts
}

/// The place of the bracket that closes the one at `k`; that of the last token if none does.
fn closing(tokens: &[Token], k: usize) -> usize {
    let mut depth = 0;
    let mut is_end = |place: usize| {
        depth += step(tokens, place);
        depth == 0
    };
    (k..tokens.len()).find(|&place| is_end(place)).unwrap_or(tokens.len() - 1)
}

/// The change of depth at token `k` of a signature: `<` and `>` are brackets, arrows are not.
fn step(tokens: &[Token], k: usize) -> i32 {
    match tokens[k].text.as_str() {
        "(" | "[" | "{" | "<" => 1,
        ">" if k > 0 && tokens[k - 1].text == "-" => 0,
        ")" | "]" | "}" | ">" => -1,
        _ => 0,
    }
}

#[test]
fn functions_with_many_parameters_are_found() {
    let found = |text: &str| many_parameters(&Tree::of(&[("cli/src/lib.rs", text)]));
    let five = "impl A { fn f<F: Fn(u8, u8) -> u8>(&mut self, a: u8, b: Map<u8, u8>, c: [u8; 2], \
                d: &F, e: u8,) {} }";
    assert_eq!(found(five), [""; 0]);
    let six = five.replace("&mut self", "s: u8");
    assert_eq!(found(&six), ["cli/src/lib.rs: f"]);
    assert_eq!(found(&format!("#[cfg(test)] mod tests {{ {six} }}")), [""; 0]);
    assert_eq!(found("fn g(f: fn(u8, u8, u8, u8, u8, u8) -> u8) {}"), [""; 0]);
}

#[test]
fn tuples_in_parameters_are_found() {
    let found = |text: &str| tuples(&Tree::of(&[("cli/src/lib.rs", text)]));
    let of = |parameters: &str| found(&format!("trait A {{ fn f<T>({parameters}) -> (u8, u8); }}"));
    for wrong in [
        "&self, (a, b): (u8, u8)",
        "a: &[(u8, T)]",
        "a: &mut (u8, T)",
        "a: u8, b: impl Iterator<Item = (u8, &'a str)>",
        "a: impl Fn(u8) -> (u8, u8)",
        "a: impl Fn((u8, u8)) -> u8",
        "a: Option<(u8, Option<u8>)>",
    ] {
        assert_eq!(of(wrong), ["cli/src/lib.rs: f"], "{wrong}");
    }
    for fine in [
        "",
        "self: Box<Self>",
        "a: (), b: (u8), c: Pair<u8, u8>",
        "a: impl Fn(u8, u8) -> Result<u8, ()>, b: &mut dyn FnMut(u8, &T)",
        "(a, b): Pair, Pair(c, d): Pair, e: fn(u8, u8) -> u8",
        "a: u8, // (a, b): (u8, u8)\n",
    ] {
        assert_eq!(of(fine), [""; 0], "{fine}");
    }
    assert_eq!(found("fn from((a, b): (u8, u8)) {}"), [""; 0]);
}

#[test]
fn tuples_in_results_are_found() {
    let found = |text: &str| tuples_in_results(&Tree::of(&[("cli/src/lib.rs", text)]));
    for wrong in [
        "(u8, u8)",
        "Result<(Self, u8), ()>",
        "Option<&(u8, T)>",
        "impl Iterator<Item = (u8, u8, T)> + '_",
        "impl Iterator<Item = (u8, (u8, T))>",
    ] {
        let text = format!("impl A {{ pub const fn f<T>(a: u8) -> {wrong} where T: B {{}} }}");
        assert_eq!(found(&text), ["cli/src/lib.rs: f"], "{wrong}");
        assert_eq!(found(&text.replace("pub", "pub(crate)")), [""; 0], "{wrong}");
        let fixtures = Tree::of(&[("tests/src/lib.rs", &*text)]);
        assert_eq!(tuples_in_results(&fixtures), [""; 0], "{wrong}");
    }
    for fine in ["()", "[(u8); 2]", "impl Fn(u8, u8) -> T", "impl Iterator<Item = (u8, &'_ T)>"] {
        assert_eq!(found(&format!("pub fn f<T>() -> {fine} {{ (1, 2) }}")), [""; 0], "{fine}");
    }
    assert_eq!(found("pub fn f() {} fn g() -> (u8, u8) {}"), [""; 0]);
}
