//! The page of `simulate`: a timeline, and curves that take more runs.

use super::{Simulate, layout, mesh};
use crate::json::write_text;
use crate::outcome::Failure;
use crate::page::{Fact, Page, timeline};
use crate::picture::curve;
use ltbw::PointSet;
use ltbw::metrics::{Summary, Trace, tolerance};
use ltbw::simulate::Options;
use std::path::Path;

/// Latencies of the curve, in nanoseconds, beside the run's own.
const LATENCIES: [u64; 4] = [1_000, 10_000, 100_000, 1_000_000];

/// The run that the page is about.
pub(super) struct Run<'a> {
    pub(super) args: &'a Simulate,
    pub(super) set: &'a PointSet,
    pub(super) name: &'a Path,
    pub(super) options: &'a Options,
    pub(super) summary: &'a Summary,
    pub(super) trace: &'a Trace,
    /// The time of one processor, in nanoseconds.
    pub(super) alone: u64,
    pub(super) text: &'a str,
    pub(super) report: &'a str,
}

impl Run<'_> {
    /// Makes the other runs and writes the page.
    pub(super) fn write(&self, path: &Path) -> Result<(), Failure> {
        let s = self.summary;
        let workers = self.args.processors;
        let plural = if workers == 1 { "" } else { "s" };
        let title = format!("{} on {workers} processor{plural}", self.name.display());
        let facts = [
            ("latency tolerance LT, worst processor", tolerance(s.worst_lt())),
            ("LT, all processors", tolerance(s.lt())),
            ("LT strict (idle time counted), all", tolerance(s.lt_strict())),
            ("efficiency, kernel", format!("{:.4}", s.efficiency(self.alone))),
            ("insertions", s.operations().to_string()),
            ("setbacks", s.setbacks().to_string()),
        ];
        let view = timeline(self.trace, workers as usize, s.makespan);
        let curves = format!("{}{}", self.over_latency()?, self.over_processors()?);
        let page = Page::new(&title)
            .facts(&facts.map(Fact::from))
            .section("Time of the processors", &view)
            .section("Other runs of the same points", &curves)
            .text("Figures", self.text);
        write_text(path, &page.html(self.report))
    }

    /// LT and, thin, LT strict.
    fn over_latency(&self) -> Result<String, Failure> {
        let own = self.options.network.latency;
        let mut latencies = LATENCIES.to_vec();
        latencies.push(own);
        latencies.sort_unstable();
        latencies.dedup();
        let (plan, config) = layout(self.args, self.set.len(), self.args.processors);
        let (mut settings, mut tolerant, mut strict) = (Vec::new(), Vec::new(), Vec::new());
        for latency in latencies {
            let mut options = Options { spans: 0, ..self.options.clone() };
            options.network.latency = latency;
            let other;
            let summary = if latency == own {
                self.summary
            } else {
                other = mesh(self.set, &plan, config, &options, self.name)?.summary;
                &other
            };
            // Without an interface cavity there is none.
            if let (Some(lt), Some(lt_strict)) = (summary.lt(), summary.lt_strict()) {
                settings.push(time(latency));
                tolerant.push(lt);
                strict.push(lt_strict);
            }
        }
        Ok(curve::svg("LT over latency (thin: LT strict)", &settings, &tolerant, &strict))
    }

    /// The speed-up and, thin, the number of processors.
    fn over_processors(&self) -> Result<String, Failure> {
        let all = self.args.processors;
        let mut counts: Vec<u32> = (0..).map(|k| 1 << k).take_while(|&p| p < all).collect();
        counts.push(all);
        let mut gains = Vec::new();
        for &count in &counts {
            let (plan, config) = layout(self.args, self.set.len(), count);
            let options = Options { spans: 0, ..self.options.clone() };
            let makespan = if count == all {
                self.summary.makespan
            } else if count == 1 {
                self.alone
            } else {
                mesh(self.set, &plan, config, &options, self.name)?.summary.makespan
            };
            gains.push(self.alone as f64 / makespan.max(1) as f64);
        }
        let settings: Vec<String> = counts.iter().map(u32::to_string).collect();
        let ideal: Vec<f64> = counts.iter().map(|&p| f64::from(p)).collect();
        Ok(curve::svg("Speed-up over processors (thin: ideal)", &settings, &gains, &ideal))
    }
}

/// A time with its unit.
fn time(nanos: u64) -> String {
    let units = [(1_000_000_000, "s"), (1_000_000, "ms"), (1_000, "µs")];
    let fits = units.iter().find(|(size, _)| nanos >= *size);
    fits.map_or(format!("{nanos} ns"), |&(size, unit)| {
        format!("{} {unit}", nanos as f64 / size as f64)
    })
}

#[cfg(test)]
mod tests {
    use super::time;

    #[test]
    fn times_have_units() {
        let cases =
            [(300, "300 ns"), (1_500, "1.5 µs"), (100_000, "100 µs"), (2_000_000_000, "2 s")];
        for (nanos, text) in cases {
            assert_eq!(time(nanos), text);
        }
    }
}
