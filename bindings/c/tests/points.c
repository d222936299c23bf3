/* What C asks of points and their mesh: neighbours, places, hash, progress, errors. */

#include <inttypes.h>
#include <ltbw.h>
#include <stdio.h>
#include <string.h>

#define COUNT 2000

static int32_t told(void *context, uint64_t done, uint64_t total) {
  (void)done;
  (void)total;
  ++*(unsigned *)context;
  return 0;
}

static int fail(const char *what) {
  fprintf(stderr, "%s: %s (%s)\n", what, ltbw_last_error(), ltbw_last_error_code());
  return 1;
}

int main(void) {
  static double points[COUNT][3];
  uint64_t state = 1;
  for (size_t i = 0; i < COUNT; i++) {
    for (size_t k = 0; k < 3; k++) {
      state = state * 6364136223846793005u + 1442695040888963407u;
      points[i][k] = (double)(state >> 33) / 4294967296.0;
    }
  }

  unsigned calls = 0;
  ltbw_run run = ltbw_run_new();
  run.threads = 2;
  run.progress = told;
  run.context = &calls;
  ltbw_mesh *mesh = NULL;
  if (ltbw_delaunay(points[0], COUNT, &run, &mesh) != LTBW_OK) {
    return fail("delaunay");
  }
  size_t tets = 0, rows = 0, facets = 0;
  const uint32_t *corners = ltbw_mesh_tets(mesh, &tets);
  const uint32_t *neighbours = ltbw_mesh_neighbours(mesh, &rows);
  ltbw_mesh_hull(mesh, &facets);
  size_t outside = 0;
  for (size_t t = 0; t < 4 * rows; t++) {
    outside += neighbours[t] == UINT32_MAX;
  }
  if (ltbw_mesh_outcome(mesh) != LTBW_COMPLETE || rows != tets || outside != facets) {
    return fail("arrays");
  }

  /* Every tetrahedron of the mesh is positive, and holds its own middle. */
  double middle[3] = {0, 0, 0};
  for (size_t i = 0; i < 4; i++) {
    for (size_t k = 0; k < 3; k++) {
      middle[k] += points[corners[i]][k] / 4;
    }
  }
  uint32_t found = 0;
  if (ltbw_orient3d(points[corners[0]], points[corners[1]], points[corners[2]],
                    points[corners[3]]) != 1 ||
      ltbw_mesh_find(mesh, middle, 1, &found) != LTBW_OK || found != 0) {
    return fail("find");
  }

  char hash[65], alone[65];
  if (ltbw_mesh_hash(mesh, hash) != LTBW_OK) {
    return fail("hash");
  }
  printf("%zu tetrahedra, %zu hull facets\nltbw.mesh/1 %s\n", tets, facets, hash);
  const char *certificate = ltbw_mesh_certificate(mesh);
  if (certificate == NULL || strstr(certificate, "\"passed\": true") == NULL) {
    return fail("certificate");
  }
  ltbw_mesh_free(mesh);

  /* One thread makes the same mesh. */
  if (ltbw_delaunay(points[0], COUNT, NULL, &mesh) != LTBW_OK ||
      ltbw_mesh_hash(mesh, alone) != LTBW_OK || strcmp(hash, alone) != 0) {
    return fail("one thread");
  }
  ltbw_mesh_free(mesh);
  ltbw_mesh_free(NULL);

  /* Points can be removed again: the mesh is that of the others. */
  const uint32_t last[] = {COUNT - 1, COUNT - 2};
  ltbw_points most = ltbw_points_new();
  most.coordinates = points[0];
  most.count = COUNT;
  most.without = last;
  most.without_count = 2;
  if (ltbw_delaunay_without(&most, &run, &mesh) != LTBW_OK || ltbw_mesh_hash(mesh, hash) != LTBW_OK) {
    return fail("without");
  }
  ltbw_mesh_free(mesh);
  if (ltbw_delaunay(points[0], COUNT - 2, NULL, &mesh) != LTBW_OK ||
      ltbw_mesh_hash(mesh, alone) != LTBW_OK || strcmp(hash, alone) != 0) {
    return fail("without two of them");
  }
  ltbw_mesh_free(mesh);

  /* What is wrong is told, with the points at fault. */
  size_t count = 0;
  points[7][1] = 0.0 / 0.0;
  ltbw_status status = ltbw_delaunay(points[0], COUNT, NULL, &mesh);
  const uint32_t *ids = ltbw_last_error_ids(&count);
  if (status != LTBW_INPUT || mesh != NULL || count != 1 || ids[0] != 7) {
    return fail("not finite");
  }
  if (ltbw_delaunay(NULL, 4, NULL, &mesh) != LTBW_INPUT ||
      ltbw_delaunay(points[0], 3, NULL, &mesh) != LTBW_INPUT ||
      ltbw_delaunay(points[0], 4, NULL, NULL) != LTBW_INPUT ||
      ltbw_delaunay(points[0], SIZE_MAX, NULL, &mesh) != LTBW_INPUT) {
    return fail("wrong arguments are taken");
  }
  /* A struct tells its size, so that it may grow. */
  run.struct_size = 0;
  if (ltbw_delaunay(points[0], 4, &run, &mesh) != LTBW_INPUT ||
      strcmp(ltbw_last_error_code(), "argument.struct_size") != 0) {
    return fail("no size");
  }
  printf("version %s\n", ltbw_version());
  return 0;
}
