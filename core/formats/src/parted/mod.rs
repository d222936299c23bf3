//! Meshes in parts: borders between parts, and the formats that tell of them.
//!
//! | module | what it holds |
//! |---|---|
//! | `files` | a part, and the names of the files of parts |
//! | `border` | shared vertices, edges and faces, numbers of the whole, copies beside |
//! | `words` | what parts tell each other about that |
//! | `mfem` | MFEM's meshes in parts |

mod border;
mod files;
mod mfem;
mod words;

pub use border::{Border, Bordering, Common, Ghost, GhostPoint, borders};
pub use files::{
    Arrays, PartOf, PartSizes, Piece, has_list, has_slabs, is_parts, part_files,
    parts_hold_exterior, parts_hold_tags,
};
pub(crate) use files::{Kind, part_file};
pub(crate) use mfem::{check, write};
pub use words::Words;
