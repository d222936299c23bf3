//! Skipping, in one place: what cannot run because a tool is missing prints
//! `SKIPPED: <what>: <reason>`, unless the environment variable `LTBW_REQUIRE` (a comma-separated
//! list) names the tool or says `all`; then it fails. Shared by the tests and by `cargo xtask`.

use std::io::Write;

/// Does the list `required` (the value of `LTBW_REQUIRE`) demand `tool`?
fn demands(required: &str, tool: &str) -> bool {
    required.split(',').map(str::trim).any(|word| word == tool || word == "all")
}

/// Says that `what` is skipped because of `reason`; an error if `LTBW_REQUIRE` demands `tool`.
pub fn skip(what: &str, tool: &str, reason: &str) -> Result<(), String> {
    let required = std::env::var("LTBW_REQUIRE").unwrap_or_default();
    if demands(&required, tool) {
        return Err(format!("{what}: LTBW_REQUIRE={required}, but {reason}"));
    }
    // Not `println!`: the test runner swallows that for tests that pass, and a skip has to be seen.
    // A closed stdout is no reason to fail.
    let _ = std::io::stdout().lock().write_all(format!("SKIPPED: {what}: {reason}\n").as_bytes());
    Ok(())
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
