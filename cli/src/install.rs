//! `completions` and `man`: files for packages of the program.

use crate::args::Args;
use crate::console;
use crate::help;
use crate::outcome::{Exit, Failure, show};
use clap::CommandFactory as _;
use ltbw::io;
use std::path::Path;

/// `ltbw completions`.
pub(crate) fn completions(shell: clap_complete::Shell) -> Result<Exit, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Args::command(), "ltbw", &mut script);
    console::data(&String::from_utf8_lossy(&script))?;
    Ok(Exit::Done)
}

/// `ltbw man`: a page for the program and one for each of its commands.
pub(crate) fn manual(folder: &Path) -> Result<Exit, Failure> {
    let mut program = Args::command();
    program.build();
    page(folder, &program, "ltbw")?;
    for command in program.get_subcommands().filter(|c| c.get_name() != "help") {
        page(folder, command, &format!("ltbw-{}", command.get_name()))?;
    }
    Ok(Exit::Done)
}

fn page(folder: &Path, command: &clap::Command, name: &str) -> Result<(), Failure> {
    let mut text = Vec::new();
    let words = command.get_after_long_help().map(ToString::to_string).unwrap_or_default();
    let words = format!("{words}\n\n{}", help::exit_codes(command.get_name()));
    let page = clap_mangen::Man::new(command.clone().after_long_help(words));
    let page = page.title(name.to_uppercase());
    page.render(&mut text).map_err(|e| Failure::Other(e.to_string()))?;
    let path = folder.join(format!("{name}.1"));
    io::write_bytes(&path, &text).map_err(Failure::Write)?;
    console::people(&format!("wrote     {}", show(&path)));
    Ok(())
}
