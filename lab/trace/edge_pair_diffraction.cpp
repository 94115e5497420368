#include "edge_pair_diffraction.h"

#include "complex_angle.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

using Complex = std::complex<double>;
constexpr Complex kI{0.0, 1.0};

constexpr double kSharp =
    8.0;  // the trapezoidal rule misses less than exp(-8) of poles further away

// Each pass of the face leaves at most a third (270 degrees, a face much narrower than a wave).
constexpr int kPasses = 4;

// Response of a wedge to a plane wave along one of its faces, as a function of the difference of
// the complex angles of both waves, at the line's points. It is even.
class Kernel {
 public:
  Kernel(double index, const ComplexAngleLine& line, std::size_t points) {
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
  double face_weight = 1.0;   // mean of the incident wave along the face and its reflection
  double other_weight = 1.0;  // the same for the other face
};

// The sound that a wedge diffracts between one of its faces and a place at some angle from it,
// summed over the complex angle. At the place: of plane waves along the face with each of the
// line's angles. By reciprocity, on the face: of sound from the place.
// @param wave  of the hyperbolic cosine of the angle between them; must decay
template <typename Wave>
std::vector<Complex> bend(const Corner& corner, double angle_rad, const ComplexAngleLine& line,
                          std::size_t points, const Wave& wave) {
  double behind_rad = kPi - angle_rad;
  if (std::abs(behind_rad) < kOnBoundary_rad) behind_rad = kOnBoundary_rad;
  // Near the shadow boundary the integrand has poles at +- i times the angle behind it, closer to
  // the line than the rule's steps. Their share of its error is known.
  const double near_rad = std::abs(behind_rad);
  const Complex decay = 2.0 * kPi * near_rad / line.step();
  const bool is_near = decay.real() < kSharp;

  const std::vector<Complex> waves = line.sample(wave, is_near ? points : 0);
  Kernel kernel(corner.index, line, points + waves.size());
  kernel.add(corner.face_weight, corner.index * behind_rad);
  kernel.add(corner.other_weight, corner.index * (kPi + angle_rad));
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
      result[j] += share * wave(std::cosh(pole));
    }
  }
  return result;
}

std::vector<Complex> couple(const Corner& corner, const FacePoint& place,
                            const ComplexAngleLine& line, double wave_number, std::size_t points) {
  const double phase = wave_number * place.radius_m;
  return bend(corner, place.angle_rad, line, points,
              [&](const Complex& cosh) { return std::exp(-kI * phase * cosh); });
}

// The wave that goes back along the face, of the wave that comes.
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

Corner corner_of(const EdgeFace& face, int edge, int band) {
  return {.index = kPi / face.open_angle_rad[edge],
          .face_weight = (1.0 + static_cast<double>(face.reflection[band])) / 2.0,
          .other_weight = (1.0 + static_cast<double>(face.other_reflection[edge][band])) / 2.0};
}

// The unfolded path across: over the face once, or forth and back.
double across(const EdgeFace& face, const FacePoint& source, const FacePoint& receiver,
              bool returns) {
  return source.radius_m + receiver.radius_m + face.width_m * (returns ? 2.0 : 1.0);
}

bool is_seen(const FacePoint& place) { return !place.in_sight.empty(); }

using ByEdge = std::array<Complex, 2>;

