/* Points to a mesh: to copy. */

#include <ltbw.h>
#include <stdio.h>

static int fail(void) {
  fprintf(stderr, "%s (%s)\n", ltbw_last_error(), ltbw_last_error_code());
  return 1;
}

int main(void) {
  const double points[][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  ltbw_mesh *mesh = NULL;
  if (ltbw_delaunay(points[0], 5, NULL, &mesh) != LTBW_OK) {
    return fail();
  }

  /* Arrays belong to the mesh: four corners each, the numbers of the points. */
  size_t count = 0;
  const uint32_t *tets = ltbw_mesh_tets(mesh, &count);
  for (size_t t = 0; t < count; t++) {
    printf("%u %u %u %u\n", tets[4 * t], tets[4 * t + 1], tets[4 * t + 2], tets[4 * t + 3]);
  }

  /* The hash is one for any order of the points, any number of threads, any machine. */
  char hash[65];
  if (ltbw_mesh_hash(mesh, hash) != LTBW_OK || ltbw_mesh_save(mesh, "points.vtu") != LTBW_OK) {
    return fail();
  }
  printf("ltbw.mesh/1 %s\n", hash);
  ltbw_mesh_free(mesh);
  return 0;
}
