//! `.vtkhdf`: VTK's meshes in HDF5, one file of several parts, each of which writes its slabs.
//!
//! Every part is a partition with its own points, as a piece of a `.pvtu` is, with the same arrays:
//! `GlobalPointIds` and `owner` of points, `worker` of cells, and tags, regions, markers and
//! attributes as far as all parts have them. Boundary triangles follow the tetrahedra of their
//! part. The places of all numbers are known when the sizes of the parts are, so that parts write
//! at once.
//! Written, not read. Source: the page on the VTKHDF file format of the VTK documentation.

mod hdf5;

use crate::parted::{Arrays, Border, PartSizes, Piece};
use crate::text::write_rows;
use hdf5::{Dataset, Head, Kind};
use std::io::{Read, Result, Seek, SeekFrom, Write};

/// VTK's numbers for a triangle and a tetrahedron.
const TRIANGLE: u8 = 5;
const TETRAHEDRON: u8 = 10;

/// The columns of a file, each a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    NumberOfPoints,
    NumberOfCells,
    NumberOfConnectivityIds,
    Points,
    Connectivity,
    Offsets,
    Types,
    Given,
    Owner,
    Tag,
    Worker,
    Region,
    Marker,
    Attribute,
}

/// The columns that every file has.
const ALWAYS: [Column; 10] = [
    Column::NumberOfPoints,
    Column::NumberOfCells,
    Column::NumberOfConnectivityIds,
    Column::Points,
    Column::Connectivity,
    Column::Offsets,
    Column::Types,
    Column::Given,
    Column::Owner,
    Column::Worker,
];

impl Column {
    /// The group, the name, the type, and the numbers of a row.
    fn described(self) -> Dataset {
        let of = |group, name, kind, columns| Dataset { group, name, kind, rows: 0, columns };
        let (points, cells) = (Some("PointData"), Some("CellData"));
        match self {
            Self::NumberOfPoints => of(None, "NumberOfPoints", Kind::I64, 1),
            Self::NumberOfCells => of(None, "NumberOfCells", Kind::I64, 1),
            Self::NumberOfConnectivityIds => of(None, "NumberOfConnectivityIds", Kind::I64, 1),
            Self::Points => of(None, "Points", Kind::F64, 3),
            Self::Connectivity => of(None, "Connectivity", Kind::I64, 1),
            Self::Offsets => of(None, "Offsets", Kind::I64, 1),
            Self::Types => of(None, "Types", Kind::U8, 1),
            Self::Given => of(points, "GlobalPointIds", Kind::I64, 1),
            Self::Owner => of(points, "owner", Kind::I32, 1),
            Self::Tag => of(points, "tag", Kind::I64, 1),
            Self::Worker => of(cells, "worker", Kind::I32, 1),
            Self::Region => of(cells, "region", Kind::I64, 1),
            Self::Marker => of(cells, "marker", Kind::I64, 1),
            Self::Attribute => of(cells, "attribute", Kind::F64, 1),
        }
    }

    /// Its rows of a part.
    fn rows(self, sizes: PartSizes) -> u64 {
        let PartSizes { points, tets, faces } = sizes;
        match self {
            Self::NumberOfPoints | Self::NumberOfCells | Self::NumberOfConnectivityIds => 1,
            Self::Points | Self::Given | Self::Owner | Self::Tag => points,
            Self::Connectivity => 4 * tets + 3 * faces,
            Self::Offsets => tets + faces + 1,
            Self::Types | Self::Worker | Self::Region | Self::Marker | Self::Attribute => {
                tets + faces
            }
        }
    }
}

/// A file of several parts, whose sizes are known.
#[derive(Clone, Debug)]
pub struct Slabs {
    parts: Vec<PartSizes>,
    columns: Vec<Column>,
    head: Head,
}

impl Slabs {
    /// A file of parts of these sizes, which all have these arrays.
    pub fn new(parts: Vec<PartSizes>, arrays: Arrays) -> Self {
        let Arrays { tags, regions, markers, attributes } = arrays;
        let more = [
            (Column::Tag, tags),
            (Column::Region, regions),
            (Column::Marker, markers),
            (Column::Attribute, attributes),
        ];
        let more = more.into_iter().filter(|(_, is_there)| *is_there).map(|(column, _)| column);
        let mut columns: Vec<Column> = ALWAYS.into_iter().chain(more).collect();
        // Columns of a group stand together.
        columns.sort_by_key(|column| column.described().group.map(|group| group == "CellData"));
        let rows = |column: Column| parts.iter().map(|&own| column.rows(own)).sum();
        let dataset = |&column: &Column| Dataset { rows: rows(column), ..column.described() };
        let datasets: Vec<Dataset> = columns.iter().map(dataset).collect();
        let attributes =
            [hdf5::integers("Version", &[2, 0]), hdf5::text("Type", "UnstructuredGrid")];
        let head = hdf5::head("VTKHDF", &attributes, &datasets);
        Self { parts, columns, head }
    }

