#include "gtf_conditions.h"
#include "gtf_ear.h"
#include "gtf_filter.h"
#include "gtf_trunk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <utility>

#include <earpoint/audio/fft.h>
#include <earpoint/core/error.h>
#include <earpoint/infer/gtf.h>

namespace earpoint {
namespace {

using D = GtfDescription;
using Complex = std::complex<float>;

constexpr int kEars = 2;
constexpr std::ptrdiff_t kFrame = std::ptrdiff_t{kEars} * D::kBins;
constexpr std::ptrdiff_t kBlock = 16;  ///< frames that share one reading of the weights
constexpr std::ptrdiff_t kHalf = D::kFrameSamples / 2;
constexpr std::ptrdiff_t kPad = (D::kFftSize - D::kFrameSamples) / 2;
constexpr float kHeardLevel = 0.05F;
constexpr float kQuietest = 1e-4F;

std::array<float, D::kFrameSamples> hamming() {
  std::array<float, D::kFrameSamples> window{};
  for (std::size_t i = 0; i < window.size(); ++i) {
    const double turn = static_cast<double>(i) / static_cast<double>(window.size());
    window[i] = static_cast<float>(0.54 - 0.46 * std::cos(2.0 * kPi * turn));
  }
  return window;
}

float level_of(double squares, double count) {
  return std::max(static_cast<float>(std::sqrt(squares / std::max(count, 1.0))), kQuietest);
}

}  // namespace

struct Gtf::State {
  explicit State(const GtfWeights& weights)
      : description(weights.description),
        past(description.past_frames),
        ahead(description.needed_ahead()),
        conditions(weights),
        ear(description),
        trunk(weights, kBlock),
        filter(weights, kBlock),
        states(static_cast<std::size_t>((late_states() + kBlock) * trunk.row())),
        block_features(static_cast<std::size_t>(kBlock * description.frame_features())),
        magnitudes(static_cast<std::size_t>((past + ahead + kBlock) * kFrame)),
        spectra(static_cast<std::size_t>((ahead + kBlock) * kFrame)),
        filtered(static_cast<std::size_t>(kFrame)),
        ring(static_cast<std::size_t>(kEars) * kRing),
        ring_weight(kRing) {
    statistics.summary.resize(static_cast<std::size_t>(description.summary_features()));
    reserve(description.window_samples);
    start_over();
  }

  /// Frames by which the trunk is ahead of the output.
  [[nodiscard]] std::ptrdiff_t late_states() const { return ahead - description.look_ahead_frames; }

  void reserve(std::ptrdiff_t samples) {
    const auto frames = static_cast<std::size_t>(1 + samples / D::kHop);
    if (window_spectra.size() == frames * kFrame) return;
    window_spectra.resize(frames * kFrame);
    window_magnitudes.resize(frames * kFrame);
    window_features.resize(frames * static_cast<std::size_t>(description.frame_features()));
  }

  void start_over() {
    trunk.reset();
    filter.reset();
    ear.forget();
    std::ranges::fill(states, 0.0F);
    std::ranges::fill(magnitudes, 0.0F);
    std::ranges::fill(spectra, Complex{});
    std::ranges::fill(ring, 0.0F);
    std::ranges::fill(ring_weight, 0.0F);
    frames_in = 0;
    frames_out = 0;
  }

  /// The spectrum of the frame whose middle is `source[centre]`, zeros outside, scaled.
  void transform(std::span<const float> source, std::ptrdiff_t centre, float scale,
                 std::span<Complex> spectrum) {
    std::ranges::fill(frame, 0.0F);
    const std::ptrdiff_t first = centre - kHalf;
    const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, -first);
    const std::ptrdiff_t end =
        std::min<std::ptrdiff_t>(D::kFrameSamples, std::ssize(source) - first);
    for (std::ptrdiff_t i = begin; i < end; ++i) {
      frame[kPad + i] = source[first + i] * scale * window[i];
    }
    fft.forward(frame, spectrum);
  }

  void update_conditions() {
    conditions.update(statistics.summary, speaker_m, source_from_target);
    trunk.condition(conditions.vector());
    filter.condition(conditions);
    is_aimed = true;
  }

