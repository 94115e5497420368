#include "wedge_diffraction.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

// Parts of the diffracted sound: past the edge, and off either face.
constexpr int kParts = 3;
using Parts = std::array<double, kParts>;

// Secondary sources are summed in bins of this length by their time of arrival: a phase error of
// 0.04 periods at 8 kHz, as each is shared between two bins.
constexpr double kBin_m = 0.0035;

// Steps along the edge grow with the distance from the apex. The first is integrated in closed
// form, as near a shadow boundary the integrand has a narrow peak there.
constexpr double kFirstStep = 1e-3;  // of the nearer end's radius
constexpr double kGrowth = 0.12;
constexpr double kCoarsestStep_m = 0.01;

class Integrand {
 public:
  Integrand(const Wedge& wedge, const EdgePoint& source, const EdgePoint& receiver,
            const UnbentSound& unbent)
      : source_(source), receiver_(receiver), index_(kPi / wedge.open_angle_rad) {
    const double difference = std::abs(source.angle_rad - receiver.angle_rad);
    const double sum = source.angle_rad + receiver.angle_rad;
    const double other_sum = 2.0 * wedge.open_angle_rad - sum;
    angles_ = {kPi - off_boundary(other_sum, unbent.mirrored) + 2.0 * wedge.open_angle_rad,
               kPi + difference, kPi - off_boundary(difference, unbent.straight),
               kPi - off_boundary(sum, unbent.mirrored)};
    for (int i = 0; i < 4; ++i) {
      sines_[i] = std::sin(index_ * angles_[i]);
      cosines_[i] = std::cos(index_ * angles_[i]);
    }
  }

  // The ways to and from a point of the edge.
  [[nodiscard]] double path_m(double z) const {
    return std::hypot(source_.radius_m, z - source_.z_m) +
           std::hypot(receiver_.radius_m, z - receiver_.z_m);
  }

  // Pressure per metre of edge.
  [[nodiscard]] Parts at(double z) const {
    const double cosh_eta = cosh_angle(z);
    const double power = std::pow(cosh_eta + std::sqrt(cosh_eta * cosh_eta - 1.0), index_);
    const double cosh_index_eta = (power + 1.0 / power) / 2.0;
    std::array<double, 4> beta;
    for (int i = 0; i < 4; ++i) {
      const double below = cosh_index_eta - cosines_[i];
      beta[i] = below > 0.0 ? sines_[i] / below : 0.0;
    }
    return weigh(z, beta);
  }

  // Pressure from the apex to a near point: there cosh(x) - 1 is x^2 / 2.
  [[nodiscard]] Parts from_apex(double apex_z, double z) const {
    const double reach = index_ * std::acosh(cosh_angle(z));
    std::array<double, 4> beta{};
    if (reach > 0.0) {
      for (int i = 0; i < 4; ++i) {
        const double half = std::sin(index_ * angles_[i] / 2.0);
        const double turn =
            2.0 * std::cos(index_ * angles_[i] / 2.0) * std::atan(reach / (2.0 * std::abs(half)));
        beta[i] = std::copysign(std::abs(z - apex_z) / reach, half) * turn;
      }
    }
    return weigh((apex_z + z) / 2.0, beta);
  }

 private:
  // Moves a turn of half a circle off the shadow boundary, to the lit side if sound passes.
  [[nodiscard]] static double off_boundary(double turn_rad, bool passes) {
    if (std::abs(turn_rad - kPi) > kOnBoundary_rad) return turn_rad;
    return passes ? kPi - kOnBoundary_rad : kPi + kOnBoundary_rad;
  }

  // Hyperbolic cosine of the imaginary angle between source and receiver, at a point of the edge.
  [[nodiscard]] double cosh_angle(double z) const {
    const double in_m = std::hypot(source_.radius_m, z - source_.z_m);
    const double out_m = std::hypot(receiver_.radius_m, z - receiver_.z_m);
    const double ratio = (in_m * out_m + (z - source_.z_m) * (z - receiver_.z_m)) /
                         (source_.radius_m * receiver_.radius_m);
    // 1 at the apex; rounding may take it below.
    return std::max(1.0, ratio);
  }

  [[nodiscard]] Parts weigh(double z, const std::array<double, 4>& beta) const {
    const double in_m = std::hypot(source_.radius_m, z - source_.z_m);
    const double out_m = std::hypot(receiver_.radius_m, z - receiver_.z_m);
    const double scale = -index_ / (4.0 * kPi * in_m * out_m);
    return {scale * (beta[1] + beta[2]), scale * beta[3], scale * beta[0]};
  }

  EdgePoint source_;
  EdgePoint receiver_;
  double index_;
  std::array<double, 4> angles_{};
  std::array<double, 4> sines_{};
  std::array<double, 4> cosines_{};
};

// The impulse response from the first arrival on, in bins of distance.
class BinnedResponse {
 public:
  explicit BinnedResponse(double first_m) : first_m_(first_m) {}

  void add(double path_m, const Parts& parts) {
    const double place = std::max(0.0, (path_m - first_m_) / kBin_m);
    const auto bin = static_cast<std::size_t>(place);
    const double upper = place - static_cast<double>(bin);
    if (bin + 2 > bins_.size()) bins_.resize(bin + 2);
    for (int part = 0; part < kParts; ++part) {
      bins_[bin][part] += (1.0 - upper) * parts[part];
      bins_[bin + 1][part] += upper * parts[part];
    }
  }

