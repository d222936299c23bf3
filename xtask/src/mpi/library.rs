//! The MPIs that the program is built against: what finds each, what starts a job by it, and what
//! it makes of a process that a signal has ended.

use crate::shell::{self, cargo, command, root, target};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// An MPI.
#[derive(Debug)]
pub(crate) struct Library {
    pub(crate) name: &'static str,
    /// Words of which its launcher says one of its version, and no other one does.
    words: &'static [&'static str],
    /// Launchers with their compilers: by names of its own, where several are installed, or not.
    tools: [(&'static str, &'static str); 2],
    install: &'static str,
    /// Options of every job.
    options: &'static [&'static str],
    /// Options by which all mail goes over TCP, if that is tried.
    tcp: &'static [&'static str],
    /// The code of a job that a signal has ended, less the signal's number.
    of_signals: i32,
    /// Options of cargo. What finds an MPI is no input of a build as cargo sees it: one package
    /// with another profile keeps the builds apart, and all that has no MPI in it is built once.
    apart: &'static [&'static str],
    /// The environment variable that names a program which is there.
    given: &'static str,
    /// The name of the program that is built.
    file: &'static str,
}

/// All of them.
pub(crate) const LIBRARIES: [Library; 2] = [
    Library {
        name: "Open MPI",
        words: &["Open MPI", "OpenRTE"],
        tools: [("mpirun.openmpi", "mpicc.openmpi"), ("mpirun", "mpicc")],
        install: "apt-get install openmpi-bin libopenmpi-dev libclang-dev clang",
        options: &["--oversubscribe"],
        tcp: &["--mca", "btl", "self,tcp", "--mca", "btl_tcp_if_include", "lo"],
        of_signals: 128,
        apart: &[],
        given: "LTBW_MPI_PROGRAM",
        file: "ltbw-mpi-openmpi",
    },
    Library {
        name: "MPICH",
        words: &["HYDRA"],
        tools: [("mpirun.mpich", "mpicc.mpich"), ("mpirun", "mpicc")],
        install: "apt-get install mpich libmpich-dev libclang-dev clang",
        options: &[],
        // MPICH 4.0 with UCX 1.13 over TCP hangs in `MPI_Finalize`, one time in ten on four.
        tcp: &[],
        of_signals: 0,
        apart: &["--config", "profile.release.package.mpi-sys.opt-level=2"],
        given: "LTBW_MPICH_PROGRAM",
        file: "ltbw-mpi-mpich",
    },
];

/// A shell's word for the number of a process, whichever MPI has started it.
pub(super) const RANK: &str = "${OMPI_COMM_WORLD_RANK:-$PMI_RANK}";

/// An MPI that is here.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub(crate) library: &'static Library,
    launcher: &'static str,
    compiler: &'static str,
}

impl Library {
    /// Looks for it; if it is not here the error tells what to install.
    pub(crate) fn find(&'static self) -> Result<Found, String> {
        let is_own = |(launcher, compiler): &(&str, &str)| {
            let said = command(launcher).arg("--version").output();
            let is_said = |said: std::process::Output| {
                let text = String::from_utf8_lossy(&said.stdout).into_owned();
                self.words.iter().any(|word| text.contains(word))
            };
            said.is_ok_and(is_said) && shell::works(command(compiler).arg("--version"))
        };
        let found = self.tools.into_iter().find(is_own);
        let (launcher, compiler) =
            found.ok_or_else(|| format!("no {} is found: {}", self.name, self.install))?;
        Ok(Found { library: self, launcher, compiler })
    }
}

impl Found {
    /// The program for it: that which the environment names, or one that is built, where the first
    /// one that is built runs its tests, too.
    pub(crate) fn build(self, runs_tests: bool) -> Result<PathBuf, String> {
        let Library { given, file, apart, .. } = self.library;
        if let Some(program) = std::env::var_os(given) {
            return Ok(program.into());
        }
        let in_package = |arguments: &[&str]| self.cargo("parallel/mpi", arguments);
        if runs_tests {
            shell::run(in_package(&["fmt"]).arg("--check"))?;
            shell::run(in_package(&["test", "--quiet", "--release", "--locked"]).args(*apart))?;
        }
        shell::run(in_package(&["build", "--quiet", "--release", "--locked"]).args(*apart))?;
        // The next one would take its place.
        let (built, kept) = (target().join("release/ltbw-mpi"), target().join("mpi").join(file));
        let copied = fs::copy(&built, &kept);
        copied.map_err(|error| format!("{}: {error}", kept.display()))?;
        Ok(kept)
    }

    /// A command of cargo in a package of its own that is built against this MPI.
    pub(crate) fn cargo(self, package: &str, arguments: &[&str]) -> Command {
        let mut cargo = cargo();
        cargo.args(arguments).arg("--manifest-path").arg(root().join(package).join("Cargo.toml"));
        // One folder: crates that two MPIs share are built once.
        cargo
            .env("CARGO_TARGET_DIR", target())
            .env("MPICC", self.compiler)
            .env_remove("MPI_PKG_CONFIG");
        cargo
    }

    /// A script in `folder` that runs a program on as many processes as its first argument says.
    pub(crate) fn script(
        self,
        name: &str,
        program: &Path,
        folder: &Path,
    ) -> Result<PathBuf, String> {
        let path = folder.join(name);
        let wrong = |error: std::io::Error| format!("{}: {error}", path.display());
        fs::create_dir_all(folder).map_err(wrong)?;
        let words = self.words("\"$ranks\"");
        let program = program.display();
        let text = format!("#!/bin/sh\nranks=$1\nshift\nexec {words} '{program}' \"$@\"\n");
        fs::write(&path, text).map_err(wrong)?;
        shell::run(command("chmod").arg("+x").arg(&path))?;
        Ok(path)
    }

    /// A job of this many processes, whose program is still to be named.
    pub(super) fn job(self, count: u32, is_tcp: bool) -> Command {
        let Library { options, tcp, .. } = self.library;
        let mut job = Command::new(self.launcher);
        job.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
        job.args(*options).args(tcp.iter().filter(|_| is_tcp));
        job.args(["-n", &count.to_string()]);
        job
    }

    /// The words of a shell before the program's name, for as many processes as `count` says.
    fn words(self, count: &str) -> String {
        let own = self.job(1, false);
        let set = own.get_envs().filter_map(|(name, value)| Some((name, value?)));
        let set = set.map(|(name, value)| format!("{}={}", name.display(), value.display()));
        let options = self.library.options.iter().map(|word| (*word).to_owned());
        let last = [self.launcher.to_owned()].into_iter().chain(options);
        let all: Vec<String> = ["env".to_owned()].into_iter().chain(set).chain(last).collect();
        format!("{} -n {count}", all.join(" "))
    }

    /// Are there jobs whose mail goes over TCP?
    pub(super) fn has_tcp(self) -> bool {
        !self.library.tcp.is_empty()
    }

    /// The code of a job with a process that a signal has ended.
    pub(super) fn code_of(self, signal: i32) -> i32 {
        self.library.of_signals + signal
    }
}
