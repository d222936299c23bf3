//! The rows of the page's tables, and what each says of a step.

use ltbw::check::{OperationView, RequestView};
use ltbw::protocol::{Attempt, Correct, Message, Note};
use ltbw::protocol::{Source, Submesh, Ticket, Worker, WorkerId};

/// The state of one operation at one worker.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Look<T> {
    pub(crate) home: Option<OperationView>,
    pub(crate) request: Option<RequestView<T>>,
    /// The locked tetrahedra that requests of it wait for.
    pub(crate) queues: Vec<T>,
}

pub(crate) fn look<S: Submesh, Q: Source<S>>(
    worker: &Worker<S, Q, Correct>,
    ticket: Ticket,
) -> Look<S::Tet> {
    let mut queues = Vec::new();
    worker.visit_waiting(&mut |t, waiter| queues.extend((waiter == ticket).then_some(t)));
    Look { home: worker.operation_of(ticket), request: worker.request_of(ticket), queues }
}

impl<T> Look<T> {
    /// The home's state without its number.
    pub(crate) fn phase(&self) -> &str {
        self.home.as_ref().map_or("no operation", |own| {
            own.state.split_once('(').map_or(own.state.as_str(), |(name, _)| name)
        })
    }

    /// The number of releases not acknowledged.
    pub(crate) fn open(&self) -> u32 {
        let state = self.home.as_ref().map_or("", |own| own.state.as_str());
        let number = state.split_once('(').map_or("0", |(_, rest)| rest.trim_end_matches(')'));
        number.parse().expect("a number")
    }

    pub(crate) fn attempt(&self) -> Attempt {
        let at_home = self.home.as_ref().map(|own| own.attempt);
        at_home.or(self.request.as_ref().map(|r| r.attempt)).unwrap_or_default()
    }

    pub(crate) fn owner(&self) -> &str {
        match &self.request {
            None => "no request",
            Some(request) if request.stalled => "stalled",
            Some(_) => "granted",
        }
    }
}

/// A transition of one operation: before and after one event at one worker.
pub(crate) struct Step<'a, S: Submesh> {
    pub(crate) me: WorkerId,
    /// Of the event's block: is it this worker's?
    pub(crate) is_mine: bool,
    pub(crate) from: WorkerId,
    pub(crate) ticket: Ticket,
    pub(crate) attempt: Attempt,
    pub(crate) before: Look<S::Tet>,
    pub(crate) after: Look<S::Tet>,
    pub(crate) sent: Vec<(WorkerId, &'a Message<S>)>,
    pub(crate) notes: Vec<Note>,
}

impl<S: Submesh> Step<'_, S> {
    /// The receivers of messages of this kind about the operation.
    pub(crate) fn to(&self, kind: &str) -> Vec<WorkerId> {
        let about = |m: &Message<S>| m.kind() == kind && m.ticket() == Some(self.ticket);
        self.sent.iter().filter(|(_, m)| about(m)).map(|(to, _)| *to).collect()
    }

    pub(crate) fn is_quiet(&self) -> bool {
        self.sent.is_empty() && self.before == self.after
    }

    pub(crate) fn has(&self, note: impl Fn(&Note) -> bool) -> bool {
        self.notes.iter().any(note)
    }

    /// Was it set back in the same step, by messages to itself?
    pub(crate) fn is_set_back(&self) -> bool {
        self.has(|n| matches!(n, Note::SetBack { ticket, .. } if *ticket == self.ticket))
    }

    pub(crate) fn is_committed(&self) -> bool {
        self.has(|n| matches!(n, Note::Committed { ticket, .. } if *ticket == self.ticket))
    }

    /// `start`: one of its ends, with the same attempt.
    pub(crate) fn started(&self) -> bool {
        let kept = self.after.home.is_none() || self.after.attempt() == self.attempt;
        let walks = self.to("walk");
        let ended = self.has(|n| matches!(n, Note::Duplicate | Note::Local));
        match self.after.phase() {
            "no operation" => walks.len() == 1 || ended || self.is_committed(),
            "Walking" => kept && walks.is_empty() && self.after.request.is_none(),
            "Expanding" => kept && self.after.request.is_some(),
            _ => self.is_set_back(),
        }
    }

    /// `advance`: granted, with one answer, or stalled, in one queue at most.
    pub(crate) fn advanced(&self) -> bool {
        let Some(request) = &self.after.request else {
            return self.is_committed() || self.is_set_back();
        };
        let answers = self.to("grant").len() + usize::from(self.from == self.me);
        if request.stalled {
            request.owed > 0 && request.wants > 0 && self.after.queues.len() <= 1
        } else {
            request.owed == 0 && request.wants == 0 && answers == 1
        }
    }

    /// Unlocked, and in no queue.
    pub(crate) fn is_released(&self) -> bool {
        self.after.request.is_none() && self.after.queues.is_empty()
    }
}

