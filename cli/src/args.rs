//! The command line and its help.

use crate::angles::degrees;
use crate::kinds::{Kind, kinds};
use crate::lenience::Lenience;
use crate::numbers::whole;
use crate::parts::Parting;
use crate::progress::Show;
use crate::simulate::Simulate;
use crate::sizes::Sizing;
use crate::streams::Streams;
use crate::surface::Preparation;
use crate::workers::Mode;
use clap::{Parser, Subcommand, ValueEnum};
use ltbw::{mesh::Redeal, points::MAX_POINTS, refine::MOST_SWEEPS};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  ltbw demo                                      the paper's model problem, meshed and shown
  ltbw mesh part.stl --max-volume 0.1 -o m.vtu   mesh a domain, check the mesh, write it
  ltbw generate uniform 1000000 -o points.npy    a million random points
  ltbw delaunay points.npy -o mesh.vtu           mesh them, check the mesh, write it
  ltbw check mesh.vtu                            check anybody's mesh, exactly
  ltbw convert mesh.vtu mesh.ele                 also writes mesh.node

Formats, by extension: points .npy .xyz .txt .csv .node .ply, and read only .npz .off .obj .stl;
domains .poly .smesh .off .obj .stl .ply .vtk; meshes .vtu .vtk .msh .mesh .ele (with
.node). `-` is stdin or stdout, in the format that --format names: --format npy, say.
stdout carries data (hash, JSON), stderr what is meant for people.";

const REFINE_EXAMPLES: &str = "\
Examples:
  ltbw refine mesh.vtu --max-volume 1e-5 -o finer.vtu
  ltbw refine mesh.msh --sizes error.mtr -o finer.msh      edge lengths at the mesh's vertices
  ltbw refine mesh.vtu --sizes solution.vtu:h -o new.vtu   those that an array of points has
  ltbw refine mesh.ele --mark large.txt -o finer.ele       half the volume where it names cells
  ltbw refine mesh.vtu --plc domain.poly --size 0.1        with the domain that it is a mesh of
  ltbw refine anybodys.vtu --delaunay -o mesh.vtu          its vertices and its boundary

All vertices of the mesh stay; its boundary, the walls between regions and the faces that it lists
are the domain, with their markers. A mesh that meets its bounds comes back with the same hash.";

/// The help of `refine` for its argument.
const MESH: &str = "The mesh: .vtu .vtk .msh .mesh .ele (with .node)";

/// Exact 3D Delaunay meshes: points in, checked mesh out.
#[derive(Debug, Parser)]
#[command(name = "ltbw", version, max_term_width = 100)]
#[command(about = "Exact 3D Delaunay meshes: points in, checked mesh out.")]
#[command(long_about = "Exact 3D Delaunay meshes: points in, checked mesh out.\n\n\
    Every mesh is exactly Delaunay, also of gridded, cospherical and duplicate points, and a\n\
    point set has one mesh: the same on every machine, for any number of threads. An independent\n\
    checker looks at every mesh before it is written.")]
