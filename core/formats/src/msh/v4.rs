//! The sections of version 4.1.

use super::parts::{Nodes, Parts, Shape, Tet, Triangle, element_type};
use super::source::Source;
use crate::error::{ParseError, Reason};
use crate::text::capacity;
use std::collections::HashMap;

/// Physical groups of the volumes and surfaces of a file.
#[derive(Debug, Default)]
pub(super) struct Volumes {
    /// The first group of each volume that is in one, and whether it is in more.
    groups: HashMap<i64, (i64, bool)>,
    /// The first group of each surface that is in one, and whether it is in more.
    surfaces: HashMap<i64, (i64, bool)>,
    /// The entity of the whole that a volume of a partition is a part of.
    parents: HashMap<i64, i64>,
    /// The number of partitions; none is 0.
    pub(super) partitions: u64,
}

/// Reads `$Entities`.
pub(super) fn entities(source: &mut Source<'_>, volumes: &mut Volumes) -> Result<(), ParseError> {
    each_entity(source, volumes, false)?;
    source.end("Entities")
}

/// Reads `$PartitionedEntities`.
pub(super) fn partitioned(
    source: &mut Source<'_>,
    volumes: &mut Volumes,
) -> Result<(), ParseError> {
    volumes.partitions = source.size()?;
    let ghosts = source.size()?;
    for _ in 0..ghosts {
        source.skip(2, Source::int)?;
    }
    each_entity(source, volumes, true)?;
    source.end("PartitionedEntities")
}

/// Reads entities, of partitions or of the whole.
fn each_entity(
    source: &mut Source<'_>,
    volumes: &mut Volumes,
    in_parts: bool,
) -> Result<(), ParseError> {
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = source.size()?;
    }
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let tag = source.int()?;
            if in_parts {
                let _parent_dimension = source.int()?;
                let parent = source.int()?;
                if dimension == 3 {
                    volumes.parents.insert(tag, parent);
                }
                let partitions = source.size()?;
                source.skip(partitions, Source::int)?;
            }
            // A point is told by its coordinates, anything else by the corners of its box.
            source.skip(if dimension == 0 { 3 } else { 6 }, Source::double)?;
            let groups = source.size()?;
            if groups > 0 {
                let first = source.int()?;
                source.skip(groups - 1, Source::int)?;
                match dimension {
                    2 => drop(volumes.surfaces.insert(tag, (first, groups > 1))),
                    3 => drop(volumes.groups.insert(tag, (first, groups > 1))),
                    _ => {}
                }
            }
            if dimension > 0 {
                let boundary = source.size()?;
                source.skip(boundary, Source::int)?;
            }
        }
    }
    Ok(())
}

/// Reads `$GhostElements`: copies of elements of other partitions.
pub(super) fn ghosts(source: &mut Source<'_>, parts: &mut Parts) -> Result<(), ParseError> {
    let count = source.size()?;
    for _ in 0..count {
        parts.ghosts.insert(source.size()?);
        let _owner = source.int()?;
        let partitions = source.size()?;
        source.skip(partitions, Source::int)?;
    }
    source.end("GhostElements")
}

/// Reads `$Nodes`.
pub(super) fn nodes(source: &mut Source<'_>, parts: &mut Parts) -> Result<(), ParseError> {
    let blocks = source.size()?;
    let announced = source.size()?;
    // The least and the largest number say nothing new.
    source.skip(2, Source::size)?;
    let each = if source.is_text() { 8 } else { 28 };
    let reserve = capacity(announced, source.remaining(), each);
    let mut nodes = Nodes::default();
    nodes.points.reserve_exact(reserve);
    nodes.numbers.reserve_exact(reserve);
    for _ in 0..blocks {
        let dimension = source.int()?;
        let _entity = source.int()?;
        let parametric = source.int()?;
        let count = source.size()?;
        if !(0..=3).contains(&dimension) || !(0..=1).contains(&parametric) {
            let text = format!("nodes of dimension {dimension}, parametric {parametric}");
            return Err(source.error(Reason::Syntax(text)));
        }
        // At most as many turns as there are bytes.
        for _ in 0..count {
            nodes.numbers.push(source.size()?);
        }
        for _ in 0..count {
            nodes.points.push([source.double()?, source.double()?, source.double()?]);
            source.skip((parametric * dimension) as u64, Source::double)?;
        }
    }
    let found = nodes.points.len() as u64;
    if found != announced {
        let text = format!("{found} nodes, where {announced} are announced");
        return Err(source.error(Reason::Syntax(text)));
    }
    nodes.finish().map_err(|r| source.error(r))?;
    parts.nodes = Some(nodes);
    source.end("Nodes")
}

/// Reads `$Elements`.
pub(super) fn elements(
    source: &mut Source<'_>,
    parts: &mut Parts,
    volumes: &Volumes,
) -> Result<(), ParseError> {
    let blocks = source.size()?;
    let announced = source.size()?;
    source.skip(2, Source::size)?;
    let each = if source.is_text() { 10 } else { 20 };
    let mut tets = Vec::with_capacity(capacity(announced, source.remaining(), each));
    let mut found = 0_u64;
    for _ in 0..blocks {
        let _dimension = source.int()?;
        let entity = source.int()?;
        let kind = source.int()?;
        let count = source.size()?;
        let Some((shape, nodes)) = element_type(kind) else {
            return Err(source.error(Reason::Unsupported(format!("elements of type {kind}"))));
        };
        let groups = match shape {
            Shape::Triangle => &volumes.surfaces,
            _ => &volumes.groups,
        };
        let (physical, more) = groups.get(&entity).copied().unwrap_or_default();
        // At most as many turns as there are bytes.
        for _ in 0..count {
            let number = source.size()?;
            match shape {
                Shape::Other => {
                    parts.other_elements = true;
                    source.skip(nodes, Source::size)?;
                }
                Shape::Triangle => {
                    parts.several_groups |= more;
                    parts.curved.triangles += usize::from(nodes > 3);
                    let corners = source.first(nodes, Source::size)?;
                    let corners = parts.corners(number, corners).map_err(|r| source.error(r))?;
                    parts.triangles.push(Triangle { number, corners, physical });
                }
                Shape::Tetrahedron => {
                    parts.several_groups |= more;
                    parts.curved.tets += usize::from(nodes > 4);
                    let corners = source.first(nodes, Source::size)?;
                    let corners = parts.corners(number, corners).map_err(|r| source.error(r))?;
                    let entity = volumes.parents.get(&entity).copied().unwrap_or(entity);
                    tets.push(Tet { number, corners, physical, entity });
                }
            }
        }
        found = found.saturating_add(count);
    }
    if found != announced {
        let text = format!("{found} elements, where {announced} are announced");
        return Err(source.error(Reason::Syntax(text)));
    }
    parts.tets = Some(tets);
    source.end("Elements")
}
