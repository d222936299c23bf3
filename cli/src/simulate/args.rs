//! The command line of `simulate`.

use crate::numbers::whole;
use crate::workers::Mode;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use ltbw::mesh::{Ownership, Redeal};
use ltbw::points::MAX_POINTS;
use ltbw::protocol::{Closure, Rule};
use ltbw::refine::{Order, Strategy};
use ltbw::simulate::{CostModel, Distribution, Network};
use ltbw_generate::PointKind;
use std::path::PathBuf;

/// `ltbw simulate`.
#[derive(Debug, clap::Args)]
pub(crate) struct Simulate {
    /// Simulated processors
    #[arg(long, value_name = "P", default_value_t = 16)]
    #[arg(value_parser = whole::<u32>(1..=1024), allow_negative_numbers = true)]
    pub(crate) processors: u32,
    /// The costs of work and messages: today's, or of the paper's 32 workstations (2.4 ms a cavity)
    #[arg(long, value_enum, default_value_t, hide_short_help = true)]
    pub(crate) machine: Machine,
    /// Mean time from sending a message to its arrival: a number with ns, us, ms or s
    /// [default: 10us; 100us on cow]
    #[arg(long, value_name = "TIME", value_parser = nanos)]
    pub(crate) latency: Option<u64>,
    /// The spread of single latencies around the mean
    #[arg(long, default_value = "constant", value_parser = distributions())]
    pub(crate) distribution: Distribution,
    /// Bandwidth of each processor's link, in Gbit/s [default: 10; 0.1 on cow]
    #[arg(long, value_name = "GBIT/S", value_parser = positive)]
    pub(crate) bandwidth: Option<f64>,
    /// The processor time that a message takes at either end [default: 500ns; 146us on cow]
    #[arg(long, value_name = "TIME", value_parser = nanos, hide_short_help = true)]
    pub(crate) message: Option<u64>,
    /// About how many points (grids round up)
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    #[arg(value_parser = whole::<u32>(4..=MAX_POINTS as u64), allow_negative_numbers = true)]
    pub(crate) points: u32,
    /// The kind of point set
    #[arg(long, default_value = "uniform", value_parser = kinds())]
    pub(crate) kind: PointKind,
    /// Refine a domain: a file, or a kind as of `generate`
    #[arg(long, value_name = "FILE|KIND")]
    #[arg(conflicts_with_all = ["points", "kind", "page", "trace", "sample", "cursors", "abreast"])]
    #[arg(hide_short_help = true)]
    pub(crate) domain: Option<PathBuf>,
    /// Refine in rounds, or as the paper does (async)
    #[arg(long, value_enum, default_value_t, requires = "domain", hide_short_help = true)]
    pub(crate) mode: Mode,
    /// Largest volume of a tetrahedron of the domain
    #[arg(long, value_name = "A", requires = "domain", allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    pub(crate) max_volume: Option<f64>,
    /// Its largest circumradius to shortest edge [default: 2]
    #[arg(long, value_name = "B", requires = "domain", allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    pub(crate) radius_edge: Option<f64>,
    /// Vertices at the start [default: 4096; async: 2048 each, but no more than a
    /// twentieth of all; of a small mesh a quarter]
    #[arg(long, value_name = "N", requires = "domain")]
    #[arg(hide_short_help = true)]
    pub(crate) start: Option<usize>,
    /// async: bad tetrahedra by largest, smallest, oldest or newest
    #[arg(long, default_value_t, requires = "domain", value_parser = orders())]
    #[arg(hide_short_help = true, hide_possible_values = true, hide_default_value = true)]
    pub(crate) order: Order,
    /// async: points off the circumcentre, up to 0.25 of the way to the shortest edge [default: 0]
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, requires = "domain")]
    #[arg(hide_default_value = true)]
    #[arg(value_parser = towards, hide_short_help = true, allow_negative_numbers = true)]
    pub(crate) towards: f64,
    /// Determines the points and all that is random in the run
    #[arg(long, default_value_t = 1)]
    #[arg(value_parser = whole::<u64>(0..=u64::MAX), allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// The rule for a request that meets a locked tetrahedron
    #[arg(long, default_value = "wound-wait", value_parser = rules())]
    pub(crate) rule: Rule,
    /// The closure that an operation locks: the cavity and its face neighbours, or all that touches
    /// the cavity (the paper's equation 5)
    #[arg(long, default_value = "face", value_parser = closures())]
    pub(crate) closure: Closure,
    /// The owner of a new tetrahedron: that of its block, that of the new point's block (as on
    /// threads), or its creator, as in the paper; blocks move under the first only
    #[arg(long, default_value = "block", value_parser = ownerships())]
    pub(crate) ownership: Ownership,
    /// When the cuts between the processors' parts of a domain move between rounds: never, as
    /// needed, or after every N-th round
    #[arg(long, value_name = "WHEN", default_value = "never", hide_short_help = true)]
    pub(crate) redeal: Redeal,
    /// A processor with work of its own looks for messages before each N-th insertion; in rounds,
    /// where others wait, before each
    #[arg(long, value_name = "N", default_value_t = 1)]
    #[arg(value_parser = whole::<u32>(1..=1_000_000), hide_short_help = true)]
    #[arg(allow_negative_numbers = true)]
    pub(crate) poll_every: u32,
    /// Send the messages between two looks for messages together, as threads and processes do
    #[arg(long, hide_short_help = true)]
    pub(crate) letters: bool,
    /// Each processor takes its points along a curve of its own, as processes do
    #[arg(long, conflicts_with = "domain", hide_short_help = true)]
    pub(crate) own_curves: bool,
    /// Do as processes of `ltbw-mpi` do: window, ownership, order of points, looks for messages and
    /// letters
    #[arg(long, conflicts_with_all = ["window", "ownership", "poll_every", "abreast", "letters"])]
    #[arg(conflicts_with = "own_curves")]
    pub(crate) as_processes: bool,
    /// Operations that a worker starts at most at a time
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=4096))]
    #[arg(hide_short_help = true, allow_negative_numbers = true)]
    pub(crate) window: Option<u32>,
    /// Insertion cursors of each worker
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=4096))]
    #[arg(hide_short_help = true, allow_negative_numbers = true)]
    pub(crate) cursors: Option<u32>,
    /// Points of a worker under way before those that need no other worker go first; 0: as they lie
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=4096))]
    #[arg(hide_short_help = true, allow_negative_numbers = true)]
    pub(crate) abreast: Option<u32>,
    /// Blocks of each worker at the start
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=256))]
    #[arg(hide_short_help = true, allow_negative_numbers = true)]
    pub(crate) blocks: Option<u32>,
    /// Points of the coarse mesh that is distributed at the start
    #[arg(long, value_name = "N", value_parser = whole::<u32>(4..=u32::MAX.into()))]
    #[arg(hide_short_help = true, allow_negative_numbers = true)]
    pub(crate) sample: Option<u32>,
    /// Processor 0 takes this number of times longer for everything
    #[arg(long, value_name = "FACTOR", value_parser = positive)]
    #[arg(hide_short_help = true)]
    pub(crate) slow: Option<f64>,
    /// Move a random block to a random worker each TIME
    #[arg(long, value_name = "TIME", value_parser = nanos)]
    #[arg(hide_short_help = true)]
    pub(crate) storm: Option<u64>,
    /// Give blocks to workers that run out of points
    #[arg(long)]
    #[arg(hide_short_help = true)]
    pub(crate) balance: bool,
    /// Write the report as JSON (ltbw.simulation/1)
    #[arg(long, value_name = "FILE|-")]
    pub(crate) json: Option<PathBuf>,
    /// Write a timeline for Perfetto: a track for each worker
    #[arg(long, value_name = "FILE|-")]
    pub(crate) trace: Option<PathBuf>,
    /// Write a page to look at: a timeline by worker, and with more runs LT over latency and the
    /// speed-up
    #[arg(long, value_name = "HTML|-")]
    pub(crate) page: Option<PathBuf>,
}