#[command(after_help = "`ltbw help COMMAND` tells more, with examples.")]
#[command(after_long_help = EXAMPLES)]
#[command(subcommand_required = true, arg_required_else_help = true)]
pub(crate) struct Args {
    /// Tell people errors and outcomes alone
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// The way in which progress is shown, on stderr
    #[arg(long, global = true, value_enum, value_name = "HOW", default_value = "bar")]
    #[arg(hide_short_help = true)]
    pub(crate) progress: Show,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Mesh a point set: its exact Delaunay triangulation, checked
    #[command(after_long_help = "\
Examples:
  ltbw delaunay points.xyz                             only the hash, on stdout
  ltbw delaunay points.npy -o mesh.vtu -o mesh.ele     two files (and mesh.node)
  ltbw delaunay points.csv --json - --check full       the report, on stdout
  ltbw delaunay points.npy --threads 4 -o mesh.pvtu    a file for each of 4 workers
  ltbw delaunay points.npy --threads 4 --tables        what the workers did with their time

Duplicate points are meshed once, under their smallest index; the report counts and maps them.
Ctrl-C stops early: the mesh of the points inserted so far is written, unchecked.")]
    Delaunay(Delaunay),
    /// Mesh a domain: conforming Delaunay refinement to bounds that are met exactly
    #[command(after_long_help = "\
Examples:
  ltbw generate cube-octahedron -o model.poly
  ltbw mesh model.poly --max-volume 1e-5 -o model.vtu
  ltbw mesh part.stl --size 2 -o part.msh --json -
  ltbw mesh model.poly --sizes model.mtr -o model.vtu         edge lengths at the vertices

The vertices of the domain are moved to a lattice (the largest move is reported); every point of
the mesh is then exact, and lies exactly on its facet. The mesh is of the inside alone unless
--keep-exterior asks for more; tags are regions, 0 the exterior. What cannot be met, near small
angles of the domain, is excused with its reason; the exit code is 1 where that is not a little.")]
    Mesh(MeshArgs),
    /// Go on with a mesh: split what is over new bounds, and keep its vertices
    #[command(after_long_help = REFINE_EXAMPLES)]
    #[command(mut_arg("domain", |arg| arg.value_name("MESH").help(MESH)))]
    #[command(mut_arg("repair", |arg| arg.hide(true)), mut_arg("holes", |arg| arg.hide(true)))]
    Refine(Refine),
    /// Check anybody's mesh: what is wrong, exactly and where
    #[command(after_long_help = "\
Examples:
  ltbw check mesh.vtu                      verdict and first defects, on stderr
  ltbw check mesh.vtu --delaunay           is it Delaunay and convex, too?
  ltbw check mesh.vtu --plc domain.poly    does it conform to the domain?
  ltbw check mesh.vtu --min-dihedral 10    has a tetrahedron an angle below 10 degrees?
  ltbw check mesh.ele --json cert.json     the certificate ltbw.cert/1, with every defect's place
  ltbw check mesh.vtu --certificate r.json --input domain.poly    is it what r.json certifies?
  ltbw check domain.stl                    a domain: .poly .smesh .off .obj .stl .ply .vtk

A mesh is judged as one for finite elements, of a body of any shape. Defects: structure (indices,
cells twice), topology (faces of three cells), orientation (flat, inverted), overlap (cells that
overlap, vertices that hang in an edge or face, edges that cross). Information: quality, pieces,
pinched edges and vertices, vertices at one place (cracks), Delaunay, convexity.
Of a domain: duplicate and unused vertices, facets that are degenerate, not planar, overlap or
cross, T-junctions, leaks, orientation, holes and regions outside; and once more after its
vertices are moved to the lattice on which it is meshed. Every test is exact.")]
    Check(Check),
    /// Convert points to points, a domain to a domain, or a mesh to a mesh
    #[command(after_long_help = "\
Examples:
  ltbw convert points.csv points.npy
  ltbw convert mesh.vtu mesh.mesh
  ltbw convert mesh.vtu points.xyz      the points of a mesh
  ltbw convert mesh.vtu mesh.msh --msh2 --ascii     for programs that read no newer Gmsh files
  ltbw convert mesh.vtk mesh.vtu --orient           no inverted tetrahedra

Points: .npy .xyz .txt .csv .node .ply, and read only .npz, .off .obj .stl (their vertices).
Domains: .poly .smesh .off .obj .stl .ply .vtk.
Meshes: .vtu .vtk .msh (4.1 and 2.2) .mesh .ele (with .node), and read only .pvtu (with its parts).
Coordinates survive bit for bit; tags survive where the format has a place for them.")]
    Convert(Convert),
    /// Generate a test point set or a model domain, the same on every machine
    #[command(after_long_help = "\
Examples:
  ltbw generate uniform 1000000 -o points.npy
  ltbw generate clusters 50000 --seed 7 -o clusters.xyz
  ltbw generate cube-octahedron -o m.poly             the paper's model problem
  ltbw generate wedge --angle 5 -o wedge.off")]
    Generate(Generate),
    /// Run the parallel kernel on simulated processors: the paper's tables
    #[command(after_long_help = "\
Examples:
  ltbw simulate                                            16 processors, 100,000 points
  ltbw simulate --processors 64 --latency 100us --points 1000000 --json run.json
  ltbw simulate --rule paper --distribution heavy-tail --trace t.json
  ltbw simulate --rule paper --closure vertex --ownership creator     all as in the paper
  ltbw simulate --domain cube-octahedron --max-volume 1e-4 --mode async   the paper's

Time is virtual: work and messages cost what the printed cost model says. One seed gives one run,
on every machine. The mesh is compared with the sequential kernel's.")]
    Simulate(Simulate),
    /// Show it: mesh the paper's model problem, check the mesh, write demo.vtu and demo.html
    Demo(Demo),
    /// Print a script that completes command lines: for bash, zsh, fish, elvish or powershell
    #[command(after_long_help = "\
Examples:
  ltbw completions bash > /etc/bash_completion.d/ltbw
  ltbw completions fish > ~/.config/fish/completions/ltbw.fish")]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write the manual pages ltbw.1, ltbw-delaunay.1, ... into a folder
    Man {
        /// The folder, which has to be there
        folder: PathBuf,
    },
    /// Hold another implementation to the conformance kit, which is inside this program
    #[command(subcommand)]
    Vectors(Vectors),
}

