//! Structs that may grow: each begins with its own size, as its caller's header has it.
//!
//! A program that was compiled with an older header hands over a shorter struct: what it does not
//! have is zero, which asks for nothing. One with a newer header hands over a longer one, whose
//! further fields have to be zero, as nobody here knows what they ask for.

use ltbw_bindings::{Class, Failure};
use std::mem::MaybeUninit;

/// The largest size that is believed: more is no size, but memory that nobody has set.
const LARGEST: usize = 4096;

/// A struct of C that begins with its size.
///
/// # Safety
/// It is `repr(C)`, its first field is the `u32` of its size, all zero is a value of it, and it is
/// longer than that field.
pub(crate) unsafe trait Growing: Copy {
    /// The name in C.
    const NAME: &str;

    /// The end of the last field that the first version of the struct had: none is shorter. It
    /// stays where it is when fields are added.
    const FIRST: usize;

    /// The struct at a pointer; none at null.
    ///
    /// # Safety
    /// The pointer is null, or points to as many bytes as the number at its beginning says.
    unsafe fn given(pointer: *const Self) -> Result<Option<Self>, Failure> {
        if pointer.is_null() {
            return Ok(None);
        }
        // SAFETY: it is not null, and the caller promises that the number is there.
        let size = unsafe { pointer.cast::<u32>().read() } as usize;
        let name = Self::NAME;
        if !(Self::FIRST..=LARGEST).contains(&size) {
            let text = format!(
                "{name}.struct_size is {size}: it has to be sizeof({name}), as {name}_new() sets it"
            );
            return Err(Failure::new(Class::Input, "argument.struct_size", text));
        }
        let own = size_of::<Self>();
        // SAFETY: as the caller promises, these bytes are there, beyond those that are known.
        let beyond = unsafe { pointer.cast::<u8>().add(own.min(size)) };
        for at in 0..size.saturating_sub(own) {
            // SAFETY: it is within the struct.
            if unsafe { beyond.add(at).read() } != 0 {
                let text = format!(
                    "{name}: the field at byte {} is of a later version than {}",
                    own + at,
                    env!("CARGO_PKG_VERSION")
                );
                return Err(Failure::new(Class::Input, "argument.later", text));
            }
        }
        let mut given = MaybeUninit::<Self>::zeroed();
        // SAFETY: both have that many bytes, and one of them is new; what is not copied is zero,
        // which is a value.
        Ok(Some(unsafe {
            let to = given.as_mut_ptr().cast::<u8>();
            pointer.cast::<u8>().copy_to_nonoverlapping(to, own.min(size));
            given.assume_init()
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A struct that has grown since its first version, with room for what may come.
    #[repr(C)]
    #[derive(Clone, Copy)]
    struct Grown {
        struct_size: u32,
        first: u32,
        second: u64,
    }

    // SAFETY: `repr(C)`, the size first, then numbers.
    unsafe impl Growing for Grown {
        const NAME: &str = "grown";
        const FIRST: usize = 8;
    }

    /// The fields that are read, or the failure's code and message.
    fn read(bytes: &[u64]) -> Result<(u32, u64), String> {
        // SAFETY: the bytes are there, or the size is refused.
        match unsafe { Grown::given(bytes.as_ptr().cast()) } {
            Ok(given) => Ok(given.map(|grown| (grown.first, grown.second)).expect("not null")),
            Err(failure) => Err(format!("{}: {}", failure.code, failure.message)),
        }
    }

    #[test]
    fn shorter_ones_are_filled_with_zeros_and_longer_ones_must_end_in_them() {
        let head = |size: u64| 7 << 32 | size;
        assert_eq!(read(&[head(16), 9]), Ok((7, 9)));
        assert_eq!(read(&[head(8), 9]), Ok((7, 0)), "what follows is not the struct's");
        assert_eq!(read(&[head(24), 9, 0]), Ok((7, 9)));
        let later = read(&[head(24), 9, 1 << 16]).unwrap_err();
        assert!(later.starts_with("argument.later: grown: the field at byte 18"), "{later}");
        for size in [0, 4, 7, 4097, u64::from(u32::MAX)] {
            let refused = read(&[head(size), 9]).unwrap_err();
            assert!(refused.starts_with("argument.struct_size"), "{size}: {refused}");
            assert!(refused.contains("grown_new()"), "{refused}");
        }
    }
}
