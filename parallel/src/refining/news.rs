//! The news of workers about a domain: about the choice of a round, or, without rounds,
//! about boundary items that are split.

mod kinds;
mod lent;

pub(crate) use kinds::NEWS_KINDS;
pub use lent::{Ball, WireAsked, WireLent, WirePart, WireParted, WirePoint};

use crate::mesh::VertexName;
use crate::protocol::{Handle, Name, WorkerId};
use ltbw_core::topology::TetId;
use ltbw_exact::Point;
use ltbw_refine::{
    Block, BoundaryItem, Carrier, Corner, Group, ItemPlace, Limit, NOWHERE, Rank, Reason, Refusal,
    Rival, Watch,
};
use smallvec::SmallVec;

/// A point as bits: the protocol never sees a float.
pub(crate) type Bits = [u64; 3];

/// The bits of a point.
pub(crate) fn bits(p: &Point) -> Bits {
    p.map(f64::to_bits)
}

/// The point of these bits.
pub(crate) fn point(bits: &Bits) -> Point {
    bits.map(f64::from_bits)
}

/// A vertex in a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct WireCorner {
    #[cfg_attr(feature = "wire", serde(with = "crate::wire::bits"))]
    pub(crate) at: Bits,
    pub(crate) carrier: Carrier,
}

impl WireCorner {
    pub(crate) fn new(corner: &Corner) -> Self {
        Self { at: bits(&corner.point), carrier: corner.carrier }
    }

    pub(crate) fn corner(&self) -> Corner {
        Corner { point: point(&self.at), carrier: self.carrier }
    }
}

/// A boundary item in a message: its corners, and its segment or facet.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct WireItem {
    corners: Vec<WireCorner>,
    of: u32,
}

impl WireItem {
    pub(crate) fn new(item: &BoundaryItem) -> Self {
        Self { corners: item.corners().iter().map(WireCorner::new).collect(), of: item.of() }
    }

    pub(crate) fn item(&self) -> BoundaryItem {
        let corners: SmallVec<[Corner; 3]> = self.corners.iter().map(WireCorner::corner).collect();
        BoundaryItem::new(&corners, self.of)
    }
}

/// A limit of edges in a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct WireLimit {
    least: u64,
    along: Option<u64>,
}

impl WireLimit {
    pub(crate) fn new(limit: Limit) -> Self {
        Self { least: limit.least.to_bits(), along: limit.along.map(f64::to_bits) }
    }

    pub(crate) fn limit(self) -> Limit {
        Limit { least: f64::from_bits(self.least), along: self.along.map(f64::from_bits) }
    }
}

/// A refusal in a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct WireRefusal {
    reason: Reason,
    limit: Option<WireLimit>,
}

impl WireRefusal {
    pub(crate) fn new(refusal: Refusal) -> Self {
        Self { reason: refusal.reason, limit: refusal.limit.map(WireLimit::new) }
    }

    pub(crate) fn refusal(self) -> Refusal {
        Refusal { reason: self.reason, limit: self.limit.map(WireLimit::limit) }
    }
}

/// A boundary item that is refused, or is not any more, in a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct WireItemRefusal {
    pub(crate) place: ItemPlace,
    pub(crate) why: Option<WireRefusal>,
}

impl WireItemRefusal {
    pub(crate) fn new(place: ItemPlace, why: Option<Refusal>) -> Self {
        Self { place, why: why.map(WireRefusal::new) }
    }
}

/// A probe: its home, and its number there in this round.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct ProbeId {
    pub(crate) home: WorkerId,
    pub(crate) number: u32,
}

/// A probe with its point, which is a candidate of this rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Proposal {
    pub(crate) probe: ProbeId,
    #[cfg_attr(feature = "wire", serde(with = "crate::wire::bits"))]
    pub(crate) to: Bits,
    pub(crate) carrier: Carrier,
    pub(crate) rank: Rank,
}

/// Where an owner's part of a probe has ended.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum PartEnd {
    /// Everything asked for was looked at.
    Found,
    /// The way crosses this subface.
    Blocked(WireItem),
    /// The way leaves the hull.
    Outside,
    /// The point is a vertex.
    Vertex,
}