    /// Bytes of the file.
    pub(crate) fn length(&self) -> u64 {
        self.head.length
    }

    /// Writes what is before the numbers.
    pub(crate) fn write_head(&self, out: &mut dyn Write) -> Result<()> {
        out.write_all(&self.head.bytes)
    }

    /// Writes the whole file, by who has all parts.
    ///
    /// # Errors
    /// Those of `out`.
    pub(crate) fn write(
        &self,
        out: &mut dyn Write,
        pieces: &[Piece],
        borders: &[Border],
    ) -> Result<()> {
        self.write_head(out)?;
        let mut at = self.head.bytes.len() as u64;
        for (&column, &place) in self.columns.iter().zip(&self.head.places) {
            std::io::copy(&mut std::io::repeat(0).take(place - at), out)?;
            at = place;
            for (part, (piece, border)) in pieces.iter().zip(borders).enumerate() {
                put(out, column, part, Own { piece, border })?;
                at += self.bytes(column, part);
            }
        }
        Ok(())
    }

    /// Writes the slabs of a part into a file whose head is written.
    ///
    /// # Errors
    /// Those of `out`.
    pub(crate) fn write_slabs(
        &self,
        out: &mut (impl Write + Seek),
        part: usize,
        piece: &Piece,
        border: &Border,
    ) -> Result<()> {
        for (&column, &place) in self.columns.iter().zip(&self.head.places) {
            let before: u64 = (0..part).map(|part| self.bytes(column, part)).sum();
            out.seek(SeekFrom::Start(place + before))?;
            put(out, column, part, Own { piece, border })?;
        }
        out.flush()
    }

    /// Bytes of a column of a part.
    fn bytes(&self, column: Column, part: usize) -> u64 {
        let row = column.described();
        column.rows(self.parts[part]) * row.columns * row.kind.bytes()
    }
}

/// A part, and what it has in common with others.
#[derive(Clone, Copy)]
struct Own<'a> {
    piece: &'a Piece,
    border: &'a Border,
}

/// Writes the rows of a part of a column.
fn put(
    out: &mut dyn Write,
    column: Column,
    part: usize,
    Own { piece, border }: Own<'_>,
) -> Result<()> {
    let mesh = &piece.mesh;
    let (points, tets, faces) = (mesh.points.len(), mesh.tets.len(), mesh.faces.len());
    let (cells, ids) = (tets + faces, 4 * tets + 3 * faces);
    let of = |cell: usize| if cell < tets { cell } else { mesh.faces[cell - tets].tet };
    let whole = |out: &mut dyn Write, count: usize, value: &(dyn Fn(usize) -> i64 + Sync)| {
        write_rows(out, count, |i, row| row.extend(value(i).to_le_bytes()))
    };
    let number = |value: usize| (value as i64).to_le_bytes();
    match column {
        Column::NumberOfPoints => out.write_all(&number(points)),
        Column::NumberOfCells => out.write_all(&number(cells)),
        Column::NumberOfConnectivityIds => out.write_all(&number(ids)),
        Column::Points => write_rows(out, points, |i, row| {
            mesh.points[i].iter().for_each(|c| row.extend(c.to_le_bytes()));
        }),
        Column::Connectivity => write_rows(out, cells, |i, row| {
            let corners: &[u32] = match mesh.tets.get(i) {
                Some(tet) => tet,
                None => &mesh.faces[i - tets].corners,
            };
            corners.iter().for_each(|&v| row.extend(i64::from(v).to_le_bytes()));
        }),
        Column::Offsets => {
            whole(out, cells + 1, &|i| (4 * i.min(tets) + 3 * i.saturating_sub(tets)) as i64)
        }
        Column::Types => write_rows(out, cells, |i, row| {
            row.push(if i < tets { TETRAHEDRON } else { TRIANGLE });
        }),
        Column::Given => whole(out, points, &|i| piece.numbers[i].into()),
        Column::Owner => {
            let owners = border.owners(part as u32, points);
            write_rows(out, points, |i, row| row.extend(owners[i].to_le_bytes()))
        }
        Column::Tag => {
            let tags = mesh.point_tags.as_deref().unwrap_or_default();
            whole(out, tags.len(), &|i| tags[i])
        }
        Column::Worker => write_rows(out, cells, |_, row| row.extend((part as i32).to_le_bytes())),
        Column::Region => {
            let tags = mesh.tet_tags.as_deref().unwrap_or_default();
            whole(out, cells, &|i| tags[of(i)])
        }
        Column::Marker => {
            whole(out, cells, &|i| if i < tets { 0 } else { mesh.faces[i - tets].marker })
        }
        Column::Attribute => {
            let values = mesh.tet_attributes.as_deref().unwrap_or_default();
            write_rows(out, cells, |i, row| row.extend(values[of(i)].to_le_bytes()))
        }
    }
}
