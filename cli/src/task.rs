//! The pipeline of `delaunay`, `mesh` and `demo`, whatever makes the mesh: what may be written is
//! found out before the work; then come the report, the files, the page and the end.

use crate::args::Depth;
use crate::binding::Binding;
use crate::console::{self, Stop};
use crate::json::{distinct, file_writable, keep_input, without_pairs, write_text};
use crate::outcome::{Exit, Failure, show};
use crate::page::{Page, Scene};
use crate::progress::Stage;
use crate::report::{
    Input, Measured, MeshPart, Predicates, Report, Seconds, Spent, Written, end, peak_rss_bytes,
};
use crate::streams::{Formats, Streams, attributes_note, name_of, on_stdout};
use ltbw::TetMesh;
use ltbw::io::{self, GroupName, MeshWriter, Piece};
use ltbw::quality::Array;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The files that a command names.
pub(crate) struct Files<'a> {
    /// The input whose format `--format` may tell.
    pub(crate) input: &'a PathBuf,
    /// All inputs.
    pub(crate) inputs: Vec<PathBuf>,
    /// Mesh files to write.
    pub(crate) outputs: &'a [PathBuf],
    pub(crate) streams: &'a Streams,
    /// Other files to write.
    pub(crate) others: Vec<PathBuf>,
    /// Parts of a mesh that is written in parts.
    pub(crate) parts: usize,
}

/// The mesh files of a command.
#[derive(Default)]
pub(crate) struct Outputs {
    /// Files of a mesh in parts, and of a whole one.
    pub(crate) in_parts: Vec<PathBuf>,
    pub(crate) whole: Vec<PathBuf>,
    /// The formats that names do not tell.
    pub(crate) formats: Formats,
    /// One of the files goes to stdout, and so nothing else does.
    pub(crate) are_on_stdout: bool,
}

impl Outputs {
    /// Is any mesh to be written?
    pub(crate) fn has_meshes(&self) -> bool {
        !(self.whole.is_empty() && self.in_parts.is_empty())
    }
}

impl Files<'_> {
    /// Finds out, before the work, what cannot be written: none may be an input, or written twice.
    pub(crate) fn look(&self) -> Result<Outputs, Failure> {
        let (in_parts, whole): (Vec<PathBuf>, Vec<PathBuf>) =
            without_pairs(self.outputs).into_iter().partition(|path| io::is_parts(path));
        let formats = self.streams.resolve(&[self.input], &whole)?;
        formats.meshes_writable(&whole)?;
        for path in &in_parts {
            io::check_parts_writable(path, self.parts).map_err(Failure::Write)?;
        }
        self.others.iter().try_for_each(|path| file_writable(path))?;
        let all = whole.iter().flat_map(io::mesh_files);
        let all = all.chain(in_parts.iter().flat_map(|path| io::part_files(path, self.parts)));
        let all: Vec<PathBuf> = all.chain(self.others.iter().cloned()).collect();
        distinct(&all)?;
        for input in &self.inputs {
            all.iter().try_for_each(|path| keep_input(input, path))?;
        }
        Ok(Outputs { in_parts, whole, formats, are_on_stdout: on_stdout(&all) })
    }
}

/// The part of a task that does not depend on what makes the mesh.
pub(crate) struct Task<'a> {
    /// `delaunay`, `mesh` or `demo`.
    pub(crate) command: &'static str,
    /// The name of the input in messages.
    pub(crate) name: &'a Path,
    /// Mesh files to write.
    pub(crate) outputs: &'a Outputs,
    /// The files of the report and of the page.
    pub(crate) json: Option<&'a Path>,
    pub(crate) page: Option<&'a Path>,
    /// The depth of the check.
    pub(crate) check: Depth,
    /// Input and options, to which the certificate is bound.
    pub(crate) binding: Binding,
    /// Ends the work early.
    pub(crate) stop: &'a Stop,
    /// The start of the program.
    pub(crate) start: Instant,
}