/// `ltbw vectors`.
#[derive(Debug, Subcommand)]
pub(crate) enum Vectors {
    /// Ask a program the kit's questions: one JSON object a line in, one a line out
    #[command(after_long_help = "\
Examples:
  ltbw vectors run --executor ./port                             a program of yours
  ltbw vectors unpack kit                                        the kit and its own executor
  ltbw vectors run --folder order --executor python3 -- kit/executor.py

Prints, for each folder, the level reached and what the wrong answers tell. Exit code 1 if an
answer was wrong; what the program does not support is counted apart. See docs/porting.md.")]
    Run(VectorsRun),
    /// Write the kit: questions with answers, their format, an executor in Python
    Unpack {
        /// The folder, which is made where it is missing
        folder: PathBuf,
    },
}

/// `ltbw vectors run`.
#[derive(Debug, clap::Args)]
pub(crate) struct VectorsRun {
    /// The program that answers
    #[arg(long, value_name = "PROGRAM")]
    pub(crate) executor: PathBuf,
    /// Its arguments
    #[arg(last = true)]
    pub(crate) arguments: Vec<String>,
    /// Another kit than the one inside this program
    #[arg(long, value_name = "DIR", alias = "vectors")]
    pub(crate) kit: Option<PathBuf>,
    /// Only this folder of the kit; may be given several times
    #[arg(long, value_name = "NAME", value_parser = [
        "predicates", "order", "cavity", "insert", "delaunay", "protocol", "interleavings",
        "rounds",
    ])]
    pub(crate) folder: Vec<String>,
    /// The longest time for an answer
    #[arg(long, value_name = "SECONDS", default_value_t = 60)]
    #[arg(value_parser = whole::<u64>(0..=u64::MAX), allow_negative_numbers = true)]
    pub(crate) timeout: u64,
}

/// `ltbw delaunay`.
#[derive(Debug, clap::Args)]
pub(crate) struct Delaunay {
    /// The points: .npy .npz .xyz .txt .csv .node .ply .off .obj .stl
    pub(crate) points: PathBuf,
    /// Points to remove from the mesh: by their coordinates, in a file like that of the points
    ///
    /// The mesh is that of the other points, which are numbered from 0 on. A point that is none of
    /// the mesh is an error.
    #[arg(long, value_name = "FILE")]
    pub(crate) without: Option<PathBuf>,
    /// Where to write the mesh: .vtu .vtk .msh .mesh .ele (with .node); may be given several times.
    /// As .pvtu, .vtkhdf, .mfem or _%.msh (Gmsh) it is left distributed: a part for each worker
    #[arg(short, long = "output", value_name = "MESH")]
    pub(crate) output: Vec<PathBuf>,
    /// Threads: above 1, that number of workers of the parallel kernel insert the points
    ///
    /// The mesh and its hash do not depend on this. By default one thread inserts, and all cores
    /// order, check, hash and write. A worker should have some 5,000 points at least.
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=1024))]
    #[arg(allow_negative_numbers = true)]
    pub(crate) threads: Option<u16>,
    /// Give blocks to workers that run out of points
    #[arg(long, requires = "threads")]
    pub(crate) balance: bool,
    /// Write the report as JSON (schema ltbw.report/1), `-` for stdout
    #[arg(long, value_name = "FILE|-")]
    pub(crate) json: Option<PathBuf>,
    /// Print the workers' figures as the paper's tables
    #[arg(long, requires = "threads")]
    pub(crate) tables: bool,
    /// Write a timeline for Perfetto or chrome://tracing: a track for each worker
    #[arg(long, value_name = "FILE|-", requires = "threads")]
    pub(crate) trace: Option<PathBuf>,
    /// Write a page to look at: the mesh to turn and cut, histograms, the workers' time
    #[arg(long, value_name = "HTML|-")]
    pub(crate) page: Option<PathBuf>,
    /// The depth of the check of the mesh before it is written
    #[arg(long, value_enum, default_value_t = Depth::Fast)]
    pub(crate) check: Depth,
    #[command(flatten)]
    pub(crate) streams: Streams,
}

/// `--check`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Depth {
    /// Do not check
    Off,
    /// All that proves the mesh Delaunay
    Fast,
    /// Every level, and the canonical hash once more, by independent code
    Full,
}

