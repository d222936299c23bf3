// The CGAL reference: a Delaunay server on a binary pipe.
//
// What: reads point sets from stdin, triangulates each with CGAL's Delaunay_triangulation_3 over
// exact predicates, and writes the finite tetrahedra, the hull facets and the canonical mesh hash
// `ltbw.mesh/1` to stdout, until end of file. The Rust side is tests/src/cgal.rs.
// Why: a second, unrelated implementation to compare every mesh with. It shares nothing with the
// kernel: the hash, with its SHA-256, is written out here once more.
//
// All numbers little-endian (the program refuses to compile elsewhere).
//   request  u64 command (1: triangulate), u32 flags, u64 n, n * 3 f64
//   flags    1 send tetrahedra, 2 send hull facets, 4 compute the hash, 8 insert in input order
//            (no spatial sort), 16 remove the later half of the points again, one by one: the
//            answer is of the others, the seconds are those of removing; bits 16..31: threads (only the build with LTBW_TBB; 0 and 1: one)
//   reply    u32 status (0 done, 1 dimension below 3, 2 not understood or refused),
//            i32 dimension, u64 distinct vertices, u64 tetrahedra, u64 hull facets,
//            f64 seconds (order and insertion), u64 peak resident bytes, 32 bytes hash,
//            then u32[4] per tetrahedron and u32[3] per hull facet, as far as asked for.
// Indices are the input's, duplicates standing for their smallest index. Facets are oriented
// outwards. After status 2 the server exits: the stream may be out of step.
//
// `--version` prints CGAL's version. `--bench FILE [THREADS]` reads n * 3 f64 from a raw file or a
// `.npy` file of f64 in C order, builds once, and prints one line: seconds, vertices, tetrahedra,
// peak resident bytes.

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/version.h>
#ifdef LTBW_TBB
#include <tbb/global_control.h>
#endif


#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <unordered_map>
#include <unordered_set>
#include <vector>

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the pipe is little-endian");

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Coords = std::array<double, 3>;
using Tet = std::array<std::uint32_t, 4>;
using Facet = std::array<std::uint32_t, 3>;
using Digest = std::array<std::uint8_t, 32>;

enum Flags : std::uint32_t { kTets = 1, kHull = 2, kHash = 4, kInputOrder = 8, kRemove = 16 };
enum Status : std::uint32_t { kDone = 0, kFlat = 1, kRefused = 2 };

// A limit against a garbled length: 2^28 points are 6 GiB of coordinates.
constexpr std::uint64_t kMaxPoints = std::uint64_t{1} << 28;

// ---- SHA-256 (FIPS 180-4) ----------------------------------------------------------------------

class Sha256 {
 public:
  void update(const void* data, std::size_t len) {
    const auto* p = static_cast<const std::uint8_t*>(data);
    total_ += len;
    while (len > 0) {
      const std::size_t take = std::min(len, sizeof block_ - fill_);
      std::memcpy(block_ + fill_, p, take);
      fill_ += take;
      p += take;
      len -= take;
      if (fill_ == sizeof block_) {
        compress();
        fill_ = 0;
      }
    }
  }

  Digest finish() {
    const std::uint64_t bits = total_ * 8;
    const std::uint8_t one = 0x80, zero = 0;
    update(&one, 1);
    while (fill_ != 56) update(&zero, 1);
    std::uint8_t length[8];
    for (int i = 0; i < 8; ++i) length[i] = static_cast<std::uint8_t>(bits >> (56 - 8 * i));
    update(length, 8);
    Digest out;
    for (int i = 0; i < 32; ++i) out[i] = static_cast<std::uint8_t>(h_[i / 4] >> (24 - 8 * (i % 4)));
    return out;
  }

 private:
  static std::uint32_t rotr(std::uint32_t x, int n) { return x >> n | x << (32 - n); }

