//! Messages and actions over the line as JSON. `verify/vectors/README.md` defines the format.

use super::line::{Line, Link, Patch, Piece};
use ltbw::protocol::{Action, Handle, Message, Name, Ticket};
use serde_json::{Value, json};

fn name(name: Name) -> Value {
    json!([name.by, name.number])
}

/// A ticket: clock, worker, sequence.
#[must_use]
pub fn ticket(ticket: Ticket) -> Value {
    json!([ticket.clock, ticket.worker, ticket.sequence])
}

fn handle(handle: &Handle) -> Value {
    json!([handle.name.by, handle.name.number, handle.block])
}

fn handles(list: &[Handle]) -> Value {
    list.iter().map(handle).collect()
}

fn link(link: Link) -> Value {
    link.map_or(Value::Null, |(name, block)| json!([name.by, name.number, block]))
}

fn piece((of, cell): &Piece) -> Value {
    let [left, right] = cell.links.map(link);
    json!({"name": name(*of), "ends": cell.ends, "left": left, "right": right})
}

fn pieces(list: &[Piece]) -> Value {
    list.iter().map(piece).collect()
}

fn patch(patch: &Patch) -> Value {
    let relink: Vec<Value> = patch
        .relink
        .iter()
        .map(|&(of, side, to)| json!({"of": name(of), "side": side, "to": link(Some(to))}))
        .collect();
    let remove: Vec<Value> = patch.remove.iter().map(|&of| name(of)).collect();
    json!({"remove": remove, "add": pieces(&patch.add), "relink": relink})
}

/// A message.
#[must_use]
pub fn message(of: &Message<Line>) -> Value {
    let mut fields = match of {
        Message::Walk { attempt, point, at, .. } => {
            json!({"attempt": attempt, "point": point, "at": at.as_ref().map(handle)})
        }
        Message::Expand { attempt, point, seeds, .. } => {
            json!({"attempt": attempt, "point": point, "seeds": handles(seeds)})
        }
        Message::Grant { attempt, answers, pieces: found, foreign, bounced, moved, .. } => json!({
            "attempt": attempt, "answers": answers, "pieces": pieces(found),
            "foreign": handles(foreign), "bounced": handles(bounced), "moved": moved,
        }),
        Message::Deny { attempt, .. }
        | Message::Wound { attempt, .. }
        | Message::Abort { attempt, .. }
        | Message::Aborted { attempt, .. } => json!({"attempt": attempt}),
        Message::Commit { patch: change, .. } => json!({"patch": change.as_ref().map(patch)}),
        Message::Migrate { block, epoch, cargo, points } => {
            json!({"block": block, "epoch": epoch, "cargo": pieces(cargo), "points": points})
        }
        Message::Stray { block, cargo } => json!({"block": block, "cargo": pieces(cargo)}),
        Message::Token(token) => json!({"count": token.count, "black": token.black}),
        Message::Stop => json!({}),
    };
    fields["kind"] = json!(of.kind());
    if let Some(of) = of.ticket() {
        fields["ticket"] = ticket(of);
    }
    fields
}

/// An action; notes are for people and not a part of the protocol.
#[must_use]
pub fn action(of: &Action<Line>) -> Option<Value> {
    match of {
        Action::Send { to, message: sent } => Some(json!({"to": to, "send": message(sent)})),
        Action::Backoff { ticket: of, attempt } => {
            Some(json!({"backoff": ticket(*of), "attempt": attempt}))
        }
        Action::Note(_) => None,
    }
}
