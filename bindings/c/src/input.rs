//! Points, surfaces and bounds, as C has them.

use crate::error::null;
use crate::run::Run;
use crate::sized::Growing;
use kernel::Point;
use ltbw_bindings::{Class, Failure, Frame, Holes, Reins, Source};
use std::ffi::{CStr, c_char, c_void};
use std::mem::offset_of;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::thread::ThreadId;
use std::time::Instant;

/// Points, and those of them that are removed again.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Points {
    /// Size of the struct, `sizeof` it: `ltbw_points_new` sets it.
    pub struct_size: u32,
    /// Coordinates: three for each point.
    pub coordinates: *const f64,
    /// Number of points.
    pub count: usize,
    /// Numbers of points that are removed from the mesh, or NULL.
    pub without: *const u32,
    /// Number of them.
    pub without_count: usize,
}

/// A surface: polygons over vertices, turned outward.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Size of the struct, `sizeof` it: `ltbw_surface_new` sets it.
    pub struct_size: u32,
    /// Coordinates: three for each vertex.
    pub vertices: *const f64,
    /// Number of vertices.
    pub vertex_count: usize,
    /// Corners of all faces, one face after the other.
    pub corners: *const u32,
    /// The number of corners of each face; NULL: three each.
    pub corner_counts: *const u32,
    /// Number of faces.
    pub face_count: usize,
    /// A marker for each face, or NULL.
    pub markers: *const i32,
}

/// A region with properties of its own. It does not grow: what regions may have one day comes
/// beside.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Region {
    /// A point inside.
    pub seed: [f64; 3],
    /// Its attribute.
    pub attribute: f64,
    /// The largest volume of its tetrahedra; 0: no bound of its own.
    pub max_volume: f64,
}

/// A wanted edge length at a place. It is called by the calling thread, has to give the same answer
/// for the same place, and positive ones.
pub type Size = Option<extern "C" fn(context: *mut c_void, place: *const f64) -> f64>;

/// The bounds that a mesh has to meet. All zero but its size: any shape, any size.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Wishes {
    /// Size of the struct, `sizeof` it: `ltbw_wishes_new` sets it.
    pub struct_size: u32,
    /// The largest volume; 0: no bound.
    pub max_volume: f64,
    /// The largest circumradius to shortest edge; 0: no bound. 2 is the usual one.
    pub radius_edge: f64,
    /// A usual edge length for all places; 0: none.
    pub edge_length: f64,
    /// A usual edge length as a function of the place, or NULL.
    pub size: Size,
    /// Handed to the size function.
    pub context: *mut c_void,
    /// The most points to insert; 0: as many as is usual.
    pub max_points: u64,
    /// A point in each void, three coordinates each; orientation means nothing then. NULL:
    /// `hole_rule` says what is void.
    pub holes: *const f64,
    /// Number of holes.
    pub hole_count: usize,
    /// The rule of voids where `holes` is NULL. 0: hole points of a file, and what the surface's
    /// orientation says: a body inside another is a void if its faces point the other way. 1:
    /// nothing. 2: bodies inside others, however turned.
    pub hole_rule: i32,
    /// Regions with properties of their own, or NULL.
    pub regions: *const Region,
    /// Number of regions.
    pub region_count: usize,
    /// Weld vertices within this distance; 0: none but what the lattice welds.
    pub repair: f64,
    /// Take facets that are coplanar within this distance for one; 0: what is usual for a surface,
    /// as the program does; below 0: only exactly coplanar ones.
    pub flat_tolerance: f64,
    /// Anything but 0: the mesh is not checked against the domain.
    pub unchecked: i32,
    /// Anything but 0: a domain that is not exactly on its lattice is refused.
    pub exact_input: i32,
    /// The coordinates of the mesh. 0: the surface's own, unless its distance from the origin takes
    /// two bits of them or more: then those from the middle of the domain, which are finer
    /// (`ltbw_mesh_offset` tells). 1: its own. 2: those from the middle.
    pub frame: i32,
    /// The share of tetrahedra, and of their volume, that may be excused from a bound in a mesh
    /// whose certificate does not say `failed`, at most 0.05. 0: 0.01, as the program does; below
    /// 0: none.
    pub excused_share: f64,
    /// Degrees, at most 12: tetrahedra with a smaller dihedral angle are split where a point
    /// serves. 0: 8, as the program does; below 0: none is. Nothing is done without a bound on
    /// `radius_edge`.
    pub min_dihedral: f64,
    /// Collapse triangles of the surface within this distance before meshing, at most 5 % of the
    /// diagonal; 0: none. A note bounds how far the surfaces are apart.
    pub simplify: f64,
    /// The most edges of a hole of the surface that triangles close, at most 256; below 3: none is.
    pub fill: u32,
    /// The longest edge, exactly; 0: no bound.
    pub max_edge: f64,
    /// Points that are vertices of the mesh, too, three coordinates each, or NULL. Within three
    /// steps of the lattice of the boundary they are put on it; those outside are left out, and a
    /// note says how many.
    pub points: *const f64,
    /// Number of them.
    pub point_count: usize,
    /// The sweeps, at most 16, in which vertices inside are moved in the end, each where the
    /// smallest dihedral angle around rises; 0: none.
    pub smooth: u32,
    /// Anything but 0: input that would be repaired, of which something would be left out or
    /// guessed, is refused.
    pub strict: i32,
}

