/* ltbw: exactly Delaunay tetrahedral meshes. Made by cbindgen from bindings/c: do not edit. */

#ifndef LTBW_H
#define LTBW_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* The version of this header. */
#define LTBW_VERSION_MAJOR 0
#define LTBW_VERSION_MINOR 1
#define LTBW_VERSION_PATCH 0

/*
 The end of a call.
 */
typedef enum ltbw_status {
  /*
   Done.
   */
  LTBW_OK = 0,
  /*
   The arguments are no points, no surface, or no bounds that a mesh can meet.
   */
  LTBW_INPUT = 1,
  /*
   The surface bounds nothing that can be meshed.
   */
  LTBW_DOMAIN = 2,
  /*
   The surface could not be brought into a Delaunay mesh.
   */
  LTBW_RECOVERY = 3,
  /*
   Cancelled before there was a mesh.
   */
  LTBW_CANCELLED = 4,
  /*
   A file could not be read or written.
   */
  LTBW_FILE = 5,
  /*
   The machine lacks memory or threads.
   */
  LTBW_MACHINE = 6,
  /*
   A defect of ltbw itself: please report it.
   */
  LTBW_INTERNAL = 70,
} ltbw_status;

/*
 The state in which the work ended.
 */
typedef enum ltbw_outcome {
  /*
   The mesh has all points.
   */
  LTBW_COMPLETE = 0,
  /*
   The mesh of a domain meets every bound.
   */
  LTBW_MET = 1,
  /*
   Some tetrahedra are over a bound, each with a reason: input angles are too small. `verdict`
   in the certificate says `excused` where they are few, `failed` where they are not.
   */
  LTBW_EXCUSED = 2,
  /*
   The budget of points was used up first.
   */
  LTBW_BUDGET = 3,
  /*
   The progress function ended the work: the mesh so far.
   */
  LTBW_STOPPED = 4,
} ltbw_outcome;

/*
 A mesh. From its making to `ltbw_mesh_free` many threads may ask it at once.
 */
typedef struct ltbw_mesh ltbw_mesh;

/*
 Told some twenty times a second, by the calling thread: points done, of a total that is 0 where
 it is not known. Anything but 0 ends the work: the mesh so far is kept.
 */
typedef int32_t (*ltbw_progress)(void *context, uint64_t done, uint64_t total);

/*
 Threads and progress. NULL where a function takes one: one thread, no progress.
 */
typedef struct ltbw_run {
  /*
   Size of the struct, `sizeof` it: `ltbw_run_new` sets it.
   */
  uint32_t struct_size;
  /*
   Threads; 0 means 1. The mesh is the same for any number.
   */
  uint32_t threads;
  /*
   The progress function, or NULL.
   */
  ltbw_progress progress;
  /*
   Handed to the progress function.
   */
  void *context;
} ltbw_run;

/*
 Points, and those of them that are removed again.
 */
typedef struct ltbw_points {
  /*
   Size of the struct, `sizeof` it: `ltbw_points_new` sets it.
   */
  uint32_t struct_size;
  /*
   Coordinates: three for each point.
   */
  const double *coordinates;
  /*
   Number of points.
   */
  size_t count;
  /*
   Numbers of points that are removed from the mesh, or NULL.
   */
  const uint32_t *without;
  /*
   Number of them.
   */
  size_t without_count;
} ltbw_points;

/*
 A surface: polygons over vertices, turned outward.
 */
typedef struct ltbw_surface {
  /*
   Size of the struct, `sizeof` it: `ltbw_surface_new` sets it.
   */
  uint32_t struct_size;
  /*
   Coordinates: three for each vertex.
   */
  const double *vertices;
  /*
   Number of vertices.
   */
  size_t vertex_count;
  /*
   Corners of all faces, one face after the other.
   */
  const uint32_t *corners;
  /*
   The number of corners of each face; NULL: three each.
   */
  const uint32_t *corner_counts;
  /*
   Number of faces.
   */
  size_t face_count;
  /*
   A marker for each face, or NULL.
   */
  const int32_t *markers;
} ltbw_surface;

/*
 A wanted edge length at a place. It is called by the calling thread, has to give the same answer
 for the same place, and positive ones.
 */
typedef double (*ltbw_size)(void *context, const double *place);

/*
 A region with properties of its own. It does not grow: what regions may have one day comes
 beside.
 */
