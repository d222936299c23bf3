//! The rules of refinement, as functions of what can be seen of a mesh: whoever runs them, on one
//! mesh or on a part of it, may not show here.
//!
//! | module | what it holds |
//! |---|---|
//! | `aim`, `aims` | the point that is proposed |
//! | `strategy` | where it is placed without rounds, and for whom first |
//! | `way`, `walk` | the way to it |
//! | `bounded`, `look` | a closure, whoever has it; the boundary in its cavity |
//! | `verdict`, `plan` | what follows for the point, and for the facets that it lies on |
//! | `group` | circumspheres that are nearly equal |
//! | `watch`, `turns` | what keeps points of one round apart, and who of those is chosen |
//! | `sliver`, `beside`, `star` | which points are tried for a sliver, and which serves |
//! | `record` | what came of earlier proposals |
//! | `block` | what bars many tetrahedra of a round |
//! | `circles` | boundary items that wait for each other |
//! | `complex`, `choice` | boundary, points, items and ranks as values |
//! | `by_values`, `surveyed` | verdicts for a closure of which values are known |

pub(crate) mod aim;
pub(crate) mod aims;
pub(crate) mod beside;
pub(crate) mod block;
pub(crate) mod bounded;
pub(crate) mod by_values;
pub(crate) mod choice;
pub(crate) mod circles;
pub(crate) mod complex;
pub(crate) mod group;
pub(crate) mod look;
pub(crate) mod past;
pub(crate) mod plan;
pub(crate) mod record;
pub(crate) mod related;
pub(crate) mod sliver;
pub(crate) mod star;
pub(crate) mod strategy;
pub(crate) mod surveyed;
pub(crate) mod turns;
pub(crate) mod verdict;
pub(crate) mod walk;
pub(crate) mod watch;
pub(crate) mod way;
