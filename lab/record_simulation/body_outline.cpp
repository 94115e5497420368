#include "body_outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace earpoint {
namespace {

using Corners = std::array<PixelPosition, 3>;

struct Extent {
  double x_min = std::numeric_limits<double>::infinity();
  double y_min = std::numeric_limits<double>::infinity();
  double x_max = -std::numeric_limits<double>::infinity();
  double y_max = -std::numeric_limits<double>::infinity();

  void add(const PixelPosition& place) {
    x_min = std::min(x_min, place.x);
    y_min = std::min(y_min, place.y);
    x_max = std::max(x_max, place.x);
    y_max = std::max(y_max, place.y);
  }
};

/// The triangles of a person in the picture plane; those that reach behind the camera are left out.
std::vector<Corners> projected(const Scene& scene, std::uint32_t instance, const Camera& camera) {
  std::vector<Corners> triangles;
  const Mesh& mesh = scene.mesh;
  // People were added last, so that their triangles are at the end.
  for (std::size_t i = mesh.triangles.size(); i-- > 0;) {
    if (mesh.triangle_instance[i] < instance) break;
    if (mesh.triangle_instance[i] != instance) continue;
    Corners corners;
    bool whole = true;
    for (int corner = 0; corner < 3; ++corner) {
      const auto place = project(camera, vertex(mesh, mesh.triangles[i][corner]));
      whole = whole && place;
      if (place) corners[corner] = *place;
    }
    if (whole) triangles.push_back(corners);
  }
  return triangles;
}

/// Marks the pixels whose middle a triangle covers.
void fill(const Corners& triangle, const PixelRegion& region, std::vector<unsigned char>& covered) {
  Extent extent;
  for (const PixelPosition& corner : triangle) extent.add(corner);
  const auto edge = [](const PixelPosition& a, const PixelPosition& b, double x, double y) {
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
  };
  const int x_begin = std::max(region.x, static_cast<int>(std::floor(extent.x_min)));
  const int x_end = std::min(region.x + region.width, static_cast<int>(std::ceil(extent.x_max)));
  const int y_begin = std::max(region.y, static_cast<int>(std::floor(extent.y_min)));
  const int y_end = std::min(region.y + region.height, static_cast<int>(std::ceil(extent.y_max)));
  for (int y = y_begin; y < y_end; ++y) {
    for (int x = x_begin; x < x_end; ++x) {
      const double a = edge(triangle[0], triangle[1], x + 0.5, y + 0.5);
      const double b = edge(triangle[1], triangle[2], x + 0.5, y + 0.5);
      const double c = edge(triangle[2], triangle[0], x + 0.5, y + 0.5);
      if ((a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0)) {
        covered[static_cast<std::size_t>(y - region.y) * region.width + (x - region.x)] = 1;
      }
    }
  }
}

}  // namespace

std::optional<BodyOutline> outline_of(const Scene& scene, std::uint32_t instance,
                                      const Camera& camera) {
  const std::vector<Corners> triangles = projected(scene, instance, camera);
  Extent extent;
  for (const Corners& triangle : triangles) {
    for (const PixelPosition& corner : triangle) extent.add(corner);
  }
  extent.x_min = std::max(0.0, extent.x_min);
  extent.y_min = std::max(0.0, extent.y_min);
  extent.x_max = std::min<double>(camera.width, extent.x_max);
  extent.y_max = std::min<double>(camera.height, extent.y_max);
  if (extent.x_min >= extent.x_max || extent.y_min >= extent.y_max) return std::nullopt;
  BodyOutline outline;
  outline.box = {extent.x_min / camera.width, extent.y_min / camera.height,
                 extent.x_max / camera.width, extent.y_max / camera.height};
  outline.pixels.x = static_cast<int>(std::floor(extent.x_min));
  outline.pixels.y = static_cast<int>(std::floor(extent.y_min));
  outline.pixels.width = static_cast<int>(std::ceil(extent.x_max)) - outline.pixels.x;
  outline.pixels.height = static_cast<int>(std::ceil(extent.y_max)) - outline.pixels.y;
  std::vector<unsigned char> covered(static_cast<std::size_t>(outline.pixels.width) *
                                     outline.pixels.height);
  for (const Corners& triangle : triangles) fill(triangle, outline.pixels, covered);
  outline.area = static_cast<int>(std::count(covered.begin(), covered.end(), 1));
  if (outline.area == 0) return std::nullopt;
  return outline;
}

}  // namespace earpoint