  void compress() {
    static constexpr std::uint32_t k[64] = {
        0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4,
        0xab1c5ed5, 0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe,
        0x9bdc06a7, 0xc19bf174, 0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f,
        0x4a7484aa, 0x5cb0a9dc, 0x76f988da, 0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7,
        0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967, 0x27b70a85, 0x2e1b2138, 0x4d2c6dfc,
        0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85, 0xa2bfe8a1, 0xa81a664b,
        0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070, 0x19a4c116,
        0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
        0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7,
        0xc67178f2};
    std::uint32_t w[64];
    for (int i = 0; i < 16; ++i) {
      w[i] = std::uint32_t{block_[4 * i]} << 24 | std::uint32_t{block_[4 * i + 1]} << 16 |
             std::uint32_t{block_[4 * i + 2]} << 8 | std::uint32_t{block_[4 * i + 3]};
    }
    for (int i = 16; i < 64; ++i) {
      const std::uint32_t s0 = rotr(w[i - 15], 7) ^ rotr(w[i - 15], 18) ^ w[i - 15] >> 3;
      const std::uint32_t s1 = rotr(w[i - 2], 17) ^ rotr(w[i - 2], 19) ^ w[i - 2] >> 10;
      w[i] = w[i - 16] + s0 + w[i - 7] + s1;
    }
    std::uint32_t a = h_[0], b = h_[1], c = h_[2], d = h_[3];
    std::uint32_t e = h_[4], f = h_[5], g = h_[6], h = h_[7];
    for (int i = 0; i < 64; ++i) {
      const std::uint32_t t1 = h + (rotr(e, 6) ^ rotr(e, 11) ^ rotr(e, 25)) +
                               ((e & f) ^ (~e & g)) + k[i] + w[i];
      const std::uint32_t t2 =
          (rotr(a, 2) ^ rotr(a, 13) ^ rotr(a, 22)) + ((a & b) ^ (a & c) ^ (b & c));
      h = g, g = f, f = e, e = d + t1, d = c, c = b, b = a, a = t1 + t2;
    }
    const std::uint32_t add[8] = {a, b, c, d, e, f, g, h};
    for (int i = 0; i < 8; ++i) h_[i] += add[i];
  }

  std::uint32_t h_[8] = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                         0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::uint8_t block_[64] = {};
  std::size_t fill_ = 0;
  std::uint64_t total_ = 0;
};

// `ltbw.mesh/1`. In a triangulation of dimension 3 every vertex belongs to a finite tetrahedron,
// so the vertices are the distinct points; `sorted` holds them by (x, y, z) with the index that
// the tetrahedra use.
Digest canonical_hash(const std::vector<std::pair<Coords, std::uint32_t>>& sorted,
                      std::size_t inputs, const std::vector<Tet>& tets) {
  std::vector<std::uint32_t> rank(inputs);
  for (std::size_t i = 0; i < sorted.size(); ++i) rank[sorted[i].second] = static_cast<std::uint32_t>(i);
  std::vector<Tet> rows(tets);
  for (Tet& t : rows) {
    for (std::uint32_t& v : t) v = rank[v];
    std::sort(t.begin(), t.end());
  }
  std::sort(rows.begin(), rows.end());
  Sha256 sha;
  sha.update("ltbw.mesh/1\n", 12);
  const std::uint64_t vertices = sorted.size(), count = rows.size();
  sha.update(&vertices, 8);
  for (const auto& v : sorted) sha.update(v.first.data(), 24);
  sha.update(&count, 8);
  sha.update(rows.data(), rows.size() * sizeof(Tet));
  return sha.finish();
}

// ---- triangulation -----------------------------------------------------------------------------

struct Result {
  int dimension = -1;
  std::uint64_t distinct = 0;
  double seconds = 0;
  std::vector<Tet> tets;
  std::vector<Facet> hull;
  Digest hash{};
};

double now() {
  using namespace std::chrono;
  return duration<double>(steady_clock::now().time_since_epoch()).count();
}

std::uint64_t peak_rss() {
  // Not getrusage: its maximum counts the parent's memory from before the exec, too.
  std::FILE* status = std::fopen("/proc/self/status", "r");
  if (status == nullptr) return 0;
  unsigned long long kib = 0;
  char line[256];
  while (std::fgets(line, sizeof line, status) != nullptr)
    if (std::sscanf(line, "VmHWM: %llu", &kib) == 1) break;
  std::fclose(status);
  return kib * 1024;
}

