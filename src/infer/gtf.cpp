#include "gtf_conditions.h"
#include "gtf_ear.h"
#include "gtf_filter.h"
#include "gtf_frames.h"
#include "gtf_phases.h"
#include "gtf_trunk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numeric>
#include <utility>

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
constexpr float kHeardLevel = 0.05F;
constexpr float kQuietest = 1e-4F;

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
        phases(description.phase_rounds),
        frames(kBlock),
        states(static_cast<std::size_t>((late_states() + kBlock) * trunk.row())),
        block_features(static_cast<std::size_t>(kBlock * description.frame_features())),
        magnitudes(static_cast<std::size_t>((past + ahead + kBlock) * kFrame)),
        spectra(static_cast<std::size_t>((ahead + kBlock) * kFrame)),
        filtered(static_cast<std::size_t>(kFrame)) {
    statistics.summary.resize(static_cast<std::size_t>(description.summary_features()));
    band_power.fill(1.0);  // a stream measures no window: all bands count alike
    reserve(description.window_samples);
    start_over();
  }

  /// Frames by which the trunk is ahead of the output.
  [[nodiscard]] std::ptrdiff_t late_states() const { return ahead - description.look_ahead_frames; }

  void reserve(std::ptrdiff_t samples) {
    const auto count = static_cast<std::size_t>(1 + samples / D::kHop);
    if (window_spectra.size() == count * kFrame) return;
    window_spectra.resize(count * kFrame);
    window_magnitudes.resize(count * kFrame);
    window_features.resize(count * static_cast<std::size_t>(description.frame_features()));
    frame_power.resize(count);
  }

  void start_over() {
    trunk.reset();
    filter.reset();
    ear.forget();
    std::ranges::fill(states, 0.0F);
    std::ranges::fill(magnitudes, 0.0F);
    std::ranges::fill(spectra, Complex{});
    phases.reset();
    frames.reset();
    frames_in = 0;
  }

  /// Takes in what was heard and seen.
  void hear() {
    conditions.hear(statistics.summary);
    is_heard = true;
    is_aimed = false;
  }

  /// What the next frames are filtered by. Costs nothing where nothing has changed.
  void condition(const Pose& pose) {
    if (is_aimed && pose == conditioned) return;
    conditioned = pose;
    conditions.aim(speaker_m, pose);
    trunk.condition(conditions.vector());
    filter.condition(conditions);
    const infer::GtfGeometry* geometry = conditions.geometry();
    pose_gain = geometry != nullptr ? geometry->expected_gain(band_power) : 1.0;
    is_aimed = true;
  }

  /// Lets the frame in `filtered` sound, or the one that it pushes out of the phase rounds.
  void sound_frame() {
    const float scale = statistics.level / kHeardLevel;
    if (phases.is_empty()) {
      frames.add(filtered, scale);
      return;
    }
    for (Complex& value : filtered) value *= scale;
    if (phases.take(filtered, scale)) frames.add(filtered, 1.0F);
  }

  /// Takes a block of frames and filters those that have all they need.
  /// @param features    [count][frame features]
  /// @param new_spectra, new_magnitudes  [count][2][bins]
  void take(std::ptrdiff_t count, const float* features, const Complex* new_spectra,
            const float* new_magnitudes) {
    std::copy_n(new_magnitudes, count * kFrame, magnitudes.data() + (past + ahead) * kFrame);
    std::copy_n(new_spectra, count * kFrame, spectra.data() + ahead * kFrame);
    float* new_states = states.data() + late_states() * trunk.row();
    // The trunk's first frame stands for the output's first: it begins with what lies ahead.
    const std::ptrdiff_t skipped =
        std::clamp<std::ptrdiff_t>(description.look_ahead_frames - frames_in, 0, count);
    std::fill_n(new_states, skipped * trunk.row(), 0.0F);
    if (skipped < count) {
      trunk.run(features + skipped * description.frame_features(), count - skipped,
                new_states + skipped * trunk.row());
    }
    frames_in += count;
    filter.read(states.data(), trunk.row(), count);
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      if (frames_in - count + i < ahead) continue;
      filter.filter(
          i,
          std::span<const float>(magnitudes)
              .subspan(static_cast<std::size_t>(i * kFrame),
                       static_cast<std::size_t>((past + 1 + description.future_frames) * kFrame)),
          std::span<const Complex>(spectra).subspan(static_cast<std::size_t>(i * kFrame),
                                                    static_cast<std::size_t>(kFrame)),
          filtered);
      sound_frame();
    }
    const auto keep = [&](auto& rows, std::ptrdiff_t kept, std::ptrdiff_t width) {
      std::copy_n(rows.data() + count * width, kept * width, rows.data());
    };
    keep(states, late_states(), trunk.row());
    keep(magnitudes, past + ahead, kFrame);
    keep(spectra, ahead, kFrame);
  }

  void measure_window(std::span<const float> source);
  void measure_power(std::ptrdiff_t frames_of_window);
  void render_window(std::span<const Pose> path, std::span<float> output);
  void follow(std::span<const float> hop);
  void take_hop();

  D description;
  std::ptrdiff_t past;
  std::ptrdiff_t ahead;
  infer::GtfConditions conditions;
  infer::GtfEar ear;
  infer::GtfTrunk trunk;
  infer::GtfFilter filter;
  infer::GtfPhases phases;
  infer::GtfFrames frames;

  Pose source_from_target;
  std::optional<Vector3> speaker_m;
  GtfStatistics statistics;
  bool is_heard = false;  ///< `conditions` has heard these statistics, and seen what is seen
  bool is_aimed = false;  ///< trunk and filter are conditioned by `conditioned`
  Pose conditioned;

  // What the next frames need of those before, oldest first.
  std::vector<float> states;
  std::vector<float> block_features;
  std::vector<float> magnitudes;
  std::vector<Complex> spectra;
  std::vector<Complex> filtered;
  std::ptrdiff_t frames_in = 0;

  std::vector<Complex> window_spectra;
  std::vector<float> window_magnitudes;
  std::vector<float> window_features;

  // Of the window: power in the head's bands, both ears together, and of every frame.
  std::array<double, D::kHeadBands> band_power{};
  std::vector<double> frame_power;
  double pose_gain = 1.0;      ///< expected of the pose that was conditioned last
  double expected_gain = 1.0;  ///< of the window, over its poses

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
  const std::ptrdiff_t count = 1 + static_cast<std::ptrdiff_t>(samples) / D::kHop;
  const auto part = [](auto& rows, std::ptrdiff_t index, std::ptrdiff_t width) {
    return std::span(rows).subspan(static_cast<std::size_t>(index * width),
                                   static_cast<std::size_t>(width));
  };
  for (std::ptrdiff_t t = 0; t < count; ++t) {
    for (std::size_t e = 0; e < kEars; ++e) {
      frames.transform(source.subspan(e * samples, samples), t * D::kHop,
                       kHeardLevel / statistics.level,
                       part(window_spectra, t, kFrame).subspan(e * D::kBins, D::kBins));
    }
    infer::GtfEar::measure(part(window_spectra, t, kFrame), part(window_magnitudes, t, kFrame));
    ear.hear(part(window_spectra, t, kFrame), part(window_magnitudes, t, kFrame),
             part(window_features, t, description.frame_features()));
  }
  ear.summarize(statistics.summary);
  measure_power(count);
}

