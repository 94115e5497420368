#include <earpoint/locate/voice_direction.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <span>
#include <utility>

#include <earpoint/audio/fft.h>
#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

using Complex = std::complex<double>;

constexpr int kFrame = 512;
constexpr int kHop = 128;
constexpr int kFirstBin = 7;   // 219 Hz
constexpr int kLastBin = 224;  // 7000 Hz
constexpr int kBins = kLastBin - kFirstBin + 1;
// In each frame a bin's floor moves by this share towards its power. A rise above the floor counts
// up to e^3.
constexpr double kFloorShare = 0.1;
constexpr double kLargestRise = 3.0;
// Bins weaker than this share of the recent loudness are noise. The loudness falls by 1 % a frame.
constexpr double kWeakest = 0.01;
constexpr double kLoudnessRise = 0.1;
constexpr double kLoudnessFall = 0.01;
// Weight of one nat of rise in one bin. Fitted on the validation homes of a simulated data set by
// the likelihood of the true speaker.
constexpr double kFrameWeight = 0.005;
constexpr double kTiny = 1e-20;

double azimuth_of(std::size_t index, std::size_t count) {
  return -kPi + 2.0 * kPi * static_cast<double>(index) / static_cast<double>(count);
}

/// The phase factors between a head's ears, [directions][bins].
std::vector<Complex> ear_phases(const HrtfSet& head) {
  EARPOINT_CHECK(head.sample_rate_hz() == VoiceDirection::kSampleRateHz);
  // Whole responses, however long: their transform is sampled at the frames' bins.
  const int size = kFrame * ((head.taps() + kFrame - 1) / kFrame);
  RealFft<double> fft(size);
  std::array<std::vector<Complex>, 2> spectra;
  for (auto& spectrum : spectra) spectrum.resize(fft.bins());
  std::vector<double> wave(size);
  std::vector<Complex> phases;
  for (std::size_t i = 0; i < VoiceDirection::kDirections; ++i) {
    const double azimuth_rad = azimuth_of(i, VoiceDirection::kDirections);
    const Hrir hrir = head.interpolated({std::cos(azimuth_rad), std::sin(azimuth_rad), 0.0});
    for (int ear = 0; ear < 2; ++ear) {
      std::ranges::fill(wave, 0.0);
      std::ranges::copy(hrir.taps[ear], wave.begin());
      fft.forward(wave, spectra[ear]);
    }
    for (int bin = kFirstBin; bin <= kLastBin; ++bin) {
      const int at = bin * (size / kFrame);
      const Complex cross = spectra[0][at] * std::conj(spectra[1][at]);
      phases.push_back(cross / (std::abs(cross) + kTiny));
    }
  }
  return phases;
}

}  // namespace

double DirectionEvidence::likelihood_near(double azimuth_rad, double spread_rad) const {
  EARPOINT_CHECK(spread_rad > 0.0);
  if (log_likelihood.empty()) return 1.0;
  const double largest = *std::ranges::max_element(log_likelihood);
  double sum = 0.0, weights = 0.0;
  for (std::size_t i = 0; i < log_likelihood.size(); ++i) {
    const double off = wrap_angle(azimuth_of(i, log_likelihood.size()) - azimuth_rad) / spread_rad;
    const double weight = std::exp(-0.5 * off * off);
    sum += weight * std::exp(log_likelihood[i] - largest);
    weights += weight;
  }
  return sum / weights;
}

double DirectionEvidence::likelihood_outside(double beyond_rad) const {
  EARPOINT_CHECK(beyond_rad < kPi);
  if (log_likelihood.empty()) return 1.0;
  const double largest = *std::ranges::max_element(log_likelihood);
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < log_likelihood.size(); ++i) {
    if (std::abs(azimuth_of(i, log_likelihood.size())) < beyond_rad) continue;
    sum += std::exp(log_likelihood[i] - largest);
    ++count;
  }
  return sum / count;
}

double DirectionEvidence::azimuth_rad() const {
  EARPOINT_CHECK(!log_likelihood.empty());
  const auto best = std::ranges::max_element(log_likelihood) - log_likelihood.begin();
  return azimuth_of(static_cast<std::size_t>(best), log_likelihood.size());
}