// The distinct points by (x, y, z), each with its smallest input index.
std::vector<std::pair<Coords, std::uint32_t>> distinct_points(const std::vector<Coords>& input) {
  std::vector<std::pair<Coords, std::uint32_t>> sorted(input.size());
  for (std::size_t i = 0; i < input.size(); ++i) sorted[i] = {input[i], static_cast<std::uint32_t>(i)};
  std::sort(sorted.begin(), sorted.end());
  const auto same = [](const auto& a, const auto& b) { return a.first == b.first; };
  sorted.erase(std::unique(sorted.begin(), sorted.end(), same), sorted.end());
  return sorted;
}

template <class Triangulation>
void extract(const Triangulation& tr, const std::vector<Coords>& input, std::uint32_t flags,
             Result& result) {
  result.dimension = tr.dimension();
  result.distinct = tr.number_of_vertices();
  if (tr.dimension() < 3 || !(flags & (kTets | kHull | kHash))) return;
  const auto sorted = distinct_points(input);
  const auto index_of = [&](typename Triangulation::Vertex_handle v) {
    const Point& p = v->point();
    const std::pair<Coords, std::uint32_t> key{{p.x(), p.y(), p.z()}, 0};
    return std::lower_bound(sorted.begin(), sorted.end(), key)->second;
  };
  std::unordered_map<const void*, std::uint32_t> index;
  index.reserve(sorted.size());
  for (auto v = tr.finite_vertices_begin(); v != tr.finite_vertices_end(); ++v) {
    index.emplace(&*v, index_of(v));
  }
  const auto vertex = [&](typename Triangulation::Cell_handle c, int i) {
    return index.at(&*c->vertex(i));
  };
  for (auto c = tr.finite_cells_begin(); c != tr.finite_cells_end(); ++c) {
    result.tets.push_back({vertex(c, 0), vertex(c, 1), vertex(c, 2), vertex(c, 3)});
  }
  if (flags & kHull) {
    for (auto c = tr.all_cells_begin(); c != tr.all_cells_end(); ++c) {
      if (!tr.is_infinite(c)) continue;
      // An infinite cell is positive with a point beyond its facet in the infinite vertex's slot:
      // the even permutations that bring that slot to the end leave the facet turned outwards.
      static constexpr int outward[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};
      const int* o = outward[c->index(tr.infinite_vertex())];
      result.hull.push_back({vertex(c, o[0]), vertex(c, o[1]), vertex(c, o[2])});
    }
  }
  if (flags & kHash) result.hash = canonical_hash(sorted, input.size(), result.tets);
}

// The points of the first half that lie nowhere in the later one stay.
template <class Triangulation>
Result run_and_remove(Triangulation& tr, const std::vector<Coords>& input, std::uint32_t flags) {
  std::vector<typename Triangulation::Vertex_handle> handles;
  typename Triangulation::Vertex_handle hint;
  for (const Coords& p : input) {
    hint = tr.insert(Point(p[0], p[1], p[2]), hint);
    handles.push_back(hint);
  }
  const std::size_t half = input.size() / 2;
  std::vector<Coords> gone(input.begin() + half, input.end()), left;
  std::sort(gone.begin(), gone.end());
  for (std::size_t i = 0; i < half; ++i) {
    if (!std::binary_search(gone.begin(), gone.end(), input[i])) left.push_back(input[i]);
  }
  std::unordered_set<const void*> removed;
  Result result;
  const double start = now();
  for (std::size_t i = half; i < handles.size(); ++i) {
    if (removed.insert(&*handles[i]).second) tr.remove(handles[i]);
  }
  result.seconds = now() - start;
  extract(tr, left, flags, result);
  return result;
}

template <class Triangulation>
Result run(Triangulation& tr, const std::vector<Coords>& input, std::uint32_t flags) {
  std::vector<Point> points;
  points.reserve(input.size());
  for (const Coords& p : input) points.emplace_back(p[0], p[1], p[2]);
  Result result;
  const double start = now();
  if (flags & kInputOrder) {
    typename Triangulation::Vertex_handle hint;
    for (const Point& p : points) hint = tr.insert(p, hint);
  } else {
    tr.insert(points.begin(), points.end());
  }
  result.seconds = now() - start;
  extract(tr, input, flags, result);
  return result;
}

