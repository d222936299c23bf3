//! Tests of the predicates: against their twins, against `robust` inside the window, and of the
//! perturbation against its definition.

mod families;
mod fast_is_slow;
mod filters;
mod perturbation;
pub(super) mod references;
mod stages;
