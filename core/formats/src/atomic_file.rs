//! Writing aside: a file appears under its final name complete, or not at all.
//!
//! Each file is written under a temporary name in the folder of the final one, flushed, synced
//! and only then renamed. When anything fails before, the temporary file is removed and whatever
//! had the final name is still there, untouched.

use super::error::{IoError, show};
use super::write_error;
use ltbw_core::CancelToken;
use std::fs::File;
use std::io::{BufWriter, Error, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, TempPath};

/// Links that are followed one after the other: as many as Linux follows.
const LINKS: usize = 40;

/// Bytes that every writer takes for its buffers, and a thread for rows of text.
const BUFFERS: usize = 4 << 20;
const ROWS: usize = 12 << 20;

/// The needs of the writing of a file.
#[derive(Clone, Copy, Default)]
pub(super) struct Needs<'a> {
    /// The token that ends it.
    pub(super) cancel: Option<&'a CancelToken>,
    /// Bytes that it takes, beside the buffers of every writer.
    pub(super) memory: usize,
}

impl<'a> Needs<'a> {
    /// No memory of its own.
    pub(super) fn until(cancel: &'a CancelToken) -> Self {
        Self { cancel: Some(cancel), memory: 0 }
    }
}

/// A file written in full under a temporary name.
pub(super) struct AtomicFile {
    file: TempPath,
    path: PathBuf,
    target: PathBuf,
}

impl AtomicFile {
    /// Writes a file with `fill`, to be named `path` by [`AtomicFile::publish`].
    pub(super) fn write(
        path: &Path,
        fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<Self, IoError> {
        Self::write_until(path, Needs::default(), fill)
    }

    /// Writes a file as [`AtomicFile::write`] does, until the token says otherwise.
    pub(super) fn write_until(
        path: &Path,
        Needs { cancel, memory }: Needs<'_>,
        fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<Self, IoError> {
        let memory = memory
            .saturating_add(BUFFERS)
            .saturating_add(rayon::current_num_threads().max(1) * ROWS);
        Self::try_write(path, Needs { cancel, memory }, fill).map_err(|e| match cancel {
            Some(token) if token.is_cancelled() => IoError::Cancelled { path: path.to_owned() },
            _ => write_error(path, e),
        })
    }

    fn try_write(
        path: &Path,
        Needs { cancel, memory }: Needs<'_>,
        fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> std::io::Result<Self> {
        let target = target(path)?;
        // Memory that is lacking must not end the program while there is a temporary file.
        ltbw_core::ask(memory).map_err(|e| Error::new(ErrorKind::OutOfMemory, e))?;
        let (file, temp_path) = temporary(&target)?.into_parts();
        let mut out = BufWriter::with_capacity(1 << 20, Cancellable { file, cancel });
        fill(&mut out)?;
        let file = out.into_inner().map_err(|e| e.into_error())?.file;
        file.sync_all()?;
        Ok(Self { file: temp_path, path: path.to_owned(), target })
    }

    /// Where the file is until it has its name.
    pub(super) fn aside(&self) -> &Path {
        &self.file
    }

    /// Gives the file its final name, unless the token was set meanwhile.
    pub(super) fn publish_unless(self, cancel: &CancelToken) -> Result<(), IoError> {
        match cancel.is_cancelled() {
            true => Err(IoError::Cancelled { path: self.path }),
            false => self.publish(),
        }
    }

    /// Gives the file its final name, replacing what had it.
    pub(super) fn publish(self) -> Result<(), IoError> {
        let Self { file, path, target } = self;
        file.persist(&target).map_err(|e| write_error(&path, e.error))
    }
}

/// A file that is written until a token says otherwise.
struct Cancellable<'a> {
    file: File,
    cancel: Option<&'a CancelToken>,
}

impl Write for Cancellable<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        match self.cancel.is_some_and(CancelToken::is_cancelled) {
            true => Err(Error::other("cancelled")),
            false => self.file.write(bytes),
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

/// An empty file under a temporary name in the folder of `target`; dropping it removes it.
fn temporary(target: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".ltbw-").suffix(".tmp");
    // As for any new file: read and write for all, less the process's umask.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder(target)).map_err(bare)
}

/// The temporary file's name means nothing to people: keep only the operating system's reason.
fn bare(error: Error) -> Error {
    let inner = error.get_ref().and_then(|e| e.source()).and_then(|e| e.downcast_ref::<Error>());
    match inner.and_then(Error::raw_os_error).or(error.raw_os_error()) {
        Some(code) => Error::from_raw_os_error(code),
        None => Error::from(error.kind()),
    }
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    }
}

/// The file to replace: symbolic links are followed; folders and devices are refused.
fn target(path: &Path) -> std::io::Result<PathBuf> {
    match std::fs::metadata(path) {
        Ok(meta) if meta.is_dir() => Err(Error::from(ErrorKind::IsADirectory)),
        Ok(meta) if !meta.is_file() => {
            Err(Error::new(ErrorKind::InvalidInput, "not a regular file"))
        }
        Ok(_) => std::fs::canonicalize(path),
        Err(e) if e.kind() == ErrorKind::NotFound => {
            let target = behind_links(path)?;
            let folder = folder(&target);
            match std::fs::metadata(folder) {
                Ok(_) => Ok(target),
                Err(e) if e.kind() == ErrorKind::NotFound => {
                    let text = format!("the folder {} is missing", show(folder));
                    Err(Error::new(ErrorKind::NotFound, text))
                }
                Err(e) => Err(e),
            }
        }
        Err(e) => Err(e),
    }
}

/// The file that a link leads to, which need not be there.
fn behind_links(path: &Path) -> std::io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..LINKS {
        match std::fs::read_link(&path) {
            Ok(next) => path = folder(&path).join(next),
            Err(_) => return Ok(path),
        }
    }
    Err(Error::other("too many symbolic links"))
}

