//! Figures of a parallel run: those of the paper's Tables III to VI and of its Figures 5 and 7, for
//! runs on threads and on simulated processors alike.
//!
//! A runtime keeps one [`Collector`] for each worker and feeds it with what the worker did and
//! when; [`Summary::new`] joins them at the end. A clock may be real or virtual.
//!
//! # Definitions
//!
//! Time is in nanoseconds. An interface cavity is *active* from the moment its home asks for its
//! closure ([`Note::Began`](crate::protocol::Note::Began)) to its commit or setback; act(w, t) is
//! the number of active cavities whose home is worker w at time t.
//!
//! * *Table III*. Surface to volume: the largest share of interface faces per tetrahedron of any
//!   worker; imbalance: most less fewest tetrahedra.
//! * *Table IV*. Completed cavities by {local, interface} × {no other cavity of the worker active,
//!   some active}.
//! * *Table V*. M: time in cavities that succeeded; A: the part of M in local cavities while
//!   act ≥ 1; I: the part of M in interface cavities while act ≥ 1; S: time in cavities that were
//!   set back. Latency tolerance LT = (A + I) / (A + I + S). Time counts for the worker that spent
//!   it. The paper's table shows the worker with the lowest LT.
//! * *LT strict* = 1 − (idle while act ≥ 1 + S) / (time with act ≥ 1): LT alone is blind to idle
//!   time.
//! * *Table VI*. Polls, those that found a message, the time of each; messages; idle time after a
//!   worker's last insertion. The paper shows the workers with the smallest and the largest share
//!   of useful polling.
//! * *Figure 5*. Each worker's time: meshing, communication, balancing, idle.
//! * *Figure 7*. Each worker's cavities by kind, its setbacks, and the requests of others that it
//!   served.
//!
//! Time goes to operations step by step: a step that handles a message about an operation costs
//! that operation, whichever worker it runs on, with sending and receiving. What a step does
//! besides (it may wake another operation) is not split off. The paper's runs refine a mesh; ours
//! insert points.

mod collector;
mod figures;
mod flow;
mod span;
mod summary;
mod trace;

pub use collector::{Cause, Collector, Step};
pub use figures::{Cavities, CavityTimes, Messages, Polls, Times, WorkerFigures};
pub use flow::{About, Flow};
pub use span::{Span, SpanKind};
pub use summary::{Extremes, Summary, tolerance};
pub use trace::Trace;

/// Time in nanoseconds since a run's start.
pub type Nanos = u64;

/// The size of a worker's submesh and of its boundary (Table III).
pub trait SubmeshSize {
    /// Tetrahedra, ghosts included.
    fn tets(&self) -> u64;

    /// Faces of these whose other side is another worker's.
    fn interface_faces(&self) -> u64;
}
