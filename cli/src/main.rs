//! The program `ltbw`; all of it is in the library beside this file.
#![deny(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    let backtraces = std::env::var_os("RUST_BACKTRACE").filter(|asked| asked != "0");
    if backtraces.is_some() {
        // A failed allocation would print a backtrace, whose own allocations fail, and wait for its
        // own lock: see `docs/decisions/09-exit-codes.md`.
        #[allow(unsafe_code)]
        // SAFETY: nothing came before, so that this process has no other thread.
        unsafe {
            std::env::set_var("RUST_BACKTRACE", "0");
        }
    }
    ltbw_cli::main(backtraces)
}
