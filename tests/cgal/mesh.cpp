// CGAL's Mesh_3 beside our meshes, for tests/quality/beside.py.
//
//   mesh DOMAIN.off SIZE plain|perturb|exude|both OUT
//
// DOMAIN has closed surfaces of triangles; what is inside an odd number of them is meshed. SIZE
// bounds edges, and the radii of the balls of facets and cells; radius to shortest edge is 2 at
// most, an angle of a facet 25 degrees at least. OUT takes the mesh: `VERTICES TETRAHEDRA`, then
// vertices and tetrahedra, numbered from 0. Prints the seconds of the processor.

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_polyhedron_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/exude_mesh_3.h>
#include <CGAL/make_mesh_3.h>
#include <CGAL/perturb_mesh_3.h>

#include <ctime>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <string>
#include <unordered_map>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Mesh_polyhedron_3<Kernel>::type;
using Domain = CGAL::Polyhedral_mesh_domain_with_features_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, Domain::Corner_index,
                                                        Domain::Curve_index>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;
namespace with = CGAL::parameters;

static double seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

static Surface read(const char* path) {
  std::ifstream file(path);
  Surface surface;
  file >> surface;
  if (!file || surface.empty()) {
    std::cerr << path << " is no surface of triangles\n";
    std::exit(1);
  }
  return surface;
}

int main(int count, char** words) {
  if (count != 5) {
    std::cerr << "mesh DOMAIN.off SIZE plain|perturb|exude|both OUT\n";
    return 2;
  }
  const std::string way = words[3];
  const double size = std::stod(words[2]);
  const Surface surface = read(words[1]);
  Domain domain(surface);
  domain.detect_features(60);
  const Criteria criteria(with::edge_size = size, with::facet_angle = 25, with::facet_size = size,
                          with::cell_radius_edge_ratio = 2, with::cell_size = size);
  const double start = seconds();
  Complex mesh =
      CGAL::make_mesh_3<Complex>(domain, criteria, with::no_perturb(), with::no_exude());
  if (way == "perturb" || way == "both") CGAL::perturb_mesh_3(mesh, domain);
  if (way == "exude" || way == "both") CGAL::exude_mesh_3(mesh);
  const double taken = seconds() - start;

  std::unordered_map<Triangulation::Vertex_handle, std::size_t> number;
  std::ofstream out(words[4]);
  const auto& triangulation = mesh.triangulation();
  for (auto cell = mesh.cells_in_complex_begin(); cell != mesh.cells_in_complex_end(); ++cell)
    for (int k = 0; k < 4; ++k) number.emplace(cell->vertex(k), 0);
  out << number.size() << ' ' << mesh.number_of_cells_in_complex() << '\n'
      << std::setprecision(17);
  std::size_t next = 0;
  for (auto v = triangulation.finite_vertices_begin(); v != triangulation.finite_vertices_end();
       ++v) {
    const auto own = number.find(v);
    if (own == number.end()) continue;
    own->second = next++;
    const auto& p = v->point();
    out << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
  }
  for (auto cell = mesh.cells_in_complex_begin(); cell != mesh.cells_in_complex_end(); ++cell) {
    for (int k = 0; k < 4; ++k) out << number.at(cell->vertex(k)) << (k < 3 ? ' ' : '\n');
  }
  std::cout << taken << '\n';
  return out.good() ? 0 : 1;
}