  /// Takes a block of frames and filters those that have all they need.
  /// @param features    [frames][frame features]
  /// @param new_spectra, new_magnitudes  [frames][2][bins]
  void take(std::ptrdiff_t frames, const float* features, const Complex* new_spectra,
            const float* new_magnitudes) {
    std::copy_n(new_magnitudes, frames * kFrame, magnitudes.data() + (past + ahead) * kFrame);
    std::copy_n(new_spectra, frames * kFrame, spectra.data() + ahead * kFrame);
    float* new_states = states.data() + late_states() * trunk.row();
    // The trunk's first frame stands for the output's first: it begins with what lies ahead.
    const std::ptrdiff_t skipped =
        std::clamp<std::ptrdiff_t>(description.look_ahead_frames - frames_in, 0, frames);
    std::fill_n(new_states, skipped * trunk.row(), 0.0F);
    if (skipped < frames) {
      trunk.run(features + skipped * description.frame_features(), frames - skipped,
                new_states + skipped * trunk.row());
    }
    frames_in += frames;
    filter.read(states.data(), trunk.row(), frames);
    for (std::ptrdiff_t i = 0; i < frames; ++i) {
      if (frames_in - frames + i < ahead) continue;
      filter.filter(
          i,
          std::span<const float>(magnitudes)
              .subspan(static_cast<std::size_t>(i * kFrame),
                       static_cast<std::size_t>((past + 1 + description.future_frames) * kFrame)),
          std::span<const Complex>(spectra).subspan(static_cast<std::size_t>(i * kFrame),
                                                    static_cast<std::size_t>(kFrame)),
          filtered);
      add_output();
    }
    const auto keep = [&](auto& rows, std::ptrdiff_t kept, std::ptrdiff_t width) {
      std::copy_n(rows.data() + frames * width, kept * width, rows.data());
    };
    keep(states, late_states(), trunk.row());
    keep(magnitudes, past + ahead, kFrame);
    keep(spectra, ahead, kFrame);
  }

  /// Overlaps the filtered frame into the ring.
  void add_output() {
    const std::ptrdiff_t first = frames_out * D::kHop - kHalf;
    for (int e = 0; e < kEars; ++e) {
      fft.inverse(std::span<const Complex>(filtered).subspan(static_cast<std::size_t>(e) * D::kBins,
                                                             D::kBins),
                  frame);
      for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, -first); i < D::kFrameSamples; ++i) {
        ring[e * kRing + (first + i) % kRing] += frame[kPad + i] * window[i];
      }
    }
    for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, -first); i < D::kFrameSamples; ++i) {
      ring_weight[(first + i) % kRing] += window[i] * window[i];
    }
    ++frames_out;
  }

  /// Takes finished samples out of the ring.
  /// @param output  planar, channels `stride` apart
  void drain(std::ptrdiff_t start, std::ptrdiff_t count, float scale, float* output,
             std::ptrdiff_t stride) {
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const std::ptrdiff_t at = (start + i) % kRing;
      const float weight = ring_weight[at];
      for (int e = 0; e < kEars; ++e) {
        float& sum = ring[e * kRing + at];
        output[e * stride + i] = weight > 0.0F ? sum * scale / weight : 0.0F;
        sum = 0.0F;
      }
      ring_weight[at] = 0.0F;
    }
  }

  void measure_window(std::span<const float> source);
  void render_window(std::span<float> output);
  void follow(std::span<const float> hop);
  void take_hop();

  D description;
  std::ptrdiff_t past;
  std::ptrdiff_t ahead;
  infer::GtfConditions conditions;
  infer::GtfEar ear;
  infer::GtfTrunk trunk;
  infer::GtfFilter filter;
  std::array<float, D::kFrameSamples> window = hamming();
  RealFft<float> fft{D::kFftSize};
  std::array<float, D::kFftSize> frame{};

  Pose source_from_target;
  std::optional<Vector3> speaker_m;
  GtfStatistics statistics;
  bool is_aimed = false;

  // What the next frames need of those before, oldest first.
  std::vector<float> states;
  std::vector<float> block_features;
  std::vector<float> magnitudes;
  std::vector<Complex> spectra;
  std::vector<Complex> filtered;
  std::ptrdiff_t frames_in = 0;
  std::ptrdiff_t frames_out = 0;

  /// Room for the frames of a block that overlap.
  static constexpr std::ptrdiff_t kRing = (kBlock + 1) * D::kHop + D::kFrameSamples;
  std::vector<float> ring;  // [2][kRing]
  std::vector<float> ring_weight;

  std::vector<Complex> window_spectra;
  std::vector<float> window_magnitudes;
  std::vector<float> window_features;

  // Of a stream.
  bool holds_statistics = false;
  std::array<std::array<float, D::kFrameSamples>, kEars> recent{};
  std::ptrdiff_t hops = 0;
  double squares = 0.0;
  double square_count = 0.0;
};

