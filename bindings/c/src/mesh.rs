//! Meshes: made, asked, written, freed.

use crate::error::{Status, guarded, null};
use crate::handle::{Arrays, Mesh};
use crate::input::{Asked, Function, Points, Surface, Wishes, path, points, values};
use crate::run::Run;
use crate::sized::Growing;
use ltbw_bindings::{Class, Failure, Meshed, Ready, Reins, Source};
use std::ffi::c_char;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// The state in which the work ended.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The mesh has all points.
    LTBW_COMPLETE = 0,
    /// The mesh of a domain meets every bound.
    LTBW_MET = 1,
    /// Some tetrahedra are over a bound, each with a reason: input angles are too small. `verdict`
    /// in the certificate says `excused` where they are few, `failed` where they are not.
    LTBW_EXCUSED = 2,
    /// The budget of points was used up first.
    LTBW_BUDGET = 3,
    /// The progress function ended the work: the mesh so far.
    LTBW_STOPPED = 4,
}

/// Hands a mesh over.
///
/// # Safety
/// `out` is null or a place for a pointer.
unsafe fn give(out: *mut *mut Mesh, meshed: Meshed) -> Result<(), Failure> {
    let mesh = Mesh { meshed, arrays: Arrays::default(), making: Mutex::new(()) };
    // SAFETY: as the caller promises.
    let out = unsafe { out.as_mut() }.ok_or_else(|| null("out"))?;
    *out = Box::into_raw(Box::new(mesh));
    Ok(())
}

/// Empties the place of a mesh, so that nobody frees what was not made.
///
/// # Safety
/// `out` is null or a place for a pointer.
unsafe fn clear(out: *mut *mut Mesh) -> Result<(), Failure> {
    // SAFETY: as the caller promises.
    *unsafe { out.as_mut() }.ok_or_else(|| null("out"))? = std::ptr::null_mut();
    Ok(())
}

/// The Delaunay mesh of `count` points, three coordinates each.
///
/// # Safety
/// Pointers as at the head of the crate; `run` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_delaunay(
    coordinates: *const f64,
    count: usize,
    run: *const Run,
    out: *mut *mut Mesh,
) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises.
        unsafe { clear(out) }?;
        // SAFETY: as the caller promises.
        let given = unsafe { points(coordinates, count, "points") }?;
        // SAFETY: as the caller promises.
        let run = unsafe { Run::of(run) }?;
        let threads = run.threads;
        let meshed = run.supervise(|reins| ltbw_bindings::delaunay(given, &[], threads, reins))?;
        // SAFETY: as the caller promises.
        unsafe { give(out, meshed) }
    })
}

/// The Delaunay mesh of points without those of them that are named: the mesh of the others. All
/// keep their numbers; those removed are in no tetrahedron. Duplicates go with their vertex.
///
/// # Safety
/// Pointers as at the head of the crate; `run` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_delaunay_without(
    given: *const Points,
    run: *const Run,
    out: *mut *mut Mesh,
) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises.
        unsafe { clear(out) }?;
        // SAFETY: as the caller promises.
        let given = unsafe { Points::given(given) }?.ok_or_else(|| null("points"))?;
        // SAFETY: as the caller promises.
        let without = unsafe { values(given.without, given.without_count, "without") }?;
        // SAFETY: as the caller promises.
        let points = unsafe { points(given.coordinates, given.count, "points") }?;
        // SAFETY: as the caller promises.
        let run = unsafe { Run::of(run) }?;
        let threads = run.threads;
        let without = without.to_vec();
        let work = |reins: &Reins| ltbw_bindings::delaunay(points, &without, threads, reins);
        let meshed = run.supervise(work)?;
        // SAFETY: as the caller promises.
        unsafe { give(out, meshed) }
    })
}

/// A conforming Delaunay mesh of the domain that a surface bounds.
///
/// # Safety
/// Pointers as at the head of the crate; `wishes` and `run` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_tetrahedralize(
    surface: *const Surface,
    wishes: *const Wishes,
    run: *const Run,
    out: *mut *mut Mesh,
) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises.
        unsafe { clear(out) }?;
        // SAFETY: as the caller promises.
        let source = unsafe { Surface::source(surface) }?;
        // SAFETY: as the caller promises.
        let (asked, run) = (unsafe { Wishes::asked(wishes) }?, unsafe { Run::of(run) }?);
        // SAFETY: as the caller promises.
        unsafe { give(out, tetrahedralized(source, &asked, run)?) }
    })
}

/// A conforming Delaunay mesh of the domain in a file: `.poly .smesh .off .obj .stl .ply
/// .vtk`.
///
/// # Safety
/// Pointers as at the head of the crate; `wishes` and `run` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_tetrahedralize_file(
    file: *const c_char,
    wishes: *const Wishes,
    run: *const Run,
    out: *mut *mut Mesh,
) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises.
        unsafe { clear(out) }?;
        // SAFETY: as the caller promises.
        let source = Source::File(unsafe { path(file) }?);
        // SAFETY: as the caller promises.
        let (asked, run) = (unsafe { Wishes::asked(wishes) }?, unsafe { Run::of(run) }?);
        // SAFETY: as the caller promises.
        unsafe { give(out, tetrahedralized(source, &asked, run)?) }
    })
}

