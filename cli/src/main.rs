//! The program `ltbw`; all of it is in the library beside this file.
#![deny(unsafe_code)]

use std::process::ExitCode;

/// Pages of the stack that the program has from its beginning.
const STACK_PAGES: u32 = 192;

/// The stack of the first thread grows as it is touched: where memory is limited, that would end
/// the program by a signal in the midst of its work, and not with a code and a word.
fn touch_stack(pages: u32) {
    let page = [0_u8; 4096];
    std::hint::black_box(&page);
    if pages > 1 {
        touch_stack(pages - 1);
    }
    std::hint::black_box(&page);
}

fn main() -> ExitCode {
    touch_stack(STACK_PAGES);
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
