//! Writing `.msh` files.

use super::MshVersion;
use super::parts::{TETRAHEDRON, TRIANGLE};
use super::sink::Sink;
use crate::error::DataError;
use crate::{Encoding, GroupName, WriteOptions, carried, check_float_tags};
use ltbw_core::{BoundaryFace, TetMesh};
use ltbw_exact::Point;
use std::io::{Error, ErrorKind, Result, Write};

/// The name of a group of triangles whose marker no group can have: this, and the marker.
pub(super) const NAME: &str = "marker ";

/// The name of a group of tetrahedra that has no other: this, and its number.
pub(super) const VOLUME: &str = "volume ";

/// The form in which the regions of a mesh are written.
pub(super) enum Regions<'a> {
    /// As physical groups: each different region, ascending.
    Groups(&'a [i64], Vec<i64>),
    /// As values of a view.
    View(&'a [i64]),
    /// Not at all: there are none.
    None,
}

impl<'a> Regions<'a> {
    fn new(tags: Option<&'a [i64]>) -> Self {
        let Some(tags) = tags else { return Regions::None };
        // Gmsh has no group 0, and some readers want a group for all elements or for none.
        if tags.is_empty() || !tags.iter().all(|&t| (1..=i64::from(i32::MAX)).contains(&t)) {
            return Regions::View(tags);
        }
        let mut different = tags.to_vec();
        different.sort_unstable();
        different.dedup();
        Regions::Groups(tags, different)
    }

    /// The physical group of a tetrahedron, and its geometrical entity, counted from 1.
    fn of(&self, tet: usize) -> (i64, i64) {
        match self {
            Regions::Groups(tags, different) => {
                let region = tags[tet];
                (region, different.partition_point(|&r| r < region) as i64 + 1)
            }
            _ => (0, 1),
        }
    }
}

/// The boundary triangles by their markers: each different one is a surface and a physical group.
pub(super) struct Surfaces<'a> {
    pub(super) faces: &'a [BoundaryFace],
    /// The different markers, ascending.
    markers: Vec<i64>,
    /// Group and name of each: a marker that can be a group is one, and has no name.
    pub(super) groups: Vec<(i64, Option<String>)>,
    /// Triangles by marker.
    pub(super) order: Vec<usize>,
}

impl<'a> Surfaces<'a> {
    fn new(faces: &'a [BoundaryFace], names: &[GroupName]) -> Self {
        let mut markers: Vec<i64> = faces.iter().map(|f| f.marker).collect();
        markers.sort_unstable();
        markers.dedup();
        Self::of_markers(markers, faces, names)
    }

    /// Triangles that have some of these markers, of which each has a surface.
    pub(super) fn of_markers(
        markers: Vec<i64>,
        faces: &'a [BoundaryFace],
        names: &[GroupName],
    ) -> Self {
        let fits = |m: &i64| (1..=i64::from(i32::MAX)).contains(m);
        // Gmsh has no group 0 and no negative one; some readers want all elements in groups.
        let mut taken: Vec<i64> =
            names.iter().filter(|n| n.dimension == 2).map(|n| n.group).collect();
        taken.extend(&markers);
        taken.sort_unstable();
        let mut free = (1..).filter(|g| taken.binary_search(g).is_err());
        let group = |m: &i64| match fits(m) {
            true => (*m, None),
            false => (free.next().unwrap_or_default(), Some(format!("{NAME}{m}"))),
        };
        let groups = markers.iter().map(group).collect();
        let mut order: Vec<usize> = (0..faces.len()).collect();
        order.sort_by_key(|&f| faces[f].marker);
        Self { faces, markers, groups, order }
    }

    /// The surface of a triangle, counted from 0.
    pub(super) fn of(&self, face: usize) -> usize {
        self.markers.partition_point(|&m| m < self.faces[face].marker)
    }

