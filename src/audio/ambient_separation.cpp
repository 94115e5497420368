#include <earpoint/audio/ambient_separation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/audio/noise_tracker.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kFrame_s = 0.032;
constexpr int kHopsPerFrame = 4;
constexpr double kStart_s = 1.0;
constexpr float kSubtractionFloor = 0.1F;  // -20 dB
constexpr float kDecisionWeight = 0.98F;
constexpr float kLowestPriorSnr = 0.00316228F;  // -25 dB
// Beyond it the estimator's gain is xi / (1 + xi) to 1e-10.
constexpr double kLargestArgument = 20.0;
// Below any noise: the square of a frame of sound at -200 dB.
constexpr float kSilence = 1e-18F;

constexpr std::array<std::string_view, 3> kNames = {"bandpass", "subtract", "mmse"};

float log_mmse_gain(float prior_snr, float posterior_snr) {
  const double share = prior_snr / (1.0 + prior_snr);
  const double v = std::max(share * posterior_snr, 1e-10);
  const double exponential_integral = v > kLargestArgument ? 0.0 : -std::expint(-v);
  return static_cast<float>(std::min(1.0, share * std::exp(0.5 * exponential_integral)));
}

}  // namespace

std::string_view name_of(AmbientSeparation separation) {
  return kNames.at(static_cast<std::size_t>(separation));
}

std::span<const std::string_view> ambient_separation_names() { return kNames; }

std::optional<AmbientSeparation> ambient_separation_named(std::string_view name) {
  const auto found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<AmbientSeparation>(found - kNames.begin());
}

struct NoiseSuppressor::State {
  State(AmbientSeparation kind, int channel_count, int sample_rate_hz, double cutoff_hz)
      : separation(kind),
        rate_hz(sample_rate_hz),
        hop(fast_fft_size(
            static_cast<int>(std::lround(kFrame_s * sample_rate_hz / kHopsPerFrame)))),
        frame(kHopsPerFrame * hop),
        start_samples(std::max<std::ptrdiff_t>(std::lround(kStart_s * sample_rate_hz), frame)),
        fft(static_cast<int>(frame)),
        bins(static_cast<std::size_t>(fft.bins())),
        first_bin(static_cast<std::size_t>(
            std::ceil(cutoff_hz * static_cast<double>(frame) / sample_rate_hz))),
        tracker(fft.bins(), static_cast<double>(hop) / sample_rate_hz),
        input(static_cast<std::size_t>(channel_count)),
        sums(input.size(), std::vector<float>(static_cast<std::size_t>(frame))),
        spectra(input.size(), std::vector<std::complex<float>>(bins)),
        power(bins),
        gain(bins),
        cleaned(bins) {
    for (std::ptrdiff_t n = 0; n < frame; ++n) {
      const double phase = std::numbers::pi * static_cast<double>(n) / static_cast<double>(frame);
      window.push_back(static_cast<float>(std::sin(phase)));
    }
    work.resize(window.size());
  }

  /// Samples received so far.
  [[nodiscard]] std::ptrdiff_t end() const { return begin + std::ssize(input.front()); }

  /// Sets `spectra` and `power` of the frame that begins at `first`; zeros beyond the sound.
  void analyse(std::ptrdiff_t first) {
    std::ranges::fill(power, 0.0F);
    for (std::size_t c = 0; c < input.size(); ++c) {
      for (std::ptrdiff_t n = 0; n < frame; ++n) {
        const std::ptrdiff_t i = first + n;
        const float x = i >= begin && i < end() ? input[c][i - begin] : 0.0F;
        work[n] = window[n] * x;
      }
      fft.forward(work, spectra[c]);
      for (std::size_t k = 0; k < bins; ++k) power[k] += std::norm(spectra[c][k]);
    }
  }

  /// Starts the noise tracker with the whole frames of the first second.
  void start_tracking() {
    std::vector<float> frames;
    const std::ptrdiff_t known = std::min(end(), start_samples);
    for (std::ptrdiff_t first = 0; first == 0 || first + frame <= known; first += hop) {
      analyse(first);
      frames.insert(frames.end(), power.begin(), power.end());
    }
    tracker.start(frames);
    next = hop - frame;
    started = true;
  }

  void update_gain() {
    const std::span<const float> noise = tracker.noise();
    for (std::size_t k = 0; k < bins; ++k) {
      const float mean = std::max(noise[k], kSilence);
      const float posterior = power[k] / mean;
      if (separation == AmbientSeparation::subtract) {
        const float left = posterior > 1.0F ? 1.0F - 1.0F / posterior : 0.0F;
        gain[k] = std::sqrt(std::max(left, kSubtractionFloor * kSubtractionFloor));
      } else {
        const float prior =
            std::max(kDecisionWeight * cleaned[k] / mean +
                         (1.0F - kDecisionWeight) * std::max(posterior - 1.0F, 0.0F),
                     kLowestPriorSnr);
        gain[k] = log_mmse_gain(prior, posterior);
      }
      if (k < first_bin) gain[k] = 0.0F;
      cleaned[k] = gain[k] * gain[k] * power[k];
    }
  }

