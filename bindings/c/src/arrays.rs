//! Arrays of a mesh: made when they are first asked for, kept until it is freed.

use crate::error::{failed, null, text};
use crate::handle::Mesh;
use ltbw_bindings::{Failure, Meshed, unpanicked};
use std::ffi::{CString, c_char};
use std::sync::{OnceLock, PoisonError};

/// A list that a mesh keeps, made once. A failure or a panic on the way makes none, and is told as
/// the thread's last failure; so is a mesh that is null.
///
/// # Safety
/// The mesh is null or one of this library.
unsafe fn kept<'m, T: 'm>(
    mesh: *const Mesh,
    place: impl FnOnce(&'m Mesh) -> &'m OnceLock<T>,
    make: impl FnOnce(&'m Meshed) -> Result<T, Failure>,
) -> Option<&'m T> {
    // SAFETY: as the caller promises.
    let mesh = unsafe { mesh.as_ref() }.ok_or_else(|| null("mesh"));
    let kept = mesh.and_then(|mesh| {
        let place = place(mesh);
        let _making = mesh.making.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(there) = place.get() {
            return Ok(there);
        }
        let made = unpanicked(|| make(&mesh.meshed))?;
        Ok(place.get_or_init(|| made))
    });
    kept.map_err(|failure| failed(&failure)).ok()
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
    let rows = unsafe { kept(mesh, |m| &m.arrays.points, |m| Ok(m.points())) };
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
    let rows = unsafe { kept(mesh, |m| &m.arrays.tets, |m| Ok(m.tets())) };
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
    let rows = unsafe { kept(mesh, |m| &m.arrays.neighbours, |m| Ok(m.neighbours())) };
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
    let rows = unsafe { kept(mesh, |m| &m.arrays.hull, |m| Ok(m.hull())) };
    // SAFETY: as the caller promises.
    unsafe { hand_out(rows.map(Vec::as_slice), count) }.cast()
}

/// Boundary triangles and their markers.
///
/// # Safety
/// As [`kept`].
unsafe fn boundary<'m>(mesh: *const Mesh) -> Option<&'m (Vec<[u32; 3]>, Vec<i64>)> {
    let make = |m: &Meshed| {
        let faces = m.boundary();
        Ok((faces.iter().map(|f| f.corners).collect(), faces.iter().map(|f| f.marker).collect()))
    };
    // SAFETY: as the caller promises.
    unsafe { kept(mesh, |m| &m.arrays.boundary, make) }
}

/// Boundary triangles of a domain, three corners each, counterclockwise from outside.
///
/// # Safety
/// The mesh is null or one of this library; `count` is null or a place for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_boundary(mesh: *const Mesh, count: *mut usize) -> *const u32 {
    // SAFETY: as the caller promises.
    let rows = unsafe { boundary(mesh) };
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
    let rows = unsafe { boundary(mesh) };
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
    let rows = unsafe { kept(mesh, |m| &m.arrays.regions, |m| Ok(m.regions())) };
    // SAFETY: as the caller promises.
    unsafe { hand_out(rows.map(Vec::as_slice), count) }
}

/// Tetrahedra over a bound and their reasons.
///
/// # Safety
/// As [`kept`].
unsafe fn excuses<'m>(mesh: *const Mesh) -> Option<&'m (Vec<u32>, Vec<CString>)> {
    let make = |m: &Meshed| {
        let all = m.excuses();
        Ok((all.iter().map(|e| e.tet).collect(), all.iter().map(|e| text(&e.reason)).collect()))
    };
    // SAFETY: as the caller promises.
    unsafe { kept(mesh, |m| &m.arrays.excuses, make) }
}

/// The tetrahedra over a bound.
///
/// # Safety
/// The mesh is null or one of this library; `count` is null or a place for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_excused(mesh: *const Mesh, count: *mut usize) -> *const u32 {
    // SAFETY: as the caller promises.
    let rows = unsafe { excuses(mesh) };
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
    let rows = unsafe { excuses(mesh) };
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
    let make = |m: &Meshed| Ok(m.certify(false)?.map(|json| text(&json)));
    // SAFETY: as the caller promises.
    let made = unsafe { kept(mesh, |m| &m.arrays.certificate, make) };
    made.and_then(Option::as_ref).map_or(std::ptr::null(), |text| text.as_ptr())
}

/// The `number`-th of the notes on how the mesh came about, for people to read: repairs of its
/// domain, say, or points that are nearly in one plane; NULL where there is none.
///
/// # Safety
/// The mesh is null or one of this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_note(mesh: *const Mesh, number: usize) -> *const c_char {
    let make = |m: &Meshed| Ok(m.notes.iter().map(|note| text(note)).collect());
    // SAFETY: as the caller promises.
    let notes: Option<&Vec<CString>> = unsafe { kept(mesh, |m| &m.arrays.notes, make) };
    let note = notes.and_then(|notes| notes.get(number));
    note.map_or(std::ptr::null(), |note| note.as_ptr())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ltbw_delaunay, ltbw_last_error, ltbw_last_error_code, ltbw_mesh_free};
    use std::ffi::CStr;

    fn last() -> [String; 2] {
        // SAFETY: both are texts that live until this thread's next failure.
        [ltbw_last_error(), ltbw_last_error_code()]
            .map(|text| unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned())
    }

    #[test]
    fn what_cannot_be_made_is_told_and_made_when_it_can_be() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut mesh = std::ptr::null_mut();
        // SAFETY: four points, and a place for the mesh, which is freed once below.
        unsafe { ltbw_delaunay(points.as_ptr().cast(), 4, std::ptr::null(), &raw mut mesh) };
        // SAFETY: the mesh was made by this library.
        let panicked = unsafe { kept(mesh, |m| &m.arrays.regions, |_| panic!("halfway")) };
        assert_eq!(panicked, None);
        assert_eq!(last(), ["a defect of ltbw: halfway", "internal.panic"]);
        let failing = |_: &Meshed| Err(null("nothing"));
        // SAFETY: as above.
        assert_eq!(unsafe { kept(mesh, |m| &m.arrays.regions, failing) }, None);
        assert_eq!(last(), ["nothing is NULL", "argument.null"]);
        // SAFETY: as above.
        let made = unsafe { kept(mesh, |m| &m.arrays.regions, |m| Ok(m.regions())) };
        assert_eq!(made, Some(&vec![1]));
        // SAFETY: as above, and a mesh that is null is none.
        unsafe { ltbw_mesh_free(mesh) };
        let mut count = 7;
        // SAFETY: the mesh is null, and `count` is a place for a number.
        let none = unsafe { ltbw_mesh_regions(std::ptr::null(), &raw mut count) };
        assert!(none.is_null() && count == 0);
        assert_eq!(last(), ["mesh is NULL", "argument.null"]);
    }
}
