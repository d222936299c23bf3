//! The descriptions.

use super::model::{Constant, Extents, Guard, Measure, Predicate, Step};

/// A step whose differences are bounded by the extents of their axes.
const fn step(name: &'static str, text: &'static str) -> Step {
    Step { name, text, measure: Measure::Axis }
}

/// A step whose differences are bounded by the largest extent.
const fn large(name: &'static str, text: &'static str) -> Step {
    Step { name, text, measure: Measure::Largest }
}

/// A constant of a whole number of u and some sixteenths of u.
const fn roundoffs(whole: u64, sixteenths: u64) -> Constant {
    Constant(16 * whole + sixteenths)
}

/// Five extents, and products of up to five differences, stay normal and finite.
const GUARD: Guard = Guard { low: -190, high: 200, parameter_low: -600, parameter_high: 600 };

/// Five extents, and products of up to eight differences, stay normal and finite.
const REFINEMENT_GUARD: Guard =
    Guard { low: -100, high: 100, parameter_low: -20, parameter_high: 20 };

/// Every predicate with a filter.
pub(crate) const PREDICATES: &[Predicate<'static>] = &[
    ORIENT3D,
    INSPHERE,
    ORIENT2D,
    INCIRCLE,
    IN_DIAMETRAL_BALL,
    IN_EQUATORIAL_BALL,
    EXCEEDS_RADIUS_EDGE,
    EXCEEDS_VOLUME,
    BELOW_DIHEDRAL,
];

/// Shewchuk's order of evaluation; his sign is opposite to ours.
const ORIENT3D: Predicate<'static> = Predicate {
    name: "orient3d",
    about: "`orient3d`: positive for the unit tetrahedron (0, x, y, z).",
    points: &["a", "b", "c", "d"],
    parameters: &[],
    vectors: &["ad", "bd", "cd"],
    extents: Extents::Space,
    steps: &[step(
        "det",
        "adz * (bdx * cdy - cdx * bdy) + bdz * (cdx * ady - adx * cdy) \
         + cdz * (adx * bdy - bdx * ady)",
    )],
    negate: true,
    constants: &[("ORIENT3D_ERROR", roundoffs(46, 1))],
    bound: &[("bound", "ORIENT3D_ERROR * mx * my * mz")],
    guard: GUARD,
    window: true,
    lattice_bits: Some(16),
    integers: true,
};

/// Shewchuk's order of evaluation; his sign is opposite to ours.
const INSPHERE: Predicate<'static> = Predicate {
    name: "insphere",
    about: "`insphere`: positive if `e` lies inside the sphere through the positively oriented \
            tetrahedron `a, b, c, d`.",
    points: &["a", "b", "c", "d", "e"],
    parameters: &[],
    vectors: &["ae", "be", "ce", "de"],
    extents: Extents::Space,
    steps: &[
        step("ab", "aex * bey - bex * aey"),
        step("bc", "bex * cey - cex * bey"),
        step("cd", "cex * dey - dex * cey"),
        step("da", "dex * aey - aex * dey"),
        step("ac", "aex * cey - cex * aey"),
        step("bd", "bex * dey - dex * bey"),
        step("abc", "aez * bc - bez * ac + cez * ab"),
        step("bcd", "bez * cd - cez * bd + dez * bc"),
        step("cda", "cez * da + dez * ac + aez * cd"),
        step("dab", "dez * ab + aez * bd + bez * da"),
        large("alift", "aex * aex + aey * aey + aez * aez"),
        large("blift", "bex * bex + bey * bey + bez * bez"),
        large("clift", "cex * cex + cey * cey + cez * cez"),
        large("dlift", "dex * dex + dey * dey + dez * dez"),
        step("det", "(dlift * abc - clift * dab) + (blift * cda - alift * bcd)"),
    ],
    negate: true,
    constants: &[("INSPHERE_ERROR", roundoffs(1104, 1))],
    bound: &[("bound", "INSPHERE_ERROR * mx * my * mz * (m * m)")],
    guard: GUARD,
    window: true,
    lattice_bits: Some(9),
    integers: true,
};

const ORIENT2D: Predicate<'static> = Predicate {
    name: "orient2d",
    about: "The orientation of the projections of `a, b, c` to the axes of `plane`: positive \
            counterclockwise.",
    points: &["a", "b", "c"],
    parameters: &[],
    vectors: &["ac", "bc"],
    extents: Extents::Plane,
    steps: &[step("det", "aci * bcj - acj * bci")],
    negate: false,
    constants: &[("ORIENT2D_ERROR", roundoffs(8, 1))],
    bound: &[("bound", "ORIENT2D_ERROR * mi * mj")],
    guard: GUARD,
    window: false,
    lattice_bits: None,
    integers: true,
};

