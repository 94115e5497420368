#include "edge_pair_diffraction.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <earpoint/core/error.h>
#include <earpoint/core/pose.h>

namespace earpoint {
namespace {

using Complex = std::complex<double>;
constexpr Complex kI{0.0, 1.0};

// Integrals over the complex angle run along a straight line through 0 that is turned by this
// slope, on which waves die away, and by the trapezoidal rule, whose error falls exponentially.
constexpr double kSlope = 0.3;
constexpr double kCoarsestStep = 0.35;
constexpr double kFarthest = 7.0;  // along the line; wedges answer with exp(-2/3 of the angle)
constexpr double kSilent = 9.0;    // exp(-9) is taken as nothing
constexpr double kSharp = 8.0;     // the rule misses less than exp(-8) of poles further away

// Each pass of the face leaves at most a third (270 degrees, a face far below a wave).
constexpr int kPasses = 4;

// Points of the line, of waves from one place up to both ends of the way.
class Line {
 public:
  explicit Line(double longest_phase)
      : step_(std::min(kCoarsestStep, std::sqrt(1.42 / longest_phase)) * Complex(1.0, -kSlope)) {}

  [[nodiscard]] Complex step() const { return step_; }

  // exp(-i phase cosh(angle)) at the points from 0 on, until it has died away; `least` or more.
  [[nodiscard]] std::vector<Complex> waves(double phase, std::size_t least = 0) const {
    std::vector<Complex> waves;
    const Complex turn = std::exp(step_);
    for (Complex power = 1.0; step_.real() * static_cast<double>(waves.size()) < kFarthest;
         power *= turn) {
      const Complex cosh = (power + 1.0 / power) / 2.0;
      if (-phase * cosh.imag() > kSilent && waves.size() >= least) break;
      waves.push_back(std::exp(-kI * phase * cosh));
    }
    return waves;
  }

 private:
  Complex step_;
};

// What a wedge does to a plane wave along one of its faces, over the difference of the complex
// angles of both waves, at the line's points; even.
class Kernel {
 public:
  Kernel(double index, const Line& line, std::size_t points) {
    const Complex turn = std::exp(index * line.step());
    Complex power = 1.0;
    for (std::size_t i = 0; i < points; ++i, power *= turn) {
      cosh_minus_1_.push_back((power + 1.0 / power) / 2.0 - 1.0);
    }
    cosh_minus_1_.front() = 0.0;
    values_.assign(points, 0.0);
  }

  // Adds sin(a) / (cosh - cos(a)) times a weight.
  void add(double weight, double angle) {
    const double half = std::sin(angle / 2.0);
    const double sine = weight * std::sin(angle);
    for (std::size_t i = 0; i < values_.size(); ++i) {
      values_[i] += sine / (cosh_minus_1_[i] + 2.0 * half * half);
    }
  }

  [[nodiscard]] Complex at(std::size_t i, std::size_t j) const {
    return values_[i > j ? i - j : j - i] + (j > 0 ? values_[i + j] : 0.0);
  }

