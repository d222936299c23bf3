//! Skipping, in one place: a test whose tool is missing prints `SKIPPED: <test>: <reason>`, unless
//! the environment variable `LTBW_REQUIRE` (a comma-separated list) names the tool or says `all`;
//! then it fails.

use std::io::Write;

/// The environment variable that lists the tools that must be there.
pub const REQUIRE: &str = "LTBW_REQUIRE";

/// Does the list `required` (the value of [`REQUIRE`]) demand `tool`?
#[must_use]
pub fn demands(required: &str, tool: &str) -> bool {
    required.split(',').map(str::trim).any(|word| word == tool || word == "all")
}

/// Reports that `test` cannot run because of `reason`.
///
/// # Panics
/// If `LTBW_REQUIRE` demands `tool`.
pub fn skip(test: &str, tool: &str, reason: &str) {
    let required = std::env::var(REQUIRE).unwrap_or_default();
    assert!(!demands(&required, tool), "{test}: {REQUIRE}={required}, but {reason}");
    // Not `println!`: the test runner swallows that for tests that pass, and a skip has to be seen.
    // A closed stdout is no reason to fail.
    let _ = std::io::stdout().lock().write_all(format!("SKIPPED: {test}: {reason}\n").as_bytes());
}

/// Number of random cases: `LTBW_CASES` if it is set, else `default`.
///
/// # Panics
/// If `LTBW_CASES` is not a number: a typo must not turn the full bar into the small one.
#[must_use]
pub fn cases(default: u32) -> u32 {
    std::env::var("LTBW_CASES")
        .map_or(default, |text| text.parse().expect("LTBW_CASES is a whole number"))
}

#[cfg(test)]
mod tests {
    use super::demands;

    #[test]
    fn a_list_demands_its_words_and_all_demands_everything() {
        assert!(demands("cgal", "cgal") && demands("coq, cgal", "cgal") && demands("all", "cgal"));
        assert!(!demands("", "cgal") && !demands("cgal2,coq", "cgal"));
    }
}