fn tetrahedralized(source: Source, asked: &Asked, run: Run) -> Result<Meshed, Failure> {
    let wishes = &asked.wishes;
    let Some(size) = asked.size else {
        let (edge_length, threads) = (asked.edge_length, run.threads);
        return run.supervise(move |reins| {
            ltbw_bindings::in_pool(threads, || {
                let ready = Ready::new(source, wishes)?;
                let constant = move |_| edge_length.unwrap_or(f64::INFINITY);
                let field: Option<&ltbw_bindings::Field<'_>> =
                    if edge_length.is_some() { Some(&constant) } else { None };
                let refined = ready.refine(wishes, field, false, &reins.progress, &reins.cancel)?;
                ready.finish(wishes, refined)
            })
        });
    };
    // The function is called by this thread, and by no other.
    let ready = ltbw_bindings::in_pool(run.threads, || Ready::new(source, wishes))?;
    let reins = Reins::default();
    let function = Function {
        size,
        context: asked.context,
        offset: ready.offset(),
        run,
        reins: &reins,
        caller: std::thread::current().id(),
        looked: Mutex::new(Instant::now()),
        failure: Mutex::new(None),
    };
    let field = |p| function.at(p);
    let refined = ready.refine(wishes, Some(&field), true, &reins.progress, &reins.cancel);
    if let Some(failure) = function.failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(failure);
    }
    let refined = refined?;
    ltbw_bindings::in_pool(run.threads, || ready.finish(wishes, refined))
}

/// Frees a mesh and all its arrays; NULL is nothing to free.
///
/// # Safety
/// The mesh is null, or comes from this library and was not freed yet.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_free(mesh: *mut Mesh) {
    if !mesh.is_null() {
        // SAFETY: as the caller promises, `Box::into_raw` made it and nobody freed it.
        drop(unsafe { Box::from_raw(mesh) });
    }
}

/// The state in which the work ended.
///
/// # Safety
/// The mesh is one of this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_outcome(mesh: *const Mesh) -> Outcome {
    use ltbw_bindings::Outcome as Own;
    // SAFETY: as the caller promises.
    match unsafe { mesh.as_ref() }.map(|mesh| mesh.meshed.outcome) {
        Some(Own::Complete) => Outcome::LTBW_COMPLETE,
        Some(Own::Met) => Outcome::LTBW_MET,
        Some(Own::Excused) => Outcome::LTBW_EXCUSED,
        Some(Own::Budget) => Outcome::LTBW_BUDGET,
        Some(Own::Cancelled) | None => Outcome::LTBW_STOPPED,
    }
}

/// The place that the mesh's coordinates are relative to: zeros, but of a domain far from the
/// origin in a frame that is not its own. Three numbers go to `offset`.
///
/// # Safety
/// The mesh is one of this library; `offset` has room for three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_offset(mesh: *const Mesh, offset: *mut f64) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises.
        let mesh = unsafe { mesh.as_ref() }.ok_or_else(|| null("mesh"))?;
        if offset.is_null() {
            return Err(null("offset"));
        }
        for (k, x) in mesh.meshed.offset().into_iter().enumerate() {
            // SAFETY: `offset` has room for three numbers, as the caller promises.
            unsafe { offset.add(k).write(x) };
        }
        Ok(())
    })
}

/// For each of `count` points, in the mesh's coordinates, a tetrahedron that holds it, or
/// `UINT32_MAX`: goes to `found`.
///
/// # Safety
/// Pointers as at the head of the crate; `found` has room for `count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_find(
    mesh: *const Mesh,
    coordinates: *const f64,
    count: usize,
    found: *mut u32,
) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises.
        let mesh = unsafe { mesh.as_ref() }.ok_or_else(|| null("mesh"))?;
        // SAFETY: as the caller promises.
        let places = unsafe { points(coordinates, count, "points") }?;
        if count > 0 && found.is_null() {
            return Err(null("found"));
        }
        let places = mesh.meshed.find(&places, &Reins::default().cancel)?;
        for (k, place) in places.into_iter().enumerate() {
            // SAFETY: `found` has room for `count` numbers, as the caller promises.
            unsafe { found.add(k).write(place) };
        }
        Ok(())
    })
}

/// The canonical hash `ltbw.mesh/1`: 64 hexadecimal digits and a zero go to `hash`.
///
/// # Safety
/// The mesh is one of this library; `hash` has room for 65 characters.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_hash(mesh: *const Mesh, hash: *mut c_char) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises.
        let mesh = unsafe { mesh.as_ref() }.ok_or_else(|| null("mesh"))?;
        if hash.is_null() {
            return Err(null("hash"));
        }
        let text = mesh.meshed.hash()?;
        if text.len() != 64 {
            return Err(Failure::new(Class::Internal, "internal.hash", text));
        }
        for (k, letter) in text.bytes().chain([0]).enumerate() {
            // SAFETY: `hash` has room for 65 characters, as the caller promises.
            unsafe { hash.add(k).write(letter as c_char) };
        }
        Ok(())
    })
}

/// Writes the mesh; the extension tells the format: `.vtu .vtk .msh .mesh .ele`.
///
/// # Safety
/// Pointers as at the head of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_mesh_save(mesh: *const Mesh, file: *const c_char) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises.
        let mesh = unsafe { mesh.as_ref() }.ok_or_else(|| null("mesh"))?;
        // SAFETY: as the caller promises.
        mesh.meshed.save(&unsafe { path(file) }?, &Reins::default().cancel)
    })
}