const INCIRCLE: Predicate<'static> = Predicate {
    name: "incircle",
    about: "The in-circle determinant of four points of one plane, projected to the axes of \
            `plane`: the lift is the squared distance in space, so that circles stay circles. \
            Positive inside if the projections of `a, b, c` turn counterclockwise.",
    points: &["a", "b", "c", "d"],
    parameters: &[],
    vectors: &["ad", "bd", "cd"],
    extents: Extents::PlaneInSpace,
    steps: &[
        large("alift", "adx * adx + ady * ady + adz * adz"),
        large("blift", "bdx * bdx + bdy * bdy + bdz * bdz"),
        large("clift", "cdx * cdx + cdy * cdy + cdz * cdz"),
        step(
            "det",
            "alift * (bdi * cdj - cdi * bdj) + blift * (cdi * adj - adi * cdj) \
             + clift * (adi * bdj - bdi * adj)",
        ),
    ],
    negate: false,
    constants: &[("INCIRCLE_ERROR", roundoffs(204, 1))],
    bound: &[("bound", "INCIRCLE_ERROR * mi * mj * (m * m)")],
    guard: GUARD,
    window: false,
    lattice_bits: None,
    integers: true,
};

/// (a - p) . (b - p), negative inside.
const IN_DIAMETRAL_BALL: Predicate<'static> = Predicate {
    name: "in_diametral_ball",
    about: "The side of the ball with diameter `a, b` on which `p` lies: positive inside, negative \
            outside.",
    points: &["a", "b", "p"],
    parameters: &[],
    vectors: &["ap", "bp"],
    extents: Extents::One,
    steps: &[step("product", "apx * bpx + apy * bpy + apz * bpz")],
    negate: true,
    constants: &[("DIAMETRAL_ERROR", roundoffs(14, 1))],
    bound: &[("bound", "DIAMETRAL_ERROR * (m * m)")],
    guard: GUARD,
    window: false,
    lattice_bits: None,
    integers: false,
};

/// With u = a - b, v = a - c, w = a - p and n = u x v:
/// |n|^2 |w|^2 + |v|^2 (u . (v - u)) (w . u) - |u|^2 (v . (v - u)) (w . v), negative inside.
const IN_EQUATORIAL_BALL: Predicate<'static> = Predicate {
    name: "in_equatorial_ball",
    about: "The side of the smallest ball whose boundary passes through `a, b, c`, which are not \
            collinear, on which `p` lies: positive inside, negative outside.",
    points: &["a", "b", "c", "p"],
    parameters: &[],
    vectors: &["ab", "ac", "bc", "ap"],
    extents: Extents::One,
    steps: &[
        step("nx", "aby * acz - abz * acy"),
        step("ny", "abz * acx - abx * acz"),
        step("nz", "abx * acy - aby * acx"),
        step("uu", "abx * abx + aby * aby + abz * abz"),
        step("vv", "acx * acx + acy * acy + acz * acz"),
        step("ww", "apx * apx + apy * apy + apz * apz"),
        step("ud", "abx * bcx + aby * bcy + abz * bcz"),
        step("vd", "acx * bcx + acy * bcy + acz * bcz"),
        step("wu", "apx * abx + apy * aby + apz * abz"),
        step("wv", "apx * acx + apy * acy + apz * acz"),
        step("value", "(nx * nx + ny * ny + nz * nz) * ww + vv * ud * wu - uu * vd * wv"),
    ],
    negate: true,
    constants: &[("EQUATORIAL_ERROR", roundoffs(1605, 1))],
    bound: &[("m2", "m * m"), ("bound", "EQUATORIAL_ERROR * (m2 * m2 * m2)")],
    guard: REFINEMENT_GUARD,
    window: false,
    lattice_bits: None,
    integers: false,
};