// Pressure at the receiver [edge at which it arrives], of sound that came to the face by one edge
// from a line source that makes H0(2) in free field.
ByEdge pass_face(const EdgeFace& face, const std::array<Corner, 2>& corners,
                 const FacePoint& source, const std::array<FacePoint, 2>& receiver, int start,
                 double wave_number) {
  double longest_m = 0.0;
  for (const FacePoint& place : receiver) {
    if (is_seen(place)) longest_m = std::max(longest_m, place.radius_m);
  }
  longest_m += source.radius_m + face.width_m;
  const ComplexAngleLine line(wave_number * longest_m);
  const std::vector<Complex> crossing = line.sample(
      [&](const Complex& cosh) { return std::exp(-kI * wave_number * face.width_m * cosh); }, 0);
  const std::size_t points = crossing.size();

  std::array<std::vector<Complex>, 2> heard;
  std::vector<Kernel> turning;
  for (int edge = 0; edge < 2; ++edge) {
    if (is_seen(receiver[edge])) {
      heard[edge] = couple(corners[edge], receiver[edge], line, wave_number, points);
    }
    turning.emplace_back(corners[edge].index, line, 2 * points);
    turning.back().add(corners[edge].face_weight + corners[edge].other_weight,
                       corners[edge].index * kPi);
  }

  // On the face incident and reflected wave coincide: the incident wave is half.
  const double incident = 0.5 / corners[0].face_weight;
  ByEdge pressure{};
  std::vector<Complex> wave = couple(corners[start], source, line, wave_number, points);
  for (Complex& part : wave) part *= kI / kPi;
  int edge = start;
  for (int pass = 0; pass < kPasses; ++pass) {
    edge = 1 - edge;
    for (std::size_t i = 0; i < points; ++i) wave[i] *= crossing[i];
    if (is_seen(receiver[edge])) {
      pressure[edge] += incident * line.step() * sum_over_line(wave, heard[edge]);
    }
    wave =
        turn_back(turning[edge], -corners[edge].index / (2.0 * kPi) * incident * line.step(), wave);
  }
  return pressure;
}

// Both ends of the shortest path, by the edges that it passes.
struct Ends {
  int in = 0;
  int out = 0;
  double across_m = 1e9;
};

Ends shortest_ends(const EdgeFace& face, const FacePlace& source, const FacePlace& receiver) {
  Ends shortest;
  for (int in = 0; in < 2; ++in) {
    for (int out = 0; out < 2; ++out) {
      const FacePoint& here = source.points[in];
      const FacePoint& there = receiver.points[out];
      if (!is_seen(here) || !is_seen(there)) continue;
      const double across_m = across(face, here, there, in == out);
      if (across_m < shortest.across_m) shortest = {in, out, across_m};
    }
  }
  return shortest;
}

// The visible parts of one edge, projected from a place to another edge `scale` times as far.
std::vector<EdgeInterval> project(const std::vector<EdgeInterval>& intervals, double z_m,
                                  double scale) {
  std::vector<EdgeInterval> projected;
  projected.reserve(intervals.size());
  for (const auto& [begin_m, end_m] : intervals) {
    projected.push_back({z_m + (begin_m - z_m) * scale, z_m + (end_m - z_m) * scale});
  }
  return projected;
}

// Sound by the parts of an edge that are visible from `near` and, past the other edge, from `far`,
// relative to the endless edge: corrects for the ends of edges. `far` counts as on the face.
DiffractionSpectrum share_in_sight(const EdgeFace& face, int edge, const FacePlace& near,
                                   const FacePlace& far, int far_edge, double across_m,
                                   double speed_m_per_s) {
  const FacePoint& place = near.points[edge];
  const FacePoint& far_place = far.points[far_edge];
  const double beyond_m = across_m - place.radius_m;
  const std::vector<EdgeInterval> intervals =
      overlap(place.in_sight, project(far_place.in_sight, far.z_m, beyond_m / far_place.radius_m));
  if (intervals.empty()) return {};
  const Wedge wedge{.open_angle_rad = face.open_angle_rad[edge],
                    .reflection = {face.reflection, face.other_reflection[edge]}};
  const EdgePoint here{place.radius_m, place.angle_rad, near.z_m};
  const EdgePoint there{beyond_m, 0.0, far.z_m};
  DiffractionSpectrum share =
      diffract(wedge, here, there, intervals, {.straight = true, .mirrored = true}, speed_m_per_s);
  const double along_m = far.z_m - near.z_m;
  const double sum_m2 = place.radius_m * place.radius_m + beyond_m * beyond_m + along_m * along_m;
  const double product_m2 = 2.0 * place.radius_m * beyond_m;
  const double shortest_m = std::sqrt(sum_m2 + product_m2);
  const double later_m = find_apex(here, there, intervals).distance_m - shortest_m;
  for (int i = 0; i < kDiffractionFrequencies; ++i) {
    const double wave_number = 2.0 * kPi * diffraction_frequency_hz(i) / speed_m_per_s;
    const auto wave = [&](const Complex& cosh) {
      const Complex distance_m = std::sqrt(sum_m2 + product_m2 * cosh);
      return std::exp(-kI * wave_number * (distance_m - shortest_m)) / distance_m;
    };
    const ComplexAngleLine line(wave_number * shortest_m);
    const Complex endless =
        bend(corner_of(face, edge, i / kFrequenciesPerBand), place.angle_rad, line, 1, wave)[0];
    const Complex parts = share[i] * std::polar(1.0, -wave_number * later_m);
    // If the endless edge diffracts almost nothing, so do its parts over the face.
    const double faint = 1e-4 / (shortest_m * shortest_m);
    share[i] = (parts * std::conj(endless) + faint) / (std::norm(endless) + faint);
  }
  return share;
}

}  // namespace