/// An owner's part of a closure: tetrahedra by their corners, and whether each is in
/// conflict.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct WireClosure {
    pub(crate) corners: Vec<WireCorner>,
    pub(crate) tets: Vec<([u32; 4], bool)>,
    /// Their regions, and their slots there, where the domain has patches.
    pub(crate) regions: Vec<u32>,
    pub(crate) slots: Vec<TetId>,
}

/// A tetrahedron by its owner and its slot there, as long as nothing is inserted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Owned {
    pub(crate) owner: WorkerId,
    pub(crate) tet: TetId,
}

/// A candidate of a round in turns, before anything is probed.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Entrant {
    pub(crate) rank: Rank,
    /// The tetrahedron that it splits, if it is none of the boundary, and the group of its
    /// circumsphere.
    pub(crate) tet: Option<TetId>,
    pub(crate) group: Option<Group>,
}

/// The verdict of a probe, as the conductor is told of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum Reported {
    /// No point does, or the rounds end.
    Nothing,
    /// Another item is to be split first.
    Asks,
    /// It cannot be split.
    Refused,
    /// The point may be inserted; if it changes a patch, it has to be alone.
    Fits {
        /// Has it to be alone?
        is_alone: bool,
    },
}

/// The findings of a probe in turns.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Report {
    /// Its number among the entrants of its home.
    pub(crate) number: u32,
    pub(crate) verdict: Reported,
    pub(crate) carrier: Carrier,
    /// Of a boundary item: the closures of points that did not do.
    pub(crate) passed: Vec<Owned>,
    /// The tetrahedra in conflict, and those around them.
    pub(crate) cavity: Vec<Owned>,
    pub(crate) ring: Vec<Owned>,
    /// The tetrahedra at which others make it wait.
    pub(crate) watch: Option<Watch<Owned>>,
}

impl Report {
    pub(crate) fn is_alone(&self) -> bool {
        matches!(self.verdict, Reported::Fits { is_alone: true })
    }

    /// Is it in nobody's way?
    pub(crate) fn is_refused(&self) -> bool {
        self.verdict == Reported::Refused
    }

    /// Its closure.
    pub(crate) fn closure(&self) -> impl Iterator<Item = Owned> + '_ {
        self.cavity.iter().chain(&self.ring).copied()
    }

    fn bytes(&self) -> u64 {
        let closures = [&self.passed, &self.cavity, &self.ring].map(Vec::len);
        let watch = self.watch.as_ref().map_or(0, Watch::size);
        16 + OWNED * (closures.iter().sum::<usize>() + watch) as u64
    }
}

/// The fate of an entrant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum Fate {
    /// Its point is inserted, or what it asks for is to be split.
    Stands,
    /// It was not probed, or is killed, or waits.
    Falls,
    /// Another one of its group was probed.
    Follows,
    /// A point of the boundary that was taken before bars it.
    Barred,
}

/// A rival in a message: bits 1, 2, 4 for there, of the boundary, apart.
pub(crate) fn rival_byte(rival: &Rival) -> u8 {
    u8::from(rival.is_there) | u8::from(rival.is_boundary) << 1 | u8::from(rival.is_apart) << 2
}

/// The rival of such a byte.
pub(crate) fn rival(byte: u8) -> Rival {
    Rival { is_there: byte & 1 != 0, is_boundary: byte & 2 != 0, is_apart: byte & 4 != 0 }
}

/// News of common faces, which the receiver knows by these tetrahedra and faces of his own.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum KeysTold {
    /// In the first exchange of a round: the ranks of the sender's tetrahedra over their bounds.
    /// None of one that was refused.
    Ranks(Vec<(Name, u8, Option<Rank>)>),
    /// In the second: comes a tetrahedron around the sender's before the receiver's?
    Behind(Vec<(Name, u8, bool)>),
}

/// Sums that all workers get of what each of them says: counts, or flags.
pub(crate) const SUMS: usize = 10;

