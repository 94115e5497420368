#include <earpoint/gtf/engine.h>

#include "engine_state.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <earpoint/core/ears.h>
#include <earpoint/error.h>
#include <earpoint/gtf/constants.h>

namespace earpoint {
namespace {

using D = GtfDescription;

constexpr std::ptrdiff_t kHalf = D::kFrameSamples / 2;

}  // namespace

Gtf::Gtf(const GtfWeights& weights) : state_(std::make_unique<State>(weights)) {}
Gtf::~Gtf() = default;
Gtf::Gtf(Gtf&&) noexcept = default;
Gtf& Gtf::operator=(Gtf&&) noexcept = default;

const GtfDescription& Gtf::description() const { return state_->description; }

void Gtf::set_picture(std::span<const float> picture, const std::optional<Box>& speaker_box) {
  state_->conditions.set_picture(picture, speaker_box);
  state_->is_heard = false;
}

void Gtf::set_pose(const Pose& source_from_target, const std::optional<Vector3>& speaker_m) {
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
  state.is_stream = false;
  state.phases.reset(state.description.phase_rounds, std::ssize(source) / kEars);
  state.measure_window(source);
  state.update_summary();
  state.render_window(path, output);
}

void Gtf::tell_voice(std::span<const float> source, std::span<float> voice) {
  State& state = *state_;
  EARPOINT_CHECK(state.description.dry_voice);
  EARPOINT_CHECK(source.size() == kEars * voice.size());
  state.voice.resize(source.size());
  state.tells_voice = true;
  // The dry voice hardly depends on the target, so the target is put at the source.
  const Pose nowhere;
  synthesize(source, {&nowhere, 1}, state.voice);
  state.tells_voice = false;
  std::copy_n(state.voice.begin(), voice.size(), voice.begin());
}

std::optional<GtfSpeaker> Gtf::locate(std::span<const float> source) {
  EARPOINT_CHECK(source.size() % kEars == 0);
  EARPOINT_CHECK(std::ssize(source) >= std::ptrdiff_t{kEars} * D::kFrameSamples);
  State& state = *state_;
  state.reserve(std::ssize(source) / kEars);
  state.start_over();
  state.is_stream = false;
  state.measure_window(source);
  state.update_summary();
  if (!state.description.geometry) return std::nullopt;
  const gtf::GtfPlace& place = state.conditions.located();
  return GtfSpeaker{.position_m = place.position_m,
                    .yaw_rad = std::atan2(place.heading_y, place.heading_x),
                    .yaw_certainty = std::min(std::hypot(place.heading_x, place.heading_y), 1.0)};
}

double Gtf::expected_gain() const {
  const State& state = *state_;
  if (!state.is_stream) return state.expected_gain;
  if (state.frames_in == 0) return 1.0;
  const gtf::GtfGeometry* geometry = state.conditions.geometry();
  return geometry != nullptr ? geometry->expected_gain(state.band_power) : 1.0;
}

const GtfStatistics& Gtf::statistics() const { return state_->statistics; }

void Gtf::start(std::optional<GtfStatistics> statistics, std::optional<int> phase_rounds) {
  State& state = *state_;
  state.start_over();
  state.is_stream = true;
  state.band_power.fill(1e-12);  // so that silence has an expected gain
  state.stream_rounds = phase_rounds.value_or(state.description.phase_rounds);
  state.phases.reset(state.stream_rounds);
  state.reserve(state.description.window_samples);
  state.recent = {};
  state.hops = 0;
  state.squares = state.square_count = 0.0;
  state.is_silent = state.was_silent = true;
  state.statistics.level = gtf::kQuietest;
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
  // Frames of 400 samples are centred on multiples of the hop, so they end 40 samples into a hop.
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
  const std::ptrdiff_t of_rounds = std::ptrdiff_t{D::kOverlappingFrames} * state_->stream_rounds;
  return D::kHop * (state_->ahead + of_rounds + 1) + kHalf;
}

std::optional<Vector3> Gtf::speaker_m() const {
  if (!state_->description.geometry) return std::nullopt;
  return state_->conditions.place().position_m;
}

}  // namespace earpoint