impl Task<'_> {
    /// A report without what comes after the mesh.
    pub(crate) fn report(&self, input: Input, outcome: &'static str) -> Report {
        Report {
            schema: Report::SCHEMA,
            command: self.command,
            input,
            mesh: MeshPart::default(),
            predicates: Predicates::default(),
            seconds: Seconds::default(),
            threads: rayon::current_num_threads(),
            peak_rss_bytes: None,
            outcome,
            refinement: None,
            quality: None,
            certificate: None,
            outputs: Vec::new(),
            workers: Vec::new(),
            share: None,
            ranks: None,
            redeals: None,
            parallel: None,
        }
    }

    /// Tells how long it took, writes the report and prints the hash.
    pub(crate) fn finish(&self, report: &mut Report) -> Result<(), Failure> {
        report.peak_rss_bytes = peak_rss_bytes();
        report.seconds.total = self.start.elapsed().as_secs_f64();
        let s = &report.seconds;
        let made = match report.refinement {
            Some(_) => vec![("refine", s.refine)],
            None => vec![("order", s.order), ("insert", s.insert)],
        };
        let after = [("hash", s.hash), ("check", s.check), ("write", s.write)];
        let stages = [("read", s.read)].into_iter().chain(made).chain(after);
        let stages: Vec<Spent> = stages.map(|(stage, time)| Spent { stage, time }).collect();
        let hash = report.mesh.hash.as_ref().filter(|_| !self.outputs.are_on_stdout);
        let written = self.json.map(|path| Written { path, text: report.to_json() });
        end(s.total, &stages, written, hash)
    }

    /// Ends the task with a defect in the mesh: it is not written, the report is.
    pub(crate) fn refuse(&self, report: &mut Report) -> Exit {
        // A defect of ours is graver than a report that could not be written.
        if let Err(failure) = self.finish(report) {
            console::people(&format!("note: {failure}"));
        }
        console::people("ltbw: defect in our own output; no mesh was written");
        Exit::OwnDefect
    }

    /// Writes the mesh, with what is beside it, and its parts.
    pub(crate) fn write<V: FnOnce() -> Vec<Array>>(
        &self,
        mesh: &TetMesh,
        beside: Beside<'_, V>,
        parts: impl FnOnce() -> Vec<Piece>,
        report: &mut Report,
    ) -> Result<(), Failure> {
        let clock = Instant::now();
        let in_parts = &self.outputs.in_parts;
        let _stage = self.outputs.has_meshes().then(|| Stage::begin("write"));
        self.write_whole(mesh, beside, report)?;
        if !in_parts.is_empty() {
            let parts = parts();
            for path in in_parts {
                console::writing(|token| io::write_parts_until(path, &parts, token))?;
                let has_tags = mesh.point_tags.is_some();
                InParts { parts: parts.len(), has_tags }.wrote(path, report);
            }
        }
        report.seconds.write = clock.elapsed().as_secs_f64();
        Ok(())
    }

    /// Writes the files that hold the whole mesh.
    pub(crate) fn write_whole<V: FnOnce() -> Vec<Array>>(
        &self,
        mesh: &TetMesh,
        Beside { values, names }: Beside<'_, V>,
        report: &mut Report,
    ) -> Result<(), Failure> {
        let Outputs { whole, formats, .. } = self.outputs;
        if whole.is_empty() {
            return Ok(());
        }
        let values = values();
        let hash = report.mesh.hash.clone();
        for path in whole {
            let writer = MeshWriter::new(mesh).values(&values).names(names);
            let writer = hash.as_deref().map_or(writer, |hash| writer.hash(hash));
            formats.write_mesh(path, writer)?;
            let note = attributes_note(mesh, formats.of_output(path)?);
            let path = &name_of(path);
            note.iter().for_each(|n| console::people(&format!("note: {}: {n}", show(path))));
            wrote(path, report);
        }
        Ok(())
    }

    /// Writes the page, if there is to be one: a view, the mesh's figures, and a timeline.
    pub(crate) fn write_page(
        &self,
        scene: &Scene<'_>,
        report: &Report,
        judged: &Judged,
        timeline: Option<&str>,
    ) -> Result<(), Failure> {
        let Some(path) = self.page else { return Ok(()) };
        let _stage = Stage::begin("page");
        let mut page = Page::new(&show(self.name)).view(scene);
        if let Some(measured) = &judged.measured {
            page = page.mesh(report, &judged.verdict, measured);
        }
        if let Some(timeline) = timeline {
            page = page.section("Time of the workers", timeline);
        }
        write_text(path, &page.html(&report.to_json().unwrap_or_default()))
    }
}

/// The things that go with a mesh: figures of its tetrahedra, and names of its groups.
pub(crate) struct Beside<'a, V> {
    pub(crate) values: V,
    pub(crate) names: &'a [GroupName],
}

/// The mesh of points has neither.
pub(crate) const ALONE: Beside<'static, fn() -> Vec<Array>> =
    Beside { values: Vec::new, names: &[] };

/// Tells of a file that was written.
fn wrote(path: &Path, report: &mut Report) {
    report.outputs.push(path.to_string_lossy().into_owned());
    console::people(&format!("wrote     {}", show(path)));
}

/// A mesh as it was written in parts.
pub(crate) struct InParts {
    /// Their number.
    pub(crate) parts: usize,
    /// Its points have tags.
    pub(crate) has_tags: bool,
}

impl InParts {
    /// Tells of its files.
    pub(crate) fn wrote(&self, path: &Path, report: &mut Report) {
        if self.has_tags && !io::parts_hold_tags(path) {
            let text = "tags of points are not kept: this format in parts has no place for them";
            console::people(&format!("note: {}: {text}", show(path)));
        }
        io::part_files(path, self.parts).iter().for_each(|path| wrote(path, report));
    }
}

/// The verdict and the quality of a mesh in the end.
pub(crate) struct Judged {
    /// The checker's verdict, for people.
    pub(crate) verdict: String,
    /// The quality, if there are tetrahedra.
    pub(crate) measured: Option<Measured>,
}

impl Judged {
    /// A mesh that nobody has checked.
    pub(crate) fn unseen(measured: Option<Measured>) -> Self {
        Self { verdict: "not checked".to_owned(), measured }
    }
}
