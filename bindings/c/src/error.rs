//! Status codes, and the reason of the last failure.

use ltbw_bindings::{Class, Failure, unpanicked};
use std::cell::{Cell, RefCell};
use std::ffi::{CString, c_char};
use std::sync::Once;

/// The end of a call.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Done.
    LTBW_OK = 0,
    /// The arguments are no points, no surface, or no bounds that a mesh can meet.
    LTBW_INPUT = 1,
    /// The surface bounds nothing that can be meshed.
    LTBW_DOMAIN = 2,
    /// The surface could not be brought into a Delaunay mesh.
    LTBW_RECOVERY = 3,
    /// Cancelled before there was a mesh.
    LTBW_CANCELLED = 4,
    /// A file could not be read or written.
    LTBW_FILE = 5,
    /// The machine lacks memory or threads.
    LTBW_MACHINE = 6,
    /// A defect of ltbw itself: please report it.
    LTBW_INTERNAL = 70,
}

/// The last failure of a thread, as C reads it.
#[derive(Default)]
struct Last {
    message: CString,
    code: CString,
    ids: Vec<u32>,
}

thread_local! {
    static LAST: RefCell<Last> = RefCell::default();
}

/// Text for C, which ends at its first zero.
pub(crate) fn text(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

/// Notes a failure; the answer is its status.
pub(crate) fn failed(failure: &Failure) -> Status {
    let last = Last {
        message: text(&failure.message),
        code: text(failure.code),
        ids: failure.ids.clone(),
    };
    // A thread that ends has no place for it any more.
    let _ = LAST.try_with(|place| *place.borrow_mut() = last);
    match failure.class {
        Class::Input => Status::LTBW_INPUT,
        Class::Domain => Status::LTBW_DOMAIN,
        Class::Recovery => Status::LTBW_RECOVERY,
        Class::Cancelled => Status::LTBW_CANCELLED,
        Class::File => Status::LTBW_FILE,
        Class::Machine => Status::LTBW_MACHINE,
        Class::Internal => Status::LTBW_INTERNAL,
    }
}

thread_local! {
    /// Is this thread within a call?
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}

/// Nothing of a panic inside a call goes to the screen of the program: its status tells. Threads
/// without a name are the library's own.
fn quiet() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            let is_named = std::thread::current().name().is_some();
            if is_named && !INSIDE.try_with(Cell::get).unwrap_or(true) {
                before(panic);
            }
        }));
    });
}

/// Carries out the work of a call: its failures and panics become a status.
pub(crate) fn guarded(work: impl FnOnce() -> Result<(), Failure>) -> Status {
    quiet();
    let before = INSIDE.replace(true);
    let done = unpanicked(work);
    INSIDE.set(before);
    match done {
        Ok(()) => Status::LTBW_OK,
        Err(failure) => failed(&failure),
    }
}

/// A pointer that must not be null is.
pub(crate) fn null(name: &str) -> Failure {
    Failure::new(Class::Input, "argument.null", format!("{name} is NULL"))
}

/// The message of this thread's last failure; empty before the first. It lives until the next one.
#[unsafe(no_mangle)]
pub extern "C" fn ltbw_last_error() -> *const c_char {
    LAST.try_with(|last| last.borrow().message.as_ptr()).unwrap_or(c"".as_ptr())
}

/// The code of this thread's last failure: a short name that stays the same between versions.
#[unsafe(no_mangle)]
pub extern "C" fn ltbw_last_error_code() -> *const c_char {
    LAST.try_with(|last| last.borrow().code.as_ptr()).unwrap_or(c"".as_ptr())
}

/// The numbers of the elements at fault in this thread's last failure, counted from 0; their number
/// goes to `count`. They live until the next failure.
///
/// # Safety
/// `count` is null or a place for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_last_error_ids(count: *mut usize) -> *const u32 {
    let ids = LAST.try_with(|last| (last.borrow().ids.as_ptr(), last.borrow().ids.len()));
    let (ids, length) = ids.unwrap_or((std::ptr::null(), 0));
    // SAFETY: the caller promises that `count` is null or a place for a number.
    if let Some(count) = unsafe { count.as_mut() } {
        *count = length;
    }
    ids
}

/// The version of the library.
#[unsafe(no_mangle)]
pub extern "C" fn ltbw_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_a_status_with_its_text() {
        assert_eq!(guarded(|| panic!("asked for")), Status::LTBW_INTERNAL);
        let message = LAST.with(|last| last.borrow().message.clone());
        assert!(message.to_string_lossy().contains("asked for"), "{message:?}");
    }
}
