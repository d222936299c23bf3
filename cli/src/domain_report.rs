//! A refined domain as people and reports hear of it, wherever its parts are.

use crate::console;
use crate::domain_job::Job;
use crate::excused::{self, SliversLeft};
use crate::picture::angles::Slivers;
use crate::report::{Input, Measured, MeshPart, Predicates, Report, quality_line};
use crate::rounds;
use crate::surface::{given_json, repairs_json, simplified_json};
use ltbw::PredicateStats;
use ltbw::domain::Prepared;
use ltbw::domain::exterior::LEFT_OUT;
use ltbw::quality::Quality;
use ltbw::refine::{ExcusedShare, RefineOutcome, RefineStats, Refined, RegionInfo};
use serde_json::{Value, json};

/// Excuses that the report lists.
const LISTED: usize = 100;

/// The things that are told of a refined domain.
pub(crate) struct Told<'a> {
    pub(crate) outcome: RefineOutcome,
    /// Vertices, exterior included; tetrahedra inside; facets of the hull.
    pub(crate) mesh: [usize; 3],
    pub(crate) predicates: PredicateStats,
    pub(crate) stats: &'a RefineStats,
    pub(crate) regions: &'a [RegionInfo],
    pub(crate) slivers: &'a SliversLeft,
    /// The mesh that tells of excuses, if one has it.
    pub(crate) refined: Option<&'a Refined>,
    /// Refined without rounds, so that the mesh depends on the timing.
    pub(crate) is_timed: bool,
}

impl<'a> Told<'a> {
    /// The things that are told of a mesh that one has.
    pub(crate) fn of(refined: &'a Refined, slivers: &'a SliversLeft, is_timed: bool) -> Self {
        let mesh = refined.mesh();
        Self {
            outcome: refined.outcome,
            mesh: [mesh.num_vertices(), refined.num_tets(), mesh.num_hull_faces()],
            predicates: mesh.predicate_stats(),
            stats: &refined.stats,
            regions: &refined.regions,
            slivers,
            refined: Some(refined),
            is_timed,
        }
    }

    /// Tells people.
    pub(crate) fn print(&self, measured: Option<&Measured>) {
        let Self { mesh: [vertices, tets, _], stats, regions, .. } = self;
        console::people(&format!(
            "mesh      {vertices} vertices, {tets} tetrahedra inside, {} regions",
            regions.len().saturating_sub(1)
        ));
        console::people(&format!(
            "points    {} on segments, {} on facets, {} inside",
            stats.segment_points, stats.facet_points, stats.free_points
        ));
        if stats.moved > 0 {
            console::people(&format!("smoothed  {} moves of vertices inside", stats.moved));
        }
        rounds::line(stats).iter().for_each(|line| console::people(line));
        let Some(Measured { quality, slivers }) = measured else { return };
        console::people(&quality_line(quality));
        if slivers.before.is_some() {
            let text = slivers.text(&quality.least_angles);
            text.iter().for_each(|text| console::people(&format!("slivers   {text}")));
        }
    }

    /// The quality of the mesh, with what was counted before slivers were split.
    pub(crate) fn measured(&self, quality: Option<Quality>) -> Option<Measured> {
        let &RefineStats { min_dihedral: below, before_slivers: before, .. } = self.stats;
        quality.map(|quality| Measured { quality, slivers: Slivers { below, before } })
    }

    /// The report, without what comes after the mesh.
    pub(crate) fn report(&self, job: &Job<'_>, ready: &Prepared) -> Report {
        let points = ready.vertex_map.len();
        let distinct = ready.domain.vertices.len();
        let left_out = ready.vertex_map.iter().filter(|&&v| v == LEFT_OUT).count();
        let duplicates = points - distinct - left_out;
        let outcome = match self.outcome {
            RefineOutcome::Met => "met",
            RefineOutcome::Excused => "excused",
            RefineOutcome::Unrecovered => "unrecovered",
            RefineOutcome::Budget => "budget",
            RefineOutcome::Cancelled => "cancelled",
        };
        let input = Input { points, distinct, duplicates, duplicate_of: Vec::new() };
        let mut report = job.task.report(input, outcome);
        let [vertices, tets, hull_faces] = self.mesh;
        report.mesh = MeshPart { vertices, tets, hull_faces, hash: None };
        report.predicates = Predicates::from(&self.predicates);
        report.refinement = Some(self.refinement(job, ready));
        report
    }

    fn refinement(&self, job: &Job<'_>, ready: &Prepared) -> Value {
        let stats = self.stats;
        let excuse = |refined: &Refined, e: &ltbw::refine::Excuse| {
            json!({
                "vertices": refined.tet(e.tet),
                "reason": e.reason.to_string(),
                "reason_at": e.reason.at(),
            })
        };
        let listed = |refined: &Refined| -> Vec<Value> {
            refined.excuses.iter().take(LISTED).map(|own| excuse(refined, own)).collect()
        };
        let (excused, share) = match self.refined {
            Some(refined) => (refined.excused(), refined.excused_share()),
            None => (Vec::new(), ExcusedShare::default()),
        };
        let region = |r: &RegionInfo| {
            json!({
                "seed": r.seed,
                "attribute": r.attribute,
                "max_volume": r.max_volume,
            })
        };
        json!({
            "segment_points": stats.segment_points,
            "facet_points": stats.facet_points,
            "free_points": stats.free_points,
            "slivers": self.slivers.json(),
            "moved": stats.moved,
            "reproducible": self.outcome != RefineOutcome::Cancelled && !self.is_timed,
            "rounds": rounds::json(stats),
            "excused": self.refined.map_or(0, |refined| refined.excuses.len()),
            "excused_at": excused::json(&excused, share),
            "excuses": self.refined.map(listed).unwrap_or_default(),
            "boundary_lost": self.refined.map_or(0, |refined| refined.lost.len()),
            "regions": self.regions.iter().skip(1).map(region).collect::<Vec<_>>(),
            "lattice": {
                "step": ready.lattice.step(),
                "fine_step": ready.lattice.fine_step(),
                "offset": ready.lattice.offset(),
                "lost_bits": ready.lattice.lost_bits(),
                "moved": ready.moved,
                "largest_move": ready.largest.map(|m| m.distance),
                "largest_move_of_diagonal":
                    ready.largest.map(|m| m.distance / ready.domain.diagonal()),
            },
            "repairs": repairs_json(ready),
            "simplified": simplified_json(ready),
            "given_points": given_json(ready),
            "parts": job.boundary.json(),
            "flat_tolerance": stats.flat_tolerance,
            "patches_folded": stats.patches_folded,
            "patches_given_up": stats.patches_given_up,
            "patches": stats.patches,
            "recover_seconds": stats.recover_seconds,
            "refine_seconds": stats.refine_seconds,
        })
    }
}