    /// The names of groups: those that tell markers, those of volumes without another, and those
    /// given, also of groups in which nothing is: where regions are a view their numbers are still
    /// those of the names.
    pub(super) fn write_names(
        &self,
        sink: &mut Sink<'_>,
        names: &[GroupName],
        regions: &Regions<'_>,
    ) -> Result<()> {
        let own = self.groups.iter().filter_map(|(group, name)| Some((2, *group, name.clone()?)));
        let volumes = match regions {
            Regions::Groups(_, different) => different.as_slice(),
            _ => &[],
        };
        let is_named = |group: &i64| names.iter().any(|n| n.dimension == 3 && n.group == *group);
        let volumes = volumes.iter().filter(|group| !is_named(group));
        let own = own.chain(volumes.map(|group| (3, *group, format!("{VOLUME}{group}"))));
        // A name ends at its line and at its quotes.
        let plain = |name: &str| name.chars().filter(|&c| !c.is_control() && c != '"').collect();
        let given = names.iter().filter(|n| matches!(n.dimension, 2 | 3));
        let given = given.map(|n| (i64::from(n.dimension), n.group, plain(&n.name)));
        let named: Vec<(i64, i64, String)> = own.chain(given).collect();
        if named.is_empty() {
            return Ok(());
        }
        sink.line(&format!("$PhysicalNames\n{}", named.len()))?;
        for (dimension, group, name) in named {
            sink.line(&format!("{dimension} {group} \"{name}\""))?;
        }
        sink.line("$EndPhysicalNames")
    }
}

/// Checks that the tags of a mesh can be written.
pub(crate) fn check(mesh: &TetMesh) -> std::result::Result<(), DataError> {
    check_float_tags("point", mesh.point_tags.as_deref())?;
    match Regions::new(mesh.tet_tags.as_deref()) {
        Regions::View(tags) => check_float_tags("tetrahedron", Some(tags)),
        _ => Ok(()),
    }
}

/// Writes a `.msh` file; binary is little endian.
///
/// # Errors
/// Those of `out`, and [`ErrorKind::InvalidInput`] for a tag that is not exactly a double where it
/// has to be, and for more points or elements than the format can number.
pub fn write(
    out: &mut dyn Write,
    mesh: &TetMesh,
    version: MshVersion,
    encoding: Encoding,
) -> Result<()> {
    write_named(out, mesh, &[], version, encoding)
}

/// Writes a `.msh` file as [`write()`] does, with names of regions and markers.
///
/// # Errors
/// Those of [`write()`].
pub fn write_named(
    out: &mut dyn Write,
    mesh: &TetMesh,
    names: &[GroupName],
    version: MshVersion,
    encoding: Encoding,
) -> Result<()> {
    write_hashed(out, mesh, names, None, WriteOptions { msh_version: version, encoding })
}

/// Writes names and the hash of the mesh, which stands in a section that readers pass over.
pub(crate) fn write_hashed(
    out: &mut dyn Write,
    mesh: &TetMesh,
    names: &[GroupName],
    hash: Option<&str>,
    options: WriteOptions,
) -> Result<()> {
    let WriteOptions { msh_version: version, encoding } = options;
    check(mesh).map_err(|e| Error::new(ErrorKind::InvalidInput, e))?;
    let faces = mesh.faces.as_slice();
    if i32::try_from(mesh.points.len().max(mesh.tets.len() + faces.len())).is_err() {
        let text = "more points or elements than a .msh file can number";
        return Err(Error::new(ErrorKind::InvalidInput, text));
    }
    let regions = Regions::new(mesh.tet_tags.as_deref());
    let text = encoding == Encoding::Ascii;
    let sink = &mut Sink { out, text };
    sink.head(match version {
        MshVersion::V4_1 => "4.1",
        MshVersion::V2_2 => "2.2",
    })?;
    if let Some(hash) = hash {
        sink.line(&format!("$Comments\n{}\n$EndComments", carried::line(hash)))?;
    }
    let surfaces = Surfaces::new(faces, names);
    surfaces.write_names(sink, names, &regions)?;
    match version {
        MshVersion::V4_1 => version_4(sink, mesh, &regions, &surfaces)?,
        MshVersion::V2_2 => version_2(sink, mesh, &regions, &surfaces)?,
    }
    if let Some(tags) = &mesh.point_tags {
        view(sink, "NodeData", "tag", tags.len(), |i| Entry { index: i, value: tags[i] })?;
    }
    if let Regions::View(tags) = regions {
        // Some readers ignore the numbers: a value for each element, in the order of the elements.
        let count = tags.len();
        view(sink, "ElementData", "region", count + faces.len(), |i| {
            let Some(place) = i.checked_sub(count) else {
                return Entry { index: i, value: tags[i] };
            };
            let face = match version {
                MshVersion::V4_1 => surfaces.order[place],
                MshVersion::V2_2 => place,
            };
            let value = tags.get(faces[face].tet).copied().unwrap_or(0);
            Entry { index: count + face, value }
        })?;
    }
    Ok(())
}

