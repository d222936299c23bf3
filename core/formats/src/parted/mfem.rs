//! MFEM's meshes in parts: `m.000000`, `m.000001` and so on, which `mfem::ParMesh` reads, each
//! process its own.
//!
//! A file is a mesh of its own, version 1.2 in text, and after it the groups of processes that
//! have something in common: vertices, edges and faces of each group, in one order at all of its
//! members. Attributes are regions, or 1; those of the boundary are markers, or 1 on the hull if
//! there is none. They have to be positive: where there is a marker 0 all are one more.
//! Source: the page on mesh formats of MFEM's documentation.

use super::border::{Border, Common};
use super::files::{PartOf, Piece};
use crate::error::DataError;
use crate::text::{push_integer, push_point, write_rows};
use std::collections::BTreeMap;
use std::io::{Result, Write};

/// MFEM's numbers for a triangle and a tetrahedron.
const TRIANGLE: u32 = 2;
const TETRAHEDRON: u32 = 4;

/// Vertices, edges and faces of a group, by their places in the lists of the border.
#[derive(Default)]
struct Group {
    vertices: Vec<usize>,
    edges: Vec<usize>,
    faces: Vec<usize>,
}

/// Checks that regions and markers can be attributes.
pub(crate) fn check(border: &Border) -> std::result::Result<(), DataError> {
    let is_attribute = |&value: &i64| (1..=i64::from(i32::MAX)).contains(&value);
    let is_marker = |&value: &i64| (0..i64::from(i32::MAX)).contains(&value);
    let regions = border.regions.iter().find(|region| !is_attribute(region));
    let markers = border.markers.iter().find(|marker| !is_marker(marker));
    match (regions, markers) {
        (None, None) => Ok(()),
        (Some(&value), _) => Err(DataError::Attributes { what: "region", value }),
        (_, Some(&value)) => Err(DataError::Attributes { what: "marker", value }),
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
    place: PartOf,
) -> Result<()> {
    let mesh = &piece.mesh;
    writeln!(out, "MFEM mesh v1.2\n\ndimension\n3\n\nelements\n{}", mesh.tets.len())?;
    let regions = mesh.tet_tags.as_deref();
    write_rows(out, mesh.tets.len(), |t, row| {
        let region = regions.map_or(1, |regions| regions[t]);
        integers(row, &[region, TETRAHEDRON.into()]);
        corners(row, &mesh.tets[t]);
    })?;
    let (faces, hull) = match border.markers.is_empty() {
        true => (&[][..], border.hull.as_slice()),
        false => (mesh.faces.as_slice(), &[][..]),
    };
    let shift = i64::from(border.markers.contains(&0));
    writeln!(out, "\nboundary\n{}", faces.len() + hull.len())?;
    write_rows(out, faces.len(), |f, row| {
        integers(row, &[faces[f].marker + shift, TRIANGLE.into()]);
        corners(row, &faces[f].corners);
    })?;
    write_rows(out, hull.len(), |f, row| {
        integers(row, &[1, TRIANGLE.into()]);
        corners(row, &hull[f]);
    })?;
    writeln!(out, "\nvertices\n{}\n3", mesh.points.len())?;
    write_rows(out, mesh.points.len(), |v, row| {
        push_point(row, &mesh.points[v], b' ');
        row.push(b'\n');
    })?;
    out.write_all(b"\nmfem_serial_mesh_end\n")?;
    groups(out, border, place)?;
    out.write_all(b"\nmfem_mesh_end\n")
}

/// The groups of parts that have something in common.
fn groups(out: &mut dyn Write, border: &Border, place: PartOf) -> Result<()> {
    let mut groups: BTreeMap<&[u32], Group> = BTreeMap::new();
    sorted(&border.vertices, &mut groups, |group| &mut group.vertices);
    sorted(&border.edges, &mut groups, |group| &mut group.edges);
    sorted(&border.faces, &mut groups, |group| &mut group.faces);
    let count = groups.len() + 1;
    writeln!(out, "\ncommunication_groups\nnumber_of_groups {count}\n\n1 {}", place.part)?;
    for parts in groups.keys() {
        let parts: Vec<String> = parts.iter().map(u32::to_string).collect();
        writeln!(out, "{} {}", parts.len(), parts.join(" "))?;
    }
    let [vertices, edges, faces] = [border.vertices.len(), border.edges.len(), border.faces.len()];
    writeln!(out, "\ntotal_shared_vertices {vertices}\ntotal_shared_edges {edges}")?;
    writeln!(out, "total_shared_faces {faces}")?;
    for (number, group) in (1..).zip(groups.values()) {
        let Group { vertices, edges, faces } = group;
        writeln!(out, "\n# group {number}\nshared_vertices {}", vertices.len())?;
        rows(out, vertices, &border.vertices, &[])?;
        writeln!(out, "\nshared_edges {}", edges.len())?;
        rows(out, edges, &border.edges, &[])?;
        writeln!(out, "\nshared_faces {}", faces.len())?;
        rows(out, faces, &border.faces, &[TRIANGLE.into()])?;
    }
    Ok(())
}

/// Sorts what parts have in common into the groups of these parts.
fn sorted<'a, const N: usize>(
    all: &'a [Common<N>],
    groups: &mut BTreeMap<&'a [u32], Group>,
    list: impl Fn(&mut Group) -> &mut Vec<usize>,
) {
    for (place, common) in all.iter().enumerate() {
        list(groups.entry(&common.parts).or_default()).push(place);
    }
}

/// Some of what parts have in common, each in a line after these numbers.
fn rows<const N: usize>(
    out: &mut dyn Write,
    places: &[usize],
    all: &[Common<N>],
    before: &[i64],
) -> Result<()> {
    write_rows(out, places.len(), |k, row| {
        integers(row, before);
        corners(row, &all[places[k]].corners);
    })
}

/// Integers, each with a blank after it.
fn integers(row: &mut Vec<u8>, values: &[i64]) {
    for &value in values {
        push_integer(row, value);
        row.push(b' ');
    }
}

/// Corners, to the end of the line.
fn corners(row: &mut Vec<u8>, corners: &[u32]) {
    for (k, &corner) in corners.iter().enumerate() {
        push_integer(row, corner.into());
        row.push(if k + 1 == corners.len() { b'\n' } else { b' ' });
    }
}
