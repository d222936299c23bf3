//! The hand-written stages evaluate the polynomials of the descriptions, to the last bit.
//!
//! Two polynomials of degree 5 that differ are equal at no more than 5 in 2^B of all points whose
//! coordinates have B bits: a single random point would tell, but for 2^-60. The other side are the
//! textbook's formulas of the tests ([`references`]).

use num_bigint::BigInt;
use proptest::prelude::*;

use super::super::PLANES;
use super::super::tests::references::{self, Place};
use super::fixed::big;
use super::*;

/// Coordinates of `bits` bits, often the largest there are.
fn coordinate(bits: u32) -> impl Strategy<Value = i128> {
    let most = (1_i128 << bits) - 1;
    prop_oneof![4 => -most..=most, 1 => Just(most), 1 => Just(-most), 1 => Just(0)]
}

fn four(bits: u32) -> impl Strategy<Value = [[i128; 3]; 4]> {
    let place = move || [coordinate(bits), coordinate(bits), coordinate(bits)];
    [place(), place(), place(), place()]
}

/// These places and the origin.
fn with_origin<const N: usize>(p: [[i128; 3]; N]) -> Vec<Place> {
    p.iter().chain([&[0; 3]]).map(|p| p.map(BigInt::from)).collect()
}

proptest! {
    #[test]
    fn small_stages_are_the_polynomials(p in four(62)) {
        let [a, b, c, d] = p.map(|p| p.map(|x| i64::try_from(x).expect("62 bits")));
        let three = with_origin([p[0], p[1], p[2]]);
        prop_assert_eq!(-big(&det3_small(&a, &b, &c)), references::orient3d(&three));
        let expected = references::insphere(&with_origin(p));
        prop_assert_eq!(big(&insphere_small(&a, &b, &c, &d)), expected);
        for plane @ [i, j] in PLANES {
            let turn = references::orient2d(&with_origin([p[0], p[1]]), plane);
            prop_assert_eq!(BigInt::from(minor(&a, &b, i, j)), turn);
            let circle = references::incircle(&three, plane);
            prop_assert_eq!(big(&incircle_small(&a, &b, &c, plane)), circle);
        }
    }

    #[test]
    fn medium_stages_are_the_polynomials(p in four(124)) {
        let [a, b, c, d] = p;
        let three = with_origin([a, b, c]);
        prop_assert_eq!(-big(&det3_medium(&a, &b, &c)), references::orient3d(&three));
        let expected = references::insphere(&with_origin(p));
        prop_assert_eq!(big(&insphere_medium(&a, &b, &c, &d)), expected);
        for plane @ [i, j] in PLANES {
            let turn = references::orient2d(&with_origin([a, b]), plane);
            prop_assert_eq!(big(&minor_medium(&a, &b, i, j)), turn);
            let circle = references::incircle(&three, plane);
            prop_assert_eq!(big(&incircle_medium(&a, &b, &c, plane)), circle);
        }
    }

    /// The factors in f64, with as many bits as keep their products exact.
    #[test]
    fn few_bits_are_the_polynomials(p in four(16)) {
        let [a, b, c, d] = p.map(|p| p.map(|x| x as f64));
        let [wa, wb, wc, wd] = insphere_factors(&a, &b, &c, &d)
            .map(|(lift, det)| BigInt::from(lift as i128) * BigInt::from(det as i128));
        prop_assert_eq!((wd - wc) + (wb - wa), references::insphere(&with_origin(p)));
    }
}