typedef struct ltbw_region {
  /*
   A point inside.
   */
  double seed[3];
  /*
   Its attribute.
   */
  double attribute;
  /*
   The largest volume of its tetrahedra; 0: no bound of its own.
   */
  double max_volume;
} ltbw_region;

/*
 The bounds that a mesh has to meet. All zero but its size: any shape, any size.
 */
typedef struct ltbw_wishes {
  /*
   Size of the struct, `sizeof` it: `ltbw_wishes_new` sets it.
   */
  uint32_t struct_size;
  /*
   The largest volume; 0: no bound.
   */
  double max_volume;
  /*
   The largest circumradius to shortest edge; 0: no bound. 2 is the usual one.
   */
  double radius_edge;
  /*
   A usual edge length for all places; 0: none.
   */
  double edge_length;
  /*
   A usual edge length as a function of the place, or NULL.
   */
  ltbw_size size;
  /*
   Handed to the size function.
   */
  void *context;
  /*
   The most points to insert; 0: as many as is usual.
   */
  uint64_t max_points;
  /*
   A point in each void, three coordinates each; orientation means nothing then. NULL:
   `hole_rule` says what is void.
   */
  const double *holes;
  /*
   Number of holes.
   */
  size_t hole_count;
  /*
   The rule of voids where `holes` is NULL. 0: hole points of a file, and what the surface's
   orientation says: a body inside another is a void if its faces point the other way. 1:
   nothing. 2: bodies inside others, however turned.
   */
  int32_t hole_rule;
  /*
   Regions with properties of their own, or NULL.
   */
  const struct ltbw_region *regions;
  /*
   Number of regions.
   */
  size_t region_count;
  /*
   Weld vertices within this distance; 0: none but what the lattice welds.
   */
  double repair;
  /*
   Take facets that are coplanar within this distance for one; 0: what is usual for a surface,
   as the program does; below 0: only exactly coplanar ones.
   */
  double flat_tolerance;
  /*
   Anything but 0: the mesh is not checked against the domain.
   */
  int32_t unchecked;
  /*
   Anything but 0: a domain that is not exactly on its lattice is refused.
   */
  int32_t exact_input;
  /*
   The coordinates of the mesh. 0: the surface's own, unless its distance from the origin takes
   two bits of them or more: then those from the middle of the domain, which are finer
   (`ltbw_mesh_offset` tells). 1: its own. 2: those from the middle.
   */
  int32_t frame;
  /*
   The share of tetrahedra, and of their volume, that may be excused from a bound in a mesh
   whose certificate does not say `failed`, at most 0.05. 0: 0.01, as the program does; below
   0: none.
   */
  double excused_share;
  /*
   Degrees, at most 12: tetrahedra with a smaller dihedral angle are split where a point
   serves. 0: 8, as the program does; below 0: none is. Nothing is done without a bound on
   `radius_edge`.
   */
  double min_dihedral;
  /*
   Collapse triangles of the surface within this distance before meshing, at most 5 % of the
   diagonal; 0: none. A note bounds how far the surfaces are apart.
   */
  double simplify;
  /*
   The most edges of a hole of the surface that triangles close, at most 256; below 3: none is.
   */
  uint32_t fill;
  /*
   The longest edge, exactly; 0: no bound.
   */
  double max_edge;
  /*
   Points that are vertices of the mesh, too, three coordinates each, or NULL. Within three
   steps of the lattice of the boundary they are put on it; those outside are left out, and a
   note says how many.
   */
  const double *points;
  /*
   Number of them.
   */
  size_t point_count;
  /*
   The sweeps, at most 16, in which vertices inside are moved in the end, each where the
   smallest dihedral angle around rises; 0: none.
   */
  uint32_t smooth;
  /*
   Anything but 0: input that would be repaired, of which something would be left out or
   guessed, is refused.
   */
  int32_t strict;
} ltbw_wishes;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Coordinates of the vertices, three each; their number goes to `count`.

 What the caller promises:

 The mesh is null or one of this library; `count` is null or a place for a number.
 */
const double *ltbw_mesh_points(const struct ltbw_mesh *mesh, size_t *count);

/*
 Corners of the tetrahedra, four each; their number goes to `count`.

 What the caller promises:

 The mesh is null or one of this library; `count` is null or a place for a number.
 */
