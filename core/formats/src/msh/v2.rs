//! The sections of version 2.2.

use super::parts::{Nodes, Parts, Shape, Tet, Triangle, element_type};
use super::source::Source;
use crate::error::{ParseError, Reason};
use crate::text::{capacity, count};

/// More tags than this no element has: physical group, entity and mesh partitions.
const MOST_TAGS: u64 = 1 << 16;

/// The count at the start of a section, a line of text also in binary files.
fn announced(source: &mut Source<'_>) -> Result<u64, ParseError> {
    let line = source.expect_line()?;
    count(line).map_err(|r| source.error(r))
}

/// Reads `$Nodes`.
pub(super) fn nodes(source: &mut Source<'_>, parts: &mut Parts) -> Result<(), ParseError> {
    let announced = announced(source)?;
    let each = if source.is_text() { 8 } else { 28 };
    let reserve = capacity(announced, source.remaining(), each);
    let mut nodes = Nodes::default();
    nodes.points.reserve_exact(reserve);
    nodes.numbers.reserve_exact(reserve);
    for _ in 0..announced {
        nodes.numbers.push(source.small_size()?);
        nodes.points.push([source.double()?, source.double()?, source.double()?]);
    }
    nodes.finish().map_err(|r| source.error(r))?;
    parts.nodes = Some(nodes);
    source.end("Nodes")
}

/// Reads `$Elements`.
pub(super) fn elements(source: &mut Source<'_>, parts: &mut Parts) -> Result<(), ParseError> {
    let announced = announced(source)?;
    let each = if source.is_text() { 16 } else { 20 };
    let mut tets = Vec::with_capacity(capacity(announced, source.remaining(), each));
    let mut found = 0;
    // Every turn reads numbers, and in binary counts elements, too.
    while found < announced {
        // Text: number, type, number of tags for each element; binary: type, count and number of
        // tags for a row of them.
        let (number, kind, row, tags) = if source.is_text() {
            let number = source.small_size()?;
            (Some(number), source.int()?, 1, source.small_size()?)
        } else {
            (None, source.int()?, source.small_size()?, source.small_size()?)
        };
        let Some((shape, nodes)) = element_type(kind) else {
            let text = format!("elements of type {kind}");
            return Err(source.error(Reason::Unsupported(text)));
        };
        if tags > MOST_TAGS || row == 0 || row > announced - found {
            let text = format!("a row of {row} elements with {tags} tags each");
            return Err(source.error(Reason::Syntax(text)));
        }
        for _ in 0..row {
            let number = match number {
                Some(number) => number,
                None => source.small_size()?,
            };
            let mut groups = [0; 2];
            for k in 0..tags {
                let tag = source.int()?;
                if let Some(group) = groups.get_mut(k as usize) {
                    *group = tag;
                }
            }
            let [physical, entity] = groups;
            match shape {
                Shape::Other => {
                    parts.other_elements = true;
                    source.skip(nodes, Source::small_size)?;
                }
                Shape::Triangle => {
                    parts.curved.triangles += usize::from(nodes > 3);
                    let corners = source.first(nodes, Source::small_size)?;
                    let corners = parts.corners(number, corners).map_err(|r| source.error(r))?;
                    parts.triangles.push(Triangle { number, corners, physical });
                }
                Shape::Tetrahedron => {
                    parts.curved.tets += usize::from(nodes > 4);
                    let corners = source.first(nodes, Source::small_size)?;
                    let corners = parts.corners(number, corners).map_err(|r| source.error(r))?;
                    tets.push(Tet { number, corners, physical, entity });
                }
            }
        }
        found += row;
    }
    parts.tets = Some(tets);
    source.end("Elements")
}
