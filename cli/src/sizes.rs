//! Wanted edge lengths: one for all places, near places, at parts of the boundary, of a file.

use crate::binding::{Chosen, Reads, Role, read_beside};
use crate::outcome::{Failure, show};
use crate::parts::Boundary;
use crate::solution::{Given, SizesFile};
use clap::builder::{PathBufValueParser, TypedValueParser as _};
use ltbw::domain::Prepared;
use ltbw::refine::{Background, BackgroundError, Sizes, SizesError};
use ltbw::{Point, TetMesh, io};
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Options of `mesh` and `refine` that say how long edges are to be.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct Sizing {
    /// Usual edge length, where the surface is no finer
    ///
    /// Mean edges are within 10 % of it; no volume exceeds that of regular edges of 1.18 H.
    #[arg(long, alias = "edge", value_name = "H", value_parser = length)]
    #[arg(allow_negative_numbers = true)]
    pub(crate) size: Option<f64>,
    /// No edge is longer, exactly
    #[arg(long, value_name = "H", value_parser = length, allow_negative_numbers = true)]
    pub(crate) max_edge: Option<f64>,
    /// Edges of length H within RADIUS [0] of a place; repeatable
    #[arg(long, value_name = "X,Y,Z:H[:RADIUS]", allow_hyphen_values = true)]
    #[arg(hide_short_help = true)]
    pub(crate) near: Vec<Near>,
    /// Edges of length H at a part, by marker or name; repeatable
    #[arg(long, value_name = "PART:H", allow_hyphen_values = true, hide_short_help = true)]
    pub(crate) size_at: Vec<SizeAt>,
    /// Edges of a turn of curved surfaces: 2πr/N at a radius of r
    #[arg(long, value_name = "N", allow_negative_numbers = true, hide_short_help = true)]
    pub(crate) curvature: Option<f64>,
    /// From there edges grow by up to G each [default: 1.3]
    #[arg(long, value_name = "G", allow_negative_numbers = true, hide_short_help = true)]
    pub(crate) growth: Option<f64>,
    /// Edge lengths at vertices: .mtr; .vtu:NAME at those of its mesh
    ///
    /// They are linear in between. TetGen's .mtr: `COUNT 1`, then a length for each vertex.
    #[arg(long, value_name = "FILE", value_parser = PathBufValueParser::new().map(SizesFile::of))]
    pub(crate) sizes: Option<SizesFile>,
    /// The mesh that --sizes is about, not the domain's vertices
    #[arg(long, value_name = "MESH", requires = "sizes")]
    #[arg(hide_short_help = true)]
    pub(crate) background: Option<PathBuf>,
}

/// A length.
fn length(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    let good = value.is_finite() && value > 0.0;
    good.then_some(value).ok_or_else(|| "a length is positive and finite".to_owned())
}

/// Short edges near a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Near {
    at: Point,
    length: f64,
    radius: f64,
}

impl FromStr for Near {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse().map_err(|e| format!("`{text}`: {e}"));
        let parts: Vec<&str> = text.split(':').collect();
        let (place, length, radius) = match parts[..] {
            [place, length] => (place, length, 0.0),
            [place, length, radius] => (place, length, number(radius)?),
            _ => return Err("expected X,Y,Z:H or X,Y,Z:H:RADIUS".to_owned()),
        };
        let at: Vec<f64> = place.split(',').map(number).collect::<Result<_, _>>()?;
        let at = at.try_into().map_err(|_| format!("`{place}`: expected three coordinates"))?;
        Ok(Self { at, length: self::length(length)?, radius })
    }
}

impl fmt::Display for Near {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { at: [x, y, z], length, radius } = self;
        write!(f, "{x:?},{y:?},{z:?}:{length:?}:{radius:?}")
    }
}

/// Short edges at a part of the boundary.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SizeAt {
    /// Its marker, or its name.
    part: String,
    length: f64,
}

impl FromStr for SizeAt {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (part, length) = text.rsplit_once(':').ok_or("expected PART:H")?;
        Ok(Self { part: part.to_owned(), length: self::length(length)? })
    }
}

impl fmt::Display for SizeAt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{:?}", self.part, self.length)
    }
}

/// The edge length at a place of the prepared domain.
pub(crate) type Field = Box<dyn Fn(Point) -> f64 + Sync>;

impl Sizing {
    /// Adds what the mesh depends on.
    pub(crate) fn bind(&self, chosen: Chosen) -> Chosen {
        let all = |list: Vec<String>| (!list.is_empty()).then(|| list.join(" "));
        chosen
            .number("size", self.size)
            .number("max_edge", self.max_edge)
            .with("sizes_field", self.sizes.as_ref().and_then(|sizes| sizes.field.as_ref()))
            .with("near", all(self.near.iter().map(Near::to_string).collect()))
            .with("size_at", all(self.size_at.iter().map(SizeAt::to_string).collect()))
            .number("curvature", self.curvature)
            .number("growth", self.growth)
    }

