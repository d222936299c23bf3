//! Numbers as text.

use ltbw_kit::hex::{from_hex, to_hex};

#[test]
fn known_numbers() {
    let known = [
        (3.0, "0x1.8p+1"),
        (0.0, "0x0p+0"),
        (-0.0, "-0x0p+0"),
        (-0.1, "-0x1.999999999999ap-4"),
        (f64::from_bits(1), "0x0.0000000000001p-1022"),
        (f64::MAX, "0x1.fffffffffffffp+1023"),
    ];
    for (value, text) in known {
        assert_eq!(to_hex(value), text);
        assert_eq!(from_hex(text).map(f64::to_bits), Some(value.to_bits()));
    }
    for wrong in ["", "1.5", "0x1.8", "0x2p+0", "0x1p+1024", "0x1.80p+1", "0x0.1p+0"] {
        assert_eq!(from_hex(wrong), None, "{wrong}");
    }
}

#[test]
fn there_and_back() {
    let mut random = ltbw_tests::families::Rng::new(1);
    for value in ltbw_tests::families::random_bits(500, random.bits()).into_iter().flatten() {
        assert_eq!(from_hex(&to_hex(value)).map(f64::to_bits), Some(value.to_bits()));
    }
}
