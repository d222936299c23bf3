//! Arrays of a mesh: made when they are first asked for, kept until it is freed.

use crate::error::text;
use crate::handle::Mesh;
use std::ffi::{CString, c_char};
use std::sync::{OnceLock, PoisonError};

/// An array of the mesh, made once; a panic on the way makes none.
fn array<'m, T>(mesh: &'m Mesh, place: &'m OnceLock<T>, make: impl FnOnce() -> T) -> Option<&'m T> {
    let _making = mesh.making.lock().unwrap_or_else(PoisonError::into_inner);
    let made = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| place.get_or_init(make)));
    made.ok()
}

/// Hands out an array and its length.
///
/// # Safety
/// `count` is null or a place for a number.
unsafe fn hand_out<T>(array: Option<&[T]>, count: *mut usize) -> *const T {
    // SAFETY: as the caller promises.
    if let Some(count) = unsafe { count.as_mut() } {
        *count = array.map_or(0, <[T]>::len);
    }
    array.map_or(std::ptr::null(), <[T]>::as_ptr)
}

/// Coordinates of the vertices, three each; their number goes to `count`.
///
/// # Safety
/// The mesh is null or one of this library; `count` is null or a place for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_points(mesh: *const Mesh, count: *mut usize) -> *const f64 {
    // SAFETY: as the caller promises.
    let mesh = unsafe { mesh.as_ref() };
    let rows = mesh.and_then(|m| array(m, &m.arrays.points, || m.meshed.points()));
    // SAFETY: as the caller promises.
    unsafe { hand_out(rows.map(Vec::as_slice), count) }.cast()
}

/// Corners of the tetrahedra, four each; their number goes to `count`.
///
/// # Safety
/// The mesh is null or one of this library; `count` is null or a place for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_tets(mesh: *const Mesh, count: *mut usize) -> *const u32 {
    // SAFETY: as the caller promises.
    let mesh = unsafe { mesh.as_ref() };
    let rows = mesh.and_then(|m| array(m, &m.arrays.tets, || m.meshed.tets()));
    // SAFETY: as the caller promises.
    unsafe { hand_out(rows.map(Vec::as_slice), count) }.cast()
}

/// Across the face opposite each corner the tetrahedron there, or `UINT32_MAX`; the number of rows
/// goes to `count`.
///
/// # Safety
/// The mesh is null or one of this library; `count` is null or a place for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_neighbours(mesh: *const Mesh, count: *mut usize) -> *const u32 {
    // SAFETY: as the caller promises.
    let mesh = unsafe { mesh.as_ref() };
    let rows = mesh.and_then(|m| array(m, &m.arrays.neighbours, || m.meshed.neighbours()));
    // SAFETY: as the caller promises.
    unsafe { hand_out(rows.map(Vec::as_slice), count) }.cast()
}

/// Facets of the convex hull of all vertices, three corners each, counterclockwise from outside.
///
/// # Safety
/// The mesh is null or one of this library; `count` is null or a place for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_hull(mesh: *const Mesh, count: *mut usize) -> *const u32 {
    // SAFETY: as the caller promises.
    let mesh = unsafe { mesh.as_ref() };
    let rows = mesh.and_then(|m| array(m, &m.arrays.hull, || m.meshed.hull()));
    // SAFETY: as the caller promises.
    unsafe { hand_out(rows.map(Vec::as_slice), count) }.cast()
}

fn boundary(mesh: &Mesh) -> Option<&(Vec<[u32; 3]>, Vec<i64>)> {
    array(mesh, &mesh.arrays.boundary, || {
        let faces = mesh.meshed.boundary();
        (faces.iter().map(|f| f.corners).collect(), faces.iter().map(|f| f.marker).collect())
    })
}

/// Boundary triangles of a domain, three corners each, counterclockwise from outside.
///
/// # Safety
/// The mesh is null or one of this library; `count` is null or a place for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_boundary(mesh: *const Mesh, count: *mut usize) -> *const u32 {
    // SAFETY: as the caller promises.
    let rows = unsafe { mesh.as_ref() }.and_then(boundary);
    // SAFETY: as the caller promises.
    unsafe { hand_out(rows.map(|(rows, _)| rows.as_slice()), count) }.cast()
}

/// The markers of the facets that the boundary triangles are part of.
///
/// # Safety
/// The mesh is null or one of this library; `count` is null or a place for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_boundary_markers(
    mesh: *const Mesh,
    count: *mut usize,
) -> *const i64 {
    // SAFETY: as the caller promises.
    let rows = unsafe { mesh.as_ref() }.and_then(boundary);
    // SAFETY: as the caller promises.
    unsafe { hand_out(rows.map(|(_, markers)| markers.as_slice()), count) }
}

/// The region of each tetrahedron, from 1.
///
/// # Safety
/// The mesh is null or one of this library; `count` is null or a place for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_regions(mesh: *const Mesh, count: *mut usize) -> *const u32 {
    // SAFETY: as the caller promises.
    let mesh = unsafe { mesh.as_ref() };
    let rows = mesh.and_then(|m| array(m, &m.arrays.regions, || m.meshed.regions()));
    // SAFETY: as the caller promises.
    unsafe { hand_out(rows.map(Vec::as_slice), count) }
}

fn excuses(mesh: &Mesh) -> Option<&(Vec<u32>, Vec<CString>)> {
    array(mesh, &mesh.arrays.excuses, || {
        let all = mesh.meshed.excuses();
        (all.iter().map(|e| e.0).collect(), all.iter().map(|e| text(&e.1)).collect())
    })
}

/// The tetrahedra over a bound.
///
/// # Safety
/// The mesh is null or one of this library; `count` is null or a place for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_excused(mesh: *const Mesh, count: *mut usize) -> *const u32 {
    // SAFETY: as the caller promises.
    let rows = unsafe { mesh.as_ref() }.and_then(excuses);
    // SAFETY: as the caller promises.
    unsafe { hand_out(rows.map(|(tets, _)| tets.as_slice()), count) }
}

/// The reason why the `number`-th of them is; NULL where there is none.
///
/// # Safety
/// The mesh is null or one of this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_excuse(mesh: *const Mesh, number: usize) -> *const c_char {
    // SAFETY: as the caller promises.
    let rows = unsafe { mesh.as_ref() }.and_then(excuses);
    let reason = rows.and_then(|(_, reasons)| reasons.get(number));
    reason.map_or(std::ptr::null(), |reason| reason.as_ptr())
}

/// The certificate as JSON: of points made anew, of a domain the one that came with the mesh; NULL
/// if the mesh was not checked.
///
/// # Safety
/// The mesh is null or one of this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_certificate(mesh: *const Mesh) -> *const c_char {
    // SAFETY: as the caller promises.
    let mesh = unsafe { mesh.as_ref() };
    let made = mesh.and_then(|m| {
        let make = || m.meshed.certify(false).ok().flatten().map(|json| text(&json));
        array(m, &m.arrays.certificate, make)
    });
    made.and_then(Option::as_ref).map_or(std::ptr::null(), |text| text.as_ptr())
}
