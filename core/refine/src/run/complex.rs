//! A run's boundary and bounds as values, and what one engine does before others refine without
//! rounds.

use super::Run;
use crate::RefineError;
use crate::mesh::bounds::Bounds;
use crate::mesh::item::{Item, Queues};
use crate::mesh::state::{Place, State};
use crate::queue::split::Refinement;
use crate::rules::aim::{Aim, Aims};
use crate::rules::complex::{Complex, ComplexError};
use crate::rules::verdict::Verdict;
use crate::table::{Map, Set};

impl<'a> Run<'a> {
    /// The boundary and the bounds as values.
    ///
    /// # Errors
    /// [`ComplexError`] if some of the boundary is missing.
    pub(super) fn complex(&self) -> Result<Complex<'a>, ComplexError> {
        let own = &self.refinement;
        Ok(Complex::of(&own.state, self.fit()?.clone(), own.floor, own.joint_most))
    }

    /// The bounds of a run that others can go on with.
    ///
    /// # Errors
    /// [`ComplexError`] if some of the boundary is missing.
    pub(super) fn fit(&self) -> Result<&Bounds<'a>, ComplexError> {
        let missing = "some of the boundary could not be recovered";
        self.refinement.bounds.as_ref().ok_or(ComplexError::Unsupported(missing))
    }
}

/// Times that the boundary items are looked through for circles.
const LOOKS: usize = 32;

impl Run<'_> {
    /// Splits boundary items that wait for each other in a circle, until there are none: the point
    /// of each would take the next one out of the mesh. What is left when nothing helps stays.
    pub(super) fn part_circles(&mut self) -> Result<(), RefineError> {
        for _ in 0..LOOKS {
            let before = self.refinement.state.mesh.num_vertices();
            for item in self.refinement.circles(&mut self.work) {
                self.refinement.split(item, &mut self.work);
                self.refine(0)?;
            }
            if self.refinement.state.mesh.num_vertices() == before {
                break;
            }
        }
        Ok(())
    }
}

impl Refinement<'_> {
    /// The boundary items that wait for themselves.
    fn circles(&mut self, work: &mut Queues) -> Vec<Item> {
        let segments = self.state.segments.keys().map(|&s| Item::Segment(s));
        let subfaces = self.state.subfaces.keys().map(|&s| Item::Subface(s));
        let all: Vec<Item> = segments.chain(subfaces).filter(|&i| !self.is_delicate(i)).collect();
        let mut first: Map<Item, Vec<Item>> = Map::default();
        for item in all {
            let waits = self.waits(item, work);
            if !waits.is_empty() {
                first.insert(item, waits);
            }
        }
        let is_in_circle = |item: &&Item| {
            let (mut seen, mut stack) = (Set::default(), vec![**item]);
            while let Some(next) = stack.pop() {
                for other in first.get(&next).into_iter().flatten() {
                    if other == *item {
                        return true;
                    }
                    if seen.insert(*other) {
                        stack.push(*other);
                    }
                }
            }
            false
        };
        first.keys().filter(is_in_circle).copied().collect()
    }

    /// Is an item of a patch, or at a small angle? Refinement without rounds leaves it.
    fn is_delicate(&self, item: Item) -> bool {
        let State { plc, angles, segments, subfaces, .. } = &self.state;
        let has = |corner: u32| self.state.has_corner(item, corner);
        match item {
            Item::Segment(s) => {
                let of = segments.get(&s);
                of.is_some_and(|&s| angles.reason_on_segment(s, &has).is_some())
            }
            Item::Subface(s) => subfaces
                .get(&s)
                .is_some_and(|&f| plc.is_patch(f) || angles.reason_on_facet(f, &has).is_some()),
            Item::Tet(..) => false,
        }
    }

    /// The boundary items that go before one, by the point proposed first.
    fn waits(&mut self, item: Item, work: &mut Queues) -> Vec<Item> {
        // Short items wait, too, until they are refused.
        let aim = self.aim_on(Aims { floor: 0.0, ..self.aims() }, item, 0);
        let from = self.state.mesh.hint();
        let Some(Aim::At { point: p, carrier, .. }) = aim else { return Vec::new() };
        let place = Place { p, carrier, from };
        let mut found = Vec::new();
        self.propose(&place, work, |judge| {
            if let Verdict::Defer(first) = judge.on_boundary(item, &place, true) {
                found = first;
            }
            Verdict::Useless
        });
        found
    }
}