void Gtf::State::measure_power(std::ptrdiff_t frames_of_window) {
  // So that silence expects something too; far below the floor of any sound.
  constexpr double kLeast = 1e-12;
  band_power.fill(kLeast);
  for (std::ptrdiff_t t = 0; t < frames_of_window; ++t) {
    frame_power[t] = kLeast;
    for (std::size_t band = 0; band < band_power.size(); ++band) {
      double sum = 0.0;
      for (std::ptrdiff_t e = 0; e < kEars; ++e) {
        const float* magnitude = window_magnitudes.data() + t * kFrame + e * D::kBins;
        for (int bin = kGtfHeadEdges[band]; bin < kGtfHeadEdges[band + 1]; ++bin) {
          sum += double{magnitude[bin]} * magnitude[bin];
        }
      }
      band_power[band] += sum;
      frame_power[t] += sum;
    }
  }
}

/// @param path  the target's pose at every frame, or the one at all of them
void Gtf::State::render_window(std::span<const Pose> path, std::span<float> output) {
  const std::ptrdiff_t samples = std::ssize(output) / kEars;
  const std::ptrdiff_t whole = 1 + samples / D::kHop;
  std::ptrdiff_t drained = 0;
  const auto drain_to = [&](std::ptrdiff_t end) {
    const std::ptrdiff_t count = std::min(end, samples) - drained;
    if (count <= 0) return;
    frames.drain(drained, count, output.data() + drained, samples);
    drained += count;
  };
  const auto pose_at = [&](std::ptrdiff_t frame) -> const Pose& {
    return path[std::clamp<std::ptrdiff_t>(frame, 0, std::ssize(path) - 1)];
  };
  // Behind the last frame there is nothing, not even the features of silence.
  std::array<Complex, kFrame> no_spectrum{};
  std::array<float, kFrame> no_magnitude{};
  std::fill_n(block_features.begin(), description.frame_features(), 0.0F);
  double expected_power = 0.0;
  for (std::ptrdiff_t t = 0; t < whole + ahead;) {
    // The frames that come out are `ahead` behind those that go in; a block has one pose.
    const Pose& pose = pose_at(t - ahead);
    condition(pose);
    std::ptrdiff_t count = 1;
    if (t < whole) {
      while (count < std::min(whole - t, kBlock) && pose_at(t - ahead + count) == pose) ++count;
      take(count, window_features.data() + t * description.frame_features(),
           window_spectra.data() + t * kFrame, window_magnitudes.data() + t * kFrame);
    } else {
      take(1, block_features.data(), no_spectrum.data(), no_magnitude.data());
    }
    for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(t, ahead); i < t + count; ++i) {
      expected_power += pose_gain * frame_power[i - ahead];
    }
    t += count;
    drain_to(frames.finished_samples());
  }
  while (phases.drain(filtered)) {
    frames.add(filtered, 1.0F);
    drain_to(frames.finished_samples());
  }
  drain_to(samples);
  expected_gain = expected_power / std::reduce(frame_power.begin(), frame_power.end());
}