impl Simulate {
    /// The costs of work and messages.
    pub(crate) fn costs(&self) -> CostModel {
        let own = self.machine.costs();
        let message = self.message.map(|ns| ns as f64);
        let [send, receive] = [own.send, own.receive].map(|time| message.unwrap_or(time));
        CostModel { send, receive, ..own }
    }
}

/// The machine whose processors are simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Machine {
    /// Today's processors on a fast network
    #[default]
    Modern,
    /// The paper's CoW: 32 Sun Ultra 5 on Fast Ethernet
    Cow,
}

impl Machine {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Modern => "modern",
            Self::Cow => "cow",
        }
    }

    fn costs(self) -> CostModel {
        match self {
            Self::Modern => CostModel::default(),
            Self::Cow => CostModel::cow(),
        }
    }

    pub(crate) fn network(self) -> Network {
        match self {
            Self::Modern => Network::default(),
            Self::Cow => Network::cow(),
        }
    }
}

fn ownerships() -> impl TypedValueParser<Value = Ownership> {
    let names = Ownership::ALL.map(Ownership::name);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Ownership>())
}

fn orders() -> impl TypedValueParser<Value = Order> {
    PossibleValuesParser::new(Order::ALL.map(Order::name)).try_map(|name| name.parse::<Order>())
}

