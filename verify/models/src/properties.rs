//! The system as stateright sees it: safety as `always`, witnesses as `sometimes`.

use crate::hull::Letter;
use crate::system::{Choice, State, System};
use crate::variants::Variant;
use crate::witness::Witness;
use ltbw::protocol::{Message, WorkerId};
use stateright::{Model, Property};

impl Witness {
    /// Does it happen in `state`?
    pub fn holds<C: Variant>(self, state: &State<C>) -> bool {
        match self {
            Self::SetBack => any(state, |_, letter| matches!(letter, Message::Abort { .. })),
            Self::Crossing => state.channels.iter().any(|(&(from, to), letters)| {
                let back = state.channels.get(&(to, from));
                from < to
                    && letters.iter().any(|l| is_expand(l))
                    && back.is_some_and(|letters| letters.iter().any(|l| is_expand(l)))
            }),
            Self::Installation => state.nodes.iter().any(|node| node.awaits_installation()),
            Self::Bounce => any(
                state,
                |_, letter| matches!(letter, Message::Grant { bounced, .. } if !bounced.is_empty()),
            ),
            Self::Stray => any(state, |_, letter| matches!(letter, Message::Stray { .. })),
            Self::LateWound => any(state, |to, letter| match letter {
                Message::Wound { ticket, .. } => {
                    state.committed.contains(ticket) && !state.nodes[to.index()].is_home_of(*ticket)
                }
                _ => false,
            }),
            Self::Walk => any(state, |_, letter| matches!(letter, Message::Walk { .. })),
            Self::Move => any(state, |_, letter| matches!(letter, Message::Migrate { .. })),
        }
    }

    fn property<C: Variant>(self) -> Property<System<C>> {
        let condition: fn(&System<C>, &State<C>) -> bool = match self {
            Self::SetBack => |_, s| Self::SetBack.holds(s),
            Self::Crossing => |_, s| Self::Crossing.holds(s),
            Self::Installation => |_, s| Self::Installation.holds(s),
            Self::Bounce => |_, s| Self::Bounce.holds(s),
            Self::Stray => |_, s| Self::Stray.holds(s),
            Self::LateWound => |_, s| Self::LateWound.holds(s),
            Self::Walk => |_, s| Self::Walk.holds(s),
            Self::Move => |_, s| Self::Move.holds(s),
        };
        Property::sometimes(self.name(), condition)
    }
}

fn is_expand<C: Variant>(letter: &Letter<C>) -> bool {
    matches!(letter, Message::Expand { .. })
}

/// Is there such a message under way? The test is given its receiver.
fn any<C: Variant>(state: &State<C>, test: impl Fn(WorkerId, &Letter<C>) -> bool) -> bool {
    state.channels.iter().any(|(&(_, to), letters)| letters.iter().any(|l| test(to, l)))
}

impl<C: Variant> Model for System<C> {
    type State = State<C>;
    type Action = Choice;

    fn init_states(&self) -> Vec<State<C>> {
        vec![self.initial()]
    }

    fn actions(&self, state: &State<C>, actions: &mut Vec<Choice>) {
        actions.extend(self.choices(state));
    }

    fn next_state(&self, state: &State<C>, choice: Choice) -> Option<State<C>> {
        Some(self.after(state, choice))
    }

    fn properties(&self) -> Vec<Property<Self>> {
        let mut properties = vec![
            Property::<Self>::always("no fault", |_, state| state.fault.is_none()),
            Property::<Self>::always("no deadlock", |system, state| {
                system.is_final(state) || !system.choices(state).is_empty()
            }),
            Property::<Self>::sometimes("the end", |system, state| system.is_final(state)),
        ];
        properties.extend(self.world.witnesses.iter().map(|witness| witness.property()));
        properties
    }
}