Result triangulate(const std::vector<Coords>& input, std::uint32_t flags) {
#ifdef LTBW_TBB
  const std::size_t threads = std::max<std::size_t>(1, flags >> 16);
  using Tds = CGAL::Triangulation_data_structure_3<
      CGAL::Triangulation_vertex_base_3<Kernel>,
      CGAL::Delaunay_triangulation_cell_base_3<Kernel>, CGAL::Parallel_tag>;
  using Triangulation = CGAL::Delaunay_triangulation_3<Kernel, Tds>;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  CGAL::Bbox_3 box;
  for (const Coords& p : input) box += CGAL::Bbox_3(p[0], p[1], p[2], p[0], p[1], p[2]);
  Triangulation::Lock_data_structure locks(box, 50);
  Triangulation tr(Kernel(), &locks);
#else
  CGAL::Delaunay_triangulation_3<Kernel> tr;
#endif
  return flags & kRemove ? run_and_remove(tr, input, flags) : run(tr, input, flags);
}

// ---- pipe --------------------------------------------------------------------------------------

template <class T>
bool get(T& value) {
  return std::fread(&value, sizeof value, 1, stdin) == 1;
}

template <class T>
void put(const T& value) {
  std::fwrite(&value, sizeof value, 1, stdout);
}

void reply(Status status, const Result& r, std::uint32_t flags) {
  put(static_cast<std::uint32_t>(status));
  put(static_cast<std::int32_t>(r.dimension));
  put(r.distinct);
  put(static_cast<std::uint64_t>(flags & kTets ? r.tets.size() : 0));
  put(static_cast<std::uint64_t>(flags & kHull ? r.hull.size() : 0));
  put(r.seconds);
  put(peak_rss());
  put(r.hash);
  if (flags & kTets) std::fwrite(r.tets.data(), sizeof(Tet), r.tets.size(), stdout);
  if (flags & kHull) std::fwrite(r.hull.data(), sizeof(Facet), r.hull.size(), stdout);
  std::fflush(stdout);
}

// -0 becomes 0; false if a coordinate is not finite (CGAL would not return).
bool clean(std::vector<Coords>& points) {
  for (Coords& p : points) {
    for (double& c : p) {
      if (!(c - c == 0)) return false;
      c += 0.0;
    }
  }
  return true;
}

int serve() {
  std::uint64_t command = 0, n = 0;
  std::uint32_t flags = 0;
  while (get(command)) {
    if (!get(flags) || !get(n)) return 1;
    if (command != 1 || n > kMaxPoints) {
      reply(kRefused, Result{}, 0);
      return 1;
    }
    std::vector<Coords> points(n);
    if (n > 0 && std::fread(points.data(), sizeof(Coords), n, stdin) != n) return 1;
    if (!clean(points)) {
      reply(kRefused, Result{}, 0);
      return 1;
    }
    const Result result = triangulate(points, flags);
    reply(result.dimension < 3 ? kFlat : kDone, result, flags);
  }
  return 0;
}

int bench(const char* path, unsigned threads) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path, "rb"), std::fclose);
  if (!file) {
    std::perror(path);
    return 1;
  }
  // A .npy file of version 1 starts with a 6-byte magic, 2 bytes of version, a u16 length of the
  // text header, and the header; the numbers follow.
  std::uint8_t head[10] = {};
  long skip = 0;
  if (std::fread(head, 1, 10, file.get()) == 10 && std::memcmp(head, "\x93NUMPY\x01", 7) == 0) {
    skip = 10 + head[8] + 256 * head[9];
  }
  std::fseek(file.get(), skip, SEEK_SET);
  std::vector<Coords> points;
  Coords p;
  while (std::fread(p.data(), sizeof p, 1, file.get()) == 1) points.push_back(p);
  if (!clean(points)) {
    std::fprintf(stderr, "%s: a coordinate is not finite\n", path);
    return 1;
  }
  const Result r = triangulate(points, kTets | threads << 16);
  std::printf("%.6f %llu %zu %llu\n", r.seconds, static_cast<unsigned long long>(r.distinct),
              r.tets.size(), static_cast<unsigned long long>(peak_rss()));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc == 2 && std::strcmp(argv[1], "--version") == 0) {
      std::puts(CGAL_VERSION_STR);
      return 0;
    }
    if (argc >= 3 && std::strcmp(argv[1], "--bench") == 0) {
      return bench(argv[2], argc > 3 ? static_cast<unsigned>(std::atoi(argv[3])) : 1);
    }
    return serve();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "cgal server: %s\n", e.what());
    return 1;
  }
}
