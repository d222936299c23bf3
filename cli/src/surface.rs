//! From a domain's file to a domain that can be meshed: the options that say how, what is told of
//! repairs, and the surface of what is wrong (`--write-defects`).

use crate::binding::{Role, read_beside};
use crate::console;
use crate::json::keep_input;
use crate::numbers::whole;
use crate::outcome::{Failure, show};
use crate::streams::Source;
use ltbw::domain::{
    Domain, DomainReport, Facet, Frame, Holes, LONGEST_LOOP, PrepareError, PrepareOptions,
    Prepared, TroubleKind,
};
use ltbw::io::{self, DomainFile, WriteOptions};
use ltbw::refine::{Given, RefineStats, largest_tolerance};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Options of `mesh` and `check` that say how a domain is prepared.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct Preparation {
    /// Reject a domain that is not exactly on its lattice
    #[arg(long)]
    #[arg(hide_short_help = true)]
    pub(crate) exact_input: bool,
    /// Points that are vertices, too: .npy .xyz .csv .node ...
    ///
    /// Within three lattice steps of the boundary they are put on it; outside: left out.
    #[arg(long, value_name = "FILE")]
    #[arg(hide_short_help = true)]
    pub(crate) points: Option<PathBuf>,
    /// Weld vertices within this distance; close seams as wide
    ///
    /// Seams are rows of T-junctions. Open edges get the ends of other open edges near them. Bodies
    /// are not united. At most 2^-10 of the domain's diagonal.
    #[arg(long, value_name = "TOL", allow_negative_numbers = true)]
    pub(crate) repair: Option<f64>,
    /// Close holes of up to N edges by triangles, which is told
    #[arg(long, value_name = "N", value_parser = whole::<u32>(3..=u64::from(LONGEST_LOOP)))]
    #[arg(hide_short_help = true)]
    pub(crate) fill: Option<u32>,
    /// Take neighbouring facets that are so nearly coplanar for one
    ///
    /// The edges inside need not be in the mesh; vertices and outline are. At most 2^-10 of the
    /// domain's diagonal; 0: facets are what they are. Default: 0 for .poly, .smesh, --exact-input;
    /// for surfaces 2^-22 of the diagonal, or what their numbers tell if that is more: two
    /// single-precision steps of the largest coordinate, or two units of the last decimal.
    #[arg(long, value_name = "TOL", allow_negative_numbers = true)]
    pub(crate) flat_tolerance: Option<f64>,
    /// Collapse triangles within this distance, before meshing
    ///
    /// Vertices that are left are the file's. Nothing crosses; topology, markers, sharp edges stay;
    /// how far the surfaces are apart is stated. At most 5 % of the domain's diagonal.
    #[arg(long, value_name = "TOL", allow_negative_numbers = true)]
    pub(crate) simplify: Option<f64>,
    /// Measure from the middle of the domain: keeps more bits far off
    ///
    /// The offset is reported. The default where the distance takes two bits or more.
    #[arg(long)]
    #[arg(hide_short_help = true)]
    pub(crate) local_frame: bool,
    /// Keep the coordinates of the file, whatever bits they cost
    #[arg(long, conflicts_with = "local_frame")]
    #[arg(hide_short_help = true)]
    pub(crate) own_frame: bool,
    /// Voids: `none`, `auto` (bodies inside others), or points in them
    ///
    /// Without it the file says it: by its hole points; or in a surface by its orientation, so that
    /// a body inside another is a void if its facets point the other way, and else a region of its
    /// own. Points are added to those of the file, and orientation means nothing then.
    #[arg(long, value_name = "none|auto|X,Y,Z;...", allow_hyphen_values = true)]
    #[arg(hide_short_help = true)]
    pub(crate) holes: Option<Holes>,
    /// Refuse input to be repaired, left out, guessed; excuse nothing
    #[arg(long)]
    pub(crate) strict: bool,
    /// Write defective facets: .ply .poly (with kinds) .off .obj .stl
    #[arg(long, value_name = "FILE")]
    #[arg(hide_short_help = true)]
    pub(crate) write_defects: Option<PathBuf>,
}