/// A row of a table and the test that a step does what it says.
pub(crate) type Row<S> = ([&'static str; 5], fn(&Step<'_, S>) -> bool);

/// The rows of *The home* whose event is a message or `Work`.
pub(crate) fn home<S: Submesh>() -> Vec<Row<S>> {
    vec![
        (
            [
                "no operation",
                "`Work`",
                "none is `Ready`; operations here < `window`; a point is left",
                "`start(new point)`",
                "see `start`",
            ],
            |s| s.started(),
        ),
        (
            [
                "no operation",
                "`Walk`",
                "`at` is none, or its block is mine",
                "`start(point, at)` with its ticket and attempt",
                "see `start`",
            ],
            |s| s.started(),
        ),
        (["no operation", "`Walk`", "else (R10)", "send it on to `at`'s owner", "gone"], |s| {
            s.to("walk").len() == 1 && s.sent.len() == 1 && s.after.home.is_none()
        }),
        (
            [
                "`Ready`",
                "`Work`",
                "it is the oldest `Ready` one",
                "`start` with its ticket and attempt",
                "see `start`",
            ],
            |s| s.started(),
        ),
        (
            [
                "`Expanding`",
                "`Grant`",
                "its attempt",
                "`granted`, below",
                "`Expanding`, or gone (commit point)",
            ],
            |s| {
                let asked = s.to("expand");
                let commits = s.to("commit");
                asked.is_sorted()
                    && match s.after.phase() {
                        "no operation" => {
                            s.is_committed() && asked.is_empty() && !commits.contains(&s.me)
                        }
                        "Expanding" => {
                            commits.is_empty() && s.after.attempt() == s.before.attempt()
                        }
                        _ => s.is_set_back(),
                    }
            },
        ),
        (
            [
                "`Expanding`",
                "`Wound`",
                "its attempt",
                "`Abort` to each worker of `asked`, ascending; forget parts, whereabouts",
                "`Releasing(number asked)`",
            ],
            |s| {
                let asked = s.before.home.as_ref().map_or(&[][..], |own| &own.asked);
                let others: Vec<WorkerId> = asked.iter().copied().filter(|&w| w != s.me).collect();
                // The release of its own part is acknowledged in the same step.
                let state = if others.is_empty() { "Ready" } else { "Releasing" };
                s.to("abort") == others
                    && s.after.phase() == state
                    && s.after.open() as usize == others.len()
                    && s.after.request.is_none()
            },
        ),
        (["`Releasing(n)`", "`Aborted`", "its attempt, n > 1", "", "`Releasing(n - 1)`"], |s| {
            s.sent.is_empty() && s.after.open() + 1 == s.before.open()
        }),
        (["`Releasing(1)`", "`Aborted`", "its attempt (R6)", "attempt + 1", "`Ready`"], |s| {
            let next = s.before.attempt().next();
            s.sent.is_empty() && s.after.phase() == "Ready" && s.after.attempt() == next
        }),
        (
            [
                "`Releasing`",
                "`Grant`, `Wound`",
                "",
                "nothing: a late message of the same attempt",
                "unchanged",
            ],
            |s| s.is_quiet(),
        ),
        (
            [
                "any other, or gone",
                "`Wound`",
                "(R7)",
                "nothing: the older one waits for a release that comes anyhow",
                "unchanged",
            ],
            |s| s.is_quiet(),
        ),
    ]
}

