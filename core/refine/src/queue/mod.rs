//! Queues: one item after the other, before the first round and in joint steps.
//!
//! | module | what it holds |
//! |---|---|
//! | `split` | the three rules, each as a transaction |
//! | `defer` | what comes first |
//! | `joint` | several items split as one step, or none |
//! | `turned` | a subface turned into another facet |

pub(crate) mod defer;
pub(crate) mod joint;
pub(crate) mod split;
pub(crate) mod turned;
