//! stdin and stdout in place of files: `-`, in the format that `--format` names.
//!
//! The format of a file without a known extension is named in the same way. Where stdout carries a
//! file nothing else goes there.

use crate::binding::{Reads, Role};
use crate::console;
pub(crate) use crate::json::name_of;
use crate::json::{file_writable, is_stdout};
use crate::outcome::{Failure, show};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use ltbw::io::{self, DomainFile, Format, IoError, MeshFile, MeshWriter, PointFile, WriteOptions};
use ltbw::{Domain, TetMesh};
use std::cell::OnceCell;
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};

/// Bytes at the front of a file that tell the hash of its mesh.
const HEAD: u64 = 4096;

/// The formats of what has no extension.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct Streams {
    /// Format of `-`, or where the extension tells none: npy, vtu, ...
    #[arg(long, value_name = "NAME", value_parser = names(), hide_possible_values = true)]
    pub(crate) format: Option<Format>,
    /// The format of such an output where --format is about the input
    #[arg(long, value_name = "NAME", value_parser = names(), hide_possible_values = true)]
    pub(crate) output_format: Option<Format>,
}

/// A parser of formats by their extensions.
fn names() -> impl TypedValueParser<Value = Format> {
    let names = Format::ALL.map(Format::extension);
    PossibleValuesParser::new(names)
        .try_map(|name| Format::from_path(Path::new(&format!("a.{name}"))))
}

/// Does `-` stand for stdin here?
pub(crate) fn is_stdin(path: &Path) -> bool {
    path.as_os_str() == "-" || path == Path::new("/dev/stdin")
}

/// Is the format left open by this path?
fn is_open(path: &Path) -> bool {
    is_stdin(path) || is_stdout(path) || Format::from_path(path).is_err()
}

impl Streams {
    /// The options, taken for inputs and outputs; an option without a use is refused.
    pub(crate) fn resolve(
        &self,
        inputs: &[&Path],
        outputs: &[PathBuf],
    ) -> Result<Formats, Failure> {
        if inputs.iter().filter(|path| is_stdin(path)).count() > 1 {
            return Err(Failure::Usage("stdin: two inputs cannot both be read from it".to_owned()));
        }
        let unused = |option: &str| {
            Err(Failure::Usage(format!("{option}: the extension of every file tells its format")))
        };
        let input = inputs.iter().any(|path| is_open(path));
        let output = outputs.iter().any(|path| is_open(path));
        let shared = self.format.filter(|_| !input && self.output_format.is_none());
        if self.output_format.is_some() && !output {
            return unused("--output-format");
        }
        if self.format.is_some() && !input && !(output && shared.is_some()) {
            return unused("--format");
        }
        Ok(Formats { input: self.format.filter(|_| input), output: self.output_format.or(shared) })
    }
}

/// The formats of an input and of outputs whose names do not tell them.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Formats {
    input: Option<Format>,
    output: Option<Format>,
}

impl Formats {
    /// An input, of which nothing is read yet.
    pub(crate) fn input(self, path: &Path) -> Result<Source, Failure> {
        let stdin = is_stdin(path);
        let name = if stdin { PathBuf::from("stdin") } else { path.to_owned() };
        let format = match (is_open(path), self.input) {
            (true, Some(format)) => format,
            (true, None) if stdin => {
                return Err(Failure::Usage("stdin: --format has to name its format".to_owned()));
            }
            _ => Format::from_path(path).map_err(Failure::Read)?,
        };
        // A `.vtk` file tells in its header whether it is a mesh.
        let is_open = is_open(path) || format == Format::Vtk;
        let (bytes, reads) = (OnceCell::new(), Reads::default());
        Ok(Source { name, format, stdin, is_open, bytes, reads })
    }

    /// The format of an output.
    pub(crate) fn of_output(self, path: &Path) -> Result<Format, Failure> {
        match self.output {
            Some(format) if is_open(path) => Ok(format),
            None if is_stdout(path) => {
                let text = "stdout: --format, or --output-format beside that of the input, has to \
                            name its format";
                Err(Failure::Usage(text.to_owned()))
            }
            _ => Format::from_path(path).map_err(Failure::Write),
        }
    }

