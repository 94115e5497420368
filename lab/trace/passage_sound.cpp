#include "passage_sound.h"

#include "edge_pair_diffraction.h"
#include "edge_view.h"
#include "line_source_wedge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

using Complex = std::complex<double>;
constexpr Complex kI{0.0, 1.0};
constexpr double kOpenAngle_rad = 1.5 * kPi;

Complex wave_at(double phase) { return {j0(phase), -y0(phase)}; }

// Points and weights from 0 to a length, denser at both ends, so that the trapezoidal rule
// converges even for singular integrands there (Sidi, 1993).
struct Rule {
  std::vector<double> points;
  std::vector<double> weights;

  Rule(double length, int count) {
    for (int i = 0; i < count; ++i) {
      const double u = (i + 0.5) / count;
      points.push_back(length * (u - std::sin(2.0 * kPi * u) / (2.0 * kPi)));
      weights.push_back(length * (1.0 - std::cos(2.0 * kPi * u)) / count);
    }
  }
};

using Vector = std::vector<Complex>;

// Solves by Gaussian elimination with pivoting, in the copied matrix.
Vector solve(std::vector<Vector> matrix, Vector right) {
  const std::size_t size = right.size();
  for (std::size_t i = 0; i < size; ++i) {
    std::size_t pivot = i;
    for (std::size_t row = i + 1; row < size; ++row) {
      if (std::norm(matrix[row][i]) > std::norm(matrix[pivot][i])) pivot = row;
    }
    std::swap(matrix[i], matrix[pivot]);
    std::swap(right[i], right[pivot]);
    for (std::size_t row = i + 1; row < size; ++row) {
      const Complex factor = matrix[row][i] / matrix[i][i];
      for (std::size_t column = i; column < size; ++column) {
        matrix[row][column] -= factor * matrix[i][column];
      }
      right[row] -= factor * right[i];
    }
  }
  for (std::size_t i = size; i-- > 0;) {
    for (std::size_t column = i + 1; column < size; ++column) {
      right[i] -= matrix[i][column] * right[column];
    }
    right[i] /= matrix[i][i];
  }
  return right;
}

// Modes across the passage, cos(n pi y / width), normalised.
class Modes {
 public:
  Modes(const Passage& passage, double wave_number)
      : passage_(passage),
        wave_number_(wave_number),
        count_(static_cast<int>(std::ceil(wave_number * passage.width_m / kPi)) + 4) {}

  // Excitation of each mode by a line source in front of a wall without passage.
  [[nodiscard]] Vector excite(const PassagePlace& place) const {
    const Rule rule(passage_.width_m, 3 * count_ + 12);
    Vector excited(count_);
    for (std::size_t i = 0; i < rule.points.size(); ++i) {
      const double distance_m = std::hypot(place.x_m, place.y_m - rule.points[i]);
      const Complex wave = 2.0 * rule.weights[i] * wave_at(wave_number_ * distance_m);
      for (int n = 0; n < count_; ++n) {
        excited[n] += norm_of(n) * std::cos(transverse(n) * rule.points[i]) * wave;
      }
    }
    return excited;
  }

  // The pressure gradient at the far end of the passage, of a pressure in front of its near end.
  [[nodiscard]] Vector drive(const Vector& pressure) const {
    const std::vector<Vector> load = radiation();
    // Sound in the passage is the sum of a part that is even and one that is odd about its middle.
    std::vector<Vector> even = load;
    std::vector<Vector> odd = load;
    Vector half = pressure;
    for (Complex& part : half) part /= 2.0;
    Vector delays(count_);
    Vector along(count_);
    for (int n = 0; n < count_; ++n) {
      along[n] = along_number(n);
      delays[n] = std::exp(-kI * along[n] * passage_.depth_m);
    }
    for (int row = 0; row < count_; ++row) {
      for (int n = 0; n < count_; ++n) {
        even[row][n] *= kI * along[n] * (1.0 - delays[n]);
        odd[row][n] *= kI * (1.0 + delays[n]);
      }
      even[row][row] += 1.0 + delays[row];
      odd[row][row] += (1.0 - delays[row]) / along[row];
    }
    const Vector even_part = solve(std::move(even), half);
    const Vector odd_part = solve(std::move(odd), half);
    Vector gradient(count_);
    for (int n = 0; n < count_; ++n) {
      gradient[n] =
          kI * along[n] * (1.0 - delays[n]) * even_part[n] - kI * (1.0 + delays[n]) * odd_part[n];
    }
    return gradient;
  }