/// `ltbw mesh`.
#[derive(Debug, clap::Args)]
pub(crate) struct MeshArgs {
    /// The domain: .poly .smesh .off .obj .stl .ply .vtk
    pub(crate) domain: PathBuf,
    /// Where to write: .vtu .vtk .msh .mesh .ele (.node); repeatable
    #[arg(short, long = "output", value_name = "MESH")]
    pub(crate) output: Vec<PathBuf>,
    /// Largest circumradius to shortest edge; ends from 2 [default: 2]
    #[arg(long, value_name = "B", allow_negative_numbers = true)]
    pub(crate) radius_edge: Option<f64>,
    /// Splits dihedral angles below D degrees; up to 12
    #[arg(long, value_name = "D", default_value_t = 8.0, allow_negative_numbers = true)]
    pub(crate) min_dihedral: f64,
    /// Moves vertices inside, for larger angles, in N sweeps
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=u64::from(MOST_SWEEPS)))]
    #[arg(allow_negative_numbers = true, default_value_t = 0, hide_default_value = true)]
    pub(crate) smooth: u32,
    /// Largest volume of a tetrahedron
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    pub(crate) max_volume: Option<f64>,
    #[command(flatten)]
    pub(crate) sizing: Sizing,
    /// Bounds in TetGen's switches: `q` with a ratio, `a` a volume
    #[arg(
        long,
        value_name = "SWITCHES",
        allow_hyphen_values = true,
        conflicts_with_all = ["radius_edge", "max_volume"]
    )]
    #[arg(hide_short_help = true)]
    pub(crate) tetgen_switches: Option<String>,
    /// The most points to insert
    #[arg(long, value_name = "N", value_parser = whole::<u64>(0..=u64::MAX))]
    #[arg(allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    pub(crate) max_points: Option<u64>,
    /// Write a timeline for Perfetto or chrome://tracing: the rounds
    #[arg(long, value_name = "FILE|-")]
    #[arg(hide_short_help = true)]
    pub(crate) trace: Option<PathBuf>,
    /// Write the exterior between domain and convex hull, too (tag 0)
    #[arg(long)]
    pub(crate) keep_exterior: bool,
    /// Write the mesh of all points where the boundary is not in it
    #[arg(long)]
    #[arg(hide_short_help = true)]
    pub(crate) write_unrecovered: bool,
    #[command(flatten)]
    pub(crate) preparation: Preparation,
    #[command(flatten)]
    pub(crate) parting: Parting,
    #[command(flatten)]
    pub(crate) lenience: Lenience,
    /// Write a page: the mesh to turn and cut, histograms, report
    #[arg(long, value_name = "HTML|-")]
    pub(crate) page: Option<PathBuf>,
    /// Write the histograms of quality as a picture
    #[arg(long, value_name = "SVG|-")]
    #[arg(hide_short_help = true)]
    pub(crate) histogram: Option<PathBuf>,
    /// Threads for rounds, checking and output [default: one per core]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=1024))]
    #[arg(allow_negative_numbers = true)]
    pub(crate) threads: Option<u16>,
    /// Refine by N workers that share no mesh; in parts as .pvtu
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=1024))]
    #[arg(allow_negative_numbers = true, conflicts_with = "trace")]
    pub(crate) workers: Option<u16>,
    /// rounds: one mesh; async: as the paper does, another each time
    #[arg(long, value_enum, default_value_t, hide_short_help = true)]
    #[arg(hide_possible_values = true, hide_default_value = true)]
    pub(crate) mode: Mode,
    /// Move workers' cuts between rounds: never, needed, or each N-th
    #[arg(long, value_name = "WHEN", default_value = "never", hide_short_help = true)]
    #[arg(hide_default_value = true)]
    pub(crate) redeal: Redeal,
    /// Write the report as JSON (schema ltbw.report/1), `-` for stdout
    #[arg(long, value_name = "FILE|-")]
    pub(crate) json: Option<PathBuf>,
    /// Check the mesh before it is written: off, fast (default), full
    #[arg(long, value_enum, default_value_t = Depth::Fast)]
    #[arg(hide_possible_values = true, hide_default_value = true)]
    pub(crate) check: Depth,
    #[command(flatten)]
    pub(crate) streams: Streams,
}

/// `ltbw refine`.
#[derive(Debug, clap::Args)]
pub(crate) struct Refine {
    #[command(flatten)]
    pub(crate) mesh: MeshArgs,
    /// The domain that it is a mesh of: keeps its segments
    #[arg(long, value_name = "DOMAIN")]
    pub(crate) plc: Option<PathBuf>,
    /// Tetrahedra to split, by number from 0: to half their volume
    #[arg(long, value_name = "FILE")]
    pub(crate) mark: Option<PathBuf>,
    /// Take the vertices and the boundary of a mesh that is not Delaunay
    #[arg(long)]
    pub(crate) delaunay: bool,
}

