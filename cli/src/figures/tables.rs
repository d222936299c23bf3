//! The figures of a parallel run as the paper's tables, beside the paper's own.

use ltbw::metrics::{Summary, Times};
use ltbw::simulate::CostModel;
use std::fmt::Write;

/// The tables of a run; `alone` is how long one processor takes for it, if that is known.
pub(crate) fn tables(summary: &Summary, alone: Option<u64>) -> String {
    let mut text = String::new();
    headline(&mut text, summary, alone);
    table_iii_and_iv(&mut text, summary);
    table_v_and_vi(&mut text, summary);
    messages(&mut text, summary);
    workers(&mut text, summary);
    text
}

/// Writing to a string does not fail.
macro_rules! line {
    ($text:expr, $($arg:tt)*) => {
        let _ = writeln!($text, $($arg)*);
    };
}

fn headline(text: &mut String, s: &Summary, alone: Option<u64>) {
    line!(text, "Insertion of points; the paper's runs refine a mesh.\n");
    line!(text, "{:<44}{:>12}{:>16}", "", "this run", "paper");
    let row = |text: &mut String, name: &str, ours: String, paper: &str| {
        line!(text, "{name:<44}{ours:>12}{paper:>16}");
    };
    row(text, "latency tolerance LT", format!("{:.4}", s.lt()), "0.96, 0.94");
    row(text, "LT strict (idle time counted)", format!("{:.4}", s.lt_strict()), "-");
    let active = percent(s.cavities.share_active());
    row(text, "cavities completed while others active", active, "63.6 %, 65.1 %");
    let each = format!("{:.1}", s.messages_per_interface_cavity());
    row(text, "messages per interface cavity", each, "17 to 33");
    row(text, "insertions (operations)", s.operations().to_string(), "");
    row(text, "setbacks", s.setbacks().to_string(), "");
    row(text, "setbacks per operation", percent(s.setback_share()), "");
    row(text, "most setbacks of one operation", s.worst_setbacks().to_string(), "");
    row(text, "makespan", seconds(s.makespan), "");
    if let Some(alone) = alone {
        row(text, "time of one processor", seconds(alone), "");
        row(text, "efficiency", percent(s.efficiency(alone)), "");
    }
}

fn table_iii_and_iv(text: &mut String, s: &Summary) {
    line!(text, "\nTable III: partition at the end");
    line!(text, "  surface to volume, largest   {:>10.4}", s.surface_to_volume());
    line!(text, "  imbalance in tetrahedra      {:>10}", s.imbalance_tets());
    let c = &s.cavities;
    let of = |n: u64| percent(n as f64 / c.all().max(1) as f64);
    line!(text, "\nTable IV: cavities completed     none active       some active");
    let row = |text: &mut String, name: &str, none: u64, some: u64| {
        line!(text, "  {name:<22}{none:>12} {:>7}{some:>10} {:>7}", of(none), of(some));
    };
    row(text, "local", c.local, c.local_active);
    row(text, "interface", c.interface, c.interface_active);
}

fn table_v_and_vi(text: &mut String, s: &Summary) {
    line!(text, "\nTable V: time of all workers");
    let row = |text: &mut String, name: &str, ns: u64| {
        line!(text, "  {name:<46}{:>12}", seconds(ns));
    };
    row(text, "M, in cavities that succeeded", s.successful);
    row(text, "A, of it local, while a cavity is active", s.local_active);
    row(text, "I, of it interface, while a cavity is active", s.interface_active);
    row(text, "S, in cavities that were set back", s.set_back);
    row(text, "idle while a cavity is active", s.times.idle_active);
    row(text, "time with a cavity active", s.times.active);
    line!(text, "\nTable VI: polls");
    let p = &s.polls;
    line!(text, "  {:<30}{:>14}{:>14}", "all", p.total, seconds(p.total_time));
    line!(text, "  {:<30}{:>14}{:>14}", "that found a message", p.useful, seconds(p.useful_time));
    row(text, "idle after the last insertion, all workers", s.times.idle_at_end);
}

fn messages(text: &mut String, s: &Summary) {
    line!(text, "\nMessages             count         bytes");
    for (kind, m) in &s.messages {
        line!(text, "  {kind:<12}{:>12}{:>14}", m.count, m.bytes);
    }
    let all = s.all_messages();
    line!(text, "  {:<12}{:>12}{:>14}", "all", all.count, all.bytes);
}

/// Figures 5 and 7; of many workers the first and the last.
fn workers(text: &mut String, s: &Summary) {
    const SHOWN: usize = 32;
    line!(text, "\nFigures 5 and 7: each worker's time and cavities");
    line!(
        text,
        "  {:>6} {:>9} {:>9} {:>9} {:>9}   {:>9} {:>9} {:>9} {:>9}",
        "worker",
        "meshing",
        "communic.",
        "balancing",
        "idle",
        "local",
        "loc. act.",
        "interf.",
        "int. act."
    );
    let hidden = s.workers.len().saturating_sub(SHOWN);
    for (k, w) in s.workers.iter().enumerate() {
        if hidden > 0 && k == SHOWN / 2 {
            line!(text, "     ... {hidden} more: --json lists them");
        }
        if (SHOWN / 2..SHOWN / 2 + hidden).contains(&k) {
            continue;
        }
        let share = |f: fn(&Times) -> u64| percent(f(&w.times) as f64 / s.makespan.max(1) as f64);
        let all = w.cavities.all().max(1) as f64;
        let kind = |n: u64| percent(n as f64 / all);
        line!(
            text,
            "  {:>6} {:>9} {:>9} {:>9} {:>9}   {:>9} {:>9} {:>9} {:>9}",
            w.worker,
            share(|t| t.meshing),
            share(|t| t.communication + t.polling),
            share(|t| t.balancing),
            share(|t| t.idle),
            kind(w.cavities.local),
            kind(w.cavities.local_active),
            kind(w.cavities.interface),
            kind(w.cavities.interface_active)
        );
    }
}

/// The cost model in a few lines: no figure of a simulation means anything without it.
pub(crate) fn cost_model(costs: &CostModel) -> String {
    let c = costs;
    format!(
        "Cost model in ns: walk step {}, conflict test {}, tetrahedron {}, step {}, poll {},\n\
         message sent {}, received {}, byte at either end {}",
        c.walk_step, c.test, c.created, c.step, c.poll, c.send, c.receive, c.byte
    )
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn seconds(ns: u64) -> String {
    format!("{:.6} s", ns as f64 * 1e-9)
}
