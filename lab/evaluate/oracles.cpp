#include <earpoint/evaluate/oracles.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/energy.h>
#include <earpoint/audio/stft.h>
#include <earpoint/core/ears.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kDirect_s = 4e-3;
constexpr double kFade_s = 0.5e-3;
constexpr std::uint64_t kTailSeed = 20230618;

/// The gain that gives energy `from` the energy `to`; 0 if `from` is silent.
double gain(double from, double to) { return from > 0.0 ? std::sqrt(to / from) : 0.0; }

class GainOracle : public Method {
 public:
  Waveform render(const Question& question) override {
    Waveform result = question.sample.source;
    for (int ear = 0; ear < kEars; ++ear) {
      const auto g = static_cast<float>(gain(energy(question.sample.source.channel(ear)),
                                             energy(question.sample.target.channel(ear))));
      for (float& x : result.channel(ear)) x *= g;
    }
    return result;
  }
};

class BandOracle : public Method {
 public:
  Waveform render(const Question& question) override {
    const Waveform& source = question.sample.source;
    Waveform result(kEars, source.samples(), source.sample_rate_hz());
    for (int ear = 0; ear < kEars; ++ear) {
      Spectrogram from = stft_.forward(source.channel(ear));
      const Spectrogram to = stft_.forward(question.sample.target.channel(ear));
      for (int bin = 0; bin < from.bins; ++bin) {
        double from_energy = 0.0;
        double to_energy = 0.0;
        for (int frame = 0; frame < from.frames; ++frame) {
          from_energy += std::norm(from.frame(frame)[bin]);
          to_energy += std::norm(to.frame(frame)[bin]);
        }
        const auto g = static_cast<float>(gain(from_energy, to_energy));
        for (int frame = 0; frame < from.frames; ++frame) from.frame(frame)[bin] *= g;
      }
      std::ranges::copy(stft_.inverse(from, source.samples()), result.channel(ear).begin());
    }
    return result;
  }

 private:
  Stft stft_;
};

const PairTruth& truth_of(const Question& question) {
  if (question.truth == nullptr) {
    throw InputError("the dry speech", "is unknown for recordings",
                     "leave this oracle out, or use simulated data");
  }
  return *question.truth;
}

/// The dry speech convolved with `response`, in the window.
Waveform heard(const PairTruth& truth, const Waveform& response) {
  const std::ptrdiff_t samples = truth.dry.samples() - truth.lead;
  Waveform result(kEars, samples, truth.dry.sample_rate_hz());
  for (int ear = 0; ear < kEars; ++ear) {
    const std::vector<float> whole = convolve(truth.dry.channel(0), response.channel(ear));
    std::copy_n(whole.begin() + truth.lead, samples, result.channel(ear).begin());
  }
  return result;
}

class AllOracle : public Method {
 public:
  Waveform render(const Question& question) override {
    const PairTruth& truth = truth_of(question);
    return heard(truth, truth.target_response);
  }
};

/// Responses with the true direct path and a tail of noise.
class NoiseTail {
 public:
  /// The sound through one of the many responses with the true direct path and decay.
  [[nodiscard]] Waveform heard(const PairTruth& truth, int draw) {
    Waveform response = truth.target_response;
    for (int ear = 0; ear < kEars; ++ear) {
      replace_tail(response.channel(ear), response.sample_rate_hz(), kEars * draw + ear);
    }
    return earpoint::heard(truth, response);
  }

 private:
  /// Keeps the direct path and replaces the rest by noise of the same energy per band and frame.
  void replace_tail(std::span<float> response, int sample_rate_hz, int number) {
    const auto direct = static_cast<std::size_t>(kDirect_s * sample_rate_hz);
    const auto fade = static_cast<std::size_t>(kFade_s * sample_rate_hz);
    std::vector<float> tail(response.begin(), response.end());
    for (std::size_t n = 0; n < response.size(); ++n) {
      const double share = n < direct ? 0.0
                           : n < direct + fade
                               ? static_cast<double>(n - direct + 1) / static_cast<double>(fade + 1)
                               : 1.0;
      tail[n] *= static_cast<float>(share);
      response[n] *= static_cast<float>(1.0 - share);
    }
    const std::vector<float> noise = like(tail, sample_rate_hz, number);
    // No noise before the end of the direct sound.
    for (std::size_t n = direct; n < response.size(); ++n) response[n] += noise[n];
  }