 private:
  [[nodiscard]] double transverse(int n) const { return n * kPi / passage_.width_m; }
  [[nodiscard]] double norm_of(int n) const {
    return std::sqrt((n == 0 ? 1.0 : 2.0) / passage_.width_m);
  }

  // Along the passage; the mode propagates or decays.
  [[nodiscard]] Complex along_number(int n) const {
    const double square = wave_number_ * wave_number_ - transverse(n) * transverse(n);
    constexpr double kLeast = 1e-6;  // at a mode's cut-off
    if (square >= 0.0) return std::max(kLeast, std::sqrt(square));
    return {0.0, -std::max(kLeast, std::sqrt(-square))};
  }

  // Pressure on each mode due to the radiation of each mode's gradient into a half-space.
  [[nodiscard]] std::vector<Vector> radiation() const {
    const double width_m = passage_.width_m;
    const Rule rule(width_m, 3 * count_ + 20);
    Vector sines(count_);
    Vector cosines(count_);
    for (std::size_t i = 0; i < rule.points.size(); ++i) {
      const double apart_m = rule.points[i];
      const Complex wave = -0.5 * kI * rule.weights[i] * wave_at(wave_number_ * apart_m);
      for (int n = 0; n < count_; ++n) {
        sines[n] += wave * std::sin(transverse(n) * apart_m);
        cosines[n] += wave * (width_m - apart_m) * std::cos(transverse(n) * apart_m);
      }
    }
    std::vector<Vector> load(count_, Vector(count_));
    load[0][0] = 2.0 / width_m * cosines[0];
    for (int n = 1; n < count_; ++n) {
      load[n][n] = 2.0 / width_m * (cosines[n] - sines[n] / transverse(n));
    }
    for (int n = 0; n < count_; ++n) {
      for (int m = n + 2; m < count_; m += 2) {
        const double a = transverse(n);
        const double b = transverse(m);
        load[n][m] =
            norm_of(n) * norm_of(m) * 2.0 * (b * sines[m] - a * sines[n]) / (a * a - b * b);
        load[m][n] = load[n][m];
      }
    }
    return load;
  }

  const Passage& passage_;
  double wave_number_;
  int count_;
};

// A place in coordinates of the edges of the side at y = 0; mirrored for the other side.
struct SideView {
  std::array<FacePoint, 2> points;
  std::array<EdgePoint, 2> edges;
};

SideView view_of(const Passage& passage, const PassagePlace& place) {
  SideView view;
  for (int edge = 0; edge < 2; ++edge) {
    const double across_m = edge == 0 ? place.x_m : passage.depth_m - place.x_m;
    double angle_rad = std::atan2(place.y_m, across_m);
    if (angle_rad < -kPi / 2.0) angle_rad += 2.0 * kPi;
    angle_rad = std::clamp(angle_rad, 0.0, kOpenAngle_rad);
    view.edges[edge] = {std::hypot(across_m, place.y_m), angle_rad, 0.0};
    view.points[edge] = {view.edges[edge].radius_m, angle_rad, {}};
  }
  // The edge on its own side of the wall is visible; the other one only from within the opening,
  // unless the opposite side hides it. As in `EdgeView`, an edge is visible from the plane of its
  // face and tested a little off the edge.
  const bool is_before = place.x_m < passage.depth_m / 2.0;
  const int near = is_before ? 0 : 1;
  view.points[near].in_sight = {{0.0, 1.0}};
  const double off_m = kEdgeClearance_m * std::sqrt(0.5);
  const double before_m = is_before ? -place.x_m : place.x_m - passage.depth_m;
  const double share = before_m / (before_m + passage.depth_m + off_m);
  const double crosses_m = place.y_m + (off_m - place.y_m) * share;
  if (view.points[near].angle_rad <= kPi + kOnBoundary_rad && crosses_m < passage.width_m) {
    view.points[1 - near].in_sight = {{0.0, 1.0}};
  }
  return view;
}