const uint32_t *ltbw_mesh_tets(const struct ltbw_mesh *mesh, size_t *count);

/*
 Across the face opposite each corner the tetrahedron there, or `UINT32_MAX`; the number of rows
 goes to `count`.

 What the caller promises:

 The mesh is null or one of this library; `count` is null or a place for a number.
 */
const uint32_t *ltbw_mesh_neighbours(const struct ltbw_mesh *mesh, size_t *count);

/*
 Facets of the convex hull of all vertices, three corners each, counterclockwise from outside.

 What the caller promises:

 The mesh is null or one of this library; `count` is null or a place for a number.
 */
const uint32_t *ltbw_mesh_hull(const struct ltbw_mesh *mesh, size_t *count);

/*
 Boundary triangles of a domain, three corners each, counterclockwise from outside.

 What the caller promises:

 The mesh is null or one of this library; `count` is null or a place for a number.
 */
const uint32_t *ltbw_mesh_boundary(const struct ltbw_mesh *mesh, size_t *count);

/*
 The markers of the facets that the boundary triangles are part of.

 What the caller promises:

 The mesh is null or one of this library; `count` is null or a place for a number.
 */
const int64_t *ltbw_mesh_boundary_markers(const struct ltbw_mesh *mesh, size_t *count);

/*
 The region of each tetrahedron, from 1.

 What the caller promises:

 The mesh is null or one of this library; `count` is null or a place for a number.
 */
const uint32_t *ltbw_mesh_regions(const struct ltbw_mesh *mesh, size_t *count);

/*
 The tetrahedra over a bound.

 What the caller promises:

 The mesh is null or one of this library; `count` is null or a place for a number.
 */
const uint32_t *ltbw_mesh_excused(const struct ltbw_mesh *mesh, size_t *count);

/*
 The reason why the `number`-th of them is; NULL where there is none.

 What the caller promises:

 The mesh is null or one of this library.
 */
const char *ltbw_mesh_excuse(const struct ltbw_mesh *mesh, size_t number);

/*
 The certificate as JSON: of points made anew, of a domain the one that came with the mesh; NULL
 if the mesh was not checked.

 What the caller promises:

 The mesh is null or one of this library.
 */
const char *ltbw_mesh_certificate(const struct ltbw_mesh *mesh);

/*
 The `number`-th of the notes on how the mesh came about, for people to read: repairs of its
 domain, say, or points that are nearly in one plane; NULL where there is none.

 What the caller promises:

 The mesh is null or one of this library.
 */
const char *ltbw_mesh_note(const struct ltbw_mesh *mesh, size_t number);

/*
 The message of this thread's last failure; empty before the first. It lives until the next one.
 */
const char *ltbw_last_error(void);

/*
 The code of this thread's last failure: a short name that stays the same between versions.
 */
const char *ltbw_last_error_code(void);

/*
 The numbers of the elements at fault in this thread's last failure, counted from 0; their number
 goes to `count`. They live until the next failure.

 What the caller promises:

 `count` is null or a place for a number.
 */
const uint32_t *ltbw_last_error_ids(size_t *count);

/*
 The version of the library.
 */
const char *ltbw_version(void);

/*
 The Delaunay mesh of `count` points, three coordinates each.

 What the caller promises:

 Pointers as at the head of the crate; `run` may be null.
 */
enum ltbw_status ltbw_delaunay(const double *coordinates,
                               size_t count,
                               const struct ltbw_run *run,
                               struct ltbw_mesh **out);

/*
 The Delaunay mesh of points without those of them that are named: the mesh of the others. All
 keep their numbers; those removed are in no tetrahedron. Duplicates go with their vertex.

 What the caller promises:

 Pointers as at the head of the crate; `run` may be null.
 */
enum ltbw_status ltbw_delaunay_without(const struct ltbw_points *given,
                                       const struct ltbw_run *run,
                                       struct ltbw_mesh **out);

/*
 A conforming Delaunay mesh of the domain that a surface bounds.

 What the caller promises:

 Pointers as at the head of the crate; `wishes` and `run` may be null.
 */
enum ltbw_status ltbw_tetrahedralize(const struct ltbw_surface *surface,
                                     const struct ltbw_wishes *wishes,
                                     const struct ltbw_run *run,
                                     struct ltbw_mesh **out);