// SAFETY: `repr(C)`, the size first, then numbers and pointers.
unsafe impl Growing for Points {
    const NAME: &str = "ltbw_points";
    const FIRST: usize = offset_of!(Self, without_count) + size_of::<usize>();
}

// SAFETY: `repr(C)`, the size first, then numbers and pointers.
unsafe impl Growing for Surface {
    const NAME: &str = "ltbw_surface";
    const FIRST: usize = offset_of!(Self, markers) + size_of::<*const i32>();
}

// SAFETY: `repr(C)`, the size first, then numbers and pointers.
unsafe impl Growing for Wishes {
    const NAME: &str = "ltbw_wishes";
    const FIRST: usize = offset_of!(Self, strict) + size_of::<i32>();
}

/// The values at a pointer, which are not looked at. Null is refused, and so are more values than
/// memory has addresses for.
///
/// # Safety
/// The pointer is null, or points to `count` values that live as long as the slice is used.
pub(crate) unsafe fn values<'a, T>(
    pointer: *const T,
    count: usize,
    name: &str,
) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(null(name));
    }
    if count > isize::MAX as usize / size_of::<T>() {
        let text = format!("{name}: {count} of them are more than memory has places for");
        return Err(Failure::new(Class::Input, "argument.length", text));
    }
    // SAFETY: it is not null, memory has as many places, and the caller promises the rest.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// A copy of values, each changed by `each`, if there is memory for it.
fn copied<T: Copy, U>(values: &[T], each: impl FnMut(T) -> U) -> Result<Vec<U>, Failure> {
    let mut copy = Vec::new();
    copy.try_reserve_exact(values.len())
        .map_err(|error| Failure::new(Class::Machine, "memory", error))?;
    copy.extend(values.iter().copied().map(each));
    Ok(copy)
}

/// The points at a pointer, three coordinates each.
///
/// # Safety
/// As [`values`], of `3 * count` numbers.
pub(crate) unsafe fn points(
    pointer: *const f64,
    count: usize,
    name: &str,
) -> Result<Vec<Point>, Failure> {
    // SAFETY: as the caller promises; a point is three numbers.
    let points = unsafe { values(pointer.cast::<Point>(), count, name) }?;
    copied(points, |point| point)
}

/// The path at a pointer.
///
/// # Safety
/// The pointer is null or a text that ends with a zero.
pub(crate) unsafe fn path(pointer: *const c_char) -> Result<PathBuf, Failure> {
    if pointer.is_null() {
        return Err(null("path"));
    }
    // SAFETY: it is not null, and the caller promises a text that ends with a zero.
    let text = unsafe { CStr::from_ptr(pointer) }.to_str();
    let text = text.map_err(|e| Failure::new(Class::Input, "file.name", e))?;
    Ok(PathBuf::from(text))
}

