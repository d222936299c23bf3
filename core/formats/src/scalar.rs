//! Numbers of binary files: any width up to 8 bytes, either byte order, as the `f64` or `i64`
//! that they equal exactly.

use super::error::Reason;

/// The meaning of a number's bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// IEEE 754, of 4 or 8 bytes.
    Float,
    /// Two's complement.
    Signed,
    /// No sign.
    Unsigned,
}

/// The type of a stored number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Scalar {
    pub(super) kind: Kind,
    /// 1, 2, 4 or 8; floats: 4 or 8.
    pub(super) bytes: usize,
    pub(super) big_endian: bool,
}

impl Scalar {
    /// The bits of `raw`, which holds one number, in the low bits of a word.
    pub(super) fn word(self, raw: &[u8]) -> u64 {
        let mut word = [0_u8; 8];
        if self.big_endian {
            for (to, from) in word.iter_mut().zip(raw.iter().rev()) {
                *to = *from;
            }
        } else {
            for (to, from) in word.iter_mut().zip(raw) {
                *to = *from;
            }
        }
        u64::from_le_bytes(word)
    }

    /// The integer in `raw`, for kinds that are integers.
    fn whole(self, raw: &[u8]) -> i128 {
        let word = self.word(raw);
        let unused = 64 - 8 * self.bytes as u32;
        match self.kind {
            Kind::Signed => i128::from(((word << unused) as i64) >> unused),
            Kind::Float | Kind::Unsigned => i128::from(word),
        }
    }

    /// A finite double that equals the number in `raw` (of `self.bytes` bytes) exactly.
    pub(super) fn float(self, raw: &[u8]) -> Result<f64, Reason> {
        if self.kind != Kind::Float {
            return exact_float(self.whole(raw));
        }
        let word = self.word(raw);
        let value = match self.bytes {
            4 => f64::from(f32::from_bits(word as u32)),
            _ => f64::from_bits(word),
        };
        if value.is_finite() { Ok(value) } else { Err(Reason::NotFinite(value.to_string())) }
    }

    /// A 64-bit integer that equals the number in `raw` (of `self.bytes` bytes) exactly.
    pub(super) fn integer(self, raw: &[u8]) -> Result<i64, Reason> {
        if self.kind == Kind::Float {
            let value = self.float(raw)?;
            return exact_integer(value).ok_or_else(|| Reason::NotAnInteger(format!("{value:?}")));
        }
        let value = self.whole(raw);
        i64::try_from(value).map_err(|_| Reason::NotAnInteger(value.to_string()))
    }
}

/// The double that equals `value`, if there is one.
pub(super) fn exact_float(value: i128) -> Result<f64, Reason> {
    let float = value as f64;
    if float as i128 == value { Ok(float) } else { Err(Reason::Inexact(value)) }
}

/// The 64-bit integer that equals `value`, if there is one.
pub(super) fn exact_integer(value: f64) -> Option<i64> {
    const END: f64 = 9_223_372_036_854_775_808.0;
    (value.fract() == 0.0 && (-END..END).contains(&value)).then_some(value as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn either_byte_order_and_sign() {
        let s = |kind, bytes, big_endian| Scalar { kind, bytes, big_endian };
        assert_eq!(s(Kind::Signed, 2, true).integer(&[0xff, 0xfe]), Ok(-2));
        assert_eq!(s(Kind::Unsigned, 2, false).integer(&[0xff, 0xfe]), Ok(0xfeff));
        assert_eq!(s(Kind::Float, 4, true).float(&1.5_f32.to_be_bytes()), Ok(1.5));
        assert_eq!(s(Kind::Float, 8, false).integer(&(-7.0_f64).to_le_bytes()), Ok(-7));
        assert_eq!(
            s(Kind::Unsigned, 8, false).integer(&[0xff; 8]),
            Err(Reason::NotAnInteger(u64::MAX.to_string()))
        );
    }

    #[test]
    fn the_ends_of_the_integers() {
        assert_eq!(exact_integer(-9_223_372_036_854_775_808.0), Some(i64::MIN));
        assert_eq!(exact_integer(9_223_372_036_854_775_808.0), None);
        assert_eq!(exact_integer(0.5), None);
        assert_eq!(exact_integer(f64::NAN), None);
        assert!(exact_float(i128::from(i64::MAX)).is_err());
    }
}
