#include <earpoint/spatial/direction_mesh.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr int kAzimuthCells = 36;
constexpr int kHeightCells = 18;
// How far outside of a triangle still counts as inside: rounding of unit vectors.
constexpr double kEdgeTolerance = 1e-9;
// A hull of less volume is flat. moved_off_circle() gives a flat one far less volume than this.
constexpr double kFlat = 1e-4;

// Moves directions slightly in or out, so that four on a circle (rings of equal elevation) have one
// triangulation. A smooth function of |y| keeps left and right alike. The shift is larger than the
// rounding of angles in files and smaller than the bulge of the sphere over half a degree.
Vector3 moved_off_circle(const Vector3& v) {
  constexpr double kAmplitude = 3e-6;
  return v * (1.0 + kAmplitude * std::sin(12.9 * v.x + 78.2 * std::abs(v.y) + 37.7 * v.z));
}

struct Tetrahedron {
  std::array<int, 4> corners{};
  double volume = 0.0;  // six-fold, signed
};

// Four directions far from any common plane, found greedily.
Tetrahedron wide_tetrahedron(std::span<const Vector3> points) {
  const auto farthest = [&](auto measure) {
    int best = 0;
    for (int i = 1; i < std::ssize(points); ++i) {
      if (measure(points[i]) > measure(points[best])) best = i;
    }
    return best;
  };
  const Vector3& a = points[0];
  const int b = farthest([&](const Vector3& p) { return norm(p - a); });
  const Vector3 ab = points[b] - a;
  const int c = farthest([&](const Vector3& p) { return norm(cross(ab, p - a)); });
  const Vector3 plane = cross(ab, points[c] - a);
  const int d = farthest([&](const Vector3& p) { return std::abs(dot(plane, p - a)); });
  return {{0, b, c, d}, dot(plane, points[d] - a)};
}

}  // namespace

struct DirectionMesh::Face {
  std::array<int, 3> corners{};
  Vector3 normal;
  double offset = 0.0;

  Face(int a, int b, int c, std::span<const Vector3> points) : corners{a, b, c} {
    normal = cross(points[b] - points[a], points[c] - points[a]);
    offset = dot(normal, points[a]);
  }
  [[nodiscard]] bool sees(const Vector3& point) const { return dot(normal, point) > offset; }
};

// Incremental convex hull: each point replaces the faces that it sees by a fan over their rim.
std::vector<DirectionMesh::Face> DirectionMesh::hull(std::span<const Vector3> points) {
  const auto [corners, volume] = wide_tetrahedron(points);
  EARPOINT_CHECK(std::abs(volume) > kFlat);
  const auto [a, b, c, d] = corners;
  const int e = volume < 0.0 ? b : c;  // counter-clockwise seen from outside
  const int f = volume < 0.0 ? c : b;
  std::vector<Face> faces = {
      {a, e, f, points}, {a, d, e, points}, {e, d, f, points}, {f, d, a, points}};

  std::vector<Face> kept;
  std::vector<std::pair<int, int>> edges;
  for (int i = 0; i < std::ssize(points); ++i) {
    if (i == a || i == b || i == c || i == d) continue;
    kept.clear();
    edges.clear();
    for (const Face& face : faces) {
      if (!face.sees(points[i])) {
        kept.push_back(face);
        continue;
      }
      for (int k = 0; k < 3; ++k) edges.emplace_back(face.corners[k], face.corners[(k + 1) % 3]);
    }
    std::sort(edges.begin(), edges.end());
    for (const auto& [from, to] : edges) {
      // An edge of two removed faces is inside of the hole; the others are its rim.
      if (!std::binary_search(edges.begin(), edges.end(), std::pair(to, from))) {
        kept.emplace_back(from, to, i, points);
      }
    }
    faces.swap(kept);
  }
  return faces;
}

bool DirectionMesh::spans_space(std::span<const Vector3> directions) {
  return directions.size() >= 4 && std::abs(wide_tetrahedron(directions).volume) > kFlat;
}

