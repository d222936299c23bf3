//! `.pvtu` read: the list of the pieces of a mesh, and the pieces put together.
//!
//! A piece is a `.vtu` file, named relative to the list. A vertex that tetrahedra of several pieces
//! have in common is in each of them: vertices of different pieces with equal coordinates (`-0.0`
//! and `0.0` are) become one, those of one piece stay apart. Cells that are there twice, as copies
//! for the neighbour (a ghost level above 0), are refused. Written by `parts.rs`.
//! Source: the VTK file formats page of the VTK documentation.

use super::error::{ParseError, Place, Reason, excerpt};
use super::text::count;
use super::vtu::{self, append};
use super::xml::{attribute, each_event, expect_kind, malformed};
use super::{IoError, Load, MeshFile, parse_error};
use ltbw_core::{BoundaryFace, TetMesh};
use ltbw_exact::Point;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// The names of the pieces that a `.pvtu` file lists, each once.
///
/// # Errors
/// What is no list of pieces, with its line.
pub fn sources(bytes: &[u8]) -> Result<Vec<String>, ParseError> {
    let (mut depth, mut found) = (0_usize, Vec::new());
    let mut seen = HashSet::new();
    each_event(bytes, bytes.len(), |event, offset| {
        let at = |reason| ParseError::at(bytes, offset, reason);
        let (element, opens) = match event {
            Event::Start(element) => (element, 1),
            Event::Empty(element) => (element, 0),
            Event::End(_) => {
                depth = depth.saturating_sub(1);
                return Ok(());
            }
            _ => return Ok(()),
        };
        if let Some(source) = piece(&element, depth).map_err(at)? {
            if !seen.insert(source.clone()) {
                let text = format!("the piece `{}` is there twice", excerpt(source.as_bytes()));
                return Err(at(Reason::Syntax(text)));
            }
            found.push(source);
        }
        depth += opens;
        Ok(())
    })?;
    if depth > 0 || found.is_empty() {
        let text = if depth > 0 { "the file ends inside an element" } else { "no piece is listed" };
        return Err(ParseError::at(bytes, bytes.len(), Reason::Syntax(text.into())));
    }
    Ok(found)
}

/// The piece that an element names, if it is one; `depth` elements are around it.
fn piece(element: &BytesStart<'_>, depth: usize) -> Result<Option<String>, Reason> {
    match (depth, element.name().into_inner()) {
        (0, _) => expect_kind(element, "PUnstructuredGrid").map(|()| None),
        (1, "PUnstructuredGrid") => match attribute(element, "GhostLevel")? {
            Some(level) if count(level.as_bytes())? > 0 => {
                Err(Reason::Unsupported(format!("pieces with {level} layers of ghost cells")))
            }
            _ => Ok(None),
        },
        (2, "Piece") => {
            let source = element.try_get_attribute("Source").map_err(|e| malformed(&e))?;
            let nameless = || Reason::Syntax("a piece without the attribute `Source`".into());
            let name = source.ok_or_else(nameless)?;
            let name = name.normalized_value(XmlVersion::Implicit1_0);
            Ok(Some(name.map_err(|e| malformed(&e))?.trim().to_owned()))
        }
        _ => Ok(None),
    }
}

/// The files of the pieces that the list at `path` names.
pub(super) fn piece_files(path: &Path, list: &[u8]) -> Result<Vec<PathBuf>, ParseError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(sources(list)?.iter().map(|name| folder.join(name)).collect())
}

/// Reads the list at `path`, and its pieces, with bytes that `load` gives.
pub(super) fn read(path: &Path, load: &mut Load<'_>) -> Result<MeshFile, IoError> {
    let pieces = piece_files(path, &load(path)?).map_err(|error| parse_error(path, error))?;
    let mut whole = Join::default();
    for piece in pieces {
        let added = vtu::read(&load(&piece)?).and_then(|file| whole.add(file));
        added.map_err(|error| parse_error(&piece, error))?;
    }
    Ok(whole.finish())
}

/// Pieces of a mesh on their way to be one.
#[derive(Debug, Default)]
pub struct Join {
    mesh: TetMesh,
    /// The first vertex at each place.
    places: HashMap<[u64; 3], u32>,
    notes: Vec<String>,
    is_begun: bool,
}

impl Join {
    /// Adds a piece. Of a vertex that others have, too, the first tag is kept.
    ///
    /// # Errors
    /// More points than indices can name; tags of some pieces alone.
    pub fn add(&mut self, piece: MeshFile) -> Result<(), ParseError> {
        let at_end = |reason| ParseError::new(Place::End, reason);
        for note in piece.notes {
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
        }
        let part = piece.mesh;
        if part.points.is_empty() {
            return Ok(());
        }
        // In rounding to nearest, -0.0 + 0.0 is 0.0; nothing else changes.
        let key = |p: &Point| p.map(|c| (c + 0.0).to_bits());
        let mut numbers = Vec::with_capacity(part.points.len());
        let mut fresh = Vec::new();
        for (place, point) in part.points.iter().enumerate() {
            let next = self.mesh.points.len();
            let next =
                u32::try_from(next).map_err(|_| at_end(Reason::TooManyPoints(next as u64)))?;
            let known = self.places.get(&key(point)).copied();
            if known.is_none() {
                self.mesh.points.push(*point);
                fresh.push(place);
            }
            numbers.push(known.unwrap_or(next));
        }
        for (point, &number) in part.points.iter().zip(&numbers) {
            self.places.entry(key(point)).or_insert(number);
        }
        let tags = part.point_tags.map(|tags| fresh.iter().map(|&place| tags[place]).collect());
        let (first, before) = (!self.is_begun, self.mesh.tets.len());
        append(&mut self.mesh.point_tags, tags, first)
            .and_then(|()| append(&mut self.mesh.tet_tags, part.tet_tags, first))
            .and_then(|()| append(&mut self.mesh.tet_attributes, part.tet_attributes, first))
            .map_err(at_end)?;
        let renamed = |corner: u32| numbers[corner as usize];
        self.mesh.tets.extend(part.tets.iter().map(|tet| tet.map(renamed)));
        self.mesh.faces.extend(part.faces.iter().map(|face| BoundaryFace {
            corners: face.corners.map(renamed),
            tet: face.tet + before,
            ..*face
        }));
        self.is_begun = true;
        Ok(())
    }

    /// The whole mesh: vertices and tetrahedra in the order of the pieces.
    pub fn finish(self) -> MeshFile {
        MeshFile { mesh: self.mesh, notes: self.notes, names: Vec::new() }
    }
}