void Gtf::State::measure_window(std::span<const float> source) {
  double sum = 0.0;
  for (const float x : source) sum += double{x} * x;
  statistics.level = level_of(sum, static_cast<double>(source.size()));
  const std::size_t samples = source.size() / kEars;
  const std::ptrdiff_t frames = 1 + static_cast<std::ptrdiff_t>(samples) / D::kHop;
  const auto part = [](auto& rows, std::ptrdiff_t index, std::ptrdiff_t width) {
    return std::span(rows).subspan(static_cast<std::size_t>(index * width),
                                   static_cast<std::size_t>(width));
  };
  for (std::ptrdiff_t t = 0; t < frames; ++t) {
    for (std::size_t e = 0; e < kEars; ++e) {
      transform(source.subspan(e * samples, samples), t * D::kHop, kHeardLevel / statistics.level,
                part(window_spectra, t, kFrame).subspan(e * D::kBins, D::kBins));
    }
    infer::GtfEar::measure(part(window_spectra, t, kFrame), part(window_magnitudes, t, kFrame));
    ear.hear(part(window_spectra, t, kFrame), part(window_magnitudes, t, kFrame),
             part(window_features, t, description.frame_features()));
  }
  ear.summarize(statistics.summary);
}

void Gtf::State::render_window(std::span<float> output) {
  const std::ptrdiff_t samples = std::ssize(output) / kEars;
  const std::ptrdiff_t frames = 1 + samples / D::kHop;
  const float scale = statistics.level / kHeardLevel;
  std::ptrdiff_t drained = 0;
  const auto drain_to = [&](std::ptrdiff_t end) {
    const std::ptrdiff_t count = std::min(end, samples) - drained;
    if (count <= 0) return;
    drain(drained, count, scale, output.data() + drained, samples);
    drained += count;
  };
  // Behind the last frame there is nothing, not even the features of silence.
  std::array<Complex, kFrame> no_spectrum{};
  std::array<float, kFrame> no_magnitude{};
  std::fill_n(block_features.begin(), description.frame_features(), 0.0F);
  for (std::ptrdiff_t t = 0; t < frames + ahead;) {
    std::ptrdiff_t count = 1;
    if (t < frames) {
      count = std::min(frames - t, kBlock);
      take(count, window_features.data() + t * description.frame_features(),
           window_spectra.data() + t * kFrame, window_magnitudes.data() + t * kFrame);
    } else {
      take(1, block_features.data(), no_spectrum.data(), no_magnitude.data());
    }
    t += count;
    drain_to(frames_out * D::kHop - kHalf);
  }
  drain_to(samples);
}

/// Lets level and summary follow the stream.
void Gtf::State::follow(std::span<const float> hop) {
  constexpr double kMemory_s = 1.0;
  const double kept = std::exp(-double{D::kHop} / (D::kSampleRateHz * kMemory_s));
  double sum = 0.0;
  for (const float x : hop) sum += double{x} * x;
  squares = kept * squares + sum;
  square_count = kept * square_count + static_cast<double>(hop.size());
  statistics.level = level_of(squares, square_count);
  ear.fade(static_cast<float>(kept));
}

