#include <earpoint/spatial/hrtf.h>

#include "hrtf_preparation.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include <fmt/format.h>

#include <earpoint/audio/fft.h>
#include <earpoint/error.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/direction_mesh.h>
#include <earpoint/spatial/rigid_sphere.h>

namespace earpoint {
namespace {

using Complex = std::complex<float>;

constexpr double kSpeedOfSound_m_per_s = 343.2;
constexpr double kPoleGap_rad = radians_from_degrees(20.0);
// Floor of a response's bins relative to the largest, as the logarithm of zero is not finite.
constexpr float kFloor = 1e-6F;

// Directions (measured ones, then stand-in poles) with what is interpolated between them.
struct Spectra {
  int fft_size = 0;
  int bins = 0;
  std::vector<Vector3> directions;
  std::vector<std::array<double, 2>> onsets;  // [direction][ear], samples
  std::vector<float> log_magnitude;           // [direction][ear][bin]
  std::vector<Complex> phase;                 // the same; of unit length, onset taken out

  [[nodiscard]] std::size_t offset(std::size_t direction, int ear) const {
    return (direction * 2 + ear) * bins;
  }
};

// Written out because std::complex's product checks for infinities.
template <typename T>
std::complex<T> product(const std::complex<T>& a, const std::complex<T>& b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

Spectra analyse(HrtfResponses& set) {
  Spectra spectra;
  // Twice the length, so that a later onset does not wrap into the start of the response.
  spectra.fft_size = fast_fft_size(2 * set.taps);
  spectra.bins = spectra.fft_size / 2 + 1;
  spectra.directions = set.directions;
  spectra.onsets = set.onsets;
  spectra.log_magnitude.resize(spectra.offset(set.directions.size(), 0));
  spectra.phase.resize(spectra.log_magnitude.size());

  RealFft<float> fft(spectra.fft_size);
  std::vector<float> padded(spectra.fft_size, 0.0F);
  std::vector<Complex> spectrum(spectra.bins);
  std::vector<float> magnitudes(spectra.bins);
  for (std::size_t i = 0; i < set.directions.size(); ++i) {
    for (int ear = 0; ear < 2; ++ear) {
      const double onset = spectra.onsets[i][ear];
      std::ranges::copy(set.response(i, ear), padded.begin());
      fft.forward(padded, spectrum);
      float largest = 1e-30F;
      for (int bin = 0; bin < spectra.bins; ++bin) {
        magnitudes[bin] = std::sqrt(std::norm(spectrum[bin]));
        largest = std::max(largest, magnitudes[bin]);
      }
      const std::complex<double> step = std::polar(1.0, 2.0 * kPi * onset / spectra.fft_size);
      std::complex<double> turn = 1.0;
      for (int bin = 0; bin < spectra.bins; ++bin) {
        const float magnitude = magnitudes[bin];
        const std::size_t at = spectra.offset(i, ear) + bin;
        spectra.log_magnitude[at] = std::log(std::max(magnitude, kFloor * largest));
        spectra.phase[at] =
            magnitude == 0.0F ? Complex(1.0F) : product(spectrum[bin] / magnitude, Complex(turn));
        turn = product(turn, step);
      }
    }
  }
  return spectra;
}

// Adds a stand-in for straight up (side = 1) or down (-1) if nothing was measured near it: the
// average of the ring of directions that come nearest.
void add_pole(Spectra& spectra, std::size_t measured, double side) {
  double highest = -1.0;
  for (std::size_t i = 0; i < measured; ++i) {
    highest = std::max(highest, side * spectra.directions[i].z);
  }
  if (highest > std::cos(kPoleGap_rad)) return;
  const std::size_t pole = spectra.directions.size();
  spectra.directions.push_back({0.0, 0.0, side});
  spectra.onsets.push_back({});
  spectra.log_magnitude.resize(spectra.offset(pole + 1, 0), 0.0F);
  spectra.phase.resize(spectra.log_magnitude.size(), 0.0F);
  constexpr double kRing = 0.03;  // in z
  int count = 0;
  for (std::size_t i = 0; i < measured; ++i) {
    if (side * spectra.directions[i].z < highest - kRing) continue;
    ++count;
    for (int ear = 0; ear < 2; ++ear) {
      spectra.onsets[pole][ear] += spectra.onsets[i][ear];
      for (int bin = 0; bin < spectra.bins; ++bin) {
        const std::size_t to = spectra.offset(pole, ear) + bin;
        const std::size_t from = spectra.offset(i, ear) + bin;
        spectra.log_magnitude[to] += spectra.log_magnitude[from];
        spectra.phase[to] += spectra.phase[from];
      }
    }
  }
  for (double& onset : spectra.onsets[pole]) onset /= count;
  for (std::size_t at = spectra.offset(pole, 0); at < spectra.phase.size(); ++at) {
    spectra.log_magnitude[at] /= static_cast<float>(count);
    const float length = std::abs(spectra.phase[at]);
    spectra.phase[at] = length > 0.0F ? spectra.phase[at] / length : Complex(1.0F);
  }
}

// The mean onset over the sphere is nearly that of the head's centre: on a rigid sphere
// (Woodworth) the near ear's lead averages a/4c, the far ear's lag a (pi/2 - 1) / 2c.
double centre_delay(const HrtfResponses& set) {
  double mean = 0.0;
  for (std::size_t i = 0; i < set.directions.size(); ++i) {
    mean += set.shares[i] * 0.5 * (set.onsets[i][0] + set.onsets[i][1]);
  }
  const double head_samples = kHeadRadius_m / kSpeedOfSound_m_per_s * set.sample_rate_hz;
  return mean - head_samples * ((kPi / 2.0 - 1.0) / 2.0 - 0.25);
}

HrtfResponses prepared(const SofaFile& file, int sample_rate_hz, HrtfEqualization equalization) {
  EARPOINT_CHECK(sample_rate_hz >= 8000);
  HrtfResponses set = farthest_shell(file);
  if (set.directions.size() < 3) {
    throw InputError(
        "head-related impulse responses",
        fmt::format("expected at least 3 directions, found {}", set.directions.size()));
  }
  if (equalization == HrtfEqualization::diffuse_field) equalize_diffuse_field(set);
  change_rate(set, sample_rate_hz);
  return set;
}

DirectionMesh make_mesh(const std::vector<Vector3>& directions) {
  if (!DirectionMesh::spans_space(directions)) {
    throw InputError("head-related impulse responses",
                     "expected directions around the head, found them all in one direction");
  }
  return DirectionMesh(directions);
}

}  // namespace

struct HrtfSet::State {
  HrtfResponses set;
  Spectra spectra;
  DirectionMesh mesh;
  double centre_delay_samples;
};

HrtfSet::HrtfSet(const SofaFile& file, int sample_rate_hz, HrtfEqualization equalization) {
  HrtfResponses set = prepared(file, sample_rate_hz, equalization);
  Spectra spectra = analyse(set);
  add_pole(spectra, set.directions.size(), 1.0);
  add_pole(spectra, set.directions.size(), -1.0);
  DirectionMesh mesh = make_mesh(spectra.directions);
  const double delay = centre_delay(set);
  state_ = std::make_shared<const State>(
      State{std::move(set), std::move(spectra), std::move(mesh), delay});
}

HrtfSet HrtfSet::load(int sample_rate_hz) { return load(default_hrtf_path(), sample_rate_hz); }

HrtfSet HrtfSet::load(const std::filesystem::path& path, int sample_rate_hz,
                      HrtfEqualization equalization) {
  return {read_sofa(path), sample_rate_hz, equalization};
}

int HrtfSet::sample_rate_hz() const { return state_->set.sample_rate_hz; }
int HrtfSet::taps() const { return state_->set.taps; }
std::size_t HrtfSet::size() const { return state_->set.directions.size(); }
double HrtfSet::centre_delay_samples() const { return state_->centre_delay_samples; }

const Vector3& HrtfSet::direction(std::size_t measurement) const {
  EARPOINT_CHECK(measurement < size());
  return state_->set.directions[measurement];
}

std::span<const float> HrtfSet::response(std::size_t measurement, int ear) const {
  EARPOINT_CHECK(measurement < size() && (ear == 0 || ear == 1));
  return std::span(state_->set.responses).subspan((measurement * 2 + ear) * taps(), taps());
}

double HrtfSet::onset_samples(std::size_t measurement, int ear) const {
  EARPOINT_CHECK(measurement < size() && (ear == 0 || ear == 1));
  return state_->spectra.onsets[measurement][ear];
}

std::size_t HrtfSet::nearest(const Vector3& direction) const {
  const auto found = static_cast<std::size_t>(state_->mesh.nearest(direction));
  if (found < size()) return found;
  // Found a stand-in for a pole: search all measured directions.
  const auto best = std::ranges::max_element(
      state_->set.directions, {}, [&](const Vector3& other) { return dot(other, direction); });
  return static_cast<std::size_t>(best - state_->set.directions.begin());
}

Hrir HrtfSet::measured(std::size_t measurement) const {
  Hrir hrir;
  for (int ear = 0; ear < 2; ++ear) {
    const std::span<const float> taps = response(measurement, ear);
    hrir.taps[ear].assign(taps.begin(), taps.end());
    hrir.onset_samples[ear] = onset_samples(measurement, ear);
  }
  return hrir;
}

double HrtfSet::distance_m() const { return state_->set.distance_m; }

Hrir HrtfSet::interpolated(const Vector3& direction) const {
  return interpolated(direction, distance_m());
}

Hrir HrtfSet::interpolated(const Vector3& direction, double distance_m) const {
  Hrir hrir;
  HrirInterpolator(*this).interpolate(direction, distance_m, hrir);
  return hrir;
}

HrirInterpolator::HrirInterpolator(HrtfSet set)
    : set_(std::move(set)),
      fft_(set_.state_->spectra.fft_size),
      spectrum_(set_.state_->spectra.bins),
      padded_(set_.state_->spectra.fft_size) {
  for (std::vector<Complex>& spectrum : near_spectra_) spectrum.resize(spectrum_.size());
}

// What a source nearer than the measurement changes.
void HrirInterpolator::near_field(const Vector3& direction, double distance_m) {
  const double towards_left = direction.y / norm(direction);
  near_field_spectra(distance_m, set_.distance_m(), towards_left, set_.sample_rate_hz() / 2.0,
                     {near_spectra_[0], near_spectra_[1]});
  const auto here = rigid_sphere_delays_s(distance_m, towards_left);
  const auto there = rigid_sphere_delays_s(set_.distance_m(), towards_left);
  for (int ear = 0; ear < 2; ++ear) {
    near_later_samples_[ear] = (here[ear] - there[ear]) * set_.sample_rate_hz();
  }
}

void HrirInterpolator::interpolate(const Vector3& direction, double distance_m, Hrir& hrir) {
  EARPOINT_CHECK(distance_m > 0.0);
  const Spectra& spectra = set_.state_->spectra;
  const DirectionMesh::Place place = set_.state_->mesh.locate(direction);
  const bool near = distance_m < set_.distance_m();
  if (near) near_field(direction, distance_m);
  for (int ear = 0; ear < 2; ++ear) {
    double onset = 0.0;
    for (int corner = 0; corner < 3; ++corner) {
      onset += place.weights[corner] * spectra.onsets[place.corners[corner]][ear];
    }
    const std::complex<double> step = std::polar(1.0, -2.0 * kPi * onset / spectra.fft_size);
    std::complex<double> ramp = 1.0;
    for (int bin = 0; bin < spectra.bins; ++bin) {
      float log_magnitude = 0.0F;
      Complex phase = 0.0F;
      for (int corner = 0; corner < 3; ++corner) {
        const auto weight = static_cast<float>(place.weights[corner]);
        const std::size_t at = spectra.offset(place.corners[corner], ear) + bin;
        log_magnitude += weight * spectra.log_magnitude[at];
        phase += weight * spectra.phase[at];
      }
      const float length = std::abs(phase);
      phase = length > 0.0F ? phase / length : Complex(1.0F);
      spectrum_[bin] = std::exp(log_magnitude) * phase * Complex(ramp);
      ramp *= step;
    }
    if (near) {
      for (int bin = 0; bin < spectra.bins; ++bin) spectrum_[bin] *= near_spectra_[ear][bin];
      onset += near_later_samples_[ear];
    }
    hrir.onset_samples[ear] = onset;
    fft_.inverse(spectrum_, padded_);
    hrir.taps[ear].assign(padded_.begin(), padded_.begin() + set_.taps());
  }
}

}  // namespace earpoint