  [[nodiscard]] std::array<std::complex<double>, kParts> spectrum(double wave_number) const {
    std::array<std::complex<double>, kParts> sum{};
    const std::complex<double> step = std::polar(1.0, -wave_number * kBin_m);
    std::complex<double> turn = 1.0;
    for (const Parts& bin : bins_) {
      for (int part = 0; part < kParts; ++part) sum[part] += bin[part] * turn;
      turn *= step;
    }
    return sum;
  }

 private:
  double first_m_;
  std::vector<Parts> bins_;
};

// On the unfolded plane the shortest path is straight.
double unbounded_apex_z(const EdgePoint& source, const EdgePoint& receiver) {
  return source.z_m +
         (receiver.z_m - source.z_m) * source.radius_m / (source.radius_m + receiver.radius_m);
}

// From `begin` towards `end`, away from the apex: midpoint rule over growing steps.
void integrate(const Integrand& integrand, double apex, double begin, double end, double first_step,
               BinnedResponse& response) {
  const double direction = end > begin ? 1.0 : -1.0;
  double z = begin;
  while (z != end) {
    const double wanted = std::min(first_step + kGrowth * std::abs(z - apex), kCoarsestStep_m);
    const double step = std::min(wanted, std::abs(end - z));
    const double next = step == std::abs(end - z) ? end : z + direction * step;
    const double middle = (z + next) / 2.0;
    Parts parts;
    if (z == apex) {
      parts = integrand.from_apex(apex, next);
    } else {
      parts = integrand.at(middle);
      for (double& part : parts) part *= std::abs(next - z);
    }
    response.add(integrand.path_m(middle), parts);
    z = next;
  }
}

DiffractionSpectrum sum_parts(const Wedge& wedge, const BinnedResponse& response,
                              double speed_m_per_s) {
  DiffractionSpectrum spectrum;
  for (int i = 0; i < kDiffractionFrequencies; ++i) {
    const int band = i / kFrequenciesPerBand;
    const auto parts = response.spectrum(2.0 * kPi * diffraction_frequency_hz(i) / speed_m_per_s);
    spectrum[i] = parts[0] + static_cast<double>(wedge.reflection[0][band]) * parts[1] +
                  static_cast<double>(wedge.reflection[1][band]) * parts[2];
  }
  return spectrum;
}

}  // namespace

double diffraction_frequency_hz(int index) {
  const int place = index % kFrequenciesPerBand;
  const double octaves = (place - (kFrequenciesPerBand - 1) / 2.0) / kFrequenciesPerBand;
  return kOctaveBandCentresHz[index / kFrequenciesPerBand] * std::exp2(octaves);
}

std::vector<EdgeInterval> overlap(const std::vector<EdgeInterval>& a,
                                  const std::vector<EdgeInterval>& b) {
  std::vector<EdgeInterval> both;
  for (const EdgeInterval& x : a) {
    for (const EdgeInterval& y : b) {
      const EdgeInterval shared{std::max(x.begin_m, y.begin_m), std::min(x.end_m, y.end_m)};
      if (shared.begin_m < shared.end_m) both.push_back(shared);
    }
  }
  return both;
}

EdgeApex find_apex(const EdgePoint& source, const EdgePoint& receiver,
                   std::span<const EdgeInterval> intervals) {
  EARPOINT_CHECK(!intervals.empty());
  const double apex_z = unbounded_apex_z(source, receiver);
  double nearest = intervals.front().begin_m;
  for (const EdgeInterval& interval : intervals) {
    const double z = std::clamp(apex_z, interval.begin_m, interval.end_m);
    if (std::abs(z - apex_z) < std::abs(nearest - apex_z)) nearest = z;
  }
  return {.distance_m = std::hypot(source.radius_m, nearest - source.z_m) +
                        std::hypot(receiver.radius_m, nearest - receiver.z_m),
          .z_m = nearest};
}

DiffractionSpectrum diffract(const Wedge& wedge, const EdgePoint& source, const EdgePoint& receiver,
                             std::span<const EdgeInterval> intervals, const UnbentSound& unbent,
                             double speed_m_per_s) {
  EARPOINT_CHECK(!intervals.empty() && wedge.open_angle_rad > 0.0);
  EARPOINT_CHECK(source.radius_m > 0.0 && receiver.radius_m > 0.0);
  const Integrand integrand(wedge, source, receiver, unbent);
  const double apex = unbounded_apex_z(source, receiver);
  const double first_step = kFirstStep * std::min(source.radius_m, receiver.radius_m);
  BinnedResponse response(find_apex(source, receiver, intervals).distance_m);
  for (const EdgeInterval& interval : intervals) {
    const double start = std::clamp(apex, interval.begin_m, interval.end_m);
    integrate(integrand, apex, start, interval.end_m, first_step, response);
    integrate(integrand, apex, start, interval.begin_m, first_step, response);
  }
  return sum_parts(wedge, response, speed_m_per_s);
}

}  // namespace earpoint
