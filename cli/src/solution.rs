//! `--sizes`: edge lengths at vertices, from a list or from the points of a solution.

use crate::binding::{Reads, Role, read_beside};
use crate::outcome::Failure;
use ltbw::{TetMesh, io};
use std::path::{Path, PathBuf};

/// A file of sizes: `.mtr`, or a `.vtu` with an array of points.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct SizesFile {
    pub(crate) file: PathBuf,
    /// The name of the array.
    pub(crate) field: Option<String>,
}

impl SizesFile {
    /// The file, and the name behind `.vtu:`.
    pub(crate) fn of(path: PathBuf) -> Self {
        let text = path.to_str().unwrap_or_default();
        let end = text.to_ascii_lowercase().rfind(".vtu:").map(|at| at + ".vtu".len());
        match end {
            Some(end) => {
                let (file, name) = text.split_at(end);
                Self { file: PathBuf::from(file), field: Some(name[1..].to_owned()) }
            }
            None => Self { file: path, field: None },
        }
    }

    fn is_solution(&self) -> bool {
        self.file.extension().is_some_and(|own| own.eq_ignore_ascii_case("vtu"))
    }

    /// Reads them; the mesh of a solution comes with its sizes.
    pub(crate) fn read(&self, reads: &Reads) -> Result<Given, Failure> {
        let name = self.field.as_deref();
        if self.is_solution() {
            let read = |path: &Path, load: &mut io::Load<'_>| io::read_field_by(path, name, load);
            let found = read_beside(reads, Role::Sizes, &self.file, read)?;
            return Ok(Given { sizes: found.values, on: Some(found.mesh) });
        }
        let read = |path: &Path, load: &mut io::Load<'_>| io::read_sizes_by(path, load);
        let sizes = read_beside(reads, Role::Sizes, &self.file, read)?;
        Ok(Given { sizes, on: None })
    }
}

/// Sizes as they were read, with the mesh that has them.
pub(crate) struct Given {
    pub(crate) sizes: Vec<f64>,
    pub(crate) on: Option<TetMesh>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_stands_behind_the_file() {
        let of = |text: &str| {
            let SizesFile { file, field } = SizesFile::of(PathBuf::from(text));
            let is_solution = SizesFile { file: file.clone(), field: None }.is_solution();
            (file.to_str().unwrap_or_default().to_owned(), field, is_solution)
        };
        let named = |file: &str, name: &str| (file.to_owned(), Some(name.to_owned()), true);
        assert_eq!(of("a.vtu:error"), named("a.vtu", "error"));
        assert_eq!(of("C:/b.VTU:h:1"), named("C:/b.VTU", "h:1"));
        assert_eq!(of("a.vtu"), ("a.vtu".to_owned(), None, true));
        assert_eq!(of("a:b.mtr"), ("a:b.mtr".to_owned(), None, false));
    }
}