    /// Finds out, before the work, whether meshes cannot be written.
    pub(crate) fn meshes_writable(self, outputs: &[PathBuf]) -> Result<(), Failure> {
        let writable = |path: &PathBuf| {
            if !is_open(path) {
                return io::check_mesh_writable(path).map_err(Failure::Write);
            }
            let format = self.of_output(path)?;
            io::check_mesh_stream(name_of(path), format).map_err(Failure::Write)?;
            file_writable(path)
        };
        outputs.iter().try_for_each(writable)
    }

    /// Finds out whether points cannot be written.
    pub(crate) fn points_writable(self, path: &Path) -> Result<(), Failure> {
        if !is_open(path) {
            return io::check_points_writable(path).map_err(Failure::Write);
        }
        io::check_points_stream(name_of(path), self.of_output(path)?).map_err(Failure::Write)?;
        file_writable(path)
    }

    /// Finds out whether a domain cannot be written.
    pub(crate) fn domain_writable(self, path: &Path) -> Result<(), Failure> {
        if !is_open(path) {
            return io::check_domain_writable(path).map_err(Failure::Write);
        }
        io::check_domain_stream(name_of(path), self.of_output(path)?).map_err(Failure::Write)?;
        file_writable(path)
    }

    /// Writes a mesh to a file or to stdout.
    pub(crate) fn write_mesh(self, path: &Path, mesh: MeshWriter<'_>) -> Result<(), Failure> {
        if !is_open(path) {
            return console::writing(|token| mesh.cancel(token).write(path));
        }
        let (name, format) = (name_of(path), self.of_output(path)?);
        write(path, |out| mesh.write_to(out, &name, format))
    }

    /// Writes points to a file or to stdout.
    pub(crate) fn write_points(
        self,
        path: &Path,
        file: &PointFile,
        options: WriteOptions,
    ) -> Result<(), Failure> {
        if !is_open(path) {
            return console::writing(|token| io::write_points_until(path, file, options, token));
        }
        let (name, format) = (name_of(path), self.of_output(path)?);
        write(path, |out| io::write_points_to(out, &name, format, file, options))
    }

    /// Writes a domain to a file or to stdout.
    pub(crate) fn write_domain(
        self,
        path: &Path,
        domain: &Domain,
        options: WriteOptions,
    ) -> Result<(), Failure> {
        if !is_open(path) {
            return console::writing(|token| io::write_domain_until(path, domain, options, token));
        }
        let (name, format) = (name_of(path), self.of_output(path)?);
        write(path, |out| io::write_domain_to(out, &name, format, domain, options))
    }
}

/// A note on the attributes or the numbers of a mesh's regions, if a format has no place for both.
pub(crate) fn attributes_note(mesh: &TetMesh, format: Format) -> Option<&'static str> {
    mesh.tet_attributes.as_ref()?;
    match format {
        Format::Ele | Format::Node => {
            mesh.tet_tags.as_ref().map(|_| "attributes of regions stand in place of their numbers")
        }
        _ if format.holds_attributes() => None,
        _ => Some("attributes of regions are not kept: this format has no place for them"),
    }
}

/// Does stdout carry one of these outputs, and so nothing else?
pub(crate) fn on_stdout(outputs: &[PathBuf]) -> bool {
    outputs.iter().any(|path| is_stdout(path))
}

/// Writes to stdout as it comes, or to a file of any extension.
fn write(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> Result<(), IoError>,
) -> Result<(), Failure> {
    if !is_stdout(path) {
        let mut bytes = Vec::new();
        fill(&mut bytes).map_err(Failure::Write)?;
        return console::writing(|_| io::write_bytes(path, &bytes));
    }
    let mut refused = None;
    console::data_with(|| {
        let mut out = BufWriter::with_capacity(1 << 20, std::io::stdout().lock());
        match fill(&mut out) {
            Ok(()) => out.flush(),
            Err(IoError::Write { source, .. }) => Err(source),
            Err(error) => {
                refused = Some(error);
                Ok(())
            }
        }
    })?;
    refused.map_or(Ok(()), |error| Err(Failure::Write(error)))
}