DirectionMesh::DirectionMesh(std::span<const Vector3> directions)
    : directions_(directions.begin(), directions.end()) {
  EARPOINT_CHECK(directions_.size() >= 4);
  std::vector<Vector3> points;
  for (const Vector3& direction : directions_) {
    EARPOINT_CHECK(std::abs(norm(direction) - 1.0) < 1e-6);
    points.push_back(moved_off_circle(direction));
  }
  std::map<std::pair<int, int>, int> triangle_of_edge;
  for (const Face& face : hull(points)) {
    const auto [i, j, k] = face.corners;
    const Vector3& u = directions_[i];
    const Vector3& v = directions_[j];
    const Vector3& w = directions_[k];
    const double determinant = dot(u, cross(v, w));
    // The origin is in the face's plane or on its outer side: there are no directions in a whole
    // hemisphere, and the face closes this gap.
    if (determinant < 1e-9) continue;
    const int index = static_cast<int>(triangles_.size());
    triangle_of_edge[{j, k}] = triangle_of_edge[{k, i}] = triangle_of_edge[{i, j}] = index;
    triangles_.push_back(
        {face.corners,
         {},
         {cross(v, w) / determinant, cross(w, u) / determinant, cross(u, v) / determinant}});
  }
  EARPOINT_CHECK(!triangles_.empty());
  for (Triangle& triangle : triangles_) {
    for (int corner = 0; corner < 3; ++corner) {
      const std::pair edge(triangle.corners[(corner + 2) % 3], triangle.corners[(corner + 1) % 3]);
      const auto found = triangle_of_edge.find(edge);
      triangle.neighbours[corner] = found == triangle_of_edge.end() ? -1 : found->second;
    }
  }
  join();
  starts_.assign(static_cast<std::size_t>(kAzimuthCells) * kHeightCells, 0);
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    Vector3 middle;
    for (const int corner : triangles_[i].corners) middle = middle + directions_[corner];
    starts_[start(normalized(middle))] = static_cast<int>(i);
  }
}

int DirectionMesh::start(const Vector3& unit) const {
  const double turns = std::atan2(unit.y, unit.x) / (2.0 * kPi) + 0.5;
  const int column = std::clamp(static_cast<int>(turns * kAzimuthCells), 0, kAzimuthCells - 1);
  const int row =
      std::clamp(static_cast<int>((unit.z + 1.0) / 2.0 * kHeightCells), 0, kHeightCells - 1);
  return row * kAzimuthCells + column;
}

std::array<double, 3> DirectionMesh::weights(const Triangle& triangle, const Vector3& v) const {
  return {dot(triangle.inverse[0], v), dot(triangle.inverse[1], v), dot(triangle.inverse[2], v)};
}

// The triangle around a unit vector, or -1.
int DirectionMesh::find(const Vector3& unit) const {
  const auto contains = [&](const std::array<double, 3>& w) {
    return *std::min_element(w.begin(), w.end()) >= -kEdgeTolerance;
  };
  // Walk across the edge that the direction lies farthest beyond.
  int current = starts_[start(unit)];
  for (std::size_t step = 0; step < triangles_.size() && current >= 0; ++step) {
    const Triangle& triangle = triangles_[current];
    const std::array<double, 3> found = weights(triangle, unit);
    if (contains(found)) return current;
    current = triangle.neighbours[std::min_element(found.begin(), found.end()) - found.begin()];
  }
  // The walk met the rim of an open mesh or went round in a circle: search all triangles.
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    if (contains(weights(triangles_[i], unit))) return static_cast<int>(i);
  }
  return -1;
}

int DirectionMesh::nearest(const Vector3& direction) const {
  EARPOINT_CHECK(norm(direction) > 0.0);
  const Vector3 unit = normalized(direction);
  const int triangle = find(unit);
  if (triangle < 0) {
    const auto best = std::ranges::max_element(
        directions_, {}, [&](const Vector3& other) { return dot(other, unit); });
    return static_cast<int>(best - directions_.begin());
  }
  // Step to the nearest joined direction while one is nearer: in a Delaunay triangulation this ends
  // at the nearest of all.
  int best = triangles_[triangle].corners[0];
  for (bool moved = true; moved;) {
    moved = false;
    const int here = best;
    for (int k = joined_begin_[here]; k < joined_begin_[here + 1]; ++k) {
      if (dot(directions_[joined_[k]], unit) > dot(directions_[best], unit)) {
        best = joined_[k];
        moved = true;
      }
    }
  }
  return best;
}

// Lists for each direction the directions that share an edge with it.
void DirectionMesh::join() {
  std::vector<std::vector<int>> joined(directions_.size());
  for (const Triangle& triangle : triangles_) {
    for (int k = 0; k < 3; ++k) {
      joined[triangle.corners[k]].push_back(triangle.corners[(k + 1) % 3]);
      joined[triangle.corners[k]].push_back(triangle.corners[(k + 2) % 3]);
    }
  }
  joined_begin_.push_back(0);
  for (std::vector<int>& row : joined) {
    std::ranges::sort(row);
    row.erase(std::unique(row.begin(), row.end()), row.end());
    joined_.insert(joined_.end(), row.begin(), row.end());
    joined_begin_.push_back(static_cast<int>(joined_.size()));
  }
}

DirectionMesh::Place DirectionMesh::locate(const Vector3& direction) const {
  EARPOINT_CHECK(norm(direction) > 0.0);
  const Vector3 unit = normalized(direction);
  const int index = find(unit);
  if (index < 0) {
    const int corner = nearest(unit);
    return {{corner, corner, corner}, {1.0, 0.0, 0.0}};
  }
  Place place{triangles_[index].corners, weights(triangles_[index], unit)};
  double sum = 0.0;
  for (double& weight : place.weights) sum += weight = std::max(weight, 0.0);
  for (double& weight : place.weights) weight /= sum;
  return place;
}

}  // namespace earpoint