/// `ltbw check`.
#[derive(Debug, clap::Args)]
pub(crate) struct Check {
    /// The mesh: .vtu .pvtu .vtk .msh .mesh .ele (with .node); or the domain: .poly .smesh .off
    /// .obj .stl .ply .vtk
    pub(crate) mesh: PathBuf,
    /// Write the certificate as JSON (ltbw.cert/1; with --plc ltbw.conformity/1; of a domain
    /// ltbw.domain/1), `-` for stdout
    #[arg(long, value_name = "FILE|-")]
    pub(crate) json: Option<PathBuf>,
    /// The order of a tetrahedron's vertices means nothing (scipy and Qhull write such meshes)
    #[arg(long)]
    pub(crate) any_order: bool,
    #[command(flatten)]
    pub(crate) streams: Streams,
    #[command(flatten)]
    pub(crate) preparation: Preparation,
    /// The mesh has to be Delaunay and convex, too: the triangulation of a point set
    #[arg(long, conflicts_with = "plc")]
    pub(crate) delaunay: bool,
    /// Check that the mesh conforms to this domain
    #[arg(long, value_name = "DOMAIN")]
    pub(crate) plc: Option<PathBuf>,
    /// With --plc: no circumradius to shortest edge may exceed this
    #[arg(long, value_name = "B", requires = "plc")]
    pub(crate) radius_edge: Option<f64>,
    /// With --plc: no volume may exceed this
    #[arg(long, value_name = "A", requires = "plc")]
    pub(crate) max_volume: Option<f64>,
    /// With --plc: no edge may be longer than this
    #[arg(long, value_name = "H", requires = "plc")]
    pub(crate) max_edge: Option<f64>,
    /// No dihedral angle may be below this many degrees: above 0, at most 90
    #[arg(
        long,
        value_name = "D",
        value_parser = degrees,
        allow_negative_numbers = true,
        conflicts_with = "certificate"
    )]
    pub(crate) min_dihedral: Option<f64>,
    /// Compare the mesh with the one that this report of `mesh` or `delaunay` certifies
    #[arg(long, value_name = "REPORT", conflicts_with_all = ["plc", "json"])]
    pub(crate) certificate: Option<PathBuf>,
    /// With --certificate: compare the input, too, and further files for --sizes and --background
    #[arg(long, value_name = "FILE", requires = "certificate")]
    pub(crate) input: Vec<PathBuf>,
}

/// `ltbw convert`.
#[derive(Debug, clap::Args)]
pub(crate) struct Convert {
    /// The file to read
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// The file to write
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Write numbers as text where the format knows both: .vtu .vtk .msh .ply
    #[arg(long)]
    pub(crate) ascii: bool,
    /// Write .msh in version 2.2 instead of 4.1
    #[arg(long)]
    pub(crate) msh2: bool,
    /// Turn negatively oriented tetrahedra to positive: some of them or all
    #[arg(long)]
    pub(crate) orient: bool,
    #[command(flatten)]
    pub(crate) streams: Streams,
}

/// `ltbw generate`.
#[derive(Debug, clap::Args)]
pub(crate) struct Generate {
    /// The kind of point set or domain
    #[arg(value_parser = kinds())]
    pub(crate) kind: Kind,
    /// About how many points (grids round up) [default: 1000], or parts of a domain
    #[arg(value_name = "N", value_parser = whole::<u32>(0..=MAX_POINTS as u64))]
    #[arg(allow_negative_numbers = true)]
    pub(crate) count: Option<u32>,
    /// Another seed gives another set of the same kind
    #[arg(long, default_value_t = 1, value_parser = whole::<u64>(0..=u64::MAX))]
    #[arg(allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// The angle of a wedge or spike
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    pub(crate) angle: Option<f64>,
    /// Where to write: points .npy .xyz .txt .csv .node .ply,
    /// domains .poly .smesh .off .obj .stl .ply .vtk
    #[arg(short, long = "output", value_name = "FILE")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) streams: Streams,
}

/// `ltbw demo`.
#[derive(Debug, clap::Args)]
pub(crate) struct Demo {
    /// Where to write the mesh; the page goes beside it, with the extension .html
    #[arg(long, value_name = "MESH", default_value = "demo.vtu")]
    pub(crate) out: PathBuf,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Args::command().debug_assert();
    }
}
