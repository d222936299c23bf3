//! Messages and actions over the line and the hull as JSON. `verify/vectors/README.md` defines the
//! format.

use crate::line::{self, Line};
use ltbw::protocol::{Action, Handle, Message, Name, NoNews, Submesh, Ticket};
use ltbw_models::hull::{self, Hull};
use ltbw_models::told::Told;
use ltbw_models::variants::Variant;
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

fn piece(of: Name, ends: Value, [left, right]: [Value; 2]) -> Value {
    json!({"name": name(of), "ends": ends, "left": left, "right": right})
}

fn patch(remove: &[Name], add: Vec<Value>, relink: impl Iterator<Item = Value>) -> Value {
    let remove: Vec<Value> = remove.iter().map(|&of| name(of)).collect();
    json!({"remove": remove, "add": add, "relink": relink.collect::<Vec<Value>>()})
}

fn relinked(of: Name, side: usize, to: Value) -> Value {
    json!({"of": name(of), "side": side, "to": to})
}

/// A mesh of the kit: what its messages carry, and its cells, as JSON.
pub trait Written: Submesh {
    /// A point.
    fn point(point: &Self::Point) -> Value;
    /// A cell.
    fn piece(piece: &Self::Piece) -> Value;
    /// A patch.
    fn patch(patch: &Self::Patch) -> Value;
    /// Cells that change their owner.
    fn cargo(cargo: &Self::Cargo) -> Value;
    /// The news of sources.
    fn told(news: &Self::News) -> Value;
    /// The ends of all cells, sorted.
    fn cells(&self) -> Value;
}

impl Written for Line {
    fn point(point: &i64) -> Value {
        json!(point)
    }

    fn piece((of, cell): &line::Piece) -> Value {
        let link = |link: line::Link| link.map_or(Value::Null, line_link);
        piece(*of, json!(cell.ends), cell.links.map(link))
    }

    fn patch(change: &line::Patch) -> Value {
        let relink = change.relink.iter();
        let relink = relink.map(|&line::Relink { of, side, to }| relinked(of, side, line_link(to)));
        patch(&change.remove, change.add.iter().map(Self::piece).collect(), relink)
    }

    fn cargo(cargo: &Vec<line::Piece>) -> Value {
        cargo.iter().map(Self::piece).collect()
    }

    fn told(news: &NoNews) -> Value {
        match *news {}
    }

    fn cells(&self) -> Value {
        json!(self.ends())
    }
}

fn line_link((name, block): line::Place) -> Value {
    json!([name.by, name.number, block])
}

/// A vertex of the hull: coordinates and block.
#[must_use]
pub fn vertex(v: hull::Vertex) -> Value {
    json!([v.x, v.y, v.block])
}

fn hull_link(link: hull::Link) -> Value {
    line_link((link.name, link.block))
}

impl<C: Variant> Written for Hull<C> {
    fn point(point: &hull::Vertex) -> Value {
        vertex(*point)
    }

    /// To the left is the edge before it, to the right that after it.
    fn piece(edge: &hull::Piece) -> Value {
        let [after, before] = edge.links.map(hull_link);
        piece(edge.name, json!(edge.ends.map(vertex)), [before, after])
    }

    fn patch(change: &hull::Patch) -> Value {
        let relink = change.relink.iter();
        let relink = relink.map(|&(of, side, to)| relinked(of, 1 - side, hull_link(to)));
        patch(&change.delete, change.create.iter().map(Self::piece).collect(), relink)
    }

    fn cargo(cargo: &Vec<hull::Piece>) -> Value {
        cargo.iter().map(Self::piece).collect()
    }

    fn told(told: &Told) -> Value {
        match told {
            Told::Ask => json!("ask"),
            Told::Answer => json!("answer"),
            Told::Up(sums) => json!({ "up": sums }),
            Told::Down(sums) => json!({ "down": sums }),
        }
    }

    fn cells(&self) -> Value {
        let mut ends: Vec<[hull::Vertex; 2]> =
            Hull::cells(self).map(|cell| cell.piece.ends).collect();
        ends.sort_unstable();
        ends.into_iter().map(|ends| json!(ends.map(vertex))).collect()
    }
}

/// A message.
#[must_use]
pub fn message<M: Written>(of: &Message<M>) -> Value {
    let mut fields = match of {
        Message::Walk { attempt, point, at, .. } => {
            json!({"attempt": attempt, "point": M::point(point), "at": at.as_ref().map(handle)})
        }
        Message::Expand { attempt, point, seeds, .. } => {
            json!({"attempt": attempt, "point": M::point(point), "seeds": handles(seeds)})
        }
        Message::Grant { attempt, answers, pieces, foreign, bounced, moved, .. } => json!({
            "attempt": attempt, "answers": answers,
            "pieces": pieces.iter().map(M::piece).collect::<Value>(),
            "foreign": handles(foreign), "bounced": handles(bounced), "moved": moved,
        }),
        Message::Deny { attempt, .. }
        | Message::Wound { attempt, .. }
        | Message::Abort { attempt, .. }
        | Message::Aborted { attempt, .. } => json!({"attempt": attempt}),
        Message::Commit { patch: change, .. } => json!({"patch": change.as_ref().map(M::patch)}),
        Message::Migrate { block, epoch, cargo, points } => json!({
            "block": block, "epoch": epoch, "cargo": M::cargo(cargo),
            "points": points.iter().map(M::point).collect::<Value>(),
        }),
        Message::Stray { block, cargo } => json!({"block": block, "cargo": M::cargo(cargo)}),
        Message::News(told) => json!({"told": M::told(told)}),
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
pub fn action<M: Written>(of: &Action<M>) -> Option<Value> {
    match of {
        Action::Send { to, message: sent } => Some(json!({"to": to, "send": message(sent)})),
        Action::Backoff { ticket: of, attempt } => {
            Some(json!({"backoff": ticket(*of), "attempt": attempt}))
        }
        Action::Note(_) => None,
    }
}