/// A share of the way from a circumcentre to the shortest edge.
fn towards(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if (0.0..=Strategy::MOST).contains(&share) => Ok(share),
        _ => Err(format!("a number from 0 to {}", Strategy::MOST)),
    }
}

fn kinds() -> impl TypedValueParser<Value = PointKind> {
    let values = PointKind::ALL.map(|k| clap::builder::PossibleValue::new(k.name()));
    PossibleValuesParser::new(values).try_map(|name| name.parse::<PointKind>())
}

fn distributions() -> impl TypedValueParser<Value = Distribution> {
    let names = Distribution::ALL.map(Distribution::name);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Distribution>())
}

fn rules() -> impl TypedValueParser<Value = Rule> {
    PossibleValuesParser::new(Rule::ALL.map(Rule::name)).try_map(|name| name.parse::<Rule>())
}

fn closures() -> impl TypedValueParser<Value = Closure> {
    let names = Closure::ALL.map(Closure::name);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Closure>())
}

/// A finite number above 0.
fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number <= 1e6 => Ok(number),
        _ => Err("not a number above 0 and up to 1000000".to_owned()),
    }
}

/// A time with its unit, as nanoseconds.
fn nanos(text: &str) -> Result<u64, String> {
    const UNITS: [(&str, f64); 5] =
        [("ns", 1.0), ("us", 1e3), ("µs", 1e3), ("ms", 1e6), ("s", 1e9)];
    let explain =
        || format!("`{text}` is no time such as 300ns, 100us, 1.5ms or 2s (a day at most)");
    if text == "0" {
        return Ok(0);
    }
    let unit = UNITS.iter().find_map(|(name, ns)| Some((text.strip_suffix(name)?, ns)));
    let (number, unit) = unit.ok_or_else(explain)?;
    let number: f64 = number.trim().parse().map_err(|_| explain())?;
    let time = (number * unit).round();
    if (0.0..=86_400e9).contains(&time) { Ok(time as u64) } else { Err(explain()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_units() {
        let good = [("0", 0), ("300ns", 300), ("100us", 100_000), ("1.5ms", 1_500_000)];
        for (text, ns) in good.into_iter().chain([("2 s", 2_000_000_000), ("7µs", 7000)]) {
            assert_eq!(nanos(text), Ok(ns), "{text}");
        }
        for text in ["", "5", "us", "-1us", "NaNs", "infs", "1e9s", "1min", "1us2"] {
            assert!(nanos(text).is_err(), "{text}");
        }
    }

    #[test]
    fn factors_are_finite_and_positive() {
        assert_eq!(positive("2.5"), Ok(2.5));
        for text in ["0", "-1", "NaN", "inf", "x", ""] {
            assert!(positive(text).is_err(), "{text}");
        }
    }
}
