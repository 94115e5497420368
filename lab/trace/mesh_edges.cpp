#include "mesh_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kSamePoint_m = 1e-3;
// Faces with a smaller angle between their normals have no crease: 15 degrees.
constexpr double kFlatCosine = 0.966;

using Cell = std::array<std::int64_t, 3>;
struct CellHash {
  std::size_t operator()(const Cell& cell) const {
    std::uint64_t hash = 0;
    for (const std::int64_t part : cell) {
      hash = (hash ^ static_cast<std::uint64_t>(part)) * 0x9E3779B97F4A7C15U;
      hash ^= hash >> 29;
    }
    return static_cast<std::size_t>(hash);
  }
};

Cell cell_of(const Vector3& point, double size_m) {
  return {std::llround(point.x / size_m), std::llround(point.y / size_m),
          std::llround(point.z / size_m)};
}

// Numbers vertices by position instead of index.
std::vector<std::uint32_t> weld(const Mesh& mesh) {
  std::unordered_map<Cell, std::uint32_t, CellHash> known;
  std::vector<std::uint32_t> places;
  places.reserve(mesh.positions.size());
  for (std::uint32_t i = 0; i < mesh.positions.size(); ++i) {
    places.push_back(known.try_emplace(cell_of(vertex(mesh, i), kSamePoint_m), i).first->second);
  }
  return places;
}

struct MeshEdge {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  std::uint32_t triangle = 0;
};

std::vector<MeshEdge> triangle_edges(const Mesh& mesh, const std::vector<bool>& counts) {
  const std::vector<std::uint32_t> places = weld(mesh);
  std::vector<MeshEdge> edges;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!counts[mesh.triangle_instance[i]]) continue;
    for (int side = 0; side < 3; ++side) {
      const std::uint32_t a = places[mesh.triangles[i][side]];
      const std::uint32_t b = places[mesh.triangles[i][(side + 1) % 3]];
      if (a != b) edges.push_back({std::min(a, b), std::max(a, b), i});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const MeshEdge& x, const MeshEdge& y) {
    return std::tie(x.a, x.b, x.triangle) < std::tie(y.a, y.b, y.triangle);
  });
  return edges;
}

// Whether all triangles of the edge lie in one plane, on both sides of the edge.
bool is_flat(const Mesh& mesh, const MeshEdge* first, const MeshEdge* last) {
  if (last - first < 2) return false;
  const Vector3 normal = normalized(scaled_normal(mesh, first->triangle));
  for (const MeshEdge* edge = first + 1; edge != last; ++edge) {
    const double cosine = dot(normal, normalized(scaled_normal(mesh, edge->triangle)));
    if (std::abs(cosine) < kFlatCosine) return false;
  }
  return true;
}

// A line in space: its direction and the point nearest to the origin, rounded.
using LineKey = std::array<std::int64_t, 6>;
struct Line {
  Vector3 direction;
  Vector3 foot;
};

Line line_through(const Vector3& a, const Vector3& b) {
  Vector3 direction = normalized(b - a);
  // One of the two directions, the same for both ways round.
  const bool flip = direction.x < -1e-4 ||
                    (std::abs(direction.x) <= 1e-4 &&
                     (direction.y < -1e-4 || (std::abs(direction.y) <= 1e-4 && direction.z < 0.0)));
  if (flip) direction = -direction;
  return {direction, a - direction * dot(a, direction)};
}

LineKey line_key(const Line& line) {
  const Cell direction = cell_of(line.direction, 0.01);
  const Cell foot = cell_of(line.foot, 0.01);
  return {direction[0], direction[1], direction[2], foot[0], foot[1], foot[2]};
}

struct Stretch {
  double begin = 0.0;
  double end = 0.0;
};

void join(const Line& line, std::vector<Stretch> stretches, double shortest_m,
          std::vector<Crease>& creases) {
  std::sort(stretches.begin(), stretches.end(),
            [](const Stretch& x, const Stretch& y) { return x.begin < y.begin; });
  for (std::size_t i = 0; i < stretches.size();) {
    Stretch joined = stretches[i++];
    while (i < stretches.size() && stretches[i].begin <= joined.end + 2.0 * kSamePoint_m) {
      joined.end = std::max(joined.end, stretches[i++].end);
    }
    if (joined.end - joined.begin < shortest_m) continue;
    creases.push_back(
        {line.foot + line.direction * joined.begin, line.foot + line.direction * joined.end});
  }
}

}  // namespace

std::vector<Crease> find_creases(const Mesh& mesh, const std::vector<bool>& counts,
                                 double shortest_m) {
  const std::vector<MeshEdge> edges = triangle_edges(mesh, counts);
  std::map<LineKey, std::pair<Line, std::vector<Stretch>>> lines;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end].a == edges[i].a && edges[end].b == edges[i].b) ++end;
    if (!is_flat(mesh, &edges[i], edges.data() + end)) {
      const Vector3 a = vertex(mesh, edges[i].a);
      const Vector3 b = vertex(mesh, edges[i].b);
      const Line line = line_through(a, b);
      auto& [known, stretches] =
          lines.try_emplace(line_key(line), line, std::vector<Stretch>{}).first->second;
      const double from = dot(a, known.direction);
      const double to = dot(b, known.direction);
      stretches.push_back({std::min(from, to), std::max(from, to)});
    }
    i = end;
  }
  std::vector<Crease> creases;
  for (const auto& [key, line] : lines) join(line.first, line.second, shortest_m, creases);
  return creases;
}

}  // namespace earpoint
