//! A timeline of a run, as a trace for Chrome's or Perfetto's viewer.

use super::span::Span;
use super::{Collector, Nanos};
use crate::protocol::WorkerId;
use std::io::{self, Write};

/// The timeline of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trace {
    /// Stretches of time, by worker, then by time.
    pub spans: Vec<Span>,
    /// Did every stretch find room?
    pub is_complete: bool,
}

impl Trace {
    /// Takes the stretches of time out of all collectors.
    pub fn take(collectors: &mut [Collector]) -> Self {
        let mut trace = Self { spans: Vec::new(), is_complete: true };
        for collector in collectors {
            let (spans, complete) = collector.take_spans();
            trace.spans.extend(spans);
            trace.is_complete &= complete;
        }
        trace
    }

    /// Writes the trace as JSON in Chrome's trace event format: one track for each worker.
    ///
    /// # Errors
    ///
    /// The errors of `out`.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let complete = self.is_complete;
        writeln!(out, "{{\"displayTimeUnit\":\"ns\",\"otherData\":{{\"complete\":{complete}}},")?;
        write!(out, "\"traceEvents\":[")?;
        let mut separator = "\n";
        for pair in self.tracks() {
            write!(
                out,
                "{separator}{{\"name\":\"thread_name\",\"ph\":\"M\",\"pid\":0,\"tid\":{pair},\
                 \"args\":{{\"name\":\"worker {pair}\"}}}}"
            )?;
            separator = ",\n";
        }
        for span in &self.spans {
            write!(
                out,
                "{separator}{{\"name\":\"{}\",\"ph\":\"X\",\"pid\":0,\"tid\":{},\"ts\":{},\
                 \"dur\":{}",
                span.kind.name(),
                span.worker,
                Micros(span.begin),
                Micros(span.end - span.begin)
            )?;
            if let Some(t) = span.ticket {
                write!(out, ",\"args\":{{\"op\":\"{}.{}.{}\"}}", t.clock, t.worker, t.sequence)?;
            }
            write!(out, "}}")?;
            separator = ",\n";
        }
        writeln!(out, "\n]}}")
    }

    fn tracks(&self) -> Vec<WorkerId> {
        let mut workers: Vec<_> = self.spans.iter().map(|span| span.worker).collect();
        workers.sort_unstable();
        workers.dedup();
        workers
    }
}

/// Nanoseconds, printed as microseconds with all their digits.
struct Micros(Nanos);

impl std::fmt::Display for Micros {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{:03}", self.0 / 1000, self.0 % 1000)
    }
}