DiffractionSpectrum diffract_over_face(const EdgeFace& face, const FacePlace& source,
                                       const FacePlace& receiver, double reference_m,
                                       double speed_m_per_s) {
  EARPOINT_CHECK(face.width_m > 0.0);
  const double along_m = receiver.z_m - source.z_m;
  const Ends ends = shortest_ends(face, source, receiver);
  // Endless edges keep the wave number along them; the rest is across.
  const double across_share = ends.across_m / std::hypot(ends.across_m, along_m);

  DiffractionSpectrum spectrum{};
  for (int i = 0; i < kDiffractionFrequencies; ++i) {
    const int band = i / kFrequenciesPerBand;
    const std::array<Corner, 2> corners{corner_of(face, 0, band), corner_of(face, 1, band)};
    const double wave_number = 2.0 * kPi * diffraction_frequency_hz(i) / speed_m_per_s;
    const double across_number = wave_number * across_share;
    for (int start = 0; start < 2; ++start) {
      const FacePoint& here = source.points[start];
      if (!is_seen(here)) continue;
      const ByEdge pressure = pass_face(face, corners, here, receiver.points, start, across_number);
      for (int end = 0; end < 2; ++end) {
        const FacePoint& there = receiver.points[end];
        if (!is_seen(there)) continue;
        // From a line source to a point source.
        const double flat_m = across(face, here, there, start == end);
        const double way_m = std::hypot(flat_m, along_m);
        const double phase = across_number * flat_m;
        const Complex line_source(j0(phase), -y0(phase));
        spectrum[i] += pressure[end] / line_source *
                       std::exp(-kI * wave_number * (way_m - reference_m)) / way_m;
      }
    }
  }

  // The correction at each end keeps the level continuous where the other edge comes into view.
  const DiffractionSpectrum in_share =
      share_in_sight(face, ends.in, source, receiver, ends.out, ends.across_m, speed_m_per_s);
  const DiffractionSpectrum out_share =
      share_in_sight(face, ends.out, receiver, source, ends.in, ends.across_m, speed_m_per_s);
  const auto behind_rad = [](const FacePoint& point) {
    return std::abs(kPi - point.angle_rad) + kOnBoundary_rad;
  };
  const double in_behind_rad = behind_rad(source.points[ends.in]);
  const double out_behind_rad = behind_rad(receiver.points[ends.out]);
  const double in_counts = in_behind_rad / (in_behind_rad + out_behind_rad);
  for (int i = 0; i < kDiffractionFrequencies; ++i) {
    spectrum[i] *= in_counts * in_share[i] + (1.0 - in_counts) * out_share[i];
  }
  return spectrum;
}

std::complex<double> line_sound_over_face(const EdgeFace& face,
                                          const std::array<FacePoint, 2>& source,
                                          const std::array<FacePoint, 2>& receiver, int band,
                                          double wave_number) {
  const std::array<Corner, 2> corners{corner_of(face, 0, band), corner_of(face, 1, band)};
  Complex sum = 0.0;
  for (int start = 0; start < 2; ++start) {
    if (!is_seen(source[start])) continue;
    for (const Complex& part :
         pass_face(face, corners, source[start], receiver, start, wave_number)) {
      sum += part;
    }
  }
  return sum;
}

}  // namespace earpoint