/// The frame in the middle of the recent samples.
void Gtf::State::take_hop() {
  for (std::size_t e = 0; e < kEars; ++e) {
    transform(recent[e], kHalf, kHeardLevel / statistics.level,
              std::span(window_spectra).subspan(e * D::kBins, D::kBins));
  }
  const std::span<const Complex> spectrum(window_spectra.data(), kFrame);
  const std::span<float> magnitude(window_magnitudes.data(), kFrame);
  const std::span<float> features(window_features.data(),
                                  static_cast<std::size_t>(description.frame_features()));
  infer::GtfEar::measure(spectrum, magnitude);
  ear.hear(spectrum, magnitude, features);
  // What was heard changes slowly.
  constexpr std::ptrdiff_t kRefresh = 10;
  if (!holds_statistics && frames_in % kRefresh == 0) {
    ear.summarize(statistics.summary);
    is_aimed = false;
  }
  if (!is_aimed) update_conditions();
  take(1, features.data(), spectrum.data(), magnitude.data());
}

Gtf::Gtf(const GtfWeights& weights) : state_(std::make_unique<State>(weights)) {}
Gtf::~Gtf() = default;
Gtf::Gtf(Gtf&&) noexcept = default;
Gtf& Gtf::operator=(Gtf&&) noexcept = default;

const GtfDescription& Gtf::description() const { return state_->description; }

void Gtf::look(std::span<const float> picture, const std::optional<Box>& speaker_box) {
  state_->conditions.look(picture, speaker_box);
  state_->is_aimed = false;
}

void Gtf::aim(const Pose& source_from_target, const std::optional<Vector3>& speaker_m) {
  state_->source_from_target = source_from_target;
  state_->speaker_m = speaker_m;
  state_->is_aimed = false;
}

void Gtf::synthesize(std::span<const float> source, std::span<float> output) {
  EARPOINT_CHECK(source.size() == output.size() && source.size() % kEars == 0);
  EARPOINT_CHECK(std::ssize(source) >= std::ptrdiff_t{kEars} * D::kFrameSamples);
  State& state = *state_;
  state.reserve(std::ssize(source) / kEars);
  state.start_over();
  state.measure_window(source);
  state.update_conditions();
  state.render_window(output);
}

const GtfStatistics& Gtf::statistics() const { return state_->statistics; }

void Gtf::start(std::optional<GtfStatistics> statistics) {
  State& state = *state_;
  state.start_over();
  state.reserve(state.description.window_samples);
  state.recent = {};
  state.hops = 0;
  state.squares = state.square_count = 0.0;
  state.holds_statistics = statistics.has_value();
  if (statistics) {
    EARPOINT_CHECK(std::ssize(statistics->summary) == state.description.summary_features());
    state.statistics = std::move(*statistics);
  }
  state.is_aimed = false;
}

void Gtf::advance(std::span<const float> source, std::span<float> output) {
  State& state = *state_;
  EARPOINT_CHECK(std::ssize(source) == std::ptrdiff_t{kEars} * D::kHop &&
                 source.size() == output.size());
  if (!state.holds_statistics) state.follow(source);
  // Frames have their middle at multiples of the hop: one lies 40 samples before the hops' grid.
  constexpr std::ptrdiff_t kOffset = std::ptrdiff_t{2} * D::kHop - kHalf;
  for (std::ptrdiff_t part = 0; part < 2; ++part) {
    const std::ptrdiff_t first = part == 0 ? 0 : D::kHop - kOffset;
    const std::ptrdiff_t count = part == 0 ? D::kHop - kOffset : kOffset;
    for (std::size_t e = 0; e < kEars; ++e) {
      std::shift_left(state.recent[e].begin(), state.recent[e].end(), count);
      std::copy_n(source.begin() + e * D::kHop + first, count, state.recent[e].end() - count);
    }
    // The hop's first 40 samples complete the frame whose middle lies 200 samples back.
    if (part == 0 && state.hops > 0) state.take_hop();
  }
  ++state.hops;
  const std::ptrdiff_t start = state.hops * D::kHop - D::kHop - latency_samples();
  std::ranges::fill(output, 0.0F);
  const std::ptrdiff_t silent = std::clamp<std::ptrdiff_t>(-start, 0, D::kHop);
  if (silent < D::kHop) {
    state.drain(start + silent, D::kHop - silent, state.statistics.level / kHeardLevel,
                output.data() + silent, D::kHop);
  }
}

std::ptrdiff_t Gtf::latency_samples() const { return D::kHop * (state_->ahead + 1) + kHalf; }

std::optional<Vector3> Gtf::speaker_m() const {
  if (!state_->description.geometry) return std::nullopt;
  return state_->conditions.place().position_m;
}

}  // namespace earpoint
