//! Tests of the predicates.
