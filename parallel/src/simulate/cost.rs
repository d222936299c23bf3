//! The costs of work and messages for a simulated processor.

use crate::mesh::redeal::Moved;
use crate::protocol::Costs;

/// Times in nanoseconds of a processor of ordinary speed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CostModel {
    /// A tetrahedron passed by point location.
    pub walk_step: f64,
    /// A conflict test.
    pub test: f64,
    /// A tetrahedron created, its part of removing the old ones included.
    pub created: f64,
    /// A tetrahedron looked at for its bounds, its place among others included.
    pub look: f64,
    /// Any step, whatever it does.
    pub step: f64,
    /// A look for messages.
    pub poll: f64,
    /// A look of a processor that has nothing else to do, and looks again and again; 0: it sleeps
    /// until a message wakes it.
    pub idle_poll: f64,
    /// Sending a message, or a letter of several.
    pub send: f64,
    /// Receiving it.
    pub receive: f64,
    /// A byte of a message, at either end.
    pub byte: f64,
}

impl Default for CostModel {
    /// The kernel's figures are measured by the example `calibrate` of this crate on one machine;
    /// a message costs what a message between two computers over a fast network does.
    fn default() -> Self {
        Self {
            walk_step: 25.0,
            test: 12.0,
            created: 35.0,
            look: 220.0,
            step: 100.0,
            poll: 50.0,
            idle_poll: 0.0,
            send: 500.0,
            receive: 500.0,
            byte: 0.1,
        }
    }
}

impl CostModel {
    /// The paper's CoW, 32 Sun Ultra 5 of 333 MHz. Work is that of the default, slowed down until a
    /// cavity of uniform points takes 2.4 ms, as in Table V (235.45 s for the 98,217 cavities of
    /// Table IV). A poll in vain takes 33 µs and a message 146 µs, as in Table VI: 93.15 - 51.19 s
    /// for 1,259,085 polls, 51.19 s for 343,375 messages. A processor with nothing to do polls on
    /// (Algorithm 2). The paper does not tell what sending costs: as much.
    pub fn cow() -> Self {
        // One processor alone takes 1.754 µs a point (100,000 uniform points, polls left out).
        const SLOWER: f64 = 2.4e6 / 1754.0;
        let own = Self::default();
        Self {
            walk_step: SLOWER * own.walk_step,
            test: SLOWER * own.test,
            created: SLOWER * own.created,
            look: SLOWER * own.look,
            step: SLOWER * own.step,
            poll: 33_000.0,
            idle_poll: 33_000.0,
            send: 146_000.0,
            receive: 146_000.0,
            byte: 0.0,
        }
    }

    /// The time of point location.
    pub fn walk(&self, costs: Costs) -> f64 {
        costs.walk_steps as f64 * self.walk_step
    }

    /// The time of a step's work in the submesh.
    pub fn work(&self, costs: Costs) -> f64 {
        self.step
            + self.walk(costs)
            + costs.tests as f64 * self.test
            + costs.created as f64 * self.created
            + costs.looks as f64 * self.look
    }

    /// The time that a message of `bytes` bytes takes its sender: its bytes alone, if it goes along
    /// in the letter of another one.
    pub fn sending(&self, bytes: u64, goes_along: bool) -> f64 {
        bytes as f64 * self.byte + if goes_along { 0.0 } else { self.send }
    }

    /// The time that it takes its receiver.
    pub fn receiving(&self, bytes: u64, goes_along: bool) -> f64 {
        bytes as f64 * self.byte + if goes_along { 0.0 } else { self.receive }
    }

    /// The time of a redeal for one worker, beside what it is told by all.
    pub(super) fn redeal(&self, own: &Moved) -> f64 {
        let &Moved { had, left, came, messages, bytes, .. } = own;
        self.step
            + had as f64 * (self.test + self.walk_step)
            + (left + came) as f64 * self.created
            // As many are sent as taken, in all.
            + messages as f64 * (self.send + self.receive) / 2.0
            + bytes as f64 * self.byte
    }

    /// Are all figures finite and none negative?
    pub(super) fn is_sensible(&self) -> bool {
        [
            self.walk_step,
            self.test,
            self.created,
            self.look,
            self.step,
            self.poll,
            self.idle_poll,
            self.send,
            self.receive,
            self.byte,
        ]
        .iter()
        .all(|ns| (0.0..=1e12).contains(ns))
    }
}
