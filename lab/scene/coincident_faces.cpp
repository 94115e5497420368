#include <earpoint/scene/coincident_faces.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace earpoint {
namespace {

using Corners = std::array<Vector3, 3>;
using Point = std::array<double, 2>;
using Flat = std::array<Point, 3>;

/// A triangle in the coordinates of its plane, and the plane to within rounding.
struct Face {
  std::uint32_t triangle = 0;
  std::array<int, 3> facing{};  // the normal, rounded; the same for both sides
  double offset_m = 0.0;        // of the plane, along the normal
  Flat flat{};                  // along the two axes that the plane lies nearest to
  double low = 0.0;             // of the first of them
  double high = 0.0;
};

Face make_face(std::uint32_t triangle, const Corners& corners, Vector3 normal) {
  constexpr double kSteps = 256.0;
  const auto rounded = [](double x) { return static_cast<int>(std::lround(x * kSteps)); };
  Face face{.triangle = triangle};
  face.facing = {rounded(normal.x), rounded(normal.y), rounded(normal.z)};
  if (face.facing < std::array<int, 3>{}) {
    normal = -normal;
    for (int& component : face.facing) component = -component;
  }
  face.offset_m = dot(normal, (corners[0] + corners[1] + corners[2]) / 3.0);
  const std::array<double, 3> size = {std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)};
  const auto across = std::max_element(size.begin(), size.end()) - size.begin();
  for (std::size_t i = 0; i < 3; ++i) {
    const std::array<double, 3> p = {corners[i].x, corners[i].y, corners[i].z};
    face.flat[i] = {p[(across + 1) % 3], p[(across + 2) % 3]};
  }
  const auto [low, high] = std::minmax({face.flat[0][0], face.flat[1][0], face.flat[2][0]});
  face.low = low;
  face.high = high;
  return face;
}

/// Whether `b` lies beyond one edge of `a`, except for a margin.
bool lies_beside(const Flat& a, const Flat& b, double margin_m) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Point& from = a[i];
    const Point& to = a[(i + 1) % 3];
    const Point& third = a[(i + 2) % 3];
    const Point along = {to[0] - from[0], to[1] - from[1]};
    const double length = std::hypot(along[0], along[1]);
    const auto beside = [&](const Point& p) {
      return (along[0] * (p[1] - from[1]) - along[1] * (p[0] - from[0])) / length;
    };
    const double side = beside(third) < 0.0 ? -1.0 : 1.0;
    const auto inwards = [&](const Point& p) { return side * beside(p); };
    if (std::max({inwards(b[0]), inwards(b[1]), inwards(b[2])}) <= margin_m) return true;
  }
  return false;
}

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Adds the pairs among faces of one plane.
void pair_within(std::span<Face> faces, double margin_m, Pairs& pairs) {
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return std::tie(a.low, a.triangle) < std::tie(b.low, b.triangle);
  });
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (std::size_t k = i + 1; k < faces.size() && faces[k].low < faces[i].high; ++k) {
      if (lies_beside(faces[i].flat, faces[k].flat, margin_m) ||
          lies_beside(faces[k].flat, faces[i].flat, margin_m)) {
        continue;
      }
      pairs.emplace_back(faces[i].triangle, faces[k].triangle);
      pairs.emplace_back(faces[k].triangle, faces[i].triangle);
    }
  }
}

Pairs find_pairs(std::vector<Face> faces, double tolerance_m) {
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return std::tie(a.facing, a.offset_m, a.triangle) < std::tie(b.facing, b.offset_m, b.triangle);
  });
  Pairs pairs;
  for (std::size_t begin = 0; begin < faces.size();) {
    std::size_t end = begin + 1;
    while (end < faces.size() && faces[end].facing == faces[begin].facing &&
           faces[end].offset_m - faces[end - 1].offset_m <= tolerance_m) {
      ++end;
    }
    // Neighbours that share an edge overlap by less than that.
    const double margin_m = 2.0 * tolerance_m;
    pair_within(std::span(faces).subspan(begin, end - begin), margin_m, pairs);
    begin = end;
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace

CoincidentFaces::CoincidentFaces(std::span<const std::array<float, 3>> positions,
                                 std::span<const std::array<std::uint32_t, 3>> triangles) {
  float largest_m = 1.0F;
  for (const std::array<float, 3>& p : positions) {
    for (const float x : p) largest_m = std::max(largest_m, std::abs(x));
  }
  // Above the rounding of positions and distances in single precision.
  const double tolerance_m = 2e-6 * static_cast<double>(largest_m);
  std::vector<Face> faces;
  faces.reserve(triangles.size());
  std::vector<Corners> corners(triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::array<float, 3>& p = positions[triangles[i][k]];
      corners[i][k] = {p[0], p[1], p[2]};
    }
    const Vector3 scaled = cross(corners[i][1] - corners[i][0], corners[i][2] - corners[i][0]);
    const double twice_area = norm(scaled);
    if (twice_area > 0.0) faces.push_back(make_face(i, corners[i], scaled / twice_area));
  }
  const Pairs pairs = find_pairs(std::move(faces), tolerance_m);
  if (pairs.empty()) return;
  corners_ = std::move(corners);
  first_.assign(triangles.size() + 1, 0);
  for (const auto& [triangle, partner] : pairs) {
    ++first_[triangle + 1];
    partners_.push_back(partner);
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
}

/// Source: Moeller and Trumbore, Journal of Graphics Tools 2 (1997).
bool CoincidentFaces::meet(std::uint32_t triangle, const std::array<float, 3>& origin,
                           const std::array<float, 3>& direction) const {
  const auto& [a, b, c] = corners_[triangle];
  const Vector3 d{direction[0], direction[1], direction[2]};
  const Vector3 across = cross(d, c - a);
  const double slope = dot(b - a, across);
  if (slope == 0.0) return false;
  const Vector3 from_corner = Vector3{origin[0], origin[1], origin[2]} - a;
  const double u = dot(from_corner, across) / slope;
  const double v = dot(d, cross(from_corner, b - a)) / slope;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0;
}

}  // namespace earpoint
