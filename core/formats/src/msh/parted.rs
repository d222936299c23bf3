//! The `.msh` file of a part: partitioned entities, and copies of the tetrahedra beside.

use super::parts::{TETRAHEDRON, TRIANGLE};
use super::sink::{Row, Sink};
use super::write::{Bounds, Regions, Surfaces, entities};
use crate::error::DataError;
use crate::parted::{Border, PartOf, Piece};
use std::io::{Result, Write};

/// Checks that the regions of all parts can be groups.
pub(crate) fn check(border: &Border) -> std::result::Result<(), DataError> {
    let is_group = |&region: &i64| (1..=i64::from(i32::MAX)).contains(&region);
    match border.regions.iter().find(|region| !is_group(region)) {
        Some(&value) => Err(DataError::Attributes { what: "region", value }),
        None => Ok(()),
    }
}

/// The numbers of entities: first those of the whole, then those of each partition, in turn.
struct Numbers {
    /// The partition, from 1, and how many there are.
    partition: i64,
    of: i64,
    /// Volumes and surfaces of the whole.
    volumes: i64,
    surfaces: i64,
}

impl Numbers {
    /// The own part of a volume, which is counted from 0.
    fn volume(&self, volume: usize) -> i64 {
        self.partition * self.volumes + volume as i64 + 1
    }

    /// The own part of a surface.
    fn surface(&self, surface: usize) -> i64 {
        self.partition * self.surfaces + surface as i64 + 1
    }

    /// The volume of the copies.
    fn ghosts(&self) -> i64 {
        (self.of + 1) * self.volumes + self.partition
    }
}

/// Writes the file of a part.
///
/// # Errors
/// Those of `out`.
pub(crate) fn write(
    out: &mut dyn Write,
    piece: &Piece,
    border: &Border,
    PartOf { part, of }: PartOf,
) -> Result<()> {
    let mesh = &piece.mesh;
    let sink = &mut Sink { out, text: false };
    sink.head("4.1")?;
    let surfaces = Surfaces::of_markers(border.markers.clone(), &mesh.faces, &[]);
    let volumes = match border.regions.is_empty() {
        true => Regions::None,
        false => Regions::Groups(&[], border.regions.clone()),
    };
    surfaces.write_names(sink, &[], &volumes)?;
    let markers: Vec<i64> = surfaces.groups.iter().map(|group| group.0).collect();
    // One volume without a group if there are no regions.
    let one = [0];
    let regions = if border.regions.is_empty() { &one[..] } else { &border.regions };
    let bounds = Bounds::of(&mesh.points);
    entities(sink, bounds, &markers, regions)?;
    let (partition, of) = (part as i64 + 1, of as i64);
    let numbers =
        Numbers { partition, of, volumes: regions.len() as i64, surfaces: markers.len() as i64 };

    sink.line("$PartitionedEntities")?;
    sink.row(|row| {
        row.size(of as u64);
        row.size(1);
        row.int(numbers.ghosts());
        row.int(partition);
        [0, 0, markers.len(), regions.len()].iter().for_each(|&n| row.size(n as u64));
    })?;
    let entity = |row: &mut Row<'_>, tag: i64, parent: [i64; 2], group: i64| {
        [tag, parent[0], parent[1]].iter().for_each(|&n| row.int(n));
        row.size(1);
        row.int(partition);
        row.point(&bounds.low);
        row.point(&bounds.high);
        row.group(group);
        row.size(0);
    };
    sink.rows(markers.len(), |i, row| {
        entity(row, numbers.surface(i), [2, i as i64 + 1], markers[i]);
    })?;
    sink.rows(regions.len(), |i, row| {
        entity(row, numbers.volume(i), [3, i as i64 + 1], regions[i]);
    })?;
    sink.end("PartitionedEntities")?;
    let whole = Part { piece, border, numbers: &numbers, surfaces: &surfaces };
    whole.nodes(sink)?;
    whole.elements(sink)?;

    sink.line("$GhostElements")?;
    sink.row(|row| row.size(border.ghosts.len() as u64))?;
    sink.rows(border.ghosts.len(), |i, row| {
        row.size(border.ghosts[i].number + 1);
        row.int(i64::from(border.ghosts[i].owner) + 1);
        row.size(1);
        row.int(partition);
    })?;
    sink.end("GhostElements")
}

/// A part on its way into a file.
struct Part<'a> {
    piece: &'a Piece,
    border: &'a Border,
    numbers: &'a Numbers,
    surfaces: &'a Surfaces<'a>,
}

