//! The judge: an independent, exact checker of tetrahedral Delaunay meshes.
//!
//! It takes plain slices, anybody's, and says what is wrong, exactly and where. It depends on
//! none of the kernel's crates and shares no code with them, so that it cannot share their bugs:
//! predicates, adjacency, perturbation and hash are its own. It never panics, and its report is
//! a function of the mesh alone, not of the number of threads.
//!
//! ```
//! use ltbw_verify::{Kind, Level, Mesh, Options, check};
//!
//! // Two tetrahedra on the same side of the face that they share.
//! let points =
//!     [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [1.0, 1.0, 3.0], [1.0, 1.0, 2.0]];
//! let report = check(&Mesh::new(&points, &[[0, 1, 2, 3], [0, 2, 1, 4]]), &Options::default());
//! assert!(!report.passed());
//! assert_eq!(report.count(Kind::FoldedFace), 1);
//! assert_eq!(report.level(Level::Topology).defects, 0);
//! for defect in &report.defects {
//!     eprintln!("{defect}");
//! }
//! ```
//!
//! # Levels
//!
//! 1. *structure* (`structure.rs`, `faces.rs`): indices exist, no tetrahedron twice, coordinates
//!    finite, no two used points at one place;
//! 2. *topology* (`topology.rs`): every face has one or two tetrahedra, neighbours on opposite
//!    sides of it; claimed adjacency and hull are the real ones; all in one piece; every hull
//!    edge has two hull facets; at full depth, the mesh is a ball at every vertex and as a whole
//!    (Euler);
//! 3. *orientation* (`geometry.rs`): every tetrahedron is positive, exactly; neighbours do not
//!    overlap;
//! 4. *Delaunay* (`geometry.rs`, `hull.rs`): no apex is inside the circumsphere of a neighbour,
//!    exactly; the hull is convex;
//! 5. *canonical* (`perturb.rs`): the symbolic perturbation decides every tie as the mesh has it.
//!
//! A level passes only if the levels before it do. [`Depth::Fast`] leaves out what the theorem
//! below does not need; it is still a proof that the mesh is Delaunay.
//!
//! *With an adjacency* ([`Mesh::neighbours`]) the checker first tries a short proof
//! (`adjacency_proof.rs`): it tests the premises of the theorem on the claims, without trusting
//! them, and takes from the conclusion what the list above tests one by one: no face of three, no
//! tetrahedron twice, one piece, vertex links, Euler's formula (which gives the number of edges),
//! and that the claims are the real adjacency. If a single test fails, or the mesh is mirrored, it
//! goes through the levels on its own adjacency and names what is wrong. The report is the same
//! either way. Whoever wants every test made all the same leaves the adjacency out.
//!
//! *In parts* ([`check_parted`], `parted/`) the same premises are tested by members of a team, each
//! of which has a part of the mesh: inside a part by the code for whole meshes, between parts where
//! their faces meet.
//!
//! # Theorem
//!
//! *If the levels up to Delaunay pass, at either depth, the tetrahedra tile the convex hull of
//! their vertices, face to face, and form a Delaunay triangulation of them.* Every premise is a
//! test that is made exactly:
//!
//! 1. some faces are joined in pairs, the two of a pair having the same three vertices; the other
//!    faces form the *hull*, and every edge of the hull has exactly two hull facets;
//! 2. every tetrahedron, turned as the check turns it, is positive, and two that a pair of faces
//!    joins lie on opposite sides of it;
//! 3. at every hull edge the far vertex of one facet is not beyond the plane of the other;
//! 4. the centre O of the first tetrahedron is strictly inside every hull facet's plane, and the
//!    ray from O through the centre Q of the first hull facet meets no other hull facet;
//! 5. at every pair of faces, the apex of one is not inside the circumsphere of the other.
//!
//! *The hull is the boundary of a convex body.* Turn every facet outward. By 2 the faces of a pair
//! cancel in the boundary of the sum of all tetrahedra, so that this boundary is the sum of the
//! hull facets; the boundary of a boundary is zero, so by 1 the two facets of a hull edge run
//! through it in opposite directions. Project the hull from O to a sphere. By 4 each facet goes
//! one to one to a positive spherical triangle, so facets at an edge go to different sides of
//! its image: away from vertices the projection is a local homeomorphism, hence a branched
//! covering of the sphere. By 4 the direction of Q, inner to its facet, has one preimage: there
//! is one sheet. So the projection is a homeomorphism, the hull is embedded and star-shaped from
//! O, and by 3 it is convex at its edges; an embedded polyhedral surface convex at its edges is
//! convex (Tietze and Nakajima; as a program checker: Mehlhorn, Näher, Seel, Seidel, Schilz,
//! Schirra, Uhrig, *Checking geometric programs or verification of geometric structures*,
//! Comput. Geom. 12:85–103, 1999; Devillers, Liotta, Preparata, Tamassia, *Checking the convexity
//! of polytopes and the planarity of subdivisions*, Comput. Geom. 11:187–208, 1998). Test 4 is
//! not redundant: a fan that goes twice around an axis passes 1, 2, 3 and 5, and is a ball.
//!
//! *The tetrahedra tile it.* The number of positive tetrahedra around a point that lies on no
//! face is the winding number of the hull around the point: 1 inside the convex body and 0
//! outside. So the tetrahedra cover it once. Hence none is there twice, and no three have one
//! face: two of them would overlap on one side of it. Nor is a face of two left unpaired: both
//! would be hull facets with one image on the sphere. They meet face to face: were a vertex
//! inside a face or edge of a tetrahedron that it does not belong to, a tetrahedron at that
//! vertex would overlap one of those that share this face, or that follow each other around this
//! edge. And a convex body tiled face to face is connected through faces, and is a ball, as a
//! whole and around every vertex: the links are spheres and, on the hull, disks, and
//! V - E + F - T = 1.
//!
//! *Local is global.* Lift the vertices to the paraboloid w = x² + y² + z². By 5 the lifted,
//! piecewise linear function is convex across every inner face, hence convex along every line
//! that misses edges, hence convex on the convex body: every tetrahedron lies on the lower hull,
//! and its circumsphere is empty (Delaunay, *Sur la sphère vide*, 1934).
//!
//! *Canonical.* The same argument with the perturbed lift w + ε^rank: all ties are decided, so
//! the mesh is the one triangulation whose perturbed spheres are empty. Orientation is not
//! perturbed: flat tetrahedra are never part of it.
//!
//! # Trusted
//!
//! This crate, `robust` inside its window, `num-bigint`, `sha2`, `rayon`, the compiler and IEEE
//! 754 arithmetic. The filter's error bounds are derived in `predicates.rs`; tests compare every
//! stage of the predicates with big integers.

#![forbid(unsafe_code)]

mod adjacency_proof;
mod angles;
mod check;
mod chunks;
mod conform;
mod defect;
mod determinant;
mod display;
mod elements;
mod exact;
mod faces;
mod geometry;
mod hash;
mod hull;
mod mesh;
mod parted;
mod perturb;
mod places;
mod predicates;
mod report;
mod structure;
mod sync;
mod topology;

pub use angles::{LeastAngle, SmallAngles, small_angles};
pub use check::{check, check_elements, signs};
pub use conform::{
    Conformity, ConformityDefect, DomainPart, Finding, Fraction, Limits, Plc, PlcFacet, conforms,
    conforms_parted,
};
pub use defect::{Defect, Kind, Level};
pub use hash::{HashError, canonical_hash};
pub use mesh::{Depth, Mesh, NO_NEIGHBOUR, Options, Point, VertexOrder};
pub use parted::{Exchange, Part, check_parted};
pub use report::{Certificate, Counts, Hash, Information, LevelReport, Outcome, Report};

/// Examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
