//! The surfaces of `cargo xtask parts`: files of a folder, a set by formula, and their twins; what
//! their meshes leave over a bound.

use crate::excuses::{Count, judge, limits};
use crate::layered::{Stack, random_honeycomb, random_laminate};
use ltbw::TetMesh;
use ltbw::domain::{Domain, PrepareOptions};
use ltbw::io::{self, Format, IoError};
use ltbw_generate::surfaces::{
    book, globe, map_points, plate, prism, shell, single, torus, turned,
};
use ltbw_generate::{DomainKind, Shape, ShapeError, generate_domain};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The amounts of noise of noisy globes.
const GLOBE_NOISE: [f64; 3] = [1e-3, 1e-2, 3e-2];
/// The amounts of noise of prisms.
const PRISM_NOISE: [f64; 3] = [1e-6, 1e-4, 1e-2];
/// The seeds of what is noisy.
const SEEDS: u64 = 4;

/// A surface with the name that its file gets. The name's extension is the format: `.stl` where
/// coordinates are 32-bit floats, `.off` and `.poly` where they are doubles.
pub type Named = (String, Domain);

/// The surfaces by formula: prisms, globes, tori, a book, plates, shells and wedges; and domains of
/// layers that have their facets in common.
///
/// # Errors
/// None for the shapes that are asked for here.
pub fn generated() -> Result<Vec<Named>, ShapeError> {
    let mut all: Vec<Named> = Vec::new();
    let mut add = |name: String, domain: Domain| all.push((name, domain));
    for n in [6, 8, 12, 16, 24, 48] {
        add(format!("prism-{n}.off"), prism(n, 0.0, 0));
        for noise in PRISM_NOISE {
            for seed in 0..SEEDS {
                add(format!("prism-{n}-{noise:e}-{seed}.off"), prism(n, noise, seed));
            }
        }
    }
    for n in [30, 100] {
        add(format!("globe-{n}.stl"), single(globe(n, n, 0.0, 0)));
    }
    for noise in GLOBE_NOISE {
        for seed in 0..SEEDS {
            add(format!("globe-30-{noise:e}-{seed}.stl"), single(globe(30, 30, noise, seed)));
        }
    }
    for n in [24_u32, 49, 70, 99] {
        add(format!("torus-{}.stl", 2 * n * n), single(torus(n)));
    }
    add("book-6-10.poly".to_owned(), book(6, 10.0));
    for thickness in [1.0, 0.1, 0.01, 0.001] {
        add(format!("plate-{thickness}.off"), plate(8, thickness));
        add(format!("shell-{thickness}.off"), shell(thickness / 4.0));
    }
    for angle in [25.0, 30.0, 45.0, 60.0] {
        let shape = Shape { angle: Some(angle), ..Shape::default() };
        add(format!("wedge-{angle}.off"), generate_domain(DomainKind::Wedge, &shape)?);
    }
    for seed in 0..2 * SEEDS {
        // Of thinner ones the bar on tetrahedra means nothing.
        add(format!("stack-{seed}.poly"), Stack::random(seed, 1_500.0).domain());
        add(format!("honeycomb-{seed}.poly"), random_honeycomb(seed).1);
        add(format!("laminate-{seed}.poly"), random_laminate(seed).1);
    }
    Ok(all)
}