  /// Processes the frame that begins at `next` and appends its first hop, which no later frame
  /// overlaps, to `done`.
  void process_frame(std::vector<std::vector<float>>& done) {
    analyse(next);
    // A frame that is partly outside the sound says nothing about the noise.
    if (next >= 0 && next + frame <= end()) tracker.update(power);
    update_gain();
    // The squared windows of overlapping frames add up to half their number.
    constexpr float kScale = 2.0F / kHopsPerFrame;
    const std::ptrdiff_t from = std::max<std::ptrdiff_t>(-next, 0);
    const std::ptrdiff_t to = std::clamp<std::ptrdiff_t>(end() - next, from, hop);
    for (std::size_t c = 0; c < input.size(); ++c) {
      for (std::size_t k = 0; k < bins; ++k) spectra[c][k] *= gain[k];
      fft.inverse(spectra[c], work);
      std::vector<float>& sum = sums[c];
      for (std::ptrdiff_t n = 0; n < frame; ++n) sum[n] += kScale * window[n] * work[n];
      if (next + hop > 0) done[c].insert(done[c].end(), sum.begin() + from, sum.begin() + to);
      sum.erase(sum.begin(), sum.begin() + hop);
      sum.resize(static_cast<std::size_t>(frame));
    }
    next += hop;
  }

  void forget_input_before(std::ptrdiff_t sample) {
    const std::ptrdiff_t count = std::clamp<std::ptrdiff_t>(sample - begin, 0, end() - begin);
    for (std::vector<float>& samples : input) {
      samples.erase(samples.begin(), samples.begin() + count);
    }
    begin += count;
  }

  Waveform process(const Waveform& block, bool last) {
    const auto channels = static_cast<int>(input.size());
    EARPOINT_CHECK(block.channels() == channels || block.samples() == 0);
    for (int c = 0; c < block.channels(); ++c) {
      const auto samples = block.channel(c);
      input[c].insert(input[c].end(), samples.begin(), samples.end());
    }
    if (!started && end() > 0 && (last || end() >= start_samples)) start_tracking();
    std::vector<std::vector<float>> done(input.size());
    while (started && (last ? next < end() : next + frame <= end())) process_frame(done);
    forget_input_before(next);
    Waveform result(channels, std::ssize(done.front()), rate_hz);
    for (int c = 0; c < channels; ++c) std::ranges::copy(done[c], result.channel(c).begin());
    return result;
  }

  AmbientSeparation separation;
  int rate_hz;
  std::ptrdiff_t hop;
  std::ptrdiff_t frame;
  std::ptrdiff_t start_samples;
  RealFft<float> fft;
  std::size_t bins;
  std::size_t first_bin;
  NoiseTracker tracker;
  bool started = false;
  std::ptrdiff_t begin = 0;  // number of input's first sample
  std::ptrdiff_t next = 0;   // where the next frame begins
  std::vector<std::vector<float>> input;
  std::vector<std::vector<float>> sums;  // of the frames so far, from `next` on
  std::vector<std::vector<std::complex<float>>> spectra;
  std::vector<float> power;
  std::vector<float> gain;
  std::vector<float> cleaned;  // power of the primary sound in the previous frame
  std::vector<float> window;
  std::vector<float> work;
};

NoiseSuppressor::NoiseSuppressor(AmbientSeparation separation, int channels, int sample_rate_hz,
                                 double cutoff_hz) {
  EARPOINT_CHECK(separation != AmbientSeparation::bandpass && channels > 0);
  EARPOINT_CHECK(sample_rate_hz >= 8000 && cutoff_hz >= 0.0 && cutoff_hz < sample_rate_hz / 2.0);
  state_ = std::make_unique<State>(separation, channels, sample_rate_hz, cutoff_hz);
}
NoiseSuppressor::~NoiseSuppressor() = default;
NoiseSuppressor::NoiseSuppressor(NoiseSuppressor&&) noexcept = default;
NoiseSuppressor& NoiseSuppressor::operator=(NoiseSuppressor&&) noexcept = default;

Waveform NoiseSuppressor::process(const Waveform& block, bool last) {
  return state_->process(block, last);
}

Waveform suppress_noise(const Waveform& sound, AmbientSeparation separation, double cutoff_hz) {
  NoiseSuppressor suppressor(separation, sound.channels(), sound.sample_rate_hz(), cutoff_hz);
  return suppressor.process(sound, true);
}

}  // namespace earpoint