/// Lets level and summary follow the stream.
void Gtf::State::follow(std::span<const float> hop) {
  constexpr double kMemory_s = 1.0;
  const double kept = std::exp(-double{D::kHop} / (D::kSampleRateHz * kMemory_s));
  double sum = 0.0;
  for (const float x : hop) sum += double{x} * x;
  squares = kept * squares + sum;
  square_count = kept * square_count + static_cast<double>(hop.size());
  const float before = statistics.level;
  statistics.level = level_of(squares, square_count);
  ear.fade(static_cast<float>(kept));
  // What is remembered was scaled by the level of its time; from now on the present one counts.
  const float rescale = before / statistics.level;
  for (float& value : magnitudes) value *= rescale;
  for (Complex& value : spectra) value *= rescale;
  filter.rescale(rescale);
  ear.rescale(rescale * rescale);
}

/// The frame in the middle of the recent samples.
void Gtf::State::take_hop() {
  for (std::size_t e = 0; e < kEars; ++e) {
    frames.transform(recent[e], kHalf, kHeardLevel / statistics.level,
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
    is_heard = false;
  }
  if (!is_heard) hear();
  condition(source_from_target);
  take(1, features.data(), spectrum.data(), magnitude.data());
}

Gtf::Gtf(const GtfWeights& weights) : state_(std::make_unique<State>(weights)) {}
Gtf::~Gtf() = default;
Gtf::Gtf(Gtf&&) noexcept = default;
Gtf& Gtf::operator=(Gtf&&) noexcept = default;

const GtfDescription& Gtf::description() const { return state_->description; }

void Gtf::look(std::span<const float> picture, const std::optional<Box>& speaker_box) {
  state_->conditions.look(picture, speaker_box);
  state_->is_heard = false;
}

void Gtf::aim(const Pose& source_from_target, const std::optional<Vector3>& speaker_m) {
  state_->source_from_target = source_from_target;
  if (state_->speaker_m == speaker_m) return;
  state_->speaker_m = speaker_m;
  state_->is_aimed = false;
}

void Gtf::ask_for_texture(double texture) {
  state_->conditions.ask_for_texture(static_cast<float>(texture));
  state_->is_aimed = false;
}

void Gtf::synthesize(std::span<const float> source, std::span<float> output) {
  synthesize(source, {&state_->source_from_target, 1}, output);
}

void Gtf::synthesize(std::span<const float> source, std::span<const Pose> path,
                     std::span<float> output) {
  EARPOINT_CHECK(source.size() == output.size() && source.size() % kEars == 0);
  EARPOINT_CHECK(std::ssize(source) >= std::ptrdiff_t{kEars} * D::kFrameSamples);
  EARPOINT_CHECK(path.size() == 1 || path.size() == 1 + source.size() / kEars / D::kHop);
  State& state = *state_;
  state.reserve(std::ssize(source) / kEars);
  state.start_over();
  state.phases.reset(std::ssize(source) / kEars);
  state.measure_window(source);
  state.hear();
  state.render_window(path, output);
}

std::optional<GtfSpeaker> Gtf::locate(std::span<const float> source) {
  EARPOINT_CHECK(source.size() % kEars == 0);
  EARPOINT_CHECK(std::ssize(source) >= std::ptrdiff_t{kEars} * D::kFrameSamples);
  State& state = *state_;
  state.reserve(std::ssize(source) / kEars);
  state.start_over();
  state.measure_window(source);
  state.hear();
  if (!state.description.geometry) return std::nullopt;
  const infer::GtfPlace& place = state.conditions.located();
  return GtfSpeaker{.position_m = place.position_m,
                    .yaw_rad = std::atan2(place.heading_y, place.heading_x),
                    .yaw_certainty = std::min(std::hypot(place.heading_x, place.heading_y), 1.0)};
}

double Gtf::expected_gain() const { return state_->expected_gain; }

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
  state.is_heard = false;
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
    state.frames.drain(start + silent, D::kHop - silent, output.data() + silent, D::kHop);
  }
}

std::ptrdiff_t Gtf::latency_samples() const {
  return D::kHop * (state_->ahead + state_->description.phase_ahead() + 1) + kHalf;
}

std::optional<Vector3> Gtf::speaker_m() const {
  if (!state_->description.geometry) return std::nullopt;
  return state_->conditions.place().position_m;
}

}  // namespace earpoint