/// The value of a view at a node or an element, which is numbered from 0.
struct Entry {
    index: usize,
    value: i64,
}

/// Writes a view.
fn view(
    sink: &mut Sink<'_>,
    section: &str,
    name: &str,
    count: usize,
    entry: impl Fn(usize) -> Entry + Sync,
) -> Result<()> {
    // One text (the name), one real (the time), three integers: time step, components, values.
    sink.line(&format!("${section}\n1\n\"{name}\"\n1\n0\n3\n0\n1\n{count}"))?;
    sink.rows(count, |i, row| {
        let Entry { index, value } = entry(i);
        row.int(index as i64 + 1);
        row.whole(value);
    })?;
    sink.end(section)
}

/// Entities, nodes and elements of version 4.1.
fn version_4(
    sink: &mut Sink<'_>,
    mesh: &TetMesh,
    regions: &Regions<'_>,
    surfaces: &Surfaces<'_>,
) -> Result<()> {
    let (points, tets) = (&mesh.points, &mesh.tets);
    let one = [0];
    let volumes: &[i64] = match regions {
        Regions::Groups(_, different) => different,
        _ => &one,
    };
    let groups: Vec<i64> = surfaces.groups.iter().map(|group| group.0).collect();
    entities(sink, Bounds::of(points), &groups, volumes)?;

    let count = points.len() as u64;
    sink.line("$Nodes")?;
    sink.row(|row| [1, count, count.min(1), count].iter().for_each(|&n| row.size(n)))?;
    sink.row(|row| {
        [3, 1, 0].iter().for_each(|&n| row.int(n));
        row.size(count);
    })?;
    sink.rows(points.len(), |i, row| row.size(i as u64 + 1))?;
    sink.rows(points.len(), |i, row| row.point(&points[i]))?;
    sink.end("Nodes")?;

    // Elements stand by region; their numbers tell the order.
    let mut order: Vec<usize> = (0..tets.len()).collect();
    if let Regions::Groups(tags, _) = regions {
        order.sort_by_key(|&t| tags[t]);
    }
    let blocks: Vec<&[usize]> =
        order.chunk_by(|&a, &b| regions.of(a).1 == regions.of(b).1).collect();
    let faces: Vec<&[usize]> =
        surfaces.order.chunk_by(|&a, &b| surfaces.of(a) == surfaces.of(b)).collect();
    let count = (tets.len() + surfaces.order.len()) as u64;
    sink.line("$Elements")?;
    let head = [(blocks.len() + faces.len()) as u64, count, count.min(1), count];
    sink.row(|row| head.iter().for_each(|&n| row.size(n)))?;
    for block in blocks {
        sink.row(|row| {
            let (_, entity) = regions.of(block[0]);
            [3, entity, TETRAHEDRON].iter().for_each(|&n| row.int(n));
            row.size(block.len() as u64);
        })?;
        sink.rows(block.len(), |i, row| {
            row.size(block[i] as u64 + 1);
            tets[block[i]].iter().for_each(|&v| row.size(u64::from(v) + 1));
        })?;
    }
    for block in faces {
        sink.row(|row| {
            [2, surfaces.of(block[0]) as i64 + 1, TRIANGLE].iter().for_each(|&n| row.int(n));
            row.size(block.len() as u64);
        })?;
        sink.rows(block.len(), |i, row| {
            row.size((tets.len() + block[i]) as u64 + 1);
            let corners = surfaces.faces[block[i]].corners;
            corners.iter().for_each(|&v| row.size(u64::from(v) + 1));
        })?;
    }
    sink.end("Elements")
}

