//! The macro of numbers in types of their own: tetrahedra, vertices, workers, blocks.

/// Numbers of one kind, from 0, which the compiler takes for no others.
#[macro_export]
#[doc(hidden)]
macro_rules! ids {
    ($($(#[$meta:meta])* $name:ident),*) => {$(
        $(#[$meta])*
        #[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(transparent)]
        pub struct $name(u32);

        impl $name {
            /// The one with this number.
            #[inline(always)]
            pub const fn new(number: u32) -> Self {
                Self(number)
            }

            /// The one with this place in an array.
            #[inline(always)]
            pub const fn at(index: usize) -> Self {
                Self(index as u32)
            }

            /// All with the numbers below `end`.
            pub fn below(
                end: u32,
            ) -> impl DoubleEndedIterator<Item = Self> + ExactSizeIterator + Clone {
                (0..end).map(Self)
            }

            /// Its number.
            #[inline(always)]
            pub const fn number(self) -> u32 {
                self.0
            }

            /// Its place in an array.
            #[inline(always)]
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl From<$name> for u32 {
            #[inline(always)]
            fn from(id: $name) -> Self {
                id.0
            }
        }

        impl ::std::fmt::Display for $name {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                self.0.fmt(f)
            }
        }

        // The number alone: states and traces name the field beside it.
        impl ::std::fmt::Debug for $name {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                self.0.fmt(f)
            }
        }
    )*};
}
