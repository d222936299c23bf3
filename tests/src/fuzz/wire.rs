//! Letters between workers: the first byte says of which kind, the others are the letter; or
//! letters, each with its length before it, that one of two members sends while both hash and check
//! a mesh of which each has a part, and put its points in order.
//!
//! A letter that can be read can be written, and read again, as it was; another one is refused by
//! the name of its sender. Neither takes more memory than a few times the letter's, as a nested or
//! an announced length would.

use ltbw::distributed::{self, Part, Slice, SliceError};
use ltbw::mesh::LocalMesh;
use ltbw::protocol::WorkerId;
use ltbw::refining::DomainMesh;
use ltbw::team::{Kind, Post, Team, TeamError};
use ltbw::transport::Mail;
use ltbw::wire::{Wire, open};
use ltbw::{Builder, Point, PointSet};
use ltbw_cli::ranks::Judge;
use ltbw_verify::{Options, check_parted};
use std::collections::VecDeque;
use std::time::Duration;

/// The first byte of a letter about points, and of one about a domain.
pub const POINTS: u8 = 0;
/// See [`POINTS`].
pub const DOMAIN: u8 = 1;
/// The first byte before letters about parts.
pub const PARTS: u8 = 2;

/// The fuzz target.
pub fn wire(bytes: &[u8]) {
    let Some((kind, letter)) = bytes.split_first() else { return };
    match kind % 3 {
        POINTS => read::<Mail<LocalMesh>>(letter),
        DOMAIN => read::<Mail<DomainMesh<'static>>>(letter),
        _ => together(&mut Team::new(Told(letter.to_vec().into()))),
    }
}

/// Hashes, gathers and checks a small mesh as a member of two, and puts its points in order,
/// whatever the other one sends; ends with the first thing that makes no sense.
pub fn together(team: &mut Team) {
    let points: Vec<Point> =
        (0..12).map(|k| [k * 7 % 5, k * 3 % 4, k % 3].map(f64::from)).collect();
    let set = PointSet::new(points).expect("finite points");
    let mesh = Builder::new().build(&set).expect("a mesh").mesh;
    let me = team.me().index();
    let own = mesh.tets().enumerate().filter(|(k, _)| k % 2 == me).map(|(_, tet)| tet);
    let part = Part {
        numbers: (0..12).collect(),
        points: set.points().to_vec(),
        tets: own.collect(),
        hull: Vec::new(),
    };
    let given = &set.points()[6 * me..6 * me + 6];
    let Part { numbers, points, tets, .. } = &part;
    let judged = ltbw_verify::Part { points, numbers, tets, given };
    let mut run = || -> Result<(), TeamError> {
        check_parted(&mut Judge(team), &judged, &Options::default())?;
        distributed::hash(team, &part)?;
        distributed::gather(team, &part, set.len())?;
        let slice = match Slice::new(team, given.to_vec()) {
            Ok(slice) => slice,
            Err(SliceError::Team(error)) => return Err(error),
            // The other one has told of points that are none.
            Err(_) => return Ok(()),
        };
        let ordered = distributed::order(team, &slice)?;
        let placed = ordered.independent(team)?;
        assert!(placed.len() <= 4);
        let vertices = ordered.vertices();
        let all = ordered.of_all(team, (0..vertices).step_by(2))?;
        assert!(all.iter().all(|&(k, p)| k < vertices && p.iter().all(|c| c.is_finite())));
        let tags: Vec<i64> = (0..slice.points().len() as i64).collect();
        distributed::tags(team, &slice, Some(&tags), &[0, 5, 7])?;
        distributed::thickness(team, &slice)?;
        distributed::gather_points(team, &slice, Some(&tags)).map(drop)
    };
    if let Err(error) = run() {
        assert!(error.to_string().contains("worker"), "{error}");
    }
}

/// The post of the first of two members, to whom the other has sent all of its letters already:
/// each with two bytes of length before it. Then it has failed.
struct Told(VecDeque<u8>);

impl Post for Told {
    fn me(&self) -> WorkerId {
        WorkerId::default()
    }

    fn members(&self) -> u32 {
        2
    }

    fn send(&mut self, _: WorkerId, _: Kind, _: Vec<u8>) {}

    fn flush(&mut self) {}

    fn take(&mut self) -> Option<(WorkerId, Kind, Vec<u8>)> {
        if self.0.len() < 2 {
            return None;
        }
        let length: Vec<u8> = self.0.drain(..2).collect();
        let length = usize::from(length[0]) | usize::from(length[1]) << 8;
        let letter = self.0.drain(..length.min(self.0.len())).collect();
        Some((WorkerId::new(1), Kind::Team, letter))
    }

    fn wait(&mut self, _: Option<Duration>) {}

    fn failed(&self) -> Option<WorkerId> {
        (self.0.len() < 2).then_some(WorkerId::new(1))
    }

    fn fail(&mut self) {}
}

fn read<M: Wire>(letter: &[u8]) {
    let from = WorkerId::new(7);
    let mut once = Vec::new();
    let put =
        |mail: &M, to: &mut Vec<u8>| mail.put(from, to).expect("what was read can be written");
    if let Err(error) = open(from, letter, |mail| put(&mail, &mut once)) {
        assert_eq!(error.from, from);
        assert!(error.at <= letter.len() && error.length == letter.len(), "{error}");
        assert!(!error.to_string().is_empty());
    }
    let mut twice = Vec::new();
    open(from, &once, |mail| put(&mail, &mut twice)).expect("what was written can be read");
    assert!(once == twice, "{once:?} is not {twice:?}");
}
