//! The script of the rounds, while they are carried out.

use super::Rounds;
use crate::refine::item::Item;
use crate::refine::script::Chosen;
use ltbw_core::topology::{INFINITE, VertexId};

impl Rounds<'_, '_> {
    /// Begins the script, if there is one.
    pub(super) fn begin_script(&mut self) {
        let Some(mut script) = self.own.script.take() else { return };
        let mesh = &self.own.state.mesh;
        script.mode = mesh.mode();
        script.start =
            (1..=mesh.num_vertices()).map(|v| mesh.kernel_point(VertexId::at(v))).collect();
        self.own.script = Some(script);
    }

    /// Writes the chosen points of this round.
    pub(super) fn script_round(&mut self, order: &[usize]) {
        let Some(mut script) = self.own.script.take() else { return };
        let state = &self.own.state;
        let chosen = order.iter().map(|&k| {
            let own = &self.candidates[k];
            let mut cavity = self.cavities[own.cavity.clone()].iter().map(|&t| state.vertices(t));
            let v = match own.item {
                Item::Tet(_, v) => Some(v),
                _ => cavity.find(|v| v[3] != INFINITE),
            };
            let near = v.map(|v| v.map(|v| state.at(v)));
            Chosen { point: own.place.p, near }
        });
        script.rounds.push(chosen.collect());
        self.own.script = Some(script);
    }

    /// Writes the vertices after the first `count`, which a joint step has made.
    pub(super) fn script_joint(&mut self, count: usize) {
        let Some(mut script) = self.own.script.take() else { return };
        let mesh = &self.own.state.mesh;
        let made = count + 1..=mesh.num_vertices();
        let chosen = made.map(|v| {
            let point = mesh.kernel_point(VertexId::at(v));
            Chosen { point, near: None }
        });
        script.rounds.push(chosen.collect());
        self.own.script = Some(script);
    }
}