    /// The lengths that the command line says by itself.
    fn own(&self, ready: &Prepared, boundary: &Boundary) -> Result<Sizes, Failure> {
        let wrong = |option: &str, error: &SizesError| Failure::Usage(format!("{option}: {error}"));
        let mut sizes = Sizes::new(ready);
        if let Some(growth) = self.growth {
            sizes = sizes.growth(growth).map_err(|e| wrong("--growth", &e))?;
        }
        if let Some(length) = self.size {
            sizes = sizes.everywhere(length).map_err(|e| wrong("--size", &e))?;
        }
        for near in &self.near {
            let Near { at, length, radius } = *near;
            let added = sizes.near(at, length, radius);
            sizes = added.map_err(|e| wrong(&format!("--near {near}"), &e))?;
        }
        for at in &self.size_at {
            let marker = boundary.marker(&at.part);
            let is_meant = |facet| marker == Some(boundary.marker_of(ready, facet));
            let added = sizes.at_facets(&ready.domain, is_meant, at.length);
            sizes = added.map_err(|e| wrong(&format!("--size-at {at}"), &e))?;
        }
        if let Some(per_turn) = self.curvature {
            let curved = sizes.curved(&ready.domain, &boundary.smooth(ready), per_turn);
            sizes = curved.map_err(|e| wrong("--curvature", &e))?;
        }
        Ok(sizes)
    }

    /// Does it ask for any length?
    fn asks(&self) -> bool {
        let somewhere = !self.near.is_empty() || !self.size_at.is_empty();
        somewhere || self.size.is_some() || self.curvature.is_some()
    }
}

/// The sizing field of the command line, if it asks for one; the files that it is read from go to
/// `reads`. Sizes are those at the vertices of the mesh that is gone on with, if one is; else those
/// of a solution are at the points of its own mesh.
pub(crate) fn field(
    sizing: &Sizing,
    ready: &Prepared,
    boundary: &Boundary,
    reads: &Reads,
    own: Option<&TetMesh>,
) -> Result<Option<Field>, Failure> {
    let lengths = sizing.own(ready, boundary)?;
    let Some(asked) = &sizing.sizes else {
        return Ok(sizing.asks().then(|| -> Field { Box::new(move |p| lengths.at(p)) }));
    };
    let Given { sizes, on } = asked.read(reads)?;
    let path = &asked.file;
    let failed = |error| match error {
        BackgroundError::Count { .. } => Failure::Usage(format!("--sizes {}: {error}", show(path))),
        error => Failure::Sizes { path: path.clone(), error },
    };
    let background = match (&sizing.background, own.or(on.as_ref())) {
        (Some(mesh), _) => {
            let read = |path: &Path, load: &mut io::Load<'_>| io::read_mesh_by(path, load);
            let file = read_beside(reads, Role::Background, mesh, read)?;
            Background::new(&file.mesh, &sizes).map_err(failed)?
        }
        (None, Some(mesh)) => Background::new(mesh, &sizes).map_err(failed)?,
        (None, None) => Background::at_vertices(ready, &sizes).map_err(failed)?,
    };
    // A background mesh is in the coordinates of the file, the domain perhaps in those of a frame.
    let offset = match sizing.background.is_some() || own.is_some() || on.is_some() {
        true => ready.lattice.offset(),
        false => [0.0; 3],
    };
    Ok(Some(Box::new(move |p| {
        background.at([0, 1, 2].map(|k| p[k] + offset[k])).min(lengths.at(p))
    })))
}

#[cfg(test)]
mod tests {
    use super::{Near, SizeAt};

    #[test]
    fn places_and_parts_are_read() {
        let near: Near = "-1,2.5,1e-3:0.1:0.5".parse().expect("a place");
        assert_eq!(near, Near { at: [-1.0, 2.5, 1e-3], length: 0.1, radius: 0.5 });
        assert_eq!(near.to_string(), "-1.0,2.5,0.001:0.1:0.5");
        assert_eq!("0,0,0:2".parse::<Near>().map(|near| near.radius), Ok(0.0));
        for wrong in ["", "1,2,3", "1,2:0.1", "1,2,3:x", "1,2,3:-1", "1,2,3:1:2:3", "1,2,3,4:1"] {
            assert!(wrong.parse::<Near>().is_err(), "{wrong}");
        }
        let at: SizeAt = "a:b:0.25".parse().expect("a part");
        assert_eq!(at, SizeAt { part: "a:b".to_owned(), length: 0.25 });
        for wrong in ["3", "3:0", "3:inf"] {
            assert!(wrong.parse::<SizeAt>().is_err(), "{wrong}");
        }
    }
}
