//! Files of ours read by meshio, PyVista and Gmsh, and files of theirs by us: `tests/readback.py`.
//!
//! Python is `$LTBW_PYTHON` or `python3`, with the packages meshio, pyvista, gmsh and numpy.

use crate::require;
use std::path::Path;
use std::process::Command;

/// The exit code of the script when a package is missing.
const MISSING: i32 = 3;

#[test]
fn meshio_pyvista_and_gmsh_read_what_we_write_and_the_other_way_round() {
    let python = std::env::var("LTBW_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/readback.py");
    let folder = tempfile::tempdir().unwrap();
    let skip = |reason: &str| require::skip("readback", "readback", reason).unwrap();
    let run = Command::new(&python)
        .arg(&script)
        .arg(env!("CARGO_BIN_EXE_ltbw"))
        .arg(folder.path())
        .output();
    let output = match run {
        Ok(output) => output,
        Err(error) => return skip(&format!("{python}: {error}")),
    };
    let stdout = String::from_utf8_lossy(&output.stdout);
    if output.status.code() == Some(MISSING) {
        return skip(stdout.trim());
    }
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{script:?}: {stdout}\n{stderr}");
    assert!(stdout.contains(" comparisons, 0 failed"), "{stdout}");
}