/// The twins of a domain: turned by 30 degrees about (1, 2, 3), times 1000, and shifted by 100
/// diagonals of its box along every axis; each rounded to 32-bit floats.
#[must_use]
pub fn twins(domain: &Domain) -> [(&'static str, Domain); 3] {
    let diagonal = domain.bounds().map_or(0.0, |(low, high)| {
        (0..3).map(|k| (high[k] - low[k]) * (high[k] - low[k])).sum::<f64>().sqrt()
    });
    [
        ("turned", single(turned(domain))),
        ("times1000", single(map_points(domain, |p| p.map(|c| c * 1000.0)))),
        ("shifted", single(map_points(domain, |p| p.map(|c| c + 100.0 * diagonal)))),
    ]
}

/// The file of a twin: `.stl` of a surface of triangles, `.off` of other surfaces, else `.poly`.
#[must_use]
pub fn twin_file(original: &Path, twin: &str, domain: &Domain, oriented: bool) -> String {
    let triangle = |f: &ltbw::domain::Facet| f.polygons.len() == 1 && f.polygons[0].len() == 3;
    let extension = match oriented {
        true if domain.facets.iter().all(triangle) => "stl",
        true => "off",
        false => "poly",
    };
    let name = original.file_name().unwrap_or_default().to_string_lossy();
    format!("{name}~{twin}.{extension}")
}

/// Counts what the mesh of a part, if it has one, leaves over a bound on circumradius to shortest
/// edge; `tolerance` is the one that its patches are flat within. A part whose boundary is not
/// recovered has no mesh.
///
/// # Errors
/// Why there is nothing to judge, in one line.
pub fn count(
    part: &Path,
    mesh: Option<&Path>,
    tolerance: f64,
    radius_edge: f64,
) -> Result<Count, String> {
    let file = io::read_domain(part).map_err(|error| error.to_string())?;
    let options = PrepareOptions { oriented: file.oriented, ..PrepareOptions::default() };
    let ready = file.domain.prepare(&options).map_err(|error| error.to_string())?;
    let mesh = match mesh {
        Some(path) => io::read_mesh_file(path).map_err(|error| error.to_string())?.mesh,
        None => TetMesh::default(),
    };
    let bounds = limits(&ready.domain, Some(radius_edge), None);
    judge(&ready.domain, tolerance, &mesh, &bounds).map(|(_, count)| count)
}

/// Gives `judge` the name of a surface, the surface, and whether its facets are oriented: small
/// ones by formula, rounded to 32-bit floats, also turned; then the parts of the folder
/// `LTBW_PARTS`, if it is set. It returns whether the surface is sound.
///
/// # Panics
/// If one by formula is not sound, or no part of the folder is.
pub fn for_each_surface(mut judge: impl FnMut(&str, &Domain, bool) -> bool) {
    let by_formula = [
        ("a prism", prism(12, 0.0, 0)),
        ("a globe", globe(8, 10, 0.0, 0)),
        ("a torus", torus(10)),
        ("a plate", plate(3, 0.1)),
        ("a shell", shell(0.1)),
    ];
    for (name, domain) in by_formula {
        for (way, domain) in [("", domain.clone()), (", turned", turned(&domain))] {
            let name = format!("{name}{way}");
            assert!(judge(&name, &single(domain), true), "{name} is sound");
        }
    }
    let Some(folder) = std::env::var_os("LTBW_PARTS") else {
        println!("no parts: LTBW_PARTS names no folder");
        return;
    };
    let mut parts = 0;
    for path in files(Path::new(&folder)).expect("a folder") {
        let Ok(file) = io::read_domain(&path) else { continue };
        parts += usize::from(judge(&path.display().to_string(), &file.domain, file.oriented));
    }
    assert!(parts > 0, "no part");
}

/// The entry of a part in the file `expected.tsv` of its folder.
#[derive(Debug, Clone)]
pub struct Expected {
    /// TetGen's tetrahedra, or why there are none.
    pub tets: String,
    /// TetGen's seconds, where it ends.
    pub seconds: String,
    /// Our outcome.
    pub ours: String,
}

/// The entries of a folder, by name; none without that file.
#[must_use]
pub fn expected(folder: Option<&Path>) -> BTreeMap<String, Expected> {
    let text = folder.and_then(|f| std::fs::read_to_string(f.join("expected.tsv")).ok());
    let line = |line: &str| {
        let mut words = line.split('\t').map(str::to_owned);
        let mut word = || words.next();
        let (name, tets, seconds, ours) = (word()?, word()?, word()?, word()?);
        Some((name, Expected { tets, seconds, ours }))
    };
    text.unwrap_or_default().lines().skip(1).filter_map(line).collect()
}

/// The files of a folder that hold domains, by name.
///
/// # Errors
/// If the folder cannot be read.
pub fn files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)?
        .filter_map(Result::ok)
        .map(|entry| entry.path())
        .filter(|path| Format::from_path(path).is_ok_and(Format::holds_domain))
        .collect();
    files.sort();
    Ok(files)
}

/// Writes the triangles of a domain as a `.poly` file for a mesher that takes no other facets:
/// equal vertices merged, polygons cut, triangles without area left out.
///
/// # Errors
/// If the file cannot be written.
pub fn write_triangles(path: &Path, domain: &Domain) -> Result<(), IoError> {
    let domain = domain.clone().welded().domain;
    let mut plain = Domain { facets: Vec::new(), segments: Vec::new(), ..domain.clone() };
    for (f, facet) in (0..).zip(&domain.facets) {
        let triangles = domain.triangulate(f).map(|found| found.triangles).unwrap_or_default();
        let facets = triangles.iter().map(|t| ltbw::domain::Facet::polygon(t, facet.marker));
        plain.facets.extend(facets);
    }
    io::write_domain(path, &plain)
}

#[cfg(test)]
mod tests {
    use super::{generated, twin_file, twins};
    use ltbw::domain::CheckOptions;
    use std::collections::BTreeSet;
    use std::path::Path;

    #[test]
    fn generated_surfaces_have_names_of_their_own_and_no_defect() {
        let all = generated().expect("the set");
        let names: BTreeSet<&String> = all.iter().map(|(name, _)| name).collect();
        assert_eq!(names.len(), all.len());
        for (name, domain) in &all {
            let options =
                CheckOptions { oriented: !name.ends_with(".poly"), ..CheckOptions::default() };
            let report = domain.check(&options).expect("a domain");
            assert!(report.passed(), "{name}: {:?}", report.defects.first());
        }
    }

    #[test]
    fn twins_have_the_shape_of_the_part() {
        let (name, domain) = generated().expect("the set").swap_remove(0);
        for (twin, other) in twins(&domain) {
            assert_eq!(domain.facets, other.facets);
            assert_ne!(domain.vertices, other.vertices);
            assert!(other.vertices.iter().flatten().all(|&c| f64::from(c as f32) == c));
            let file = twin_file(Path::new(&name), twin, &other, true);
            assert_eq!(file, format!("prism-6.off~{twin}.stl"));
        }
    }
}
