//! `vectors`: writes the cases of the conformance kit. They come from `ltbw-kit`, which has the
//! oracles that they are compared with. The program's own copy of the kit follows.

use crate::shell::{self, cargo, root};

/// Writes every file of the kit that has changed, and the copy inside the program.
pub(crate) fn run() -> Result<(), String> {
    let folder = root().join("verify/vectors");
    let mut command = cargo();
    command.args(["run", "--quiet", "-p", "ltbw-kit", "--bin", "vectors", "--"]).arg(&folder);
    shell::run(&mut command)?;
    // The example builds the program's library, which takes the copy in: it has to be there.
    let copy = root().join("cli/kit/vectors.json.gz");
    let mut command = cargo();
    command.args(["run", "--quiet", "-p", "ltbw-cli", "--example", "pack_kit", "--"]);
    shell::run(command.arg(&folder).arg(&copy))
}