/// Tells, before long work starts, what would certainly keep `path` from being written: a missing
/// folder or one that takes no file, or something under that name that is not a file. A file is
/// made under a temporary name, and removed.
pub(super) fn check(path: &Path) -> Result<(), IoError> {
    let check = || {
        let target = target(path)?;
        match std::fs::metadata(folder(&target)) {
            Ok(meta) if !meta.is_dir() => Err(Error::from(ErrorKind::NotADirectory)),
            Ok(_) => temporary(&target).map(drop),
            Err(e) => Err(e),
        }
    };
    check().map_err(|e| write_error(path, e))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(dir: &Path) -> Vec<String> {
        let mut v: Vec<String> = std::fs::read_dir(dir)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        v.sort();
        v
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.xyz");
        std::fs::write(&path, "old").unwrap();
        let result = AtomicFile::write(&path, |out| {
            out.write_all(&[b'x'; 3 << 20])?;
            Err(Error::from(ErrorKind::StorageFull))
        });
        assert!(matches!(result, Err(IoError::Write { .. })));
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(names(dir.path()), ["a.xyz"]);
    }

    #[test]
    fn a_write_that_is_cancelled_in_the_midst_leaves_the_old_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.xyz");
        std::fs::write(&path, "old").unwrap();
        let (token, mut taken) = (CancelToken::new(), 0);
        let result = AtomicFile::write_until(&path, Needs::until(&token), |out| {
            for k in 0..100 {
                if k == 3 {
                    token.cancel();
                }
                out.write_all(&[b'x'; 1 << 20])?;
                taken += 1;
            }
            Ok(())
        });
        assert!(matches!(result, Err(IoError::Cancelled { .. })));
        assert!((3..6).contains(&taken), "{taken}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(names(dir.path()), ["a.xyz"]);
    }

    #[test]
    fn nothing_appears_before_it_is_published() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.xyz");
        let aside = AtomicFile::write(&path, |out| out.write_all(b"new")).unwrap();
        assert!(!path.exists());
        aside.publish().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(names(dir.path()), ["a.xyz"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed_and_modes_are_ordinary() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let (real, link) = (dir.path().join("real.xyz"), dir.path().join("link.xyz"));
        std::fs::write(&real, "old").unwrap();
        let ordinary = std::fs::metadata(&real).unwrap().permissions().mode();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        AtomicFile::write(&link, |out| out.write_all(b"new")).unwrap().publish().unwrap();
        assert_eq!(std::fs::read(&real).unwrap(), b"new");
        assert!(std::fs::symlink_metadata(&link).unwrap().file_type().is_symlink());
        assert_eq!(std::fs::metadata(&real).unwrap().permissions().mode(), ordinary);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_what_is_not_there_yet_is_followed() {
        use std::os::unix::fs::symlink;
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        std::fs::create_dir(at("deep")).unwrap();
        symlink("deep/second", at("first")).unwrap();
        symlink("../real.xyz", at("deep/second")).unwrap();
        check(&at("first")).unwrap();
        AtomicFile::write(&at("first"), |out| out.write_all(b"new")).unwrap().publish().unwrap();
        assert_eq!(std::fs::read(at("real.xyz")).unwrap(), b"new");
        for link in ["first", "deep/second"] {
            assert!(std::fs::symlink_metadata(at(link)).unwrap().file_type().is_symlink());
        }
        symlink("nowhere/a.xyz", at("broken")).unwrap();
        symlink("round", at("round")).unwrap();
        for (link, why) in [("broken", "/nowhere is missing"), ("round", "symbolic links")] {
            let error = check(&at(link)).unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
        }
    }

    #[test]
    fn a_folder_that_is_missing_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("missing").join("a.xyz");
        let written =
            AtomicFile::write(&path, |out| out.write_all(b"new")).err().unwrap().to_string();
        assert!(written.ends_with("/missing is missing"), "{written}");
        assert_eq!(check(&path).unwrap_err().to_string(), written);
    }

    #[test]
    fn folders_are_refused_early() {
        let dir = tempfile::tempdir().unwrap();
        assert!(check(dir.path()).is_err());
        assert!(check(&dir.path().join("missing").join("a.xyz")).is_err());
        assert!(check(&dir.path().join("a.xyz")).is_ok());
    }
}
