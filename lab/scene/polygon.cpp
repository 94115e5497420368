#include "polygon.h"

#include <cmath>

namespace earpoint {
namespace {

struct Point2 {
  double u;
  double v;
};

/// Twice the signed area of a triangle.
double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
}

bool inside(const Point2& p, const Point2& a, const Point2& b, const Point2& c) {
  return turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
}

bool same(const Point2& a, const Point2& b) { return a.u == b.u && a.v == b.v; }

/// Projects along the largest part of the normal, so that the polygon turns counter-clockwise.
std::vector<Point2> flattened(const std::vector<Vector3>& corners) {
  Vector3 normal;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    normal = normal + cross(corners[i], corners[(i + 1) % corners.size()]);  // Newell
  }
  std::vector<Point2> flat;
  const double x = std::abs(normal.x);
  const double y = std::abs(normal.y);
  const double z = std::abs(normal.z);
  for (const Vector3& p : corners) {
    Point2 q = {p.x, p.y};
    double sign = normal.z;
    if (x > y && x > z) {
      q = {p.y, p.z};
      sign = normal.x;
    } else if (y > z) {
      q = {p.z, p.x};
      sign = normal.y;
    }
    if (sign < 0.0) q.u = -q.u;
    flat.push_back(q);
  }
  return flat;
}

bool is_ear(const std::vector<Point2>& flat, const std::vector<std::uint32_t>& ring,
            std::size_t at) {
  const std::size_t n = ring.size();
  const Point2& a = flat[ring[(at + n - 1) % n]];
  const Point2& b = flat[ring[at]];
  const Point2& c = flat[ring[(at + 1) % n]];
  if (turn(a, b, c) <= 0.0) return false;
  for (const std::uint32_t other : ring) {
    const Point2& p = flat[other];
    if (same(p, a) || same(p, b) || same(p, c)) continue;
    if (inside(p, a, b, c)) return false;
  }
  return true;
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> triangulate(const std::vector<Vector3>& corners) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  if (corners.size() < 3) return triangles;
  if (corners.size() == 3) return {{0, 1, 2}};
  const std::vector<Point2> flat = flattened(corners);
  std::vector<std::uint32_t> ring(corners.size());
  for (std::size_t i = 0; i < ring.size(); ++i) ring[i] = static_cast<std::uint32_t>(i);
  std::size_t at = 0;
  std::size_t passed = 0;  // corners since the last ear
  while (ring.size() > 3) {
    const std::size_t n = ring.size();
    at %= n;
    // A self-intersecting polygon may have no ear left: then any corner is cut.
    if (passed < n && !is_ear(flat, ring, at)) {
      ++at;
      ++passed;
      continue;
    }
    triangles.push_back({ring[(at + n - 1) % n], ring[at], ring[(at + 1) % n]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(at));
    passed = 0;
    // The previous corner may be an ear now; starting there avoids slivers.
    if (at > 0) --at;
  }
  triangles.push_back({ring[0], ring[1], ring[2]});
  return triangles;
}

}  // namespace earpoint
