//! `refine`: a mesh that is there is gone on with.

use crate::args::Refine;
use crate::binding::{Role, read_beside};
use crate::console;
use crate::mesh::{Start, mesh_from};
use crate::others::Others;
use crate::outcome::{Exit, Failure, show};
use crate::parts::Told;
use crate::progress::Stage;
use crate::sizes::{Field, field};
use crate::streams::{Formats, Source};
use crate::surface::given;
use ltbw::TetMesh;
use ltbw::domain::{PreparedSkin, Skin, SkinError};
use ltbw::io::{self, DomainFile};
use ltbw::refine::Marked;
use std::path::PathBuf;

/// `ltbw refine`.
pub(crate) fn refine(args: &Refine, others: Others<'_>) -> Result<Exit, Failure> {
    if args.plc.is_none() && args.mesh.preparation.points.is_some() {
        let text = "--points: the vertices of the mesh are given; more are taken with --plc alone";
        return Err(Failure::Usage(text.to_owned()));
    }
    if args.mesh.preparation.simplify.is_some() {
        let text = "--simplify: the vertices of the mesh are kept, those of its boundary too";
        return Err(Failure::Usage(text.to_owned()));
    }
    mesh_from(&args.mesh, others, Some(args))
}

impl Refine {
    /// The files that are read.
    pub(crate) fn inputs(&self) -> Vec<PathBuf> {
        let mut all = io::mesh_files(&self.mesh.domain);
        all.extend(self.plc.iter().flat_map(io::domain_files));
        all.extend(self.mark.clone());
        all
    }

    /// Reads the mesh, and makes the domain with its vertices ready.
    pub(crate) fn start(&self, source: &Source) -> Result<Start, Failure> {
        let file = source.noted_mesh()?;
        let name = source.show();
        file.notes.iter().for_each(|n| console::people(&format!("note: {name}: {n}")));
        let failed = |error| {
            let help = match error {
                SkinError::NotDelaunay { .. } => "; --delaunay takes its vertices and boundary",
                _ => "",
            };
            Failure::Mesh { path: source.name.clone(), error, help }
        };
        let skin = Skin::of(&file.mesh).map_err(failed)?;
        if !self.delaunay {
            let _stage = Stage::begin("check");
            skin.check_delaunay().map_err(failed)?;
        }
        let preparation = &self.mesh.preparation;
        let (ready, flat) = match &self.plc {
            Some(plc) => {
                let domain = Formats::default().input(plc)?;
                let mut own = preparation.read(&domain)?;
                skin.give_outer(&mut own.domain);
                let (mut ready, flat) = preparation.prepare_file(own, &domain)?;
                skin.give_inner(&mut ready);
                let reads = domain.reads().list();
                reads.into_iter().for_each(|read| source.reads().take(Role::Domain, read));
                (ready, flat)
            }
            None => {
                let options = preparation.options(&mut DomainFile::default());
                let PreparedSkin { ready, flat_tolerance } =
                    skin.prepare(&options).map_err(failed)?;
                let flat = preparation.flat(&ready, flat_tolerance)?;
                given(&ready).iter().for_each(|line| console::people(line));
                (ready, flat)
            }
        };
        let told = Told::named(file.names);
        let boundary = self.mesh.parting.boundary(&ready, flat, told, source);
        let field = field(&self.mesh.sizing, &ready, &boundary, source.reads(), Some(&file.mesh))?;
        let field = self.marked(&file.mesh, ready.lattice.offset(), source, field)?;
        Ok(Start { ready, flat_tolerance: flat, field, boundary })
    }

    /// The sizing field with what the marked tetrahedra ask for.
    fn marked(
        &self,
        mesh: &TetMesh,
        offset: ltbw::Point,
        source: &Source,
        field: Option<Field>,
    ) -> Result<Option<Field>, Failure> {
        let Some(path) = &self.mark else { return Ok(field) };
        let load = |path: &std::path::Path, load: &mut io::Load<'_>| load(path);
        let bytes = read_beside(source.reads(), Role::Mark, path, load)?;
        let wrong = |why: String| Failure::Usage(format!("--mark {}: {why}", show(path)));
        let text = String::from_utf8_lossy(&bytes);
        let words = text
            .lines()
            .flat_map(|line| line.split('#').next().unwrap_or_default().split_whitespace());
        let number = |word: &str| word.parse().map_err(|_| wrong(format!("`{word}` is no number")));
        let numbers: Vec<usize> = words.map(number).collect::<Result<_, _>>()?;
        if numbers.is_empty() {
            return Err(wrong("it names no tetrahedron".to_owned()));
        }
        if let Some(most) = numbers.iter().find(|&&tet| tet >= mesh.tets.len()) {
            let count = mesh.tets.len();
            return Err(wrong(format!("there is no tetrahedron {most}: the mesh has {count}")));
        }
        let failed = |error| Failure::Sizes { path: path.clone(), error };
        let marked = Marked::new(mesh, &numbers).map_err(failed)?;
        Ok(Some(Box::new(move |p| {
            let own = marked.at([0, 1, 2].map(|k| p[k] + offset[k]));
            field.as_ref().map_or(own, |field| own.min(field(p)))
        })))
    }
}
