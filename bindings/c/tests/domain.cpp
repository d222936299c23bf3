// What C++ asks of a domain: a size function, progress, regions, a file, a frame, errors.

#include <cstdio>
#include <ltbw.h>
#include <memory>
#include <string>
#include <vector>

namespace {

struct Free {
  void operator()(ltbw_mesh *mesh) const { ltbw_mesh_free(mesh); }
};
using Mesh = std::unique_ptr<ltbw_mesh, Free>;

double fine_near_x0(void *context, const double *p) {
  ++*static_cast<long *>(context);
  return 0.1 + 0.4 * p[0];
}

double no_length(void *, const double *) { return -1.0; }

int32_t stop(void *, uint64_t, uint64_t) { return 1; }

int fail(const char *what) {
  std::fprintf(stderr, "%s: %s (%s)\n", what, ltbw_last_error(), ltbw_last_error_code());
  return 1;
}

} // namespace

int main(int count, char **words) {
  std::vector<double> vertices;
  for (int v = 0; v < 8; ++v) {
    vertices.insert(vertices.end(), {double(v >> 2 & 1), double(v >> 1 & 1), double(v & 1)});
  }
  const std::vector<uint32_t> corners = {0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1,
                                         2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3};
  const std::vector<uint32_t> four(6, 4);
  const std::vector<int32_t> markers = {10, 11, 12, 13, 14, 15};
  ltbw_surface surface = ltbw_surface_new();
  surface.vertices = vertices.data();
  surface.vertex_count = 8;
  surface.corners = corners.data();
  surface.corner_counts = four.data();
  surface.face_count = 6;
  surface.markers = markers.data();

  long asked = 0;
  ltbw_wishes wishes = ltbw_wishes_new();
  wishes.radius_edge = 2.0;
  wishes.size = fine_near_x0;
  wishes.context = &asked;
  ltbw_mesh *made = nullptr;
  if (ltbw_tetrahedralize(&surface, &wishes, nullptr, &made) != LTBW_OK) {
    return fail("tetrahedralize");
  }
  Mesh mesh(made);
  size_t tets = 0, faces = 0, marked = 0, regions = 0, excused = 0;
  ltbw_mesh_tets(made, &tets);
  ltbw_mesh_boundary(made, &faces);
  const int64_t *marks = ltbw_mesh_boundary_markers(made, &marked);
  ltbw_mesh_regions(made, &regions);
  ltbw_mesh_excused(made, &excused);
  if (ltbw_mesh_outcome(made) != LTBW_MET || asked == 0 || faces != marked || regions != tets ||
      excused != 0 || ltbw_mesh_excuse(made, 0) != nullptr) {
    return fail("arrays");
  }
  for (size_t f = 0; f < marked; ++f) {
    if (marks[f] < 10 || marks[f] > 15) {
      return fail("markers");
    }
  }
  double offset[3] = {1, 1, 1};
  if (ltbw_mesh_offset(made, offset) != LTBW_OK || offset[0] != 0 || offset[1] != 0 ||
      offset[2] != 0) {
    return fail("offset");
  }
  const char *certificate = ltbw_mesh_certificate(made);
  if (certificate == nullptr ||
      std::string(certificate).find("\"passed\":true") == std::string::npos) {
    return fail("certificate");
  }
  std::printf("%zu tetrahedra, %zu boundary triangles, %ld sizes\n", tets, faces, asked);

  // A file, if one is named.
  if (count > 1 && ltbw_mesh_save(made, words[1]) != LTBW_OK) {
    return fail("save");
  }
  if (ltbw_mesh_save(made, "/no/such/folder/a.vtu") != LTBW_FILE) {
    return fail("a file in no folder");
  }

  // What is wrong is told.
  made = nullptr;
  wishes.size = no_length;
  if (ltbw_tetrahedralize(&surface, &wishes, nullptr, &made) != LTBW_INPUT || made != nullptr) {
    return fail("a size that is no length");
  }
  wishes = ltbw_wishes_new();
  wishes.max_volume = -1.0;
  if (ltbw_tetrahedralize(&surface, &wishes, nullptr, &made) != LTBW_INPUT) {
    return fail("a volume below nothing");
  }
  surface.face_count = 5;
  if (ltbw_tetrahedralize(&surface, nullptr, nullptr, &made) != LTBW_DOMAIN) {
    return fail("an open surface");
  }
  surface.face_count = 6;

  // Far from the origin coordinates are relative to a place, unless the frame is the surface's own.
  std::vector<double> far = vertices;
  for (double &x : far) {
    x += 5e5;
  }
  surface.vertices = far.data();
  for (int32_t frame = 0; frame < 4; ++frame) {
    wishes = ltbw_wishes_new();
    wishes.frame = frame;
    made = nullptr;
    const ltbw_status status = ltbw_tetrahedralize(&surface, &wishes, nullptr, &made);
    Mesh one(made);
    if (frame == 3 ? status != LTBW_INPUT
                   : status != LTBW_OK || ltbw_mesh_offset(made, offset) != LTBW_OK ||
                         (offset[0] == 0) != (frame == 1)) {
      return fail("frame");
    }
  }
  surface.vertices = vertices.data();

  // Progress may end the work, here far from its end: the mesh so far, or none yet.
  wishes = ltbw_wishes_new();
  wishes.max_volume = 1e-8;
  ltbw_run run = ltbw_run_new();
  run.progress = stop;
  const ltbw_status status = ltbw_tetrahedralize(&surface, &wishes, &run, &made);
  Mesh stopped(made);
  const bool kept = status == LTBW_OK && ltbw_mesh_outcome(made) == LTBW_STOPPED;
  if (!kept && status != LTBW_CANCELLED) {
    return fail("stop");
  }
  return 0;
}
