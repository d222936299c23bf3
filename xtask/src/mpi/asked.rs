//! The command line of `mpi`.

use super::library::LIBRARIES;

const USAGE: &str = "cargo xtask mpi [--only openmpi|mpich] [--ranks 1,2,3,4] [--readers] \
                     [--validate] [--speed] [--seeds N] [--faults N] [--seed N]";

/// The demands of a command line.
#[derive(Debug)]
pub(super) struct Asked {
    /// The names of the MPIs.
    pub(super) libraries: Vec<&'static str>,
    /// The numbers of processes, if some are named.
    pub(super) ranks: Option<Vec<u32>>,
    pub(super) has_readers: bool,
    pub(super) validates: bool,
    pub(super) has_speed: bool,
    /// Sets at random, and nothing else.
    pub(super) seeds: Option<u64>,
    /// Jobs with faults, and nothing else.
    pub(super) faults: Option<u64>,
    pub(super) seed: u64,
}

impl Asked {
    pub(super) fn of(rest: &[String]) -> Result<Self, String> {
        let seed = std::time::UNIX_EPOCH.elapsed().map_or(1, |since| since.as_secs());
        let libraries = LIBRARIES.iter().map(|library| library.name).collect();
        let (has_readers, validates, has_speed) = (false, false, false);
        let (ranks, seeds, faults) = (None, None, None);
        let mut own =
            Self { libraries, ranks, has_readers, validates, has_speed, seeds, faults, seed };
        let mut words = rest.iter().map(String::as_str);
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or_else(|| USAGE.to_owned());
            let number = |text: &str| {
                text.parse::<u64>().map_err(|_| format!("{word} {text}: no number; {USAGE}"))
            };
            match word {
                "--readers" => own.has_readers = true,
                "--validate" => own.validates = true,
                "--speed" => own.has_speed = true,
                "--seeds" => own.seeds = Some(number(value()?)?),
                "--faults" => own.faults = Some(number(value()?)?),
                "--seed" => own.seed = number(value()?)?,
                "--only" => {
                    let asked = value()?;
                    let is_asked = |name: &&str| name.to_lowercase().replace(' ', "") == asked;
                    own.libraries.retain(is_asked);
                }
                "--ranks" => {
                    let list = value()?.split(',').map(number).collect::<Result<Vec<u64>, _>>()?;
                    let count = |count: u64| u32::try_from(count).ok().filter(|&own| own > 0);
                    let ranks: Option<Vec<u32>> = list.into_iter().map(count).collect();
                    own.ranks = Some(ranks.ok_or_else(|| USAGE.to_owned())?);
                }
                _ => return Err(USAGE.to_owned()),
            }
        }
        if own.libraries.is_empty() { Err(USAGE.to_owned()) } else { Ok(own) }
    }
}

#[cfg(test)]
mod tests {
    use super::Asked;

    fn asked(line: &str) -> Result<Asked, String> {
        Asked::of(&line.split_whitespace().map(str::to_owned).collect::<Vec<_>>())
    }

    #[test]
    fn a_command_line_is_told_or_refused() {
        let own = asked("--only mpich --ranks 2,16 --seeds 5 --seed 9").unwrap();
        assert_eq!((own.libraries, own.ranks), (vec!["MPICH"], Some(vec![2, 16])));
        assert_eq!((own.seeds, own.faults, own.seed), (Some(5), None, 9));
        assert_eq!(asked("").unwrap().libraries, ["Open MPI", "MPICH"]);
        for line in ["--only lam", "--ranks 0", "--ranks", "--seeds x", "--fast"] {
            assert!(asked(line).unwrap_err().contains("cargo xtask mpi"), "{line}");
        }
    }
}
