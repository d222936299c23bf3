//! Arguments that are no pointers, no lengths and no rules are refused before anything is done.

use ltbw::*;
use std::ffi::CStr;
use std::ptr::null;

/// Lengths of which none is that of an array of numbers, or of rows of three.
const LENGTHS: [usize; 4] = [usize::MAX, usize::MAX / 3, isize::MAX as usize, 1 << 62];

fn code() -> String {
    // SAFETY: it is a text that lives until this thread's next failure.
    unsafe { CStr::from_ptr(ltbw_last_error_code()) }.to_string_lossy().into_owned()
}

/// Nothing is asked for.
const NOTHING: Wishes = Wishes {
    struct_size: size_of::<Wishes>() as u32,
    max_volume: 0.0,
    radius_edge: 0.0,
    edge_length: 0.0,
    size: None,
    context: std::ptr::null_mut(),
    max_points: 0,
    holes: null(),
    hole_count: 0,
    hole_rule: 0,
    regions: null(),
    region_count: 0,
    repair: 0.0,
    flat_tolerance: 0.0,
    unchecked: 0,
    exact_input: 0,
    frame: 0,
    excused_share: 0.0,
    min_dihedral: 0.0,
    simplify: 0.0,
    fill: 0,
    max_edge: 0.0,
    points: null(),
    point_count: 0,
    smooth: 0,
    strict: 0,
};

/// The number of tetrahedra, or the code of the failure.
fn tetrahedralized(surface: &Surface, wishes: &Wishes) -> Result<usize, String> {
    let (mut mesh, mut count) = (std::ptr::null_mut(), 0);
    // SAFETY: tests give arrays as long as they say, or lengths that are refused; the mesh is freed
    // once.
    unsafe {
        let status = ltbw_tetrahedralize(surface, wishes, null(), &raw mut mesh);
        assert_eq!(mesh.is_null(), status != Status::LTBW_OK);
        if status != Status::LTBW_OK {
            return Err(code());
        }
        ltbw_mesh_tets(mesh, &raw mut count);
        ltbw_mesh_free(mesh);
    }
    Ok(count)
}

/// The faces of the unit cube, turned outward.
const FACES: [u32; 24] = [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3];

/// Corners of a cube around the origin.
fn cube(half: f64) -> impl Iterator<Item = [f64; 3]> {
    let corner =
        move |v: u32| [v >> 2, v >> 1, v].map(|bit| half * (2.0 * f64::from(bit & 1) - 1.0));
    (0..8).map(corner)
}

/// Two cubes, one in the other, which is turned inward or not.
struct Nested {
    vertices: Vec<[f64; 3]>,
    corners: Vec<u32>,
    counts: [u32; 12],
}

impl Nested {
    fn new(inward: bool) -> Self {
        let mut inner = FACES.map(|v| v + 8);
        if inward {
            inner.as_chunks_mut::<4>().0.iter_mut().for_each(|face| face.reverse());
        }
        let vertices = cube(4.0).chain(cube(1.0)).collect();
        Self { vertices, corners: [FACES, inner].concat(), counts: [4; 12] }
    }

    fn surface(&self) -> Surface {
        Surface {
            struct_size: size_of::<Surface>() as u32,
            vertices: self.vertices.as_ptr().cast(),
            vertex_count: self.vertices.len(),
            corners: self.corners.as_ptr(),
            corner_counts: self.counts.as_ptr(),
            face_count: self.counts.len(),
            markers: null(),
        }
    }
}

