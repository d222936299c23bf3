//! The start of a run: the first mesh, the boundary brought into it, the regions.

use super::{NEAR, Refiner, Run};
use crate::RefineError;
use crate::complex::carrier::UNIT;
use crate::complex::patch::{DISSOLVED, Unfound};
use crate::complex::plc::Plc;
use crate::heed::Heed;
use crate::mesh::bounds::{Largest, check_limits, check_sweeps, check_tolerance};
use crate::mesh::item::Queues;
use crate::mesh::region::RegionInfo;
use crate::mesh::state::{Lengths, State};
use crate::outcome::RefineStats;
use crate::queue::split::{Ends, Refinement};
use crate::table::Set;
use ltbw_core::build::Phase;
use ltbw_core::mesh::Vertex;
use ltbw_domain::{Domain, Lattice};
use std::sync::Arc;
use std::time::Instant;

impl<'a> Refiner<'a> {
    /// The mesh with the boundary and the regions, and what there is to do in it. Where some of the
    /// boundary is missing there is nothing to do, and no region but the exterior.
    pub(crate) fn recovered(
        &self,
        domain: &Domain,
        lattice: &Lattice,
    ) -> Result<(Run<'a>, Vec<RegionInfo>), RefineError> {
        check_sweeps(self.smooth)?;
        let largest = Largest { volume: self.max_volume, edge: self.max_edge };
        check_limits(self.radius_edge, self.min_dihedral, largest, lattice)?;
        let tolerance = self.flat_tolerance.unwrap_or(0.0);
        check_tolerance(tolerance, domain)?;
        let clock = Instant::now();
        let (mut without, mut given_up) = (Set::default(), 0);
        let mut done = None;
        for _ in 0..if tolerance > 0.0 { DISSOLVED } else { 0 } {
            match self.recovered_within(domain, lattice, tolerance, &without)? {
                Ok(found) => done = Some(found),
                Err(Unfound { dissolve, .. }) if !dissolve.is_empty() => {
                    given_up += dissolve.len();
                    without.extend(dissolve);
                    continue;
                }
                Err(Unfound { patches, .. }) => given_up += patches,
            }
            break;
        }
        if done.is_none() {
            done = self.recovered_within(domain, lattice, 0.0, &without)?.ok();
        }
        // Without patches there is nothing that may not be found.
        let (mut run, regions) = done.ok_or(RefineError::NoInterior)?;
        run.stats.patches_given_up = given_up;
        run.stats.recover_seconds = clock.elapsed().as_secs_f64();
        Ok((run, regions))
    }

    /// The mesh within a tolerance, without the patches that grow from some facets; an error if
    /// there are none, if they cannot be brought into the mesh, or have one region on both sides.
    fn recovered_within(
        &self,
        domain: &Domain,
        lattice: &Lattice,
        tolerance: f64,
        without: &Set<u32>,
    ) -> Result<Result<(Run<'a>, Vec<RegionInfo>), Unfound>, RefineError> {
        let heed = Heed(self.cancel);
        let plc = Plc::within(domain, lattice, tolerance, without, heed)?;
        let patches = plc.facets.iter().filter(|facet| facet.patch.is_some()).count();
        let all = Unfound { patches, dissolve: Vec::new() };
        if tolerance > 0.0 && patches == 0 {
            return Ok(Err(all));
        }
        let most = self.max_points.unwrap_or_else(|| self.default_budget(domain));
        let floor = self.floor_in_steps(domain, lattice);
        let is_sized = self.max_volume.is_some() || self.max_edge.is_some() || self.field.is_some();
        let is_bounded = self.radius_edge.is_some() || is_sized;
        let mut cuts = plc.cuts(floor, if is_bounded { most } else { 0 }, heed)?;
        let mut mesh = plc.first_mesh(&mut cuts, lattice, heed)?;
        let expected = self.expected_tets(domain);
        mesh.expect_tets(expected);
        let patches_folded = plc.folds;
        let stats = RefineStats { patches, patches_folded, ..RefineStats::default() };
        let carriers = mesh.numbers().iter().map(|&own| plc.carrier_of(own, &cuts)).collect();
        let next_number = (plc.count() + cuts.len()) as Vertex;
        let near = NEAR * floor / UNIT as f64;
        let lengths = Lengths { near, fine_step: lattice.fine_step() };
        let mut state = State::new(mesh, plc, carriers, lengths, heed)?;
        state.expect_tets(expected);
        let ends = Ends { floor, joint_most: self.joint_most, sweeps: self.smooth };
        let mut run = Run {
            refiner: *self,
            refinement: Refinement::new(state, next_number, ends),
            work: Queues::default(),
            stats: RefineStats {
                min_dihedral: self.dihedral().map_or(0.0, |_| self.min_dihedral),
                flat_tolerance: tolerance,
                ..stats
            },
            steps: 0,
            most,
            stop: None,
            over: None,
            rounds: Vec::new(),
        };
        cuts.iter().for_each(|cut| run.refinement.inserted.points.count(cut.carrier()));
        run.recover()?;
        let found = match patches {
            0 => None,
            _ => match run.recover_patches()? {
                Ok(found) => Some(found),
                Err(unknown) => {
                    let patch =
                        |f: &u32| run.refinement.state.plc.facets[*f as usize].patch.as_ref();
                    let dissolve = unknown.iter().filter_map(patch).map(|p| p.first).collect();
                    return Ok(Err(Unfound { patches, dissolve }));
                }
            },
        };
        let mut regions = vec![RegionInfo::default()];
        if run.refinement.state.is_complete() {
            heed.ask()?;
            let state = &mut run.refinement.state;
            match state.flood(&domain.holes, &domain.regions, found.as_ref())? {
                Some(all) => regions = all,
                None => return Ok(Err(all)),
            }
            Arc::make_mut(&mut state.angles).bound_tips(self.radius_edge);
            run.refinement.bounds = Some(self.bounds(&regions, lattice));
            // From here on a refinement that is cancelled has a mesh to give.
            self.tell(Phase::Refine, run.refinement.state.mesh.num_vertices());
            run.put_all();
        }
        Ok(Ok((run, regions)))
    }
}
