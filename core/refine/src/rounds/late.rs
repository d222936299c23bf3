//! The late steps, when no tetrahedron is left that may be split: those that were refused are asked
//! again, relieved, and asked for shorter edges, and slivers are split. Each is a function of the
//! mesh, and rounds go on wherever it leaves something to split.

use super::{Class, Next, Rounds};
use crate::late::again::Asking;
use crate::late::relief::Goal;
use crate::outcome::Sliver;
use crate::rules::sliver::Terms;
use crate::thin::Thin;
use ltbw_core::topology::TetId;

/// A late step.
#[derive(Clone, Copy)]
enum Step {
    /// Tetrahedra refused because of what no point served are asked again.
    Retry,
    Relief(Goal),
    /// Where many were refused at one corner they are asked for shorter edges.
    Insist,
    Slivers,
    /// Slivers that are flat, at the price of others over their bounds.
    Flat(Price),
}

/// The price at which flat slivers go, beside bounds that are broken for a while.
#[derive(Clone, Copy)]
enum Price {
    /// No sliver.
    None,
    /// Slivers of a degree and more.
    Slivers,
}

/// The most flat slivers that go at a price: more are the doing of the domain's surface.
const MOST_FLAT: usize = 32;

/// The late steps in their order. What is flat is a matter of few, and bounded by its own steps.
const STEPS: [Step; 13] = [
    Step::Retry,
    Step::Relief(Goal::Bounds),
    Step::Insist,
    Step::Slivers,
    Step::Relief(Goal::Angles),
    Step::Relief(Goal::Bounds),
    // Relief makes room.
    Step::Slivers,
    Step::Flat(Price::None),
    Step::Slivers,
    Step::Flat(Price::Slivers),
    Step::Slivers,
    Step::Flat(Price::Slivers),
    Step::Slivers,
];

/// The memory of the late steps.
#[derive(Debug, Default)]
pub(super) struct Late {
    /// The step to come.
    pub(super) step: usize,
    /// The numbers of points at which refusals for rounding were forgotten.
    pub(super) retried: Vec<u64>,
    pub(super) asking: Asking,
    /// Slivers not yet looked at, when all else is done.
    pub(super) slivers: Option<Vec<Thin>>,
    /// The number of flat ones, and of points, when they were last looked for.
    flat: usize,
    before: u64,
    /// The tetrahedra that may have tiny dihedral angles, if others have looked at all.
    pub(super) thin: Option<Vec<TetId>>,
}

impl Late {
    /// Others have begun with slivers, since the steps before had nothing to do, and leave these.
    pub(super) fn go_on_with(&mut self, slivers: Vec<Thin>) {
        self.step = Self::first_slivers();
        self.slivers = Some(slivers);
    }

    /// Is the step to come the first one of slivers?
    pub(super) fn is_at_first_slivers(&self) -> bool {
        self.step == Self::first_slivers()
    }

    fn first_slivers() -> usize {
        STEPS.iter().position(|step| matches!(step, Step::Slivers)).unwrap_or(0)
    }
}

impl Rounds<'_, '_> {
    /// The class of the next round, or relief, when no tetrahedron is left to split; `None` if
    /// nothing is left to do.
    pub(super) fn next_late(&mut self) -> Option<Next> {
        // Every step is bounded by itself, and followed by the next one.
        while let Some(&step) = STEPS.get(self.late.step) {
            let is_asked = match step {
                Step::Retry => self.retry(),
                Step::Insist => self.insist(),
                Step::Slivers if self.has_slivers_first() => {
                    return Some(Next::Round(Class::Slivers));
                }
                Step::Slivers => {
                    self.late.slivers = None;
                    false
                }
                Step::Flat(_) if self.has_flat() => return Some(Next::Round(Class::Slivers)),
                Step::Flat(_) => {
                    self.late.slivers = None;
                    match self.late.flat {
                        0 => self.late.step = STEPS.len(),
                        // Where no point was made other slivers would stay as they are.
                        _ if self.own.inserted.points.total() == self.late.before => {
                            self.late.step += 1;
                        }
                        _ => {}
                    }
                    false
                }
                Step::Relief(goal) => {
                    self.late.step += 1;
                    return Some(Next::Relief(goal));
                }
            };
            if !is_asked {
                self.late.step += 1;
                continue;
            }
            self.find_foremost();
            if !self.front.foremost.is_empty() {
                return Some(Next::Round(Class::Tets));
            }
        }
        None
    }

    /// Is any sliver left? When they are looked for first, angles are counted.
    fn has_slivers_first(&mut self) -> bool {
        let is_asked = self.own.bounds.as_ref().is_some_and(|own| own.count_angles);
        if is_asked && self.terms().is_some() && self.stats.before_slivers.is_none() {
            self.stats.before_slivers = Some(self.own.state.least_angles(self.threads));
        }
        self.has_slivers()
    }

    /// The terms on which a point is taken for a sliver; `None` if slivers are not looked for.
    pub(super) fn terms(&self) -> Option<Terms<'_>> {
        let bounds = self.own.bounds.as_ref()?;
        let dihedral = bounds.dihedral?;
        Some(match STEPS.get(self.late.step) {
            Some(Step::Flat(Price::None)) => Terms { bounds, dihedral, keeps_bounds: false },
            Some(Step::Flat(Price::Slivers)) => {
                Terms { bounds, dihedral: dihedral.or_tiny(), keeps_bounds: false }
            }
            _ => Terms { bounds, dihedral, keeps_bounds: true },
        })
    }

    /// Is a flat sliver left? They are looked for once in a step.
    fn has_flat(&mut self) -> bool {
        if self.late.slivers.is_none() {
            let mut flat = self.own.slivers();
            flat.retain(|&(_, v)| self.own.state.least_angle(v) < Sliver::FLAT);
            if flat.len() > MOST_FLAT {
                flat.clear();
            }
            self.late.flat = flat.len();
            self.late.slivers = Some(flat);
            self.late.before = self.own.inserted.points.total();
        }
        self.late.slivers.as_ref().is_some_and(|flat| !flat.is_empty())
    }

    /// Asks refused tetrahedra for shorter edges; `false` if there are none, or often enough.
    fn insist(&mut self) -> bool {
        let tets = self.own.insist(&mut self.late.asking);
        self.blocks.clear();
        self.look_at(&tets);
        !tets.is_empty()
    }
}
