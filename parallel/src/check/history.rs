//! Properties of a whole run, which no single state shows.

use super::{Between, Check, Inspect, require};
use crate::protocol::{Attempt, Invariant, Name, Note, Rules, Source, Ticket};
use std::collections::{BTreeMap, HashMap};

/// The history so far, for properties that no single state shows.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// The tetrahedron that each name was given to.
    names: HashMap<Name, Vec<u64>>,
    /// The name of each tetrahedron.
    tets: HashMap<Vec<u64>, Name>,
    attempts: BTreeMap<Ticket, Attempt>,
}

impl History {
    /// P2 over time: a name is of one tetrahedron, a tetrahedron of one name.
    ///
    /// # Errors
    /// P2.
    pub fn look<S: Inspect, Q: Source<S>, C: Rules>(
        &mut self,
        between: &Between<'_, S, Q, C>,
    ) -> Check {
        let here = between.tets().map(|(_, tet)| (tet.name, &tet.vertices));
        let sent = between.sent.iter().map(|(name, vertices)| (*name, vertices));
        for (name, vertices) in here.chain(sent) {
            let Some(name) = name else { continue };
            let first = self.names.entry(name).or_insert_with(|| vertices.clone());
            require(Invariant::P2, first == vertices, || {
                format!("{name:?} was {first:?} and is {vertices:?}")
            })?;
            let one = *self.tets.entry(vertices.clone()).or_insert(name);
            require(Invariant::P2, one == name, || {
                format!("{vertices:?} is {one:?} and {name:?}")
            })?;
        }
        Ok(())
    }

    /// P8 over time: an attempt is one above the last one of its operation.
    ///
    /// # Errors
    /// P8.
    pub fn note(&mut self, note: Note) -> Check {
        let (ticket, now, is_new) = match note {
            Note::SetBack { ticket, attempt } => (ticket, attempt, true),
            Note::Committed { ticket, setbacks, .. } => (ticket, setbacks, false),
            _ => return Ok(()),
        };
        let last = self.attempts.entry(ticket).or_default();
        let before = std::mem::replace(last, now);
        require(Invariant::P8, now == if is_new { before.next() } else { before }, || {
            format!("attempt {now} of {ticket:?} comes after {before}")
        })
    }
}