/// One number for each of these sums.
pub type Sums = [i64; SUMS];

/// News of a domain.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum DomainNews {
    /// News of the faces that the sender has in common with the receiver.
    Keys {
        /// The exchange: two in a round.
        exchange: u64,
        /// Faces of which the receiver knows this already are left out.
        keys: KeysTold,
    },
    /// The sums of the sender and those below it in the tree.
    Up(Sums),
    /// All sums.
    Down(Sums),
    /// A probe walks straight from `start` to its point, and then searches.
    Way {
        /// The probe.
        own: Proposal,
        /// The tetrahedron and face that it comes in by.
        at: Handle,
        /// The place where it started.
        #[cfg_attr(feature = "wire", serde(with = "crate::wire::bits"))]
        start: Bits,
        /// May the point be inserted?
        may: bool,
        /// The region of the tetrahedron that it comes from.
        region: u32,
    },
    /// A probe looks for a tetrahedron in conflict with its point, and then searches.
    Seek {
        /// The probe.
        own: Proposal,
        /// The tetrahedron that the walk comes to; none if the sender has none at all.
        at: Option<Handle>,
    },
    /// A probe asks for the receiver's part of its closure, which it reserves.
    Search {
        /// The probe.
        own: Proposal,
        /// Tetrahedra to look at; those in conflict lead to others.
        seeds: Vec<Handle>,
    },
    /// The home of a probe asks for tetrahedra of the receiver: their regions tell which sides of
    /// its own one are subfaces of patches.
    Beyond {
        /// The probe.
        probe: ProbeId,
        /// The tetrahedra.
        at: Vec<Handle>,
    },
    /// The answer to one of these four, to the home.
    Part {
        /// The number of the probe.
        number: u32,
        /// The end.
        end: PartEnd,
        /// New parts of the closure.
        found: WireClosure,
        /// Other workers' tetrahedra beside those in conflict.
        foreign: Vec<Handle>,
    },
    /// Refusals have left these behind.
    Blocks(Vec<Block>),
    /// The probe reserves nothing after all.
    Void(ProbeId),
    /// The home of the probe wants to hear of its rivals.
    WantRivals(ProbeId),
    /// The sender's candidates of a round in turns, to the conductor.
    Entrants(Vec<Entrant>),
    /// The receiver is to probe for these, from the conductor.
    Launch(Vec<u32>),
    /// The findings of a probe, to the conductor.
    Report(Report),
    /// The fates of all the receiver's candidates, from the conductor.
    Fates(Vec<Fate>),
    /// The items that the sender keeps, all of which wait, to the conductor.
    Waiting(Vec<WireAsked>),
    /// The conductor is to be lent all tetrahedra at vertices in these.
    Lend(Vec<Ball>),
    /// These are lent, to the conductor.
    Lent(WirePart),
    /// The outcome of the circles, from the conductor; nothing if it could not split them.
    Parted(Option<Box<WireParted>>),
    /// The rivals in the sender's part of a closure, in the order in which it has told of it.
    Rivals {
        /// The number of the probe.
        number: u32,
        /// A byte for each tetrahedron; none if there is no rival.
        rivals: Vec<u8>,
    },
    /// A boundary item is to be split.
    Ask {
        /// The item.
        item: WireItem,
        /// The edges that this may lead to.
        limit: Option<WireLimit>,
        /// Another item that waits for it.
        waiter: Option<ItemPlace>,
    },
    /// A boundary item is gone.
    Gone(ItemPlace),
    /// The item that this one waits for is gone, or refused.
    Release(ItemPlace),
    /// Boundary items that the sender keeps were refused, or are not any more.
    Refused(Vec<WireItemRefusal>),
    /// Tetrahedra beside the blocks with these subfaces are gone, or will be.
    Unblocked(Vec<ItemPlace>),
    /// A boundary item of the sender's list is split, or cannot be: the items that wait for it are
    /// asked again. (Without rounds.)
    Ended([VertexName; 3]),
    /// Some news, one after the other.
    Several(
        #[cfg_attr(feature = "wire", serde(deserialize_with = "crate::wire::flat::deserialize"))]
        Vec<DomainNews>,
    ),
}

