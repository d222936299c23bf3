//! When messages arrive.

use crate::metrics::Nanos;
use crate::protocol::WorkerId;
use ltbw_core::Random;

/// The network between the processors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Network {
    /// The mean time from sending a message to its arrival, without its bytes.
    pub latency: Nanos,
    /// The spread of the latencies of single messages around the mean.
    pub distribution: Distribution,
    /// Nanoseconds that a byte takes a processor's link, one message after the other.
    pub byte: f64,
    /// Messages that are held back and arrive together.
    pub bursts: Option<Bursts>,
}

impl Default for Network {
    /// 10 µs, always; 10 Gbit/s.
    fn default() -> Self {
        Self { latency: 10_000, distribution: Distribution::Constant, byte: 0.8, bursts: None }
    }
}

impl Network {
    /// Fast Ethernet, of the paper's CoW: 100 Mbit/s. The paper gives no latency: 100 µs.
    pub fn cow() -> Self {
        Self { latency: 100_000, byte: 80.0, ..Self::default() }
    }
}

/// For `length` at the begin of each `every`, no message arrives; then all do that should have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bursts {
    /// The period.
    pub every: Nanos,
    /// The part of it without arrivals.
    pub length: Nanos,
}

/// The spread of the latencies of single messages around their mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "kebab-case"))]
pub enum Distribution {
    /// All the same.
    #[default]
    Constant,
    /// Anything up to twice the mean, equally likely.
    Uniform,
    /// Exponential.
    Exponential,
    /// Pareto with exponent 2: at least half of the mean, of infinite variance.
    HeavyTail,
}

impl Distribution {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Constant, Self::Uniform, Self::Exponential, Self::HeavyTail];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Uniform => "uniform",
            Self::Exponential => "exponential",
            Self::HeavyTail => "heavy-tail",
        }
    }

    /// A random time of this distribution.
    pub(super) fn sample(self, mean: Nanos, random: &mut Random) -> Nanos {
        let factor = match self {
            Self::Constant => return mean,
            Self::Uniform => 2.0 * random.unit(),
            Self::Exponential => exponential(random),
            // P(x > t) = (1/2 / t)^2; 2^-53 stands for 0.
            Self::HeavyTail => 0.5 / random.unit().max(f64::EPSILON / 2.0).sqrt(),
        };
        (mean as f64 * factor) as Nanos
    }
}

impl std::str::FromStr for Distribution {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|d| d.name() == text);
        found.ok_or_else(|| {
            format!("no distribution `{text}`: constant, uniform, exponential or heavy-tail")
        })
    }
}

/// A time of mean 1, exponentially distributed, by comparisons alone (von Neumann, 1951): the
/// logarithms of different systems differ in their last digits.
fn exponential(random: &mut Random) -> f64 {
    // A trial fails with probability 1/e: 1000 failures do not happen.
    for whole in 0..1000 {
        let first = random.unit();
        let mut last = first;
        let mut length = 1;
        // The length of a falling run exceeds n with probability 1/n!.
        loop {
            let next = random.unit();
            if next >= last {
                break;
            }
            last = next;
            length += 1;
        }
        if length % 2 == 1 {
            return f64::from(whole) + first;
        }
    }
    1000.0
}

/// The state of the network.
pub(super) struct Links {
    network: Network,
    processors: usize,
    random: Random,
    /// By sender: when its link has sent all so far.
    link: Vec<Nanos>,
    /// By sender and receiver: the last arrival.
    last: Vec<Nanos>,
}

impl Links {
    pub(super) fn new(network: Network, processors: usize, seed: u64) -> Self {
        Self {
            network,
            processors,
            random: Random::new(seed),
            link: vec![0; processors],
            last: vec![0; processors * processors],
        }
    }

    /// When a message of `bytes` bytes, sent at `time`, arrives: not before earlier ones of the
    /// same pair.
    pub(super) fn arrival(
        &mut self,
        from: WorkerId,
        to: WorkerId,
        time: Nanos,
        bytes: u64,
    ) -> Nanos {
        let link = &mut self.link[from.index()];
        *link = (*link).max(time) + (bytes as f64 * self.network.byte) as Nanos;
        let latency = self.network.distribution.sample(self.network.latency, &mut self.random);
        let mut arrival = link.saturating_add(latency);
        if let Some(bursts) = self.network.bursts {
            let into = arrival % bursts.every;
            arrival += bursts.length.saturating_sub(into);
        }
        let last = &mut self.last[from.index() * self.processors + to.index()];
        *last = arrival.max(*last);
        *last
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn latencies_have_their_mean() {
        for distribution in Distribution::ALL {
            let mut random = Random::new(5);
            let n = 200_000;
            let sum: u64 = (0..n).map(|_| distribution.sample(10_000, &mut random)).sum();
            let mean = sum as f64 / f64::from(n);
            assert!((mean / 10_000.0 - 1.0).abs() < 0.05, "{distribution:?}: {mean}");
        }
    }

    #[test]
    fn exponential_times_have_their_tail() {
        let mut random = Random::new(6);
        let n = 200_000;
        let above = |t: f64, random: &mut Random| {
            (0..n).filter(|_| exponential(random) > t).count() as f64 / f64::from(n)
        };
        for (t, expected) in [(0.5, 0.60653), (1.0, 0.36788), (3.0, 0.04979)] {
            assert!((above(t, &mut random) - expected).abs() < 0.005, "{t}");
        }
    }

    #[test]
    fn pairs_keep_their_order_and_others_do_not() {
        let network = Network { distribution: Distribution::Exponential, ..Network::default() };
        let mut links = Links::new(network, 3, 1);
        let mut overtaken = 0;
        let mut last = [0; 3];
        for time in 0..1000 {
            let [a, b] = [1, 2]
                .map(|to| links.arrival(WorkerId::default(), WorkerId::new(to), time * 100, 10));
            assert!(a >= last[1] && b >= last[2]);
            overtaken += usize::from(b < a);
            last = [0, a, b];
        }
        assert!((200..800).contains(&overtaken), "{overtaken}");
    }

    #[test]
    fn bursts_hold_messages_back() {
        let bursts = Some(Bursts { every: 1000, length: 300 });
        let network = Network { latency: 10, byte: 0.0, bursts, ..Network::default() };
        let mut links = Links::new(network, 2, 1);
        let arrivals = [0, 100, 289, 290, 995, 1500]
            .map(|t| links.arrival(WorkerId::default(), WorkerId::new(1), t, 8));
        assert_eq!(arrivals, [300, 300, 300, 300, 1300, 1510]);
    }

    #[test]
    fn links_send_one_message_after_the_other() {
        let network = Network { latency: 10, byte: 1.0, ..Network::default() };
        let mut links = Links::new(network, 3, 1);
        assert_eq!(links.arrival(WorkerId::default(), WorkerId::new(1), 0, 100), 110);
        assert_eq!(links.arrival(WorkerId::default(), WorkerId::new(2), 50, 100), 210);
        assert_eq!(links.arrival(WorkerId::default(), WorkerId::new(2), 500, 100), 610);
    }

    use super::super::network::Bursts;
}