// Height of a straight line between two places at a plane x.
double height_at(const PassagePlace& a, const PassagePlace& b, double x_m) {
  return a.y_m + (b.y_m - a.y_m) * (x_m - a.x_m) / (b.x_m - a.x_m);
}

double length(const PassagePlace& a, const PassagePlace& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

// Sound that the side at y = 0 adds to the straight sound: its reflection and diffraction.
Complex sound_of_side(const Passage& passage, const PassagePlace& source,
                      const PassagePlace& receiver, bool straight, double wave_number) {
  const PassagePlace image{receiver.x_m, -receiver.y_m};
  const double near_m = height_at(source, image, 0.0);
  const double far_m = height_at(source, image, passage.depth_m);
  const bool mirrored =
      near_m > 0.0 && near_m < passage.width_m && far_m < 0.0 && far_m > -passage.width_m;
  const SideView here = view_of(passage, source);
  const SideView there = view_of(passage, receiver);
  Complex sum = mirrored ? wave_at(wave_number * length(source, image)) : 0.0;
  for (int edge = 0; edge < 2; ++edge) {
    if (here.points[edge].in_sight.empty() || there.points[edge].in_sight.empty()) continue;
    sum += line_sound_past_wedge(kOpenAngle_rad, here.edges[edge], there.edges[edge],
                                 {.straight = straight, .mirrored = mirrored}, wave_number);
  }
  EdgeFace face;
  face.width_m = passage.depth_m;
  face.open_angle_rad = {kOpenAngle_rad, kOpenAngle_rad};
  return sum + line_sound_over_face(face, here.points, there.points, 0, wave_number);
}

}  // namespace

Complex sound_through_passage(const Passage& passage, const PassagePlace& source,
                              const PassagePlace& receiver, double wave_number) {
  EARPOINT_CHECK(passage.width_m > 0.0 && passage.depth_m > 0.0 && wave_number > 0.0);
  EARPOINT_CHECK(source.x_m < 0.0 && receiver.x_m > passage.depth_m);
  const Modes modes(passage, wave_number);
  const Vector gradient = modes.drive(modes.excite(source));
  const Vector heard = modes.excite({receiver.x_m - passage.depth_m, receiver.y_m});
  Complex sum = 0.0;
  for (std::size_t n = 0; n < heard.size(); ++n) sum += heard[n] * gradient[n];
  return 0.25 * kI * sum;
}

Complex sound_past_single_sides(const Passage& passage, const PassagePlace& source,
                                const PassagePlace& receiver, double wave_number) {
  const double near_m = height_at(source, receiver, 0.0);
  const double far_m = height_at(source, receiver, passage.depth_m);
  const bool straight =
      near_m >= 0.0 && near_m <= passage.width_m && far_m >= 0.0 && far_m <= passage.width_m;
  const auto opposite = [&](const PassagePlace& place) {
    return PassagePlace{place.x_m, passage.width_m - place.y_m};
  };
  const Complex direct = straight ? wave_at(wave_number * length(source, receiver)) : 0.0;
  return direct + sound_of_side(passage, source, receiver, straight, wave_number) +
         sound_of_side(passage, opposite(source), opposite(receiver), straight, wave_number);
}

}  // namespace earpoint