impl Preparation {
    /// Refuses what makes no sense, before anything is read.
    pub(crate) fn check(&self, inputs: &[&Path]) -> Result<(), Failure> {
        let repair = self.repair.unwrap_or(0.0);
        if repair.is_nan() || repair < 0.0 || repair.is_infinite() {
            return Err(Failure::Usage(format!("--repair {repair}: a tolerance is a length")));
        }
        if self.exact_input && repair > 0.0 {
            let text = "--exact-input and --repair: what is repaired is not the exact input";
            return Err(Failure::Usage(text.to_owned()));
        }
        if self.exact_input && self.fill.is_some() {
            let text = "--exact-input and --fill: what is filled is not the exact input";
            return Err(Failure::Usage(text.to_owned()));
        }
        let simplify = self.simplify.unwrap_or(0.0);
        if !(0.0..f64::INFINITY).contains(&simplify) {
            return Err(Failure::Usage(format!("--simplify {simplify}: a tolerance is a length")));
        }
        let flat = self.flat_tolerance.unwrap_or(0.0);
        if !(0.0..f64::INFINITY).contains(&flat) {
            return Err(Failure::Usage(format!(
                "--flat-tolerance {flat}: a tolerance is a length"
            )));
        }
        if self.exact_input && flat > 0.0 {
            let text = "--exact-input and --flat-tolerance: what is flat within a tolerance is not \
                        exact";
            return Err(Failure::Usage(text.to_owned()));
        }
        if let Some(path) = &self.write_defects {
            io::check_domain_writable(path).map_err(Failure::Write)?;
            inputs.iter().try_for_each(|input| keep_input(input, path))?;
        }
        Ok(())
    }

    /// The options for the library; the domain gets the holes that are asked for.
    pub(crate) fn options(&self, file: &mut DomainFile) -> PrepareOptions {
        let mut options = PrepareOptions {
            exact_input: self.exact_input,
            repair: self.repair.unwrap_or(0.0),
            frame: match (self.local_frame, self.own_frame) {
                (true, _) => Frame::Local,
                (_, true) => Frame::Own,
                _ => Frame::Auto,
            },
            oriented: file.oriented,
            nested_voids: false,
            strict: self.strict,
            simplify: self.simplify.unwrap_or(0.0),
            fill: self.fill.unwrap_or(0),
        };
        self.holes.iter().for_each(|holes| holes.apply(&mut file.domain, &mut options));
        options
    }

    /// Reads a domain, and the points that are to be vertices, too.
    pub(crate) fn read(&self, source: &Source) -> Result<DomainFile, Failure> {
        let mut file = source.domain()?;
        file.notes.iter().for_each(|n| console::people(&format!("note: {}: {n}", source.show())));
        if let Some(path) = &self.points {
            let read = |path: &Path, load: &mut io::Load<'_>| io::read_points_by(path, load);
            let more = read_beside(source.reads(), Role::Points, path, read)?;
            more.notes.iter().for_each(|n| console::people(&format!("note: {}: {n}", show(path))));
            file.domain.points.extend(more.points);
        }
        Ok(file)
    }

    /// Reads and prepares a domain; tells what was repaired. With the tolerance within which
    /// facets are taken for coplanar.
    pub(crate) fn prepare(&self, source: &Source) -> Result<(Prepared, f64), Failure> {
        self.prepare_file(self.read(source)?, source)
    }