/// The circumcentre is d + n / (2 det) for n = |a|^2 (b x c) + |b|^2 (c x a) + |c|^2 (a x b), a, b
/// and c being the differences to d: |n|^2 is compared with (2 ratio det)^2 l^2.
const EXCEEDS_RADIUS_EDGE: Predicate<'static> = Predicate {
    name: "exceeds_radius_edge",
    about: "Whether the circumradius of `a, b, c, d` exceeds `ratio` (positive) times its \
            shortest edge: positive if it does, negative if it is less.",
    points: &["a", "b", "c", "d"],
    parameters: &["ratio"],
    vectors: &["ad", "bd", "cd", "ab", "bc", "ca"],
    extents: Extents::One,
    steps: &[
        step("alift", "adx * adx + ady * ady + adz * adz"),
        step("blift", "bdx * bdx + bdy * bdy + bdz * bdz"),
        step("clift", "cdx * cdx + cdy * cdy + cdz * cdz"),
        step("px", "bdy * cdz - bdz * cdy"),
        step("py", "bdz * cdx - bdx * cdz"),
        step("pz", "bdx * cdy - bdy * cdx"),
        step("qx", "cdy * adz - cdz * ady"),
        step("qy", "cdz * adx - cdx * adz"),
        step("qz", "cdx * ady - cdy * adx"),
        step("rx", "ady * bdz - adz * bdy"),
        step("ry", "adz * bdx - adx * bdz"),
        step("rz", "adx * bdy - ady * bdx"),
        step("nx", "alift * px + blift * qx + clift * rx"),
        step("ny", "alift * py + blift * qy + clift * ry"),
        step("nz", "alift * pz + blift * qz + clift * rz"),
        step("det", "adx * px + ady * py + adz * pz"),
        step("ablift", "abx * abx + aby * aby + abz * abz"),
        step("bclift", "bcx * bcx + bcy * bcy + bcz * bcz"),
        step("calift", "cax * cax + cay * cay + caz * caz"),
        step("shortest", "min(min(min(alift, blift), clift), min(min(ablift, bclift), calift))"),
        step("limit", "2 * ratio * det"),
        step("value", "nx * nx + ny * ny + nz * nz - limit * limit * shortest"),
    ],
    negate: false,
    constants: &[("RADIUS_ERROR", roundoffs(25_596, 1)), ("EDGE_ERROR", roundoffs(11_664, 1))],
    bound: &[
        ("m2", "m * m"),
        ("m4", "m2 * m2"),
        ("bound", "(RADIUS_ERROR + EDGE_ERROR * (ratio * ratio)) * (m4 * m4)"),
    ],
    guard: REFINEMENT_GUARD,
    window: false,
    lattice_bits: None,
    integers: false,
};

/// The determinant, here with our sign, against six times the volume.
const EXCEEDS_VOLUME: Predicate<'static> = Predicate {
    name: "exceeds_volume",
    about: "Whether the signed volume of `a, b, c, d` (of the sign of `orient3d`) exceeds \
            `volume` (positive): positive if it does, negative if it is less.",
    points: &["a", "b", "c", "d"],
    parameters: &["volume"],
    vectors: &["ad", "bd", "cd"],
    extents: Extents::Space,
    steps: &[
        step(
            "det",
            "adz * (cdx * bdy - bdx * cdy) + bdz * (adx * cdy - cdx * ady) \
             + cdz * (bdx * ady - adx * bdy)",
        ),
        step("value", "det - 6 * volume"),
    ],
    negate: false,
    constants: &[("VOLUME_ERROR", roundoffs(52, 1)), ("VOLUME_LIMIT_ERROR", roundoffs(12, 1))],
    bound: &[("bound", "VOLUME_ERROR * mx * my * mz + VOLUME_LIMIT_ERROR * volume")],
    guard: GUARD,
    window: false,
    lattice_bits: None,
    integers: false,
};

/// With e = a - b, p = e x (a - c) and q = e x (a - d), whose angle is the dihedral one at ab:
/// (p . q)^2 is compared with cos2 |p|^2 |q|^2.
const BELOW_DIHEDRAL: Predicate<'static> = Predicate {
    name: "below_dihedral",
    about: "Whether the dihedral angle of `a, b, c, d` at the edge `ab`, or its supplement, is \
            below the angle up to 90 degrees whose cosine has the square `cos2` (positive): \
            positive if it is, negative if both are larger.",
    points: &["a", "b", "c", "d"],
    parameters: &["cos2"],
    vectors: &["ab", "ac", "ad"],
    extents: Extents::One,
    steps: &[
        step("px", "aby * acz - abz * acy"),
        step("py", "abz * acx - abx * acz"),
        step("pz", "abx * acy - aby * acx"),
        step("qx", "aby * adz - abz * ady"),
        step("qy", "abz * adx - abx * adz"),
        step("qz", "abx * ady - aby * adx"),
        step("pp", "px * px + py * py + pz * pz"),
        step("qq", "qx * qx + qy * qy + qz * qz"),
        step("pq", "px * qx + py * qy + pz * qz"),
        step("value", "pq * pq - cos2 * (pp * qq)"),
    ],
    negate: false,
    constants: &[("DIHEDRAL_ERROR", roundoffs(3360, 1)), ("COSINE_ERROR", roundoffs(3504, 1))],
    bound: &[
        ("m2", "m * m"),
        ("m4", "m2 * m2"),
        ("bound", "(DIHEDRAL_ERROR + COSINE_ERROR * cos2) * (m4 * m4)"),
    ],
    guard: REFINEMENT_GUARD,
    window: false,
    lattice_bits: None,
    integers: false,
};