impl Part<'_> {
    /// The own nodes, and those that the copies have beside.
    fn nodes(&self, sink: &mut Sink<'_>) -> Result<()> {
        let Self { piece, border, numbers, .. } = *self;
        let points = &piece.mesh.points;
        let all = || border.numbers.iter().copied().chain(border.points.iter().map(|p| p.number));
        let count = points.len() + border.points.len();
        let range = [all().min(), all().max()].map(|n| n.map_or(0, |n| n + 1));
        let blocks = [!points.is_empty(), !border.points.is_empty()];
        let blocks = blocks.iter().filter(|is_there| **is_there).count();
        sink.line("$Nodes")?;
        let head = [blocks as u64, count as u64, range[0], range[1]];
        sink.row(|row| head.iter().for_each(|&n| row.size(n)))?;
        let block = |sink: &mut Sink<'_>, entity: i64, count: usize| {
            sink.row(|row| {
                [3, entity, 0].iter().for_each(|&n| row.int(n));
                row.size(count as u64);
            })
        };
        if !points.is_empty() {
            block(sink, numbers.volume(0), points.len())?;
            sink.rows(points.len(), |i, row| row.size(border.numbers[i] + 1))?;
            sink.rows(points.len(), |i, row| row.point(&points[i]))?;
        }
        if !border.points.is_empty() {
            block(sink, numbers.ghosts(), border.points.len())?;
            sink.rows(border.points.len(), |i, row| row.size(border.points[i].number + 1))?;
            sink.rows(border.points.len(), |i, row| row.point(&border.points[i].at))?;
        }
        sink.end("Nodes")
    }

    /// Tetrahedra by region, the copies, boundary triangles by marker.
    fn elements(&self, sink: &mut Sink<'_>) -> Result<()> {
        let Self { piece, border, numbers, surfaces } = *self;
        let mesh = &piece.mesh;
        let volume = |t: usize| match &mesh.tet_tags {
            Some(tags) => border.regions.partition_point(|&region| region < tags[t]),
            None => 0,
        };
        let mut order: Vec<usize> = (0..mesh.tets.len()).collect();
        order.sort_by_key(|&t| volume(t));
        let blocks: Vec<&[usize]> = order.chunk_by(|&a, &b| volume(a) == volume(b)).collect();
        let faces: Vec<&[usize]> =
            surfaces.order.chunk_by(|&a, &b| surfaces.of(a) == surfaces.of(b)).collect();
        let (ghosts, after) = (&border.ghosts, border.all_tets + border.faces_before);
        let number = |v: u32| match border.numbers.get(v as usize) {
            Some(number) => number + 1,
            None => border.points[v as usize - border.numbers.len()].number + 1,
        };
        let mut range = [u64::MAX, 0];
        let mut cover = |first: u64, count: usize| {
            if count > 0 {
                range = [range[0].min(first + 1), range[1].max(first + count as u64)];
            }
        };
        cover(border.tets_before, mesh.tets.len());
        cover(after, surfaces.order.len());
        ghosts.iter().for_each(|ghost| cover(ghost.number, 1));
        sink.line("$Elements")?;
        let count = (mesh.tets.len() + ghosts.len() + surfaces.order.len()) as u64;
        let blocks_of_all = blocks.len() + usize::from(!ghosts.is_empty()) + faces.len();
        let head = [blocks_of_all as u64, count, range[0].min(range[1]), range[1]];
        sink.row(|row| head.iter().for_each(|&n| row.size(n)))?;
        let block = |sink: &mut Sink<'_>, head: [i64; 3], count: usize| {
            sink.row(|row| {
                head.iter().for_each(|&n| row.int(n));
                row.size(count as u64);
            })
        };
        for list in blocks {
            block(sink, [3, numbers.volume(volume(list[0])), TETRAHEDRON], list.len())?;
            sink.rows(list.len(), |i, row| {
                row.size(border.tets_before + list[i] as u64 + 1);
                mesh.tets[list[i]].iter().for_each(|&v| row.size(number(v)));
            })?;
        }
        if !ghosts.is_empty() {
            block(sink, [3, numbers.ghosts(), TETRAHEDRON], ghosts.len())?;
            sink.rows(ghosts.len(), |i, row| {
                row.size(ghosts[i].number + 1);
                ghosts[i].corners.iter().for_each(|&v| row.size(number(v)));
            })?;
        }
        for list in faces {
            block(sink, [2, numbers.surface(surfaces.of(list[0])), TRIANGLE], list.len())?;
            sink.rows(list.len(), |i, row| {
                row.size(after + list[i] as u64 + 1);
                let corners = surfaces.faces[list[i]].corners;
                corners.iter().for_each(|&v| row.size(number(v)));
            })?;
        }
        sink.end("Elements")
    }
}