/// An input of the program.
#[derive(Debug)]
pub(crate) struct Source {
    /// Its name in messages: the path, or `stdin`.
    pub(crate) name: PathBuf,
    /// Its format.
    pub(crate) format: Format,
    stdin: bool,
    is_open: bool,
    bytes: OnceCell<Vec<u8>>,
    reads: Reads,
}

impl Source {
    /// Its name in a message.
    pub(crate) fn show(&self) -> String {
        show(&self.name)
    }

    /// The points in it.
    pub(crate) fn points(&self) -> Result<PointFile, Failure> {
        if self.is_open {
            return io::parse_points(&self.name, self.format, self.bytes()?).map_err(Failure::Read);
        }
        io::read_points_by(&self.name, &mut |path| self.reads.load_first(path))
            .map_err(Failure::Read)
    }

    /// Is it a domain? A `.vtk` file tells it in its header.
    pub(crate) fn is_domain(&self) -> Result<bool, Failure> {
        match self.format {
            Format::Vtk => Ok(io::vtk::is_surface(self.bytes()?)),
            format => Ok(format.holds_domain()),
        }
    }

    /// The mesh in it.
    pub(crate) fn mesh(&self) -> Result<MeshFile, Failure> {
        if self.is_open {
            return io::parse_mesh(&self.name, self.format, self.bytes()?).map_err(Failure::Read);
        }
        io::read_mesh_file(&self.name).map_err(Failure::Read)
    }

    /// The mesh in it; that it was read is noted.
    pub(crate) fn noted_mesh(&self) -> Result<MeshFile, Failure> {
        if self.is_open {
            return self.mesh();
        }
        io::read_mesh_by(&self.name, &mut |path| self.reads.load_first(path)).map_err(Failure::Read)
    }

    /// The hash that it says its mesh has, if it says one.
    pub(crate) fn carried_hash(&self) -> Result<Option<String>, Failure> {
        if !matches!(self.format, Format::Vtu | Format::Msh) || io::is_parts(&self.name) {
            return Ok(None);
        }
        if self.stdin || self.bytes.get().is_some() {
            return Ok(io::carried_hash(self.format, self.bytes()?));
        }
        // It stands at the front.
        let mut head = Vec::new();
        let read = std::fs::File::open(&self.name).and_then(|file| {
            file.take(HEAD).read_to_end(&mut head)?;
            Ok(io::carried_hash(self.format, &head))
        });
        read.map_err(|source| Failure::Read(IoError::Read { path: self.name.clone(), source }))
    }

    /// The files of which points or a domain were read.
    pub(crate) fn reads(&self) -> &Reads {
        &self.reads
    }

    /// The domain in it.
    pub(crate) fn domain(&self) -> Result<DomainFile, Failure> {
        if self.is_open {
            return io::parse_domain(&self.name, self.format, self.bytes()?).map_err(Failure::Read);
        }
        io::read_domain_by(&self.name, &mut |path| self.reads.load_first(path))
            .map_err(Failure::Read)
    }

    /// All of it, which is read once.
    pub(crate) fn bytes(&self) -> Result<&[u8], Failure> {
        if let Some(bytes) = self.bytes.get() {
            return Ok(bytes);
        }
        let bytes = if self.stdin {
            let mut bytes = Vec::new();
            let read = std::io::stdin().lock().read_to_end(&mut bytes);
            let failed = |source| IoError::Read { path: self.name.clone(), source };
            read.map(|_| bytes).map_err(failed)
        } else {
            io::read_bytes(&self.name)
        };
        let bytes = bytes.map_err(Failure::Read)?;
        self.reads.add(Role::Input, &self.name, &bytes);
        Ok(self.bytes.get_or_init(|| bytes))
    }
}