/*
 A conforming Delaunay mesh of the domain in a file: `.poly .smesh .off .obj .stl .ply
 .vtk`.

 What the caller promises:

 Pointers as at the head of the crate; `wishes` and `run` may be null.
 */
enum ltbw_status ltbw_tetrahedralize_file(const char *file,
                                          const struct ltbw_wishes *wishes,
                                          const struct ltbw_run *run,
                                          struct ltbw_mesh **out);

/*
 Frees a mesh and all its arrays; NULL is nothing to free.

 What the caller promises:

 The mesh is null, or comes from this library and was not freed yet.
 */
void ltbw_mesh_free(struct ltbw_mesh *mesh);

/*
 The state in which the work ended.

 What the caller promises:

 The mesh is one of this library.
 */
enum ltbw_outcome ltbw_mesh_outcome(const struct ltbw_mesh *mesh);

/*
 The place that the mesh's coordinates are relative to: zeros, but of a domain far from the
 origin in a frame that is not its own. Three numbers go to `offset`.

 What the caller promises:

 The mesh is one of this library; `offset` has room for three numbers.
 */
enum ltbw_status ltbw_mesh_offset(const struct ltbw_mesh *mesh, double *offset);

/*
 For each of `count` points, in the mesh's coordinates, a tetrahedron that holds it, or
 `UINT32_MAX`: goes to `found`.

 What the caller promises:

 Pointers as at the head of the crate; `found` has room for `count` numbers.
 */
enum ltbw_status ltbw_mesh_find(const struct ltbw_mesh *mesh,
                                const double *coordinates,
                                size_t count,
                                uint32_t *found);

/*
 The canonical hash `ltbw.mesh/1`: 64 hexadecimal digits and a zero go to `hash`.

 What the caller promises:

 The mesh is one of this library; `hash` has room for 65 characters.
 */
enum ltbw_status ltbw_mesh_hash(const struct ltbw_mesh *mesh, char *hash);

/*
 Writes the mesh; the extension tells the format: `.vtu .vtk .msh .mesh .ele`.

 What the caller promises:

 Pointers as at the head of the crate.
 */
enum ltbw_status ltbw_mesh_save(const struct ltbw_mesh *mesh, const char *file);

/*
 The orientation of a tetrahedron: positive if it is that of the origin and the three unit
 vectors in their order.

 What the caller promises:

 Each pointer is null or points to three numbers.
 */
int32_t ltbw_orient3d(const double *a, const double *b, const double *c, const double *d);

/*
 Positive if e is inside the sphere through a, b, c, d, a tetrahedron of positive orientation.

 What the caller promises:

 Each pointer is null or points to three numbers.
 */
int32_t ltbw_insphere(const double *a,
                      const double *b,
                      const double *c,
                      const double *d,
                      const double *e);

/*
 Positive if e is inside the perturbed sphere: never 0 for five different points.

 What the caller promises:

 Each pointer is null or points to three numbers.
 */
int32_t ltbw_side_of_sphere(const double *a,
                            const double *b,
                            const double *c,
                            const double *d,
                            const double *e);

/*
 Positive if d is beyond the perturbed hull facet a, b, c.

 What the caller promises:

 Each pointer is null or points to three numbers.
 */
int32_t ltbw_side_of_hull_facet(const double *a,
                                const double *b,
                                const double *c,
                                const double *d);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* LTBW_H */

/* One of zeros, which asks for nothing, and its size. */
static inline ltbw_run ltbw_run_new(void) {
  ltbw_run made;
  memset(&made, 0, sizeof made);
  made.struct_size = (uint32_t)sizeof made;
  return made;
}

/* One of zeros, which asks for nothing, and its size. */
static inline ltbw_points ltbw_points_new(void) {
  ltbw_points made;
  memset(&made, 0, sizeof made);
  made.struct_size = (uint32_t)sizeof made;
  return made;
}

/* One of zeros, which asks for nothing, and its size. */
static inline ltbw_surface ltbw_surface_new(void) {
  ltbw_surface made;
  memset(&made, 0, sizeof made);
  made.struct_size = (uint32_t)sizeof made;
  return made;
}

/* One of zeros, which asks for nothing, and its size. */
static inline ltbw_wishes ltbw_wishes_new(void) {
  ltbw_wishes made;
  memset(&made, 0, sizeof made);
  made.struct_size = (uint32_t)sizeof made;
  return made;
}
