//! `tsan`: the thread runtime under ThreadSanitizer, then its canary.
//!
//! The sanitizer is a nightly flag that stable rustc takes with `RUSTC_BOOTSTRAP=1`, so that what
//! runs is compiled as the tests are. The standard library is not built anew: `--cfg tsan` makes
//! the mailbox's locks visible (`parallel/src/sync/annotated.rs` says how, and what that assumes).
//! Nothing is suppressed.
//!
//! The canary is the same program with the locks hidden again: if no race is reported then, a run
//! without report shows nothing.

use crate::require;
use crate::shell::{self, cargo, command, target, works};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The sanitizer's words for a race.
const RACE: &str = "WARNING: ThreadSanitizer: data race";

/// Builds the program, runs it, runs the canary.
pub(crate) fn run() -> Result<(), String> {
    let host = host()?;
    if host != "x86_64-unknown-linux-gnu" {
        return require::skip("tsan", "tsan", &format!("not set up for {host}"));
    }
    let program = build(&host)?;
    let clean = execute(&program, false)?;
    let said = String::from_utf8_lossy(&clean.stderr);
    if !clean.status.success() || said.contains("ThreadSanitizer") {
        return Err(format!("{}\n{said}", clean.status));
    }
    print!("tsan: no race in {}", String::from_utf8_lossy(&clean.stdout));
    let canary = execute(&program, true)?;
    if !String::from_utf8_lossy(&canary.stderr).contains(RACE) {
        return Err("the canary lives: no race is reported with the locks hidden".to_string());
    }
    println!("tsan: the canary was caught");
    Ok(())
}

fn host() -> Result<String, String> {
    let output = command("rustc").arg("-vV").output().map_err(|error| error.to_string())?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = text.lines().find_map(|line| line.strip_prefix("host: "));
    line.map(str::to_string).ok_or_else(|| "rustc does not name its host".to_string())
}

fn build(host: &str) -> Result<PathBuf, String> {
    let folder = target().join("tsan");
    let flags = std::env::var("RUSTFLAGS").unwrap_or_default();
    let ours = "--cfg tsan -Zsanitizer=thread -Cunsafe-allow-abi-mismatch=sanitizer";
    let mut build = cargo();
    // With a target of its own the flags are not given to build scripts.
    build
        .args(["build", "--quiet", "-p", "ltbw", "--example", "races", "--target", host])
        // Built fast rather than well, as the models are: the run is short.
        .args(["--config", "profile.dev.package.'*'.opt-level=1"])
        .env("CARGO_PROFILE_DEV_OPT_LEVEL", "1")
        .env("RUSTC_BOOTSTRAP", "1")
        .env("RUSTFLAGS", format!("{flags} {ours}").trim_start())
        .env("CARGO_TARGET_DIR", &folder);
    shell::run(&mut build)?;
    Ok(folder.join(host).join("debug/examples/races"))
}

/// Runs `program`, as the canary up to its first race.
fn execute(program: &Path, canary: bool) -> Result<Output, String> {
    // The sanitizer's shadow memory does not fit every layout that the kernel may choose.
    let mut run = if works(command("setarch").args(["-R", "true"])) {
        let mut run = command("setarch");
        run.arg("-R").arg(program);
        run
    } else {
        Command::new(program)
    };
    let halt = u8::from(canary);
    run.env("TSAN_OPTIONS", format!("halt_on_error={halt}")).env_remove("LTBW_TSAN_CANARY");
    if canary {
        run.env("LTBW_TSAN_CANARY", "1");
    }
    run.output().map_err(|error| format!("{run:?}: {error}"))
}
