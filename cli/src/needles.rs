//! A word on surfaces of needles: what they cost, and the option that leaves fewer.

use crate::remedy::rounded_up;
use ltbw::domain::{Needles, Prepared, largest_simplification, simplify};
use ltbw::refine::largest_tolerance;

/// Needles below which, or parts of all triangles below which, nothing is said.
const FEW: usize = 20;

/// The most triangles for which options are tried.
const TRIED: usize = 20_000;

/// A note on a surface that has many needles.
pub(crate) fn advice(ready: &Prepared, flat_tolerance: f64) -> Option<String> {
    let now = Needles::of(&ready.domain, flat_tolerance);
    let Needles { triangles, needles, mean_side } = now;
    if needles < FEW || needles * FEW < triangles {
        return None;
    }
    let options = match triangles > TRIED {
        true => vec![format!("`--simplify {}` would leave fewer", rounded_up(mean_side / 16.0))],
        false => [simpler(ready, flat_tolerance, now), flatter(ready, flat_tolerance, now)]
            .into_iter()
            .flatten()
            .collect(),
    };
    let all = format!("note: {triangles} triangles, {needles} of them below 5 degrees");
    Some(match options.is_empty() {
        true => format!("{all}, each with small tetrahedra beside it"),
        false => format!("{all}: {}", options.join("; ")),
    })
}

/// The least tolerance of some that leaves a quarter of the needles.
fn simpler(ready: &Prepared, flat_tolerance: f64, now: Needles) -> Option<String> {
    let limit = largest_simplification(&ready.domain);
    let tolerances = [64.0, 16.0, 8.0].map(|part| rounded_up(now.mean_side / part));
    tolerances.into_iter().filter(|&tolerance| tolerance <= limit).find_map(|tolerance| {
        let simplify::SimplifiedDomain { domain: left, told } =
            simplify::simplified(&ready.domain, tolerance);
        let helps = 4 * Needles::of(&left, flat_tolerance).needles <= now.needles;
        helps.then(|| format!("`--simplify {tolerance}` would leave {}", told.triangles[1]))
    })
}

/// The tolerance of some that takes half of the needles for parts of flat facets.
fn flatter(ready: &Prepared, flat_tolerance: f64, now: Needles) -> Option<String> {
    let limit = largest_tolerance(&ready.domain) / 1.1;
    let tolerances = [1024.0, 64.0].map(|part| rounded_up(now.mean_side / part));
    let mut some = tolerances.into_iter().filter(|&t| flat_tolerance < t && t <= limit);
    some.find_map(|tolerance| {
        let left = Needles::of(&ready.domain, tolerance).needles;
        let taken = now.needles - left.min(now.needles);
        (2 * left <= now.needles)
            .then(|| format!("`--flat-tolerance {tolerance}` takes {taken} of these for flat ones"))
    })
}
