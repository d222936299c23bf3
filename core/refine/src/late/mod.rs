//! Late steps: what was refused, and tetrahedra that the bounds allow.
//!
//! | module | what it holds |
//! |---|---|
//! | `again` | what was refused is asked again |
//! | `moved` | a vertex inside in another place |
//! | `relief` | a point with which fewer are over |
//! | `sharp` | angles too small for their bound of shape |
//! | `sliver` | flat tetrahedra that the bounds allow |

pub(crate) mod again;
pub(crate) mod moved;
pub(crate) mod relief;
pub(crate) mod sharp;
pub(crate) mod sliver;
