#include <earpoint/core/axes.h>

#include <algorithm>
#include <array>

namespace earpoint {

Quaternion quaternion_from_axes(const Vector3& x, const Vector3& y, const Vector3& z) {
  // The largest of the four is found from the trace, the others from it.
  const double trace = x.x + y.y + z.z;
  const std::array<double, 4> squares{trace, x.x, y.y, z.z};
  const auto largest = std::max_element(squares.begin(), squares.end()) - squares.begin();
  if (largest == 0) return normalized({1.0 + trace, y.z - z.y, z.x - x.z, x.y - y.x});
  if (largest == 1) {
    return normalized({y.z - z.y, 1.0 + x.x - y.y - z.z, y.x + x.y, z.x + x.z});
  }
  if (largest == 2) {
    return normalized({z.x - x.z, y.x + x.y, 1.0 - x.x + y.y - z.z, z.y + y.z});
  }
  return normalized({x.y - y.x, z.x + x.z, z.y + y.z, 1.0 - x.x - y.y + z.z});
}

}  // namespace earpoint
