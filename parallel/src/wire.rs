//! Messages as bytes, for workers that share no memory: mails one after the other make a *letter*.
//!
//! The encoding is postcard's: numbers in as few bytes as they need, coordinates in eight. A letter
//! is read by the bytes that came and takes memory for no more than these tell; what is no letter
//! is an error that names its sender.

use crate::payload::{LOAD_BYTES, Payload, bytes};
use crate::protocol::{Submesh, WorkerId};
use crate::transport::Mail;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The version of the letters: workers with different ones do not understand each other.
pub const VERSION: u32 = 1;

/// A letter that cannot be read, or written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a letter of worker {from} makes no sense at byte {at} of {length}: {reason}")]
pub struct WireError {
    /// Its sender.
    pub from: WorkerId,
    /// The first byte of the message that makes no sense.
    pub at: usize,
    /// The bytes of the letter.
    pub length: usize,
    /// The reason.
    pub reason: String,
}

/// A value that travels.
pub trait Wire: Sized {
    /// Adds it to the end of a letter of `from`.
    ///
    /// # Errors
    /// [`WireError`] if it has no encoding, which no message of ours is without.
    fn put(&self, from: WorkerId, letter: &mut Vec<u8>) -> Result<(), WireError>;

    /// Takes it from `at` of a letter of `from`, and says where the next one begins.
    ///
    /// # Errors
    /// [`WireError`] if there is none.
    fn get(from: WorkerId, letter: &[u8], at: &mut usize) -> Result<Self, WireError>;
}

/// Adds a value to the end of a letter.
pub(crate) fn put(
    value: &impl Serialize,
    from: WorkerId,
    letter: &mut Vec<u8>,
) -> Result<(), WireError> {
    let at = letter.len();
    match postcard::to_extend(value, std::mem::take(letter)) {
        Ok(longer) => *letter = longer,
        Err(error) => return Err(WireError { from, at, length: at, reason: error.to_string() }),
    }
    Ok(())
}

/// Takes a value from `at` of a letter.
pub(crate) fn get<T: DeserializeOwned>(
    from: WorkerId,
    letter: &[u8],
    at: &mut usize,
) -> Result<T, WireError> {
    let rest = letter.get(*at..).unwrap_or_default();
    let fail = |reason: String| WireError { from, at: *at, length: letter.len(), reason };
    match postcard::take_from_bytes(rest) {
        Ok((_, after)) if after.len() == rest.len() => {
            Err(fail("a message of no bytes".to_owned()))
        }
        Ok((value, after)) => {
            *at = letter.len() - after.len();
            Ok(value)
        }
        Err(error) => Err(fail(error.to_string())),
    }
}

/// A value as bytes.
pub fn bytes_of(value: &impl Serialize, from: WorkerId) -> Result<Vec<u8>, WireError> {
    let mut letter = Vec::new();
    put(value, from, &mut letter)?;
    Ok(letter)
}

/// The value that a whole letter is.
pub fn value_of<T: DeserializeOwned>(from: WorkerId, letter: &[u8]) -> Result<T, WireError> {
    let mut at = 0;
    let value = get(from, letter, &mut at)?;
    match at == letter.len() {
        true => Ok(value),
        false => {
            let reason = "bytes after its end".to_owned();
            Err(WireError { from, at, length: letter.len(), reason })
        }
    }
}

impl<S: Submesh> Wire for Mail<S>
where
    Mail<S>: Serialize + DeserializeOwned,
{
    fn put(&self, from: WorkerId, letter: &mut Vec<u8>) -> Result<(), WireError> {
        put(self, from, letter)
    }

    fn get(from: WorkerId, letter: &[u8], at: &mut usize) -> Result<Self, WireError> {
        get(from, letter, at)
    }
}

/// The bytes that the simulator charges for a mail.
pub fn charged<S: Payload>(mail: &Mail<S>) -> u64 {
    mail.message.as_ref().map_or(LOAD_BYTES, bytes)
}

