// A surface in a file to a mesh with sizes, checked: to copy. Usage: domain part.stl mesh.vtu

#include <cstdio>
#include <ltbw.h>
#include <memory>

namespace {

struct Free {
  void operator()(ltbw_mesh *mesh) const { ltbw_mesh_free(mesh); }
};

int fail() {
  std::fprintf(stderr, "%s (%s)\n", ltbw_last_error(), ltbw_last_error_code());
  return 1;
}

// Edge lengths at a place; `context` is what the wishes say, here the least of all.
double finer_at_the_bottom(void *context, const double *p) {
  const double least = *static_cast<const double *>(context);
  return p[2] > 0 ? least + 0.2 * p[2] : least;
}

} // namespace

int main(int count, char **words) {
  if (count != 3) {
    std::fprintf(stderr, "usage: domain SURFACE MESH\n");
    return 2;
  }
  double least = 0.05;
  ltbw_wishes wishes = ltbw_wishes_new();
  wishes.radius_edge = 2.0;
  wishes.size = finer_at_the_bottom;
  wishes.context = &least;
  ltbw_mesh *made = nullptr;
  if (ltbw_tetrahedralize_file(words[1], &wishes, nullptr, &made) != LTBW_OK) {
    return fail();
  }
  const std::unique_ptr<ltbw_mesh, Free> mesh(made);
  size_t tets = 0;
  ltbw_mesh_tets(mesh.get(), &tets);
  std::printf("%zu tetrahedra\n%s\n", tets, ltbw_mesh_certificate(mesh.get()));
  return ltbw_mesh_save(mesh.get(), words[2]) == LTBW_OK ? 0 : fail();
}
