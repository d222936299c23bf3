//! `cargo xtask vectors`: writes the conformance kit's cases into the folder that is named.
#![forbid(unsafe_code)]

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let Some(folder) = std::env::args().nth(1) else {
        eprintln!("vectors: name the folder to write to");
        return ExitCode::from(2);
    };
    for ltbw_kit::Generated { path, text } in ltbw_kit::files() {
        let full = Path::new(&folder).join(&path);
        if std::fs::read_to_string(&full).is_ok_and(|old| old == text) {
            continue;
        }
        let parent = full.parent().unwrap_or(Path::new(&folder));
        if let Err(error) =
            std::fs::create_dir_all(parent).and_then(|()| std::fs::write(&full, &text))
        {
            eprintln!("vectors: {}: {error}", full.display());
            return ExitCode::FAILURE;
        }
        println!("written: {path}, {} bytes", text.len());
    }
    ExitCode::SUCCESS
}
