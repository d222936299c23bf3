//! The timeline of a parallel run, as the page's script takes it.

use super::{Filling, filled};
use ltbw::metrics::{Nanos, SpanKind, Trace};
use serde_json::json;

const HTML: &str = include_str!("timeline.html");
const SCRIPT: &str = include_str!("timeline.js");

/// Letters in all rows together, and the most in a row.
const LETTERS: usize = 1_000_000;
const FINEST: usize = 4_000;

/// The order in which the kinds of time are explained; a letter is a place in it.
const KINDS: [SpanKind; 8] = [
    SpanKind::Walk,
    SpanKind::Expand,
    SpanKind::Fill,
    SpanKind::Setback,
    SpanKind::Wait,
    SpanKind::Poll,
    SpanKind::Balance,
    SpanKind::Idle,
];

/// A row for each worker; `end` is how long the run took.
pub(crate) fn timeline(trace: &Trace, workers: usize, end: Nanos) -> String {
    let kinds = KINDS.map(SpanKind::name);
    let data = json!({ "kinds": kinds, "end": end, "rows": rows(trace, workers, end) });
    let data = data.to_string().replace('<', "\\u003c");
    filled(HTML, &[("data", &*data), ("script", SCRIPT)].map(Filling::from))
}

/// A letter for each stretch of time: what the worker did for most of it; a blank if nothing is
/// known.
fn rows(trace: &Trace, workers: usize, end: Nanos) -> Vec<String> {
    let bins = (LETTERS / workers.max(1)).clamp(1, FINEST);
    let width = (end as f64 / bins as f64).max(1.0);
    let mut shares = vec![[0.0; KINDS.len()]; bins * workers];
    for span in &trace.spans {
        let (worker, kind) = (span.worker.index(), KINDS.iter().position(|&k| k == span.kind));
        let (Some(kind), true) = (kind, worker < workers) else { continue };
        let (begin, until) = (span.begin as f64 / width, span.end as f64 / width);
        // The conversions saturate.
        let (first, last) = (begin as usize, (until.ceil() as usize).min(bins));
        for bin in first..last {
            let inside = until.min((bin + 1) as f64) - begin.max(bin as f64);
            shares[worker * bins + bin][kind] += inside;
        }
    }
    let letter = |share: &[f64; KINDS.len()]| {
        let most = (0..KINDS.len()).max_by(|&a, &b| share[a].total_cmp(&share[b])).unwrap_or(0);
        if share[most] > 0.0 { char::from(b'a' + most as u8) } else { ' ' }
    };
    shares.chunks(bins).map(|row| row.iter().map(letter).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltbw::metrics::Span;
    use ltbw::protocol::WorkerId;

    #[test]
    fn a_stretch_shows_what_took_most_of_it() {
        let span = |worker, begin, end, kind| Span { worker, begin, end, kind, ticket: None };
        let spans = vec![
            span(WorkerId::default(), 0, 2_000, SpanKind::Walk),
            span(WorkerId::default(), 2_000, 2_001, SpanKind::Poll),
            span(WorkerId::default(), 2_001, 4_000, SpanKind::Fill),
            span(WorkerId::new(1), 1_000, 3_000, SpanKind::Idle),
            span(WorkerId::new(7), 0, 1, SpanKind::Idle),
        ];
        let rows = rows(&Trace { spans, flows: Vec::new(), is_complete: true }, 2, 4_000);
        assert_eq!(rows[0], format!("{}f{}", "a".repeat(2_000), "c".repeat(1_999)));
        let (blank, idle) = (" ".repeat(1_000), "h".repeat(2_000));
        assert_eq!(rows[1], format!("{blank}{idle}{blank}"));
    }

    #[test]
    fn a_page_of_many_workers_stays_small() {
        let trace = Trace { spans: Vec::new(), flows: Vec::new(), is_complete: true };
        let all: usize = rows(&trace, 1_024, 1_000_000).iter().map(String::len).sum();
        assert!(all <= LETTERS);
        assert_eq!(rows(&trace, 1, 0)[0].len(), FINEST);
    }
}