 private:
  std::vector<Complex> cosh_minus_1_;
  std::vector<Complex> values_;
};

// One edge of the face, in one band.
struct Corner {
  double index = 0.0;         // pi over the open angle
  double face_weight = 1.0;   // of what comes along the face and of what it reflects: their mean
  double other_weight = 1.0;  // the same for the other face
};

// What a place hears of a plane wave that comes along the face with each of the line's complex
// angles, and by reciprocity what it sends there.
std::vector<Complex> couple(const Corner& corner, const FacePoint& place, const Line& line,
                            double wave_number, std::size_t points) {
  double behind_rad = kPi - place.angle_rad;
  if (std::abs(behind_rad) < kOnBoundary_rad) behind_rad = kOnBoundary_rad;
  // Near the shadow boundary the integrand has poles at +- i times the angle behind it, closer to
  // the line than the rule's steps. Their share of its error is known.
  const double near_rad = std::abs(behind_rad);
  const Complex decay = 2.0 * kPi * near_rad / line.step();
  const bool is_near = decay.real() < kSharp;

  const double phase = wave_number * place.radius_m;
  const std::vector<Complex> waves = line.waves(phase, is_near ? points : 0);
  Kernel kernel(corner.index, line, points + waves.size());
  kernel.add(corner.face_weight, corner.index * behind_rad);
  kernel.add(corner.other_weight, corner.index * (kPi + place.angle_rad));
  std::vector<Complex> result(points);
  for (std::size_t j = 0; j < points; ++j) {
    for (std::size_t i = 0; i < waves.size(); ++i) result[j] += kernel.at(j, i) * waves[i];
    result[j] *= -corner.index / (2.0 * kPi) * line.step();
  }
  if (!is_near) return result;
  const Complex share = std::copysign(corner.face_weight, behind_rad) / (std::exp(decay) - 1.0);
  for (std::size_t j = 0; j < points; ++j) {
    const Complex angle = static_cast<double>(j) * line.step();
    for (const Complex& pole : {angle + kI * near_rad, angle - kI * near_rad}) {
      result[j] += share * std::exp(-kI * phase * std::cosh(pole));
    }
  }
  return result;
}

// Turns what comes along the face into what goes back.
std::vector<Complex> turn_back(const Kernel& kernel, Complex scale,
                               const std::vector<Complex>& coming) {
  std::vector<Complex> going(coming.size());
  for (std::size_t i = 0; i < going.size(); ++i) {
    for (std::size_t j = 0; j < coming.size(); ++j) going[i] += kernel.at(i, j) * coming[j];
    going[i] *= scale;
  }
  return going;
}

Complex sum_over_line(const std::vector<Complex>& a, const std::vector<Complex>& b) {
  Complex sum = a[0] * b[0] / 2.0;
  for (std::size_t i = 1; i < a.size(); ++i) sum += a[i] * b[i];
  return 2.0 * sum;
}

using ByEdge = std::array<Complex, 2>;

// Pressure at the receiver [edge at which it arrives], of sound that came to the face by one edge
// from a line source that makes H0(2) in free field.
ByEdge pass_face(const EdgeFace& face, const std::array<Corner, 2>& corners, double face_weight,
                 const std::array<FacePoint, 2>& source, const std::array<FacePoint, 2>& receiver,
                 int start, double wave_number) {
  double longest_m = 0.0;
  for (const FacePoint& place : receiver) {
    if (place.in_sight) longest_m = std::max(longest_m, place.radius_m);
  }
  longest_m += source[start].radius_m + face.width_m;
  const Line line(wave_number * longest_m);
  const std::vector<Complex> across = line.waves(wave_number * face.width_m);
  const std::size_t points = across.size();

  std::array<std::vector<Complex>, 2> heard;
  std::vector<Kernel> turning;
  for (int edge = 0; edge < 2; ++edge) {
    if (receiver[edge].in_sight) {
      heard[edge] = couple(corners[edge], receiver[edge], line, wave_number, points);
    }
    turning.emplace_back(corners[edge].index, line, 2 * points);
    turning.back().add(corners[edge].face_weight + corners[edge].other_weight,
                       corners[edge].index * kPi);
  }

  // On the face the incident and the reflected wave are one: what comes is half of it.
  const double incident = 0.5 / face_weight;
  ByEdge pressure{};
  std::vector<Complex> wave = couple(corners[start], source[start], line, wave_number, points);
  for (Complex& part : wave) part *= kI / kPi;
  int edge = start;
  for (int pass = 0; pass < kPasses; ++pass) {
    edge = 1 - edge;
    for (std::size_t i = 0; i < points; ++i) wave[i] *= across[i];
    if (receiver[edge].in_sight) {
      pressure[edge] += incident * line.step() * sum_over_line(wave, heard[edge]);
    }
    wave = turn_back(turning[edge], -corners[edge].index / (2.0 * kPi) * incident * line.step(),
                     wave);
  }
  return pressure;
}

// The share of an endless edge's sound that comes from beyond a point whose way is longer than the
// shortest by some phase: Fresnel's integral, within 0.002 (Abramowitz and Stegun 7.3.32 and 33).
Complex fresnel_share(double phase) {
  const double u = std::sqrt(2.0 * phase / kPi);
  const double f = (1.0 + 0.926 * u) / (2.0 + 1.792 * u + 3.104 * u * u);
  const double g = 1.0 / (2.0 + 4.142 * u + 3.492 * u * u + 6.670 * u * u * u);
  return (g - kI * f) * std::exp(-kI * phase) / (1.0 - kI);
}

// The share of what is in sight.
Complex share_in_sight(const AlongFace& along, double source_m, double receiver_m,
                       double wave_number) {
  const double apex_z = along.source_z_m + (along.receiver_z_m - along.source_z_m) * source_m /
                                               (source_m + receiver_m);
  struct Ways {
    double length_m;
    double product_m2;
    double slope;
    double bend_per_m;
  };
  const auto ways = [&](double z) {
    const double in_m = std::hypot(source_m, z - along.source_z_m);
    const double out_m = std::hypot(receiver_m, z - along.receiver_z_m);
    return Ways{in_m + out_m, in_m * out_m,
                (z - along.source_z_m) / in_m + (z - along.receiver_z_m) / out_m,
                source_m * source_m / std::pow(in_m, 3) +
                    receiver_m * receiver_m / std::pow(out_m, 3)};
  };
  const Ways shortest = ways(apex_z);
  const auto beyond = [&](double z) {
    const Ways there = ways(z);
    const double longer_m = std::max(1e-12, there.length_m - shortest.length_m);
    // Fresnel's ways grow with the square of z and spread alike; far from the apex those here grow
    // otherwise and spread more.
    const double weaker =
        shortest.product_m2 / there.product_m2 *
        std::min(2.0, std::sqrt(2.0 * longer_m * shortest.bend_per_m) / std::abs(there.slope));
    const Complex share = fresnel_share(wave_number * longer_m) * (longer_m > 1e-9 ? weaker : 1.0);
    return z < apex_z ? 1.0 - share : share;
  };
  Complex share = 0.0;
  for (const EdgeInterval& interval : along.intervals) {
    share += beyond(interval.begin_m) - beyond(interval.end_m);
  }
  return share;
}

double nearest_radius_m(const std::array<FacePoint, 2>& place) {
  double nearest_m = 1e9;
  for (const FacePoint& point : place) {
    if (point.in_sight) nearest_m = std::min(nearest_m, point.radius_m);
  }
  return nearest_m;
}

}  // namespace

DiffractionSpectrum diffract_over_face(const EdgeFace& face,
                                       const std::array<FacePoint, 2>& source,
                                       const std::array<FacePoint, 2>& receiver,
                                       const AlongFace& along, double reference_m,
                                       double speed_m_per_s) {
  EARPOINT_CHECK(face.width_m > 0.0);
  const double along_m = along.receiver_z_m - along.source_z_m;
  const double source_m = nearest_radius_m(source) + face.width_m / 2.0;
  const double receiver_m = nearest_radius_m(receiver) + face.width_m / 2.0;
  // Endless edges keep the wave's slope along them; what is left runs across.
  const double across_m = source_m + receiver_m;
  const double across_share = across_m / std::hypot(across_m, along_m);

  DiffractionSpectrum spectrum{};
  for (int i = 0; i < kDiffractionFrequencies; ++i) {
    const int band = i / kFrequenciesPerBand;
    const double face_weight = (1.0 + static_cast<double>(face.reflection[band])) / 2.0;
    std::array<Corner, 2> corners;
    for (int edge = 0; edge < 2; ++edge) {
      corners[edge] = {
          .index = kPi / face.open_angle_rad[edge],
          .face_weight = face_weight,
          .other_weight = (1.0 + static_cast<double>(face.other_reflection[edge][band])) / 2.0};
    }
    const double wave_number = 2.0 * kPi * diffraction_frequency_hz(i) / speed_m_per_s;
    const double across_number = wave_number * across_share;
    for (int start = 0; start < 2; ++start) {
      if (!source[start].in_sight) continue;
      const ByEdge pressure =
          pass_face(face, corners, face_weight, source, receiver, start, across_number);
      for (int end = 0; end < 2; ++end) {
        if (!receiver[end].in_sight) continue;
        // From a line source to a point source.
        const double flat_m = source[start].radius_m + receiver[end].radius_m +
                              face.width_m * (start == end ? 2.0 : 1.0);
        const double way_m = std::hypot(flat_m, along_m);
        const double phase = across_number * flat_m;
        const Complex line_source(j0(phase), -y0(phase));
        spectrum[i] += pressure[end] / line_source *
                       std::exp(-kI * wave_number * (way_m - reference_m)) / way_m;
      }
    }
    spectrum[i] *= share_in_sight(along, source_m, receiver_m, wave_number);
  }
  return spectrum;
}

}  // namespace earpoint