/// Bytes of some corners, most of which are free.
fn corners_bytes(all: &[WireCorner]) -> u64 {
    let bytes = |corner: &WireCorner| match corner.carrier {
        Carrier::Free => 25,
        Carrier::Corner(_) | Carrier::Facet(_) => 29,
        Carrier::Segment(..) => 33,
    };
    all.iter().map(bytes).sum()
}

fn item_bytes(item: &WireItem) -> u64 {
    5 + corners_bytes(&item.corners)
}

const HANDLE: u64 = 13;
const POINT: u64 = 24;
/// A key, which the place decides only where two are equal.
const RANK: u64 = 9;
const PROBE: u64 = 8;
/// A carrier takes up to 9 bytes.
const PROPOSAL: u64 = PROBE + POINT + RANK + 9;
const PLACE: u64 = 3 * POINT + 1;
const OWNED: u64 = 8;
/// A rank, a slot, and four numbers of a group.
const ENTRANT: u64 = RANK + 4 + 28;

impl DomainNews {
    /// Bytes beside the header, as a compact encoding would have them.
    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Self::Keys { keys: KeysTold::Ranks(all), .. } => 8 + all.len() as u64 * (9 + RANK),
            Self::Keys { keys: KeysTold::Behind(all), .. } => 8 + all.len() as u64 * 9,
            Self::Up(_) | Self::Down(_) => 4 * SUMS as u64,
            Self::Way { .. } => PROPOSAL + HANDLE + POINT + 1,
            Self::Seek { at, .. } => PROPOSAL + 1 + at.map_or(0, |_| HANDLE),
            Self::Search { seeds, .. } => PROPOSAL + 4 + HANDLE * seeds.len() as u64,
            Self::Beyond { at, .. } => PROBE + 4 + HANDLE * at.len() as u64,
            Self::Part { end, found, foreign, .. } => {
                let end = match end {
                    PartEnd::Blocked(item) => item_bytes(item),
                    _ => 0,
                };
                9 + end
                    + corners_bytes(&found.corners)
                    + 8 * found.tets.len() as u64
                    + 6 * found.regions.len() as u64
                    + HANDLE * foreign.len() as u64
            }
            Self::Void(_) | Self::WantRivals(_) => PROBE,
            Self::Entrants(all) => 4 + ENTRANT * all.len() as u64,
            Self::Launch(all) => 4 + 4 * all.len() as u64,
            Self::Report(report) => report.bytes(),
            Self::Fates(all) => 4 + all.len() as u64,
            Self::Waiting(all) => lent::asked_bytes(all),
            Self::Lend(all) => lent::balls_bytes(all),
            Self::Lent(part) => part.bytes(),
            Self::Parted(parted) => 1 + parted.as_ref().map_or(0, |own| own.bytes()),
            Self::Rivals { rivals, .. } => 8 + rivals.len() as u64 / 2,
            Self::Ask { item, waiter, .. } => item_bytes(item) + 18 + waiter.map_or(1, |_| PLACE),
            Self::Gone(_) | Self::Release(_) => PLACE,
            Self::Blocks(all) => 4 + (PLACE + 8 * POINT) * all.len() as u64,
            Self::Unblocked(all) => 4 + PLACE * all.len() as u64,
            Self::Refused(all) => 4 + (PLACE + 36) * all.len() as u64,
            Self::Ended(_) => 3 * 8,
            Self::Several(all) => all.iter().map(|news| 1 + news.bytes()).sum(),
        }
    }
}

/// The vertex at infinity in a closure.
pub(crate) const INFINITE_CORNER: u32 = NOWHERE;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rivals_come_as_they_are_sent() {
        for bits in 0..8_u8 {
            let [is_there, is_boundary, is_apart] = [0, 1, 2].map(|k| bits >> k & 1 == 1);
            let sent = Rival { is_there, is_boundary, is_apart };
            assert_eq!(rival(rival_byte(&sent)), sent);
        }
    }
}
