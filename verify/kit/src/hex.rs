//! Hexadecimal floats, as C's `%a` and Python's `float.hex` write them: every bit is visible, and
//! no reader has to round.

/// `value` as hexadecimal text, without trailing zeros: `0x1.8p+1` is 3.
///
/// # Panics
/// If `value` is not finite.
#[must_use]
pub fn to_hex(value: f64) -> String {
    assert!(value.is_finite(), "vectors have finite numbers only, not {value}");
    let bits = value.to_bits();
    let sign = if value.is_sign_negative() { "-" } else { "" };
    let (biased, fraction) = (bits >> 52 & 0x7ff, bits & ((1 << 52) - 1));
    let (whole, exponent) = match (biased, fraction) {
        (0, 0) => (0, 0),
        (0, _) => (0, -1022),
        _ => (1, biased as i64 - 1023),
    };
    let digits = format!("{fraction:013x}");
    let digits = digits.trim_end_matches('0');
    let point = if digits.is_empty() { "" } else { "." };
    format!("{sign}0x{whole}{point}{digits}p{exponent:+}")
}

/// Reads what [`to_hex`] writes; `None` for anything else.
#[must_use]
pub fn from_hex(text: &str) -> Option<f64> {
    let (sign, rest) = match text.strip_prefix('-') {
        Some(rest) => (1u64 << 63, rest),
        None => (0, text),
    };
    let (mantissa, exponent) = rest.strip_prefix("0x")?.split_once('p')?;
    let exponent: i64 = exponent.parse().ok()?;
    let (whole, digits) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    if digits.len() > 13 || digits.ends_with('0') {
        return None;
    }
    let fraction = u64::from_str_radix(&format!("{digits:0<13}"), 16).ok()?;
    let biased = match (whole, exponent) {
        ("0", 0) if fraction == 0 => 0,
        ("0", -1022) if fraction != 0 => 0,
        ("1", -1022..=1023) => (exponent + 1023) as u64,
        _ => return None,
    };
    Some(f64::from_bits(sign | biased << 52 | fraction))
}
