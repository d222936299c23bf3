//! Test support for the workspace: the CGAL reference, exact oracles and input families.
//!
//! | module | what it holds |
//! |---|---|
//! | [`cgal`] | the CGAL server process of `tests/cgal/server.cpp`: build, start, ask |
//! | [`oracle`] | the predicates by `rug`, and brute-force Delaunay of a few points |
//! | [`epsilon`] | the perturbation by its definition: polynomials in ε |
//! | [`small_world`] | all meshes of all subsets of a few points, by definition |
//! | [`overlap`] | whether two tetrahedra overlap, by `rug` |
//! | [`overlaps`] | overlaps planted into sound meshes |
//! | [`families`] | the input families of the bars, deterministic by seed |
//! | [`domains`], [`layered`] | random domains |
//! | [`excuses`] | the counter of excuses: angles of a domain, what its mesh leaves over a bound |
//! | [`five_points`] | five points at a time, for the predicates |
//! | [`compare`] | our mesh against CGAL's: tetrahedra, hull facets, hash; two refined domains |
//! | [`parts`] | the surfaces of `cargo xtask parts` |
//! | [`plant`] | defects planted into sound meshes, for the checker to find |
//! | [`solids`] | sound meshes of bodies of every shape |
//! | [`fuzz`] | the bodies of the fuzz targets, so that `cargo test` replays their corpora |
//! | [`corpora`] | these corpora, an archive a target |
//! | [`interleave`] | the parallel kernel, one event at a time in a chosen order |
//! | [`require`] | what is skipped when a tool is missing, and when that is a failure |
#![forbid(unsafe_code)]

pub mod cgal;
pub mod compare;
pub mod corpora;
pub mod domains;
pub mod epsilon;
pub mod excuses;
pub mod families;
pub mod five_points;
pub mod fuzz;
pub mod interleave;
pub mod layered;
pub mod oracle;
pub mod overlap;
pub mod overlaps;
pub mod parts;
pub mod plant;
pub mod require;
pub mod small_world;
pub mod solids;
pub mod teams;

use std::ops::Range;

/// Number of random cases: `LTBW_CASES` if it is set, else `default`.
///
/// # Panics
/// If `LTBW_CASES` is not a number: a typo must not turn the full bar into the small one.
#[must_use]
pub fn cases(default: u32) -> u32 {
    std::env::var("LTBW_CASES")
        .map_or(default, |text| text.parse().expect("LTBW_CASES is a whole number"))
}

/// The seeds of random cases: `LTBW_CASES` if it is set (their number, or `first..end`, so that a
/// long run can be done in pieces), else as many as `default`, from 0 on.
///
/// # Panics
/// If `LTBW_CASES` is neither, or names none.
#[must_use]
pub fn seeds(default: u32) -> Range<u64> {
    let Ok(text) = std::env::var("LTBW_CASES") else { return 0..u64::from(default) };
    let (first, end) = text.split_once("..").unwrap_or(("0", &text));
    let number = |text: &str| text.parse().expect("LTBW_CASES is 1000 or 0..1000");
    let seeds = number(first)..number(end);
    assert!(!seeds.is_empty(), "LTBW_CASES names no case");
    seeds
}

/// The median of at least one number; of an even count, the mean of the middle two.
#[must_use]
pub fn median(numbers: &mut [f64]) -> f64 {
    numbers.sort_by(f64::total_cmp);
    (numbers[(numbers.len() - 1) / 2] + numbers[numbers.len() / 2]) / 2.0
}
