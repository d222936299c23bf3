//! `cli`: bytes to a command line, which is understood or refused.

use std::ffi::OsString;

/// Words of the command line, as long as they are short: the first byte of a word chooses one, and
/// a byte from 128 on begins raw text instead, up to the next zero.
const WORDS: [&str; 56] = [
    "delaunay",
    "check",
    "convert",
    "generate",
    "demo",
    "help",
    "uniform",
    "grid",
    "sphere",
    "clusters",
    "ltbw",
    "-h",
    "--help",
    "-V",
    "--version",
    "-o",
    "--output",
    "--threads",
    "--json",
    "--check",
    "--seed",
    "--any-order",
    "--ascii",
    "--msh2",
    "--out",
    "--",
    "-",
    "",
    "0",
    "1",
    "16",
    "1024",
    "1025",
    "65536",
    "-1",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "1e3",
    "0x10",
    "off",
    "fast",
    "full",
    "a.vtu",
    "a.xyz",
    "a.npy",
    "a.ele",
    "/",
    "-ox.vtu",
    "--output=",
    "--threads=2",
    "--json=-",
    "--check=fast",
    "--seed=",
    "--unknown",
    "-oo",
];

/// The command line of `bytes`, the program's name first.
#[must_use]
pub fn words(bytes: &[u8]) -> Vec<OsString> {
    let mut words = vec![OsString::from("ltbw")];
    let mut rest = bytes;
    while let Some((&first, tail)) = rest.split_first() {
        if first < 128 {
            words.push(WORDS[usize::from(first) % WORDS.len()].into());
            rest = tail;
        } else {
            let end = tail.iter().position(|&b| b == 0).unwrap_or(tail.len());
            words.push(raw(&tail[..end]));
            rest = tail.get(end + 1..).unwrap_or_default();
        }
    }
    words
}

/// Any bytes where the system allows them in arguments; elsewhere, what is text in them.
#[cfg(unix)]
fn raw(bytes: &[u8]) -> OsString {
    std::os::unix::ffi::OsStringExt::from_vec(bytes.to_vec())
}

#[cfg(not(unix))]
fn raw(bytes: &[u8]) -> OsString {
    String::from_utf8_lossy(bytes).into_owned().into()
}

/// Parses the command line of `bytes`; runs nothing.
///
/// # Panics
/// If the parser panics, or refuses with another exit code than that of bad usage, or with more
/// than one line, or with control characters in it, or asked for help gives none.
pub fn cli(bytes: &[u8]) {
    let words = words(bytes);
    let Err(refusal) = ltbw_cli::parse(&words) else {
        assert!(words.len() > 1, "a command line without a command was understood");
        return;
    };
    let text = &refusal.text;
    if refusal.is_help {
        assert!(text.contains("ltbw") && text.ends_with('\n'), "{words:?}: {text:?}");
        // Without a command, help is for people and the exit code says so.
        assert!([0, 2].contains(&refusal.exit), "{words:?}: exit {}", refusal.exit);
        return;
    }
    assert_eq!(refusal.exit, 2, "{words:?}: {text:?}");
    assert!(!text.chars().any(char::is_control), "{words:?}: {text:?}");
    // The help to read is that of the command, if there is one.
    let (said, help) = text.rsplit_once("; see `ltbw").unwrap_or_default();
    assert!(said.len() > 10 && help.ends_with(" --help`"), "{words:?}: {text:?}");
}