struct VoiceDirection::State {
  explicit State(const HrtfSet& head) : phases(ear_phases(head)), fft(kFrame), window(kFrame) {
    for (int i = 0; i < kFrame; ++i) {
      window[i] = 0.5 - 0.5 * std::cos(2.0 * kPi * i / kFrame);
    }
    for (auto& spectrum : spectra) spectrum.resize(fft.bins());
  }

  /// Adds the frame at the front of the samples to the sum over frames.
  void add_frame() {
    for (int ear = 0; ear < 2; ++ear) {
      std::ranges::transform(window, std::span(samples[ear]).first(kFrame), wave.begin(),
                             [](double weight, float sample) { return weight * sample; });
      fft.forward(wave, spectra[ear]);
    }
    std::array<double, kBins> power{};
    double mean = 0.0;
    for (int i = 0; i < kBins; ++i) {
      power[i] =
          0.5 * (std::norm(spectra[0][kFirstBin + i]) + std::norm(spectra[1][kFirstBin + i]));
      mean += power[i] / kBins;
    }
    loudness += (mean - loudness) * (mean > loudness ? kLoudnessRise : kLoudnessFall);
    if (!has_frame) loudness = mean;
    has_frame = true;
    for (int i = 0; i < kBins; ++i) {
      const double rise = std::log(power[i] / (floor[i] + kTiny) + kTiny);
      floor[i] += kFloorShare * (power[i] - floor[i]);
      if (power[i] <= kWeakest * loudness || power[i] <= kTiny) continue;
      const Complex cross = spectra[0][kFirstBin + i] * std::conj(spectra[1][kFirstBin + i]);
      sum[i] += std::clamp(rise, 0.0, kLargestRise) * cross / (std::abs(cross) + kTiny);
    }
  }

  std::vector<Complex> phases;
  RealFft<double> fft;
  std::vector<double> window;
  std::array<double, kFrame> wave{};
  std::array<std::vector<Complex>, 2> spectra;
  std::array<std::vector<float>, 2> samples;  ///< not yet in a frame, or shared by frames
  std::array<double, kBins> floor{};
  std::array<Complex, kBins> sum{};
  double loudness = 0.0;
  bool has_frame = false;
};

VoiceDirection::VoiceDirection(const HrtfSet& head) : state_(std::make_unique<State>(head)) {}
VoiceDirection::~VoiceDirection() = default;
VoiceDirection::VoiceDirection(VoiceDirection&&) noexcept = default;
VoiceDirection& VoiceDirection::operator=(VoiceDirection&&) noexcept = default;

void VoiceDirection::start() {
  for (auto& samples : state_->samples) samples.clear();
  state_->floor.fill(0.0);
  state_->loudness = 0.0;
  state_->has_frame = false;
}

DirectionEvidence VoiceDirection::listen(const Waveform& block) {
  EARPOINT_CHECK(block.channels() == 2 && block.sample_rate_hz() == kSampleRateHz);
  State& state = *state_;
  DirectionEvidence evidence;
  for (int ear = 0; ear < 2; ++ear) {
    const std::span<const float> sound = block.channel(ear);
    state.samples[ear].insert(state.samples[ear].end(), sound.begin(), sound.end());
    for (const float sample : sound) evidence.power += static_cast<double>(sample) * sample;
  }
  if (block.samples() > 0) evidence.power /= 2.0 * static_cast<double>(block.samples());
  state.sum.fill({});
  while (std::ssize(state.samples[0]) >= kFrame) {
    state.add_frame();
    for (auto& samples : state.samples) samples.erase(samples.begin(), samples.begin() + kHop);
  }
  evidence.log_likelihood.resize(kDirections);
  for (std::size_t i = 0; i < kDirections; ++i) {
    double agreement = 0.0;
    for (int bin = 0; bin < kBins; ++bin) {
      agreement += (state.sum[bin] * std::conj(state.phases[i * kBins + bin])).real();
    }
    evidence.log_likelihood[i] = kFrameWeight * agreement;
  }
  return evidence;
}

}  // namespace earpoint