impl Surface {
    /// The surface at a pointer, copied.
    ///
    /// # Safety
    /// The pointer is null or points to a surface whose pointers are as its fields say.
    pub(crate) unsafe fn source(surface: *const Self) -> Result<Source, Failure> {
        // SAFETY: as the caller promises.
        let given = unsafe { Self::given(surface) }?.ok_or_else(|| null("surface"))?;
        let faces = given.face_count;
        if faces > 0 && given.corners.is_null() {
            return Err(null("corners"));
        }
        let mut length = 0_usize;
        let mut start = |corners: usize| {
            let start = length;
            length = length.saturating_add(corners);
            start
        };
        let starts = match given.corner_counts.is_null() {
            // SAFETY: as the caller promises, three corners of each face are there.
            true => copied(
                unsafe { values(given.corners.cast::<[u32; 3]>(), faces, "corners") }?,
                |face| start(face.len()),
            )?,
            // SAFETY: as the caller promises.
            false => {
                copied(unsafe { values(given.corner_counts, faces, "corner_counts") }?, |count| {
                    start(count as usize)
                })?
            }
        };
        // SAFETY: as the caller promises, the corners are as many as the counts say.
        let corners = unsafe { values(given.corners, length, "corners") }?;
        let markers = match given.markers.is_null() {
            true => &[],
            // SAFETY: as the caller promises.
            false => unsafe { values(given.markers, faces, "markers") }?,
        };
        Ok(Source::Arrays {
            // SAFETY: as the caller promises.
            vertices: unsafe { points(given.vertices, given.vertex_count, "vertices") }?,
            corners: copied(corners, i64::from)?,
            starts,
            markers: copied(markers, |marker| marker)?,
        })
    }
}

/// Bounds, and the wish of edge lengths.
pub(crate) struct Asked {
    pub(crate) wishes: ltbw_bindings::Wishes,
    pub(crate) edge_length: Option<f64>,
    pub(crate) size: Size,
    pub(crate) context: *mut c_void,
}

impl Wishes {
    /// The wishes at a pointer, copied; null means none.
    ///
    /// # Safety
    /// The pointer is null or points to wishes whose pointers are as its fields say.
    pub(crate) unsafe fn asked(wishes: *const Self) -> Result<Asked, Failure> {
        // SAFETY: as the caller promises.
        let Some(given) = unsafe { Self::given(wishes) }? else {
            let wishes = ltbw_bindings::Wishes::default();
            return Ok(Asked {
                wishes,
                edge_length: None,
                size: None,
                context: std::ptr::null_mut(),
            });
        };
        let positive = |value: f64| (value != 0.0).then_some(value);
        let holes = match (given.holes.is_null(), given.hole_rule) {
            (true, 0) => Holes::Given,
            (true, 1) => Holes::None,
            (true, 2) => Holes::Auto,
            // SAFETY: as the caller promises.
            (false, 0) => Holes::At(unsafe { points(given.holes, given.hole_count, "holes") }?),
            (_, rule) => return Err(no_hole_rule(rule)),
        };
        // SAFETY: as the caller promises.
        let regions = unsafe { values(given.regions, given.region_count, "regions") }?;
        let region = |r: Region| kernel::Region {
            seed: r.seed,
            attribute: r.attribute,
            max_volume: positive(r.max_volume),
        };
        // SAFETY: as the caller promises.
        let more = unsafe { points(given.points, given.point_count, "wishes.points") }?;
        let edge_length = positive(given.edge_length).map(length).transpose()?;
        Ok(Asked {
            wishes: ltbw_bindings::Wishes {
                max_volume: positive(given.max_volume),
                max_edge: positive(given.max_edge),
                radius_edge: positive(given.radius_edge),
                max_points: (given.max_points > 0).then_some(given.max_points),
                holes,
                regions: copied(regions, region)?,
                repair: given.repair,
                simplify: given.simplify,
                fill: given.fill,
                flat_tolerance: match given.flat_tolerance {
                    0.0 => None,
                    below if below < 0.0 => Some(0.0),
                    within => Some(within),
                },
                points: more,
                smooth: given.smooth,
                exact_input: given.exact_input != 0,
                strict: given.strict != 0,
                frame: frame(given.frame)?,
                unchecked: given.unchecked != 0,
                excused_share: positive(given.excused_share)
                    .map(|share| if share < 0.0 { 0.0 } else { share }),
                min_dihedral: positive(given.min_dihedral)
                    .map(|degrees| if degrees < 0.0 { 0.0 } else { degrees }),
                ..ltbw_bindings::Wishes::default()
            },
            edge_length,
            size: given.size,
            context: given.context,
        })
    }
}