/// The corners of a box around points.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub(super) low: Point,
    pub(super) high: Point,
}

impl Bounds {
    pub(super) fn of(points: &[Point]) -> Self {
        let mut bounds = Self { low: [0.0; 3], high: [0.0; 3] };
        for (k, p) in points.iter().enumerate() {
            for axis in 0..3 {
                let Self { low, high } = &mut bounds;
                low[axis] = if k == 0 { p[axis] } else { p[axis].min(low[axis]) };
                high[axis] = if k == 0 { p[axis] } else { p[axis].max(high[axis]) };
            }
        }
        bounds
    }
}

/// Surfaces and volumes, each with its group; 0: none. What bounds them is not told.
pub(super) fn entities(
    sink: &mut Sink<'_>,
    bounds: Bounds,
    surfaces: &[i64],
    volumes: &[i64],
) -> Result<()> {
    sink.line("$Entities")?;
    let counts = [0, 0, surfaces.len(), volumes.len()];
    sink.row(|row| counts.iter().for_each(|&n| row.size(n as u64)))?;
    for groups in [surfaces, volumes] {
        sink.rows(groups.len(), |i, row| {
            row.int(i as i64 + 1);
            row.point(&bounds.low);
            row.point(&bounds.high);
            row.group(groups[i]);
            row.size(0);
        })?;
    }
    sink.end("Entities")
}

/// Nodes and elements of version 2.2.
fn version_2(
    sink: &mut Sink<'_>,
    mesh: &TetMesh,
    regions: &Regions<'_>,
    surfaces: &Surfaces<'_>,
) -> Result<()> {
    let (points, tets, text) = (&mesh.points, &mesh.tets, sink.text);
    sink.line(&format!("$Nodes\n{}", points.len()))?;
    sink.rows(points.len(), |i, row| {
        row.int(i as i64 + 1);
        row.point(&points[i]);
    })?;
    sink.end("Nodes")?;
    let faces = surfaces.faces;
    sink.line(&format!("$Elements\n{}", tets.len() + faces.len()))?;
    if !text && !tets.is_empty() {
        // One row of all: their type, how many they are, and two tags each.
        sink.row(|row| [TETRAHEDRON, tets.len() as i64, 2].iter().for_each(|&n| row.int(n)))?;
    }
    sink.rows(tets.len(), |i, row| {
        row.int(i as i64 + 1);
        if text {
            row.int(TETRAHEDRON);
            row.int(2);
        }
        let (physical, entity) = regions.of(i);
        row.int(physical);
        row.int(entity);
        tets[i].iter().for_each(|&v| row.int(i64::from(v) + 1));
    })?;
    if !text && !faces.is_empty() {
        sink.row(|row| [TRIANGLE, faces.len() as i64, 2].iter().for_each(|&n| row.int(n)))?;
    }
    sink.rows(faces.len(), |i, row| {
        row.int((tets.len() + i) as i64 + 1);
        if text {
            row.int(TRIANGLE);
            row.int(2);
        }
        let surface = surfaces.of(i);
        row.int(surfaces.groups[surface].0);
        row.int(surface as i64 + 1);
        faces[i].corners.iter().for_each(|&v| row.int(i64::from(v) + 1));
    })?;
    sink.end("Elements")
}