#[test]
fn structs_that_do_not_know_their_size_are_refused() {
    let nested = Nested::new(true);
    let whole = nested.surface();
    let found = tetrahedralized(&whole, &NOTHING);
    assert!(found.is_ok());
    for struct_size in [0, 8, NOTHING.struct_size - 1, u32::MAX] {
        let refused = tetrahedralized(&whole, &Wishes { struct_size, ..NOTHING });
        assert_eq!(refused, Err("argument.struct_size".to_owned()), "{struct_size}");
    }
    for struct_size in [0, 8, whole.struct_size - 1, u32::MAX] {
        let refused = tetrahedralized(&Surface { struct_size, ..whole }, &NOTHING);
        assert_eq!(refused, Err("argument.struct_size".to_owned()), "{struct_size}");
    }
    // A program of a later version may ask for no more than this one knows.
    #[repr(C)]
    struct Later {
        known: Wishes,
        further: u64,
    }
    let known = Wishes { struct_size: size_of::<Later>() as u32, ..NOTHING };
    for (further, expected) in [(0, found), (1, Err("argument.later".to_owned()))] {
        let later = Later { known, further };
        let (wishes, mut mesh, mut count) = (&raw const later, std::ptr::null_mut(), 0);
        // SAFETY: the struct is as long as it says, and the mesh is freed once.
        let asked = unsafe {
            match ltbw_tetrahedralize(&raw const whole, wishes.cast(), null(), &raw mut mesh) {
                Status::LTBW_OK => {
                    ltbw_mesh_tets(mesh, &raw mut count);
                    ltbw_mesh_free(mesh);
                    Ok(count)
                }
                _ => Err(code()),
            }
        };
        assert_eq!(asked, expected);
    }
}

#[test]
fn lengths_that_memory_has_no_places_for_are_refused() {
    let (points, mut mesh) = ([[0.0; 3]; 4], std::ptr::null_mut());
    let nested = Nested::new(false);
    let whole = nested.surface();
    for length in LENGTHS {
        // SAFETY: a length that is refused is not made use of.
        let status =
            unsafe { ltbw_delaunay(points.as_ptr().cast(), length, null(), &raw mut mesh) };
        assert_eq!((status, &*code()), (Status::LTBW_INPUT, "argument.length"), "{length}");
        let given = Points {
            struct_size: size_of::<Points>() as u32,
            coordinates: points.as_ptr().cast(),
            count: 4,
            without: [0_u32].as_ptr(),
            without_count: length,
        };
        // SAFETY: a length that is refused is not made use of.
        let status = unsafe { ltbw_delaunay_without(&raw const given, null(), &raw mut mesh) };
        assert_eq!((status, &*code()), (Status::LTBW_INPUT, "argument.length"), "{length}");
        let surfaces = [
            Surface { vertex_count: length, ..whole },
            Surface { face_count: length, ..whole },
            Surface { face_count: length, corner_counts: null(), ..whole },
        ];
        for surface in surfaces {
            let refused = tetrahedralized(&surface, &NOTHING);
            assert_eq!(refused, Err("argument.length".to_owned()), "{surface:?}");
        }
        let region = Region { seed: [2.0; 3], attribute: 1.0, max_volume: 0.0 };
        let wishes = [
            Wishes { holes: points.as_ptr().cast(), hole_count: length, ..NOTHING },
            Wishes { regions: &raw const region, region_count: length, ..NOTHING },
            Wishes { points: points.as_ptr().cast(), point_count: length, ..NOTHING },
        ];
        for wishes in wishes {
            let refused = tetrahedralized(&whole, &wishes);
            assert_eq!(refused, Err("argument.length".to_owned()), "{wishes:?}");
        }
    }
}

#[test]
fn null_is_refused_whatever_the_length() {
    let mut mesh = std::ptr::null_mut();
    let nested = Nested::new(false);
    let whole = nested.surface();
    for length in [1, 12, 1 << 40].into_iter().chain(LENGTHS) {
        // SAFETY: null is refused.
        let status = unsafe { ltbw_delaunay(null(), length, null(), &raw mut mesh) };
        assert_eq!((status, &*code()), (Status::LTBW_INPUT, "argument.null"), "{length}");
        let surfaces = [
            Surface { vertices: null(), vertex_count: length, ..whole },
            Surface { corners: null(), face_count: length, ..whole },
            Surface { corners: null(), corner_counts: null(), face_count: length, ..whole },
        ];
        for surface in surfaces {
            let refused = tetrahedralized(&surface, &NOTHING);
            assert_eq!(refused, Err("argument.null".to_owned()), "{surface:?}");
        }
        let regions = Wishes { region_count: length, ..NOTHING };
        assert_eq!(tetrahedralized(&whole, &regions), Err("argument.null".to_owned()));
    }
}

