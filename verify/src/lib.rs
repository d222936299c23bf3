//! Independent exact checker.