/// Why a number is no rule of holes.
fn no_hole_rule(rule: i32) -> Failure {
    let text = format!("a hole rule of {rule}: it is 0, 1 or 2, and 0 beside holes");
    Failure::new(Class::Input, "holes.rule", text)
}

/// The frame of a number.
fn frame(number: i32) -> Result<Frame, Failure> {
    match number {
        0 => Ok(Frame::Auto),
        1 => Ok(Frame::Own),
        2 => Ok(Frame::Local),
        _ => {
            let text = format!("a frame of {number}: it is 0, 1 or 2");
            Err(Failure::new(Class::Input, "frame.number", text))
        }
    }
}

/// A length, or why it is none. An infinite one asks for nothing.
pub(crate) fn length(value: f64) -> Result<f64, Failure> {
    match value > 0.0 {
        true => Ok(value),
        false => Err(Failure::new(
            Class::Input,
            "size.value",
            format!("an edge length of {value:?}: it has to be positive"),
        )),
    }
}

/// A size function on its way through the refinement, which calls it from one thread.
pub(crate) struct Function<'a> {
    pub(crate) size: extern "C" fn(*mut c_void, *const f64) -> f64,
    pub(crate) context: *mut c_void,
    pub(crate) offset: Point,
    pub(crate) run: Run,
    pub(crate) reins: &'a Reins,
    /// The thread that called the library.
    pub(crate) caller: ThreadId,
    pub(crate) looked: Mutex<Instant>,
    pub(crate) failure: Mutex<Option<Failure>>,
}

impl Function<'_> {
    /// The length at a place; infinite, which asks for nothing, once one was no length.
    pub(crate) fn at(&self, p: Point) -> f64 {
        if self.reins.cancel.is_cancelled() {
            return f64::INFINITY;
        }
        let place = [0, 1, 2].map(|k| p[k] + self.offset[k]);
        self.asked(&place).unwrap_or_else(|failure| {
            let message = format!("{} at {place:?}", failure.message);
            *self.failure.lock().unwrap_or_else(PoisonError::into_inner) =
                Some(Failure { message, ..failure });
            self.reins.cancel.cancel();
            f64::INFINITY
        })
    }

    fn asked(&self, place: &Point) -> Result<f64, Failure> {
        if std::thread::current().id() != self.caller {
            let text = "a size function was asked by another thread than the caller's";
            return Err(Failure::new(Class::Internal, "internal.thread", text));
        }
        let mut looked = self.looked.lock().unwrap_or_else(PoisonError::into_inner);
        if looked.elapsed() >= ltbw_bindings::PATIENCE {
            *looked = Instant::now();
            self.run.tell(self.reins);
        }
        length((self.size)(self.context, place.as_ptr()))
    }
}

// SAFETY: the foreign functions and their contexts are used by the caller's thread alone, which
// `asked` looks at first; all else is `Sync`.
unsafe impl Sync for Function<'_> {}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values without a size take no memory, however many they are; copies of a size would.
    #[test]
    fn a_copy_that_memory_does_not_hold_is_refused() {
        let failure = copied(&[(); 1 << 44], |()| [0.0; 3]).unwrap_err();
        assert_eq!((failure.class, failure.code), (Class::Machine, "memory"));
        assert_eq!(copied(&[1_u32, 2], i64::from).unwrap(), [1, 2]);
    }
}
