//! The figures of a parallel run as the paper's tables, beside the paper's own.

use ltbw::metrics::{
    Cavities, CavityTimes, Extremes, Polls, Summary, Times, WorkerFigures, tolerance,
};
use ltbw::simulate::{CostModel, Whole};
use std::fmt::Write;

/// The work of the processors in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Doing {
    /// They insert given points.
    Insertion,
    /// They refine a domain in rounds.
    Rounds,
    /// They refine a domain as the paper does.
    Async,
}

impl Doing {
    fn text(self) -> &'static str {
        match self {
            Self::Insertion => "Insertion of points; the paper's runs refine a mesh.",
            Self::Rounds => "Refinement in rounds; the paper's runs refine without.",
            Self::Async => "Refinement without rounds, as the paper's.",
        }
    }
}

/// Other knowledge of a run than its figures.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub(crate) doing: Doing,
    /// The time of one processor for what the kernel does.
    pub(crate) alone: Option<u64>,
    /// The time of the whole, and of one processor for it, with the parts of it.
    pub(crate) whole: Option<Whole>,
    /// The time of the whole on the clock, where there is one.
    pub(crate) clock: Option<u64>,
}

/// The tables of a run.
pub(crate) fn tables(summary: &Summary, run: &Run) -> String {
    let mut text = String::new();
    headline(&mut text, summary, run);
    table_iii(&mut text, summary);
    table_iv(&mut text, summary);
    table_v(&mut text, summary);
    table_vi(&mut text, summary);
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

/// A row of the headline: a figure of this run, and the paper's two.
fn headline_row(text: &mut String, name: &str, ours: &str, paper: [&str; 2]) {
    line!(text, "{name:<44}{ours:>12}{:>10}{:>8}", paper[0], paper[1]);
}

/// The paper's figures are those of cube-in-cube with 8 and 16 million tetrahedra, where
/// nothing else is said.
fn headline(text: &mut String, s: &Summary, run: &Run) {
    line!(
        text,
        "{} Paper: cube-in-cube, 8M and 16M tetrahedra,\n32 processors.\n",
        run.doing.text()
    );
    line!(text, "{:<44}{:>12}{:>10}{:>8}", "", "this run", "paper 8M", "16M");
    let mut row = |name: &str, ours: String, paper| headline_row(text, name, &ours, paper);
    let worst = s.extremes_of_tolerance().map(|of| of.least.worker.to_string());
    let name = format!("latency tolerance LT, worst worker ({})", worst.unwrap_or("-".to_owned()));
    row(&name, tolerance(s.worst_lt()), ["0.96", "0.94"]);
    row("LT, all workers", tolerance(s.lt()), ["-"; 2]);
    let strict = "LT strict (idle time counted), worst worker";
    row(strict, tolerance(s.worst_lt_strict()), ["-"; 2]);
    row("LT strict, all workers", tolerance(s.lt_strict()), ["-"; 2]);
    times(text, s, run);
    let mut row = |name: &str, ours: String| headline_row(text, name, &ours, ["-"; 2]);
    row("insertions (operations)", s.operations().to_string());
    row("setbacks", s.setbacks().to_string());
    row("setbacks per operation", percent(s.setback_share()));
    row("most setbacks of one operation", s.worst_setbacks().to_string());
    row("messages per interface cavity", format!("{:.1}", s.messages_per_interface_cavity()));
}

/// The time of the kernel, and that of the whole, which the paper's is.
fn times(text: &mut String, s: &Summary, run: &Run) {
    let mut row = |name: &str, ours: String, paper| headline_row(text, name, &ours, paper);
    row("makespan, kernel", seconds(s.makespan), ["-"; 2]);
    if let Some(alone) = run.alone {
        row("time of one processor, kernel", seconds(alone), ["-"; 2]);
        row("speed-up over one processor, kernel", gain(alone, s.makespan), ["-"; 2]);
        row("efficiency, kernel", percent(s.efficiency(alone)), ["-"; 2]);
    }
    let whole = run.whole.map(|whole| whole.makespan).or(run.clock);
    row("makespan, whole", whole.map_or("-".to_owned(), seconds), ["201 s", "388 s"]);
    let Some(whole) = run.whole else { return };
    row("  start and end, on one processor", seconds(whole.start), ["-"; 2]);
    row("  distribution of the mesh at the start", seconds(whole.distribution), ["-"; 2]);
    row("  gathering of the mesh", seconds(whole.gathering), ["-"; 2]);
    row("  numbers for the parts that stay", seconds(whole.numbering), ["-"; 2]);
    row("time of one processor, whole", seconds(whole.one_processor), ["-"; 2]);
    row("speed-up over one processor, whole", gain(whole.one_processor, whole.makespan), ["-"; 2]);
    row("efficiency, whole", percent(whole.efficiency), ["-"; 2]);
}

/// The speed-up from one time to another.
fn gain(alone: u64, together: u64) -> String {
    format!("{:.2}", alone as f64 / together.max(1) as f64)
}

fn table_iii(text: &mut String, s: &Summary) {
    line!(text, "\nTable III: partition at the end; the paper's: 1M on 16 processors");
    line!(text, "  {:<28}{:>10}{:>14}{:>14}", "", "this run", "paper, LTBW", "paper, SMGP");
    let surface = s.surface_to_volume();
    line!(
        text,
        "  {:<28}{surface:>10.4}{:>14}{:>14}",
        "surface to volume, largest",
        ".101",
        ".064"
    );
    let imbalance = s.imbalance_tets();
    line!(text, "  {:<28}{imbalance:>10}{:>14}{:>14}", "imbalance in tetrahedra", "11194", "3058");
}

/// The workers that tolerate latency worst and best, as the paper has it.
fn table_iv(text: &mut String, s: &Summary) {
    let Some(Extremes { least: worst, most: best }) = s.extremes_of_tolerance() else { return };
    line!(
        text,
        "\nTable IV: cavities completed by the workers of lowest and highest LT, and by all"
    );
    let of = |w: &WorkerFigures| w.worker.to_string();
    let head = ["worker", &of(worst), &of(best), "all"];
    columns(text, &head, ["worst 16M", "best 16M"]);
    let own = [worst.cavities, best.cavities, s.cavities];
    let row = |text: &mut String, name: &str, f: fn(&Cavities) -> u64, paper: [&str; 2]| {
        let [a, b, c] = own.map(|c| f(&c).to_string());
        columns(text, &[name, &a, &b, &c], paper);
    };
    row(text, "local, none active", |c| c.local, ["32840", "29826"]);
    row(text, "local, some active", |c| c.local_active, ["44800", "43444"]);
    row(text, "interface, none other active", |c| c.interface, ["2893", "2907"]);
    row(text, "interface, some active", |c| c.interface_active, ["17684", "17588"]);
    let [a, b, c] = own.map(|c| percent(c.share_active()));
    columns(text, &["share while some active", &a, &b, &c], ["63.6 %", "65.1 %"]);
}

/// The worker of the lowest LT, as the paper has it.
fn table_v(text: &mut String, s: &Summary) {
    let Some(Extremes { least: worst, most: best }) = s.extremes_of_tolerance() else { return };
    line!(text, "\nTable V: time of the workers of lowest and highest LT, and of all");
    let of = |w: &WorkerFigures| w.worker.to_string();
    columns(text, &["worker", &of(worst), &of(best), "all"], ["paper 8M", "paper 16M"]);
    let own = [(worst.cavity_times, worst.times), (best.cavity_times, best.times)];
    let own = [own[0], own[1], (s.cavity_times, s.times)];
    type Part = fn(&(CavityTimes, Times)) -> u64;
    let row = |text: &mut String, name: &str, f: Part, paper: [&str; 2]| {
        let [a, b, c] = own.map(|times| seconds(f(&times)));
        columns(text, &[name, &a, &b, &c], paper);
    };
    row(text, "M, in cavities that succeeded", |t| t.0.successful, ["107.37 s", "235.45 s"]);
    row(text, "A, of it local, a cavity active", |t| t.0.local_active, ["54.78 s", "107.40 s"]);
    let name = "I, of it interface, one active";
    row(text, name, |t| t.0.interface_active, ["41.43 s", "42.39 s"]);
    let active: Part = |t| t.0.local_active + t.0.interface_active;
    row(text, "A + I", active, ["96.21 s", "149.79 s"]);
    row(text, "S, in cavities that were set back", |t| t.0.set_back, ["4.18 s", "9.98 s"]);
    row(text, "idle while a cavity is active", |t| t.1.idle_active, ["-"; 2]);
    row(text, "time with a cavity active", |t| t.1.active, ["-"; 2]);
    let lt = own.map(|(cavities, _)| tolerance(cavities.lt()));
    columns(text, &["LT = (A + I) / (A + I + S)", &lt[0], &lt[1], &lt[2]], ["0.96", "0.94"]);
}

/// The workers with the smallest and the largest share of useful polling, as the paper has it.
fn table_vi(text: &mut String, s: &Summary) {
    let Some(Extremes { least, most }) = s.extremes_of_polling() else { return };
    line!(
        text,
        "\nTable VI: polls of the workers with the least and the most useful ones, by time"
    );
    let of = |w: &WorkerFigures| w.worker.to_string();
    let head = ["least 8M", "most 8M", "least 16M", "most 16M"];
    columns(text, &["worker", &of(least), &of(most), "all"], head);
    let run = seconds(s.makespan);
    let paper = ["201.30 s", "201.30 s", "388.26 s", "388.35 s"];
    columns(text, &["run time, kernel", &run, &run, &run], paper);
    let own = [least.polls, most.polls, s.polls];
    let row = |text: &mut String, name: &str, f: fn(&Polls) -> String, paper: [&str; 4]| {
        let [a, b, c] = own.map(|p| f(&p));
        columns(text, &[name, &a, &b, &c], paper);
    };
    let paper = ["861388", "157744", "1330290", "289530"];
    row(text, "polls", |p| p.total.to_string(), paper);
    let paper = ["43292", "50546", "71205", "91451"];
    row(text, "that found a message", |p| p.useful.to_string(), paper);
    let paper = ["58.63 s", "57.75 s", "93.15 s", "102.30 s"];
    row(text, "their time", |p| seconds(p.total_time), paper);
    let paper = ["30.11 s", "53.95 s", "51.19 s", "94.10 s"];
    row(text, "of it useful", |p| seconds(p.useful_time), paper);
    let vain = |a: u64, b: u64| percent((a - b) as f64 / s.makespan.max(1) as f64);
    let [a, b] = [least, most].map(|w| vain(w.polls.total_time, w.polls.useful_time));
    let paper = ["14.2 %", "1.9 %", "10.8 %", "2.1 %"];
    columns(text, &["in vain, of the run's time", &a, &b, "-"], paper);
    let received = s.workers.iter().map(|w| w.received).sum::<u64>().to_string();
    let [a, b] = [least, most].map(|w| w.received.to_string());
    let paper = ["200684", "380254", "343375", "643776"];
    columns(text, &["messages taken", &a, &b, &received], paper);
    let [a, b] = [least, most].map(|w| seconds(w.times.idle_at_end));
    let all = seconds(s.times.idle_at_end);
    let paper = ["33.95 s", "2.51 s", "49.38 s", "4.93 s"];
    columns(text, &["idle after the last insertion", &a, &b, &all], paper);
}

/// A name, three figures of this run, and some of the paper.
fn columns<const N: usize>(text: &mut String, own: &[&str; 4], paper: [&str; N]) {
    let [name, a, b, c] = own;
    let paper = paper.map(|figure| format!("{figure:>12}")).concat();
    line!(text, "  {name:<34}{a:>13}{b:>13}{c:>14}{paper}");
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
    line!(
        text,
        "\nFigures 5 and 7: each worker's time; its cavities, setbacks and services to others"
    );
    line!(
        text,
        "  {:>6} {:>7} {:>8} {:>8} {:>8} {:>8}  {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "worker",
        "LT",
        "meshing",
        "communi.",
        "balanc.",
        "idle",
        "local",
        "l. act.",
        "interf.",
        "i. act.",
        "set back",
        "services"
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
        let all = (w.cavities.all() + w.setbacks + w.services).max(1) as f64;
        let kind = |n: u64| percent(n as f64 / all);
        line!(
            text,
            "  {:>6} {:>7} {:>8} {:>8} {:>8} {:>8}  {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}",
            w.worker,
            tolerance(w.lt()),
            share(|t| t.meshing),
            share(|t| t.communication + t.polling),
            share(|t| t.balancing),
            share(|t| t.idle),
            kind(w.cavities.local),
            kind(w.cavities.local_active),
            kind(w.cavities.interface),
            kind(w.cavities.interface_active),
            kind(w.setbacks),
            kind(w.services)
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