  /// Noise with the energy of `sound` in every octave band of every frame.
  std::vector<float> like(const std::vector<float>& sound, int sample_rate_hz, int number) {
    RandomStream random(kTailSeed, {static_cast<std::uint64_t>(number)});
    std::vector<float> noise(sound.size());
    for (float& x : noise) x = static_cast<float>(random.normal());
    const Spectrogram wanted = stft_.forward(sound);
    Spectrogram shaped = stft_.forward(noise);
    const double hz_per_bin = static_cast<double>(sample_rate_hz) / stft_.shape().fft_size;
    for (int frame = 0; frame < shaped.frames; ++frame) {
      for (int first = 0; first < shaped.bins;) {
        // The band edges are the lowest edge times powers of two.
        const int last =
            std::min(shaped.bins, first == 0 ? static_cast<int>(90.0 / hz_per_bin) + 1 : 2 * first);
        double has = 0.0;
        double needs = 0.0;
        for (int bin = first; bin < last; ++bin) {
          has += std::norm(shaped.frame(frame)[bin]);
          needs += std::norm(wanted.frame(frame)[bin]);
        }
        const auto g = static_cast<float>(gain(has, needs));
        for (int bin = first; bin < last; ++bin) shaped.frame(frame)[bin] *= g;
        first = last;
      }
    }
    return stft_.inverse(shaped, std::ssize(sound));
  }

  Stft stft_;
};

class DryDirectOracle : public Method {
 public:
  Waveform render(const Question& question) override { return tail_.heard(truth_of(question), 0); }

 private:
  NoiseTail tail_;
};

class ExpectedOracle : public Method {
 public:
  Waveform render(const Question& question) override {
    const PairTruth& truth = truth_of(question);
    std::vector<Waveform> draws;
    draws.reserve(kDraws);
    for (int draw = 0; draw < kDraws; ++draw) draws.push_back(tail_.heard(truth, draw));
    Waveform result = draws.front();
    for (int ear = 0; ear < kEars; ++ear) {
      std::vector<Spectrogram> spectra;
      spectra.reserve(draws.size());
      for (const Waveform& draw : draws) spectra.push_back(stft_.forward(draw.channel(ear)));
      std::ranges::copy(sound_of(spectra, result.samples()), result.channel(ear).begin());
    }
    return result;
  }

 private:
  /// A sound whose magnitudes are close to the medians over all draws.
  std::vector<float> sound_of(const std::vector<Spectrogram>& draws, std::ptrdiff_t samples) {
    const std::vector<float> medians = median_magnitudes(draws);
    Spectrogram result = sum_of(draws);  // the phase of what all draws share
    for (int pass = 0;; ++pass) {
      for (std::size_t i = 0; i < medians.size(); ++i) {
        result.values[i] = std::polar(medians[i], std::arg(result.values[i]));
      }
      std::vector<float> sound = stft_.inverse(result, samples);
      if (pass == kPasses) return sound;
      result = stft_.forward(sound);
    }
  }

  static std::vector<float> median_magnitudes(const std::vector<Spectrogram>& draws) {
    std::vector<float> medians(draws.front().values.size());
    std::array<float, kDraws> magnitudes{};
    for (std::size_t i = 0; i < medians.size(); ++i) {
      std::ranges::transform(draws, magnitudes.begin(),
                             [i](const Spectrogram& draw) { return std::abs(draw.values[i]); });
      std::ranges::nth_element(magnitudes, magnitudes.begin() + kDraws / 2);
      medians[i] = magnitudes[kDraws / 2];
    }
    return medians;
  }

  static Spectrogram sum_of(const std::vector<Spectrogram>& draws) {
    Spectrogram sum = draws.front();
    for (const Spectrogram& draw : std::span(draws).subspan(1)) {
      std::ranges::transform(sum.values, draw.values, sum.values.begin(), std::plus<>());
    }
    return sum;
  }

  static constexpr int kDraws = 17;
  // Of the Griffin-Lim algorithm: no sound has exactly the medians as its spectrogram. Eight passes
  // reduce Mag from 0.68 to 0.65 of that of input, on validation pairs.
  static constexpr int kPasses = 8;
  NoiseTail tail_;
  Stft stft_;
};

template <typename Oracle>
MethodEntry entry(std::string_view name, std::string_view what, bool needs_truth) {
  return {.name = std::string(name),
          .what = std::string(what),
          .is_oracle = true,
          .make = [] { return std::make_unique<Oracle>(); },
          .needs_truth = needs_truth};
}

}  // namespace

std::vector<MethodEntry> oracle_methods() {
  return {
      entry<GainOracle>("oracle-gain", "the source at the true level of each ear", false),
      entry<BandOracle>("oracle-bands", "the source at the true level of each bin and ear", false),
      entry<DryDirectOracle>("oracle-dry-direct",
                             "true dry speech and direct path, tail of matched noise", true),
      entry<ExpectedOracle>("oracle-expected",
                            "the same, with median magnitudes over many such tails", true),
      entry<AllOracle>("oracle-all", "true dry speech and response", true)};
}

}  // namespace earpoint
