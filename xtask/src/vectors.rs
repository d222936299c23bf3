//! `vectors`: writes the cases of the conformance kit. They come from `ltbw-tests`, which has the
//! oracles that they are compared with.

use crate::shell::{self, cargo, root};

/// Writes every file of the kit that has changed.
pub(crate) fn run() -> Result<(), String> {
    let folder = root().join("verify/vectors");
    let mut command = cargo();
    command.args(["run", "--quiet", "-p", "ltbw-tests", "--bin", "vectors", "--"]).arg(folder);
    shell::run(&mut command)
}