/// All mails of a letter, in their order.
///
/// # Errors
/// [`WireError`] at the first bytes that are none; the mails before it are in `into`.
pub fn open<M: Wire>(
    from: WorkerId,
    letter: &[u8],
    mut into: impl FnMut(M),
) -> Result<(), WireError> {
    let mut at = 0;
    // Ends: a mail has at least one byte.
    while at < letter.len() {
        into(M::get(from, letter, &mut at)?);
    }
    Ok(())
}

/// Coordinates as bits, which travel as the floats that they are; in text as numbers.
pub(crate) mod bits {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(bits: &[u64; 3], to: S) -> Result<S::Ok, S::Error> {
        match to.is_human_readable() {
            true => bits.serialize(to),
            false => bits.map(f64::from_bits).serialize(to),
        }
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<[u64; 3], D::Error> {
        match from.is_human_readable() {
            true => <[u64; 3]>::deserialize(from),
            false => <[f64; 3]>::deserialize(from).map(|p| p.map(f64::to_bits)),
        }
    }
}

/// News that are told together, none of which is such news itself: a letter cannot make its reader
/// go deeper and deeper.
pub(crate) mod flat {
    use serde::de::value::U32Deserializer;
    use serde::de::{
        DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, Error, IntoDeserializer,
        Visitor,
    };
    use serde::{Deserialize, forward_to_deserialize_any};
    use std::fmt;
    use std::marker::PhantomData;

    /// The variant that holds others.
    const DEEP: &str = "Several";

    pub(crate) fn deserialize<'de, D, T>(from: D) -> Result<Vec<T>, D::Error>
    where
        D: Deserializer<'de>,
        T: DeserializeOwned,
    {
        let all = Vec::<Single<T>>::deserialize(from)?;
        Ok(all.into_iter().map(|single| single.0).collect())
    }

    /// A value of an enum that is not `DEEP`.
    struct Single<T>(T);

    impl<'de, T: DeserializeOwned> Deserialize<'de> for Single<T> {
        fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
            T::deserialize(Shallow(from)).map(Self)
        }
    }

    struct Shallow<D>(D);

    impl<'de, D: Deserializer<'de>> Deserializer<'de> for Shallow<D> {
        type Error = D::Error;

        fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, D::Error> {
            Err(D::Error::custom("not an enum"))
        }

        fn deserialize_enum<V: Visitor<'de>>(
            self,
            name: &'static str,
            variants: &'static [&'static str],
            visitor: V,
        ) -> Result<V::Value, D::Error> {
            self.0.deserialize_enum(name, variants, Watched { visitor, variants })
        }

        forward_to_deserialize_any! {
            bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf
            option unit unit_struct newtype_struct seq tuple tuple_struct map struct identifier
            ignored_any
        }
    }

    struct Watched<V> {
        visitor: V,
        variants: &'static [&'static str],
    }

    impl<'de, V: Visitor<'de>> Visitor<'de> for Watched<V> {
        type Value = V::Value;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            self.visitor.expecting(f)
        }

        fn visit_enum<A: EnumAccess<'de>>(self, access: A) -> Result<V::Value, A::Error> {
            self.visitor.visit_enum(Looked { access, variants: self.variants })
        }
    }

    struct Looked<A> {
        access: A,
        variants: &'static [&'static str],
    }

    impl<'de, A: EnumAccess<'de>> EnumAccess<'de> for Looked<A> {
        type Error = A::Error;
        type Variant = A::Variant;

        fn variant_seed<T: DeserializeSeed<'de>>(
            self,
            seed: T,
        ) -> Result<(T::Value, A::Variant), A::Error> {
            let (number, variant) = self.access.variant_seed(PhantomData::<u32>)?;
            if self.variants.get(number as usize) == Some(&DEEP) {
                return Err(A::Error::custom("news in news in news"));
            }
            let number: U32Deserializer<A::Error> = number.into_deserializer();
            Ok((seed.deserialize(number)?, variant))
        }
    }
}