#[test]
fn a_rule_says_what_is_void() {
    let ruled = |inward: bool, hole_rule| {
        tetrahedralized(&Nested::new(inward).surface(), &Wishes { hole_rule, ..NOTHING })
    };
    let [filled, empty] = [1, 2].map(|rule| ruled(false, rule).expect("a mesh"));
    assert!(empty < filled, "{empty} {filled}");
    assert_eq!([false, true].map(|inward| ruled(inward, 0)), [Ok(filled), Ok(empty)]);
    assert_eq!([1, 2].map(|rule| ruled(true, rule)), [Ok(filled), Ok(empty)]);
    let inside = [0.0; 3];
    let holes = Wishes { holes: inside.as_ptr(), hole_count: 1, ..NOTHING };
    assert_eq!(tetrahedralized(&Nested::new(false).surface(), &holes), Ok(empty));
    let both = Wishes { hole_rule: 2, ..holes };
    let refused =
        [ruled(false, 3), ruled(false, -1), tetrahedralized(&Nested::new(false).surface(), &both)];
    assert!(refused.iter().all(|code| *code == Err("holes.rule".to_owned())), "{refused:?}");
}

#[test]
fn points_are_vertices_and_those_outside_are_told_of() {
    let surface_of = Nested::new(false);
    // Inside, on a facet, at a corner, outside.
    let points = [[0.5, 0.25, 2.0], [4.0, 1.25, 0.5], [4.0; 3], [9.0, 0.0, 0.0]];
    let given = |count| Wishes {
        points: points.as_ptr().cast(),
        point_count: count,
        hole_rule: 1,
        ..NOTHING
    };
    let (mut mesh, mut count) = (std::ptr::null_mut(), 0);
    // SAFETY: the arrays are as long as they say; the mesh is freed once, after it was read.
    unsafe {
        let surface = surface_of.surface();
        let status = ltbw_tetrahedralize(&surface, &given(4), null(), &raw mut mesh);
        assert_eq!(status, Status::LTBW_OK);
        let vertices = ltbw_mesh_points(mesh, &raw mut count).cast::<[f64; 3]>();
        let vertices = std::slice::from_raw_parts(vertices, count);
        assert_eq!(vertices[16..18], points[..2], "they follow the vertices of the surface");
        let notes: Vec<String> = (0..)
            .map(|k| ltbw_mesh_note(mesh, k))
            .take_while(|note| !note.is_null())
            .map(|note| CStr::from_ptr(note).to_string_lossy().into_owned())
            .collect();
        let expected = [
            "1 point left out: outside",
            "given: 2 points: 1 inside, 1 on facets, 0 on edges; 1 are at a vertex, or given twice",
        ];
        assert!(expected.iter().all(|note| notes.iter().any(|own| own == note)), "{notes:?}");
        ltbw_mesh_free(mesh);
    }
    let strict = |count| Wishes { strict: 1, ..given(count) };
    let surface = surface_of.surface();
    assert_eq!(tetrahedralized(&surface, &strict(4)), Err("domain.strict".to_owned()));
    assert!(tetrahedralized(&surface, &strict(3)).is_ok());
    assert_eq!(
        tetrahedralized(&surface, &Wishes { points: null(), ..given(1) }),
        Err("argument.null".to_owned())
    );
    let moved = |smooth| tetrahedralized(&surface, &Wishes { smooth, radius_edge: 2.0, ..NOTHING });
    assert!(moved(1).is_ok());
    assert_eq!(moved(17), Err("refine.bound".to_owned()));
    let no_number = [f64::NAN; 3];
    let wrong = Wishes { points: no_number.as_ptr(), point_count: 1, ..NOTHING };
    assert!(tetrahedralized(&surface, &wrong).is_err());
}

#[test]
fn points_that_are_nearly_flat_are_told_of() {
    for (thick, told) in [(1e-9, true), (1.0, false)] {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.4, 0.3, thick]];
        let mut mesh = std::ptr::null_mut();
        // SAFETY: four points; the mesh is freed once, after its notes were read.
        unsafe {
            let status = ltbw_delaunay(points.as_ptr().cast(), 4, null(), &raw mut mesh);
            assert_eq!(status, Status::LTBW_OK);
            let note = ltbw_mesh_note(mesh, 0);
            assert_eq!(!note.is_null(), told);
            assert!(!told || CStr::from_ptr(note).to_string_lossy().contains("thickness 1.000e-9"));
            assert!(ltbw_mesh_note(mesh, 1).is_null());
            ltbw_mesh_free(mesh);
        }
    }
}
