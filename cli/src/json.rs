//! JSON files: a path, or stdout for `-`; other text; and the inputs that no output may overwrite.

use crate::console;
use crate::outcome::{Failure, show};
use ltbw::io;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Does this argument mean stdout?
pub(crate) fn is_stdout(path: &Path) -> bool {
    path.as_os_str() == "-" || path == Path::new("/dev/stdout")
}

/// The name of an output in messages.
pub(crate) fn name_of(path: &Path) -> PathBuf {
    if is_stdout(path) { PathBuf::from("stdout") } else { path.to_owned() }
}

/// Finds out whether nothing can be written to `path`, a file or stdout, before the work starts.
pub(crate) fn file_writable(path: &Path) -> Result<(), Failure> {
    if is_stdout(path) {
        return Ok(());
    }
    io::check_bytes_writable(path).map_err(Failure::Write)
}

/// Finds out, before the work, whether the report of a check cannot be written: it replaces none of
/// the inputs, and is not the same file as `other`.
pub(crate) fn check_report(
    json: &Path,
    inputs: &[PathBuf],
    other: Option<&PathBuf>,
) -> Result<(), Failure> {
    inputs.iter().try_for_each(|input| keep_input(input, json))?;
    file_writable(json)?;
    distinct(&other.cloned().into_iter().chain([json.to_owned()]).collect::<Vec<_>>())
}

/// Refuses to write `output` where the file `input` is.
pub(crate) fn keep_input(input: &Path, output: &Path) -> Result<(), Failure> {
    // A file that is not there has no canonical path, and cannot be overwritten.
    let (Ok(from), Ok(to)) = (input.canonicalize(), output.canonicalize()) else { return Ok(()) };
    if from != to || is_stdout(output) {
        return Ok(());
    }
    Err(Failure::Usage(format!("{}: this would overwrite the input", show(output))))
}

/// The outputs without a `.node` that is written beside an `.ele` among them: one mesh.
pub(crate) fn without_pairs(outputs: &[PathBuf]) -> Vec<PathBuf> {
    let is = |path: &Path, extension| path.extension().is_some_and(|e| e == extension);
    let named =
        |output: &&PathBuf| !is(output, "node") || !outputs.contains(&output.with_extension("ele"));
    outputs.iter().filter(named).cloned().collect()
}

/// Refuses to write two outputs to one place.
pub(crate) fn distinct(outputs: &[PathBuf]) -> Result<(), Failure> {
    let mut places = HashSet::new();
    for output in outputs {
        // stdout has two names.
        let output = if is_stdout(output) { Path::new("-") } else { output };
        let output = &behind_links(output);
        // A file that is not there yet has a folder all the same.
        let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new(".")).canonicalize();
        let place =
            output.canonicalize().ok().or_else(|| Some(folder.ok()?.join(output.file_name()?)));
        if !places.insert(place.unwrap_or_else(|| output.to_owned())) {
            let text = format!("{}: two outputs would be written there", show(output));
            return Err(Failure::Usage(text));
        }
    }
    Ok(())
}

/// The path that a symbolic link leads to, whether anything is there or not.
fn behind_links(path: &Path) -> PathBuf {
    let mut path = path.to_owned();
    // A circle of links is refused where it is to be written.
    for _ in 0..40 {
        let Ok(next) = path.read_link() else { break };
        path = path.parent().unwrap_or(Path::new("")).join(next);
    }
    path
}

/// Writes JSON to a file, or to stdout for `-`.
pub(crate) fn write_json(path: &Path, text: &str) -> Result<(), Failure> {
    if is_stdout(path) {
        console::data(text)
    } else {
        console::writing(|_| io::write_bytes(path, text.as_bytes()))
    }
}

/// Writes a file of text, or to stdout for `-`, and says so.
pub(crate) fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    write_json(path, text)?;
    console::people(&format!("wrote     {}", show(&name_of(path))));
    Ok(())
}