    /// Prepares a domain that was read.
    pub(crate) fn prepare_file(
        &self,
        mut file: DomainFile,
        source: &Source,
    ) -> Result<(Prepared, f64), Failure> {
        let options = self.options(&mut file);
        let result = file.domain.prepare(&options);
        let report = result.as_ref().err().and_then(PrepareError::report);
        print_troubles(report);
        self.told(&file.domain, report)?;
        if let (Some(tolerance), Some(_)) =
            (self.repair, result.as_ref().err().and_then(PrepareError::report))
        {
            console::people(&format!("note: --repair {tolerance:e} leaves defects"));
        }
        if let Some(report) = report {
            closable(&file.domain, report, &options).iter().for_each(|n| console::people(n));
        }
        let failed = |error| Failure::Domain { path: source.name.clone(), error };
        let ready = result.map_err(failed)?;
        self.note_repairs(&ready);
        let told = ready.simplified.as_ref().map(|told| format!("simple    {}", told.note()));
        told.iter().for_each(|line| console::people(line));
        let usual = file.flat_tolerance(&ready, &options);
        let flat = self.flat(&ready, usual)?;
        Ok((ready, flat))
    }

    /// The tolerance within which facets are taken for coplanar.
    pub(crate) fn flat(&self, ready: &Prepared, usual: f64) -> Result<f64, Failure> {
        let flat = self.flat_tolerance.unwrap_or(usual);
        let limit = largest_tolerance(&ready.domain);
        if flat > limit {
            return Err(Failure::Usage(format!(
                "--flat-tolerance {flat:e}: at most {limit:e}, 2^-10 of the domain's diagonal"
            )));
        }
        Ok(flat)
    }

    fn note_repairs(&self, ready: &Prepared) {
        ready.notes().iter().for_each(|n| console::people(&format!("note: {n}")));
        given(ready).iter().for_each(|line| console::people(line));
        if let Some(tolerance) = self.repair.filter(|_| !ready.repairs.used_tolerance()) {
            console::people(&format!("note: --repair {tolerance:e} changed nothing"));
        }
    }

    /// Writes what is wrong where that is asked for; `report`: in the numbers of the input.
    pub(crate) fn told(
        &self,
        domain: &Domain,
        report: Option<&DomainReport>,
    ) -> Result<(), Failure> {
        let Some(path) = &self.write_defects else { return Ok(()) };
        let surface = report.map(|report| defective(domain, report)).unwrap_or_default();
        if surface.facets.is_empty() {
            console::people(&format!("note: no defects of facets: {} was not written", show(path)));
            return Ok(());
        }
        let options = WriteOptions::default();
        console::writing(|token| io::write_domain_until(path, &surface, options, token))?;
        let count = surface.facets.len();
        console::people(&format!("wrote     {}: {count} facets with defects", show(path)));
        Ok(())
    }
}

/// The points that are vertices, too, in a line.
pub(crate) fn given(ready: &Prepared) -> Option<String> {
    ready.given().map(|text| format!("given     {text}"))
}

/// The points that are vertices, too, for the report.
pub(crate) fn given_json(ready: &Prepared) -> Value {
    let placed = &ready.placed;
    json!({
        "vertices": ready.domain.points.len(),
        "on_edges": placed.on_edges,
        "on_facets": placed.on_facets,
        "doubled": placed.doubled,
        "farthest_move": placed.farthest,
    })
}

/// Tells what the defects of a domain mean, a line for each kind.
pub(crate) fn print_troubles(report: Option<&DomainReport>) {
    for trouble in report.iter().flat_map(|report| &report.troubles) {
        console::people(&format!("kind      {trouble}"));
    }
}

/// The facets of a domain that its troubles are about, with the number of the kind (its place in
/// [`TroubleKind::ALL`], from 1) as their marker; the gravest comes last and wins.
/// Facets that are no polygon with an area cannot be written as faces, and are left out.
fn defective(domain: &Domain, report: &DomainReport) -> Domain {
    let mut markers = std::collections::BTreeMap::new();
    for trouble in &report.troubles {
        let number =
            1 + TroubleKind::ALL.iter().position(|k| *k == trouble.kind).unwrap_or_default() as i32;
        markers.extend(trouble.facets.iter().map(|&f| (f, number)));
    }
    let mut place = vec![None; domain.vertices.len()];
    let mut surface = Domain::default();
    for (f, marker) in markers {
        let sound = domain.triangulate(f).filter(|found| found.is_sound());
        for triangle in sound.map(|found| found.triangles).unwrap_or_default() {
            let corners = triangle.map(|v| {
                *place[v as usize].get_or_insert_with(|| {
                    surface.vertices.push(domain.vertices[v as usize]);
                    surface.vertices.len() as u32 - 1
                })
            });
            surface.facets.push(Facet::polygon(&corners, marker));
        }
    }
    surface
}