/// The rows of *The owner* whose event is a message.
pub(crate) fn owner<S: Submesh>() -> Vec<Row<S>> {
    vec![
        (
            [
                "no request",
                "`Expand`",
                "",
                "new request; wants = seeds; owed = 1; `advance`",
                "granted, or stalled",
            ],
            |s| s.advanced(),
        ),
        (
            [
                "granted",
                "`Expand`",
                "its attempt (P8)",
                "push seeds; owed + 1; `advance`",
                "granted, or stalled",
            ],
            |s| s.advanced(),
        ),
        (
            [
                "stalled",
                "`Expand`",
                "its attempt (P8)",
                "put the seeds *beneath* the top of wants (R5); owed + 1",
                "stalled",
            ],
            |s| {
                let owed = |look: &Look<S::Tet>| look.request.as_ref().map_or(0, |r| r.owed);
                s.sent.is_empty()
                    && s.after.owner() == "stalled"
                    && owed(&s.after) == owed(&s.before) + 1
                    && s.after.queues == s.before.queues
            },
        ),
        (
            [
                "any",
                "`Abort`",
                "its attempt (P8)",
                "leave all queues; `release`; `Aborted` to the sender",
                "no request",
            ],
            |s| s.is_released() && s.to("aborted") == [s.from],
        ),
        (
            [
                "granted",
                "`Commit`",
                "",
                "unlock; apply the patch; send strays; `wake`",
                "no request",
            ],
            |s| s.is_released(),
        ),
        (
            [
                "no request",
                "`Commit`",
                "a patch, nothing to remove",
                "apply; send strays; `wake`",
                "no request",
            ],
            |s| s.is_released(),
        ),
    ]
}

/// Rows whose events are inside a step: the state before, and those that may follow.
pub(crate) const WITHIN: [(&str, &str, &[&str]); 3] = [
    (
        "`Walking`",
        "its tetrahedron is unlocked, or its name installed, or a block leaves (R11)",
        &["Ready"],
    ),
    ("stalled", "its tetrahedron is unlocked", &["granted", "stalled"]),
    ("stalled", "its name is installed, or its block leaves (R11)", &["granted", "stalled"]),
];

/// The number of the row for an event at the home: `None` if the page says that it cannot happen.
pub(crate) fn at_home<T>(
    event: &str,
    look: &Look<T>,
    attempt: Attempt,
    is_mine: bool,
) -> Option<usize> {
    let same = look.attempt() == attempt;
    Some(match (look.phase(), event) {
        ("no operation", "work") => 0,
        ("no operation", "walk") if is_mine => 1,
        ("no operation", "walk") => 2,
        ("Ready", "work") => 3,
        ("Expanding", "grant") if same => 4,
        ("Expanding", "wound") if same => 5,
        ("Releasing", "aborted") if same => 6 + usize::from(look.open() == 1),
        ("Releasing", "grant") if same => 8,
        ("Releasing", "wound") if same => 8,
        (_, "wound") => 9,
        _ => return None,
    })
}

/// The number of the row for a message to the owner.
pub(crate) fn at_owner<T>(
    event: &str,
    look: &Look<T>,
    attempt: Attempt,
    patched: bool,
) -> Option<usize> {
    let same = look.request.as_ref().is_some_and(|r| r.attempt == attempt);
    Some(match (look.owner(), event) {
        ("no request", "expand") => 0,
        ("granted", "expand") if same => 1,
        ("stalled", "expand") if same => 2,
        (_, "abort") if same => 3,
        ("granted", "commit") => 4,
        ("no request", "commit") if patched => 5,
        _ => return None,
    })
}
