#include "ambisonics.h"

#include <cmath>
#include <complex>

#include <earpoint/error.h>

namespace earpoint {
namespace {

// sqrt((2 n + 1) (2 - [m = 0]) (n - m)! / (n + m)!)
double norm_n3d(int n, int m) {
  double ratio = (2.0 * n + 1.0) * (m == 0 ? 1.0 : 2.0);
  for (int k = n - m + 1; k <= n + m; ++k) ratio /= k;
  return std::sqrt(ratio);
}

}  // namespace

void encode_ambisonics(const Vector3& direction, int order, std::span<float> gains) {
  EARPOINT_CHECK(order >= 0 && std::ssize(gains) == ambisonic_channels(order));
  std::complex<double> around =
      1.0;             // (x + i y)^m: sin^m of the angle from z, turned by m azimuths
  double start = 1.0;  // the associated Legendre function of degree m over sin^m
  for (int m = 0; m <= order; ++m) {
    double below = 0.0;
    double legendre = start;
    for (int n = m; n <= order; ++n) {
      const double scale = norm_n3d(n, m) * legendre;
      gains[n * n + n + m] = static_cast<float>(scale * around.real());
      if (m > 0) gains[n * n + n - m] = static_cast<float>(scale * around.imag());
      const double next =
          ((2.0 * n + 1.0) * direction.z * legendre - (n + m) * below) / (n - m + 1.0);
      below = legendre;
      legendre = next;
    }
    around *= std::complex<double>(direction.x, direction.y);
    start *= 2.0 * m + 1.0;
  }
}

}  // namespace earpoint