/// The kinds of trouble for the JSON reports.
pub(crate) fn troubles_json(report: &DomainReport) -> Vec<Value> {
    let json = |t: &ltbw::domain::Trouble| {
        json!({
            "kind": t.kind.code(),
            "places": t.places,
            "bodies": t.bodies,
            "first": t.first.as_ref().map(|d| json!({ "defect": d.to_string(), "at": d.at })),
        })
    };
    report.troubles.iter().map(json).collect()
}

/// Tells what became of the tolerance within which facets are taken for coplanar.
pub(crate) fn print_patches(asked: f64, stats: &RefineStats) {
    let (count, tolerance) = (stats.patches, stats.flat_tolerance);
    if count > 0 {
        console::people(&format!("patches   {count} of facets coplanar within {tolerance:e}"));
    }
    if stats.patches_folded > 0 {
        let folded = stats.patches_folded;
        console::people(&format!(
            "note: {folded} patches end where they would fold over themselves"
        ));
    }
    if stats.patches_given_up > 0 {
        let given_up = stats.patches_given_up;
        console::people(&format!(
            "note: {given_up} patches of facets coplanar within {asked:e} could not be brought \
             into the mesh: their facets are taken as they are"
        ));
    }
}

/// The effect of `--simplify`, for the JSON report.
pub(crate) fn simplified_json(ready: &Prepared) -> Value {
    let Some(told) = &ready.simplified else { return Value::Null };
    let [before, after] = told.triangles;
    json!({
        "tolerance": told.tolerance,
        "removed": told.removed,
        "triangles_before": before,
        "triangles": after,
        "from_before": told.from_before,
        "from_after": told.from_after,
    })
}

/// The repairs, for the JSON reports.
pub(crate) fn repairs_json(ready: &Prepared) -> Value {
    let r = &ready.repairs;
    json!({
        "welded": r.welded,
        "welded_by_tolerance": r.welded_by_tolerance,
        "farthest_weld": r.farthest_weld,
        "degenerate_facets": r.degenerate.len(),
        "doubled_facets": r.doubled.len(),
        "inner_facets": r.inner.len(),
        "spliced_vertices": r.spliced,
        "seam_vertices": r.seams,
        "filled_holes": r.filled.len(),
        "filling_facets": r.filling,
        "flap_facets": r.flaps.len(),
        "ending_facets": r.ends.len(),
        "exterior_facets": r.exterior.len(),
        "exterior_segments": r.exterior_segments,
        "exterior_vertices": r.exterior_vertices,
        "exterior_points": r.exterior_points,
        "exterior_holes": r.exterior_holes,
    })
}

/// The line that says which `--fill` would make an open surface sound, found by trying.
fn closable(domain: &Domain, report: &DomainReport, options: &PrepareOptions) -> Option<String> {
    let is_open = report.troubles.iter().any(|trouble| trouble.kind == TroubleKind::Open);
    if !is_open || options.fill > 0 || options.exact_input {
        return None;
    }
    let filled = PrepareOptions { fill: LONGEST_LOOP, strict: false, ..*options };
    let repairs = domain.prepare(&filled).ok()?.repairs;
    let most = repairs.filled.iter().max()?;
    let holes = match repairs.filled.len() {
        1 => "the hole".to_owned(),
        n => format!("its {n} holes"),
    };
    Some(format!("note: --fill {most} closes {holes}"))
}
