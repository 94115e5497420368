#include <earpoint/kernels/lattice.h>

#include <earpoint/error.h>

namespace earpoint::kernels {
namespace {

/// The taps as a polynomial at `point`, divided by the product of `point` minus the other points.
double at_point(std::span<const double, 3> taps, double point, double distances) {
  return (taps[0] + point * (taps[1] + point * taps[2])) / distances;
}

}  // namespace

std::array<double, kMostPositions> factors_of_taps(Scheme scheme, std::span<const double, 3> taps) {
  switch (scheme) {
    case Scheme::four: {
      constexpr double kNear2 = 0.5;  // kNear^2, exactly
      constexpr double kFar2 = 2.0;
      const double near = 2.0 * kNear2 * (kNear2 - kFar2);
      const double far = 2.0 * kFar2 * (kFar2 - kNear2);
      return {at_point(taps, 0.0, kNear2 * kFar2), at_point(taps, kNear, near),
              at_point(taps, -kNear, near),        at_point(taps, kFar, far),
              at_point(taps, -kFar, far),          taps[2]};
    }
    case Scheme::three:  // points 0, 1, -1, 1/2 and infinity
      return {at_point(taps, 0.0, 0.5),
              at_point(taps, 1.0, 1.0),
              at_point(taps, -1.0, -3.0),
              at_point(taps, 0.5, -0.375),
              taps[2],
              0.0};
    case Scheme::two:  // y0 = w1 (x0 + x1) + (w2 - w1) x1, y1 = w1 (x0 + x1) + (w0 - w1) x0
      return {taps[1], taps[2] - taps[1], taps[0] - taps[1], 0.0, 0.0, 0.0};
    case Scheme::taps:
      break;
  }
  EARPOINT_CHECK(false && "single taps have no transform");
  return {};
}

}  // namespace earpoint::kernels
