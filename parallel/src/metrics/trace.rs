//! A timeline of a run, as a trace for Chrome's or Perfetto's viewer.

use super::flow::{Flow, join};
use super::span::Span;
use super::{Collector, Nanos};
use crate::protocol::WorkerId;
use std::io::{self, Write};

/// The timeline of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trace {
    /// Stretches of time, by worker, then by time.
    pub spans: Vec<Span>,
    /// Messages about operations, by the time at which they were sent.
    pub flows: Vec<Flow>,
    /// Did every stretch and every message find room?
    pub is_complete: bool,
}

impl Trace {
    /// The name and version of the format of [`Trace::write`].
    pub const SCHEMA: &'static str = "ltbw.trace/1";

    /// Takes the stretches of time out of all collectors.
    pub fn take(collectors: &mut [Collector]) -> Self {
        let mut trace = Self { spans: Vec::new(), flows: Vec::new(), is_complete: true };
        let (mut sent, mut taken) = (Vec::new(), Vec::new());
        for collector in collectors {
            let [mut starts, mut ends] = collector.take_ports();
            sent.append(&mut starts);
            taken.append(&mut ends);
            trace.spans.extend(collector.take_spans());
            trace.is_complete &= collector.has_kept_all();
        }
        trace.flows = join(sent, taken);
        trace
    }

    /// Writes the trace as JSON in Chrome's trace event format: one track for each worker, an arrow
    /// for each message, such as those from a request to its answer.
    ///
    /// # Errors
    ///
    /// The errors of `out`.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let (schema, complete) = (Self::SCHEMA, self.is_complete);
        write!(out, "{{\"displayTimeUnit\":\"ns\",")?;
        writeln!(out, "\"otherData\":{{\"schema\":\"{schema}\",\"complete\":{complete}}},")?;
        write!(
            out,
            "\"traceEvents\":[\n{{\"name\":\"process_name\",\"ph\":\"M\",\"pid\":0,\
             \"args\":{{\"name\":\"ltbw\"}}}}"
        )?;
        for pair in self.tracks() {
            write!(
                out,
                ",\n{{\"name\":\"thread_name\",\"ph\":\"M\",\"pid\":0,\"tid\":{pair},\
                 \"args\":{{\"name\":\"worker {pair}\"}}}}"
            )?;
        }
        for span in &self.spans {
            write!(
                out,
                ",\n{{\"name\":\"{}\",\"ph\":\"X\",\"pid\":0,\"tid\":{},\"ts\":{},\
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
        }
        for (id, flow) in self.flows.iter().enumerate() {
            let ends = [("s", flow.from, flow.sent), ("f\",\"bp\":\"e", flow.to, flow.taken)];
            for (end, worker, time) in ends {
                write!(
                    out,
                    ",\n{{\"name\":\"{}\",\"cat\":\"message\",\"ph\":\"{end}\",\"id\":{id},\
                     \"pid\":0,\"tid\":{worker},\"ts\":{}}}",
                    flow.kind,
                    Micros(time)
                )?;
            }
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
