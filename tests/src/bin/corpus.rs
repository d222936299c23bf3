//! `corpus unpack TARGET FOLDER` and `corpus pack TARGET FOLDER`: the committed corpus of a fuzz
//! target as files, and files as the committed corpus. `cargo xtask fuzz` calls it.

use ltbw_tests::corpora::{archive, read, write};
use std::fs;
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let done = match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["unpack", target, folder] => unpack(target, Path::new(folder)),
        ["pack", target, folder] => pack(target, Path::new(folder)),
        _ => Err(std::io::Error::other("usage: corpus unpack|pack TARGET FOLDER")),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("corpus: {error}");
            ExitCode::FAILURE
        }
    }
}

fn unpack(target: &str, folder: &Path) -> std::io::Result<()> {
    fs::create_dir_all(folder)?;
    for (name, bytes) in read(&archive(target))? {
        fs::write(folder.join(name), bytes)?;
    }
    Ok(())
}

fn pack(target: &str, folder: &Path) -> std::io::Result<()> {
    let files = fs::read_dir(folder)?.map(|entry| fs::read(entry?.path()));
    let inputs = files.collect::<std::io::Result<Vec<_>>>()?;
    println!("{target}: {} inputs", inputs.len());
    write(&archive(target), inputs)
}
