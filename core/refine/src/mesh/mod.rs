//! The boundary in a mesh: marks, tables, and what follows from them.
//!
//! | module | what it holds |
//! |---|---|
//! | `state` | mesh, marks and tables |
//! | `marks` | marks of faces and edges, regions: one word per tetrahedron |
//! | `item` | subsegments, subfaces, tetrahedra that are to be split |
//! | `encroachment` | pending boundary items by place |
//! | `journal` | the changes of a joint step, to be taken back |
//! | `survey`, `facet` | the boundary in a cavity; the change of a facet |
//! | `names` | what is boundary, as carriers tell |
//! | `tiles` | where a patch is in the mesh |
//! | `region` | inside, outside, regions |
//! | `bounds`, `limit` | what is over its bounds; how short edges may be |
//! | `window` | the mesh of a part of the vertices |
//! | `key`, `number` | orders by coordinates alone; numbers that are functions of the mesh |

pub(crate) mod bounds;
pub(crate) mod encroachment;
pub(crate) mod facet;
pub(crate) mod item;
pub(crate) mod journal;
pub(crate) mod key;
pub(crate) mod limit;
pub(crate) mod marks;
pub(crate) mod names;
pub(crate) mod number;
pub(crate) mod region;
pub(crate) mod state;
pub(crate) mod survey;
pub(crate) mod tiles;
pub(crate) mod window;
