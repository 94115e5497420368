#include <earpoint/render/voice_placer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include <earpoint/error.h>
#include <earpoint/spatial/binaural.h>
#include <earpoint/spatial/dsp_renderer.h>
#include <earpoint/spatial/speaker_direction.h>

namespace earpoint {
namespace {

constexpr double kBlock_s = 0.02;
// Nearer than this a direction means nothing.
constexpr double kNearest_m = 0.2;
constexpr int kUnknownSize_px = 1000;

/// Gains of the channels in the mono voice.
std::array<float, 2> channel_gains(StereoKind kind) {
  switch (kind) {
    case StereoKind::one_channel:
      return {1.0F, 1.0F};  // the other one is silent
    case StereoKind::inverted:
      return {0.5F, -0.5F};
    case StereoKind::plausible:
    case StereoKind::same:
    case StereoKind::panned:
      return {0.5F, 0.5F};
  }
  EARPOINT_CHECK(false);
}

}  // namespace

Vector3 VoicePlacement::at(double time_s) const {
  const auto after = std::ranges::upper_bound(rows, time_s, {}, &Row::time_s);
  if (after == rows.begin()) return rows.front().mouth_m;
  const Row& before = *std::prev(after);
  if (after == rows.end()) return before.mouth_m;
  const double share = (time_s - before.time_s) / (after->time_s - before.time_s);
  return before.mouth_m + share * (after->mouth_m - before.mouth_m);
}

VoicePlacement placed_at(const Vector3& mouth_m, StereoKind kind) {
  return {.rows = {{0.0, mouth_m}}, .kind = kind};
}

std::optional<VoicePlacement> placed_at(const SpeakerTrack& track, StereoKind kind,
                                        double horizontal_fov_rad,
                                        const SpeakerTrack::PictureSize& picture) {
  const auto [width, height] = picture.value_or(std::array{kUnknownSize_px, kUnknownSize_px});
  VoicePlacement placement{.rows = {}, .kind = kind};
  for (const SpeakerTrack::Row& row : track.rows()) {
    if (!row.box) continue;
    placement.rows.push_back({row.time_s, cartesian_from_spherical(speaker_direction_from_box(
                                              *row.box, horizontal_fov_rad, width, height))});
  }
  return placement.rows.empty() ? std::nullopt : std::optional(std::move(placement));
}

struct VoicePlacer::State {
  State(VoicePlacement voice_placement, const HrtfSet& head)
      : placement(std::move(voice_placement)),
        rate_hz(head.sample_rate_hz()),
        panner(head, static_cast<int>(std::lround(kBlock_s * head.sample_rate_hz()))),
        skip(panner.delay_samples()) {}

  /// Pans the block at the front of the voice.
  void pan(std::array<std::vector<float>, 2>& output) {
    const int size = panner.block_size();
    panned += size;
    Spherical place = spherical_from_cartesian(placement.at(static_cast<double>(panned) / rate_hz));
    place.distance_m = std::max(place.distance_m, kNearest_m);
    const auto gain = static_cast<float>(1.0 / distance_gain(place.distance_m));
    std::vector<float> mono(voice.begin(), voice.begin() + size);
    voice.erase(voice.begin(), voice.begin() + size);
    for (float& sample : mono) sample *= gain;
    std::array<std::vector<float>, 2> ears{std::vector<float>(size), std::vector<float>(size)};
    panner.process(mono, place, ears[0], ears[1]);
    const auto skipped = static_cast<std::ptrdiff_t>(std::min<std::ptrdiff_t>(skip, size));
    skip -= skipped;
    for (int ear = 0; ear < 2; ++ear) {
      output[ear].insert(output[ear].end(), ears[ear].begin() + skipped, ears[ear].end());
    }
  }

  Waveform ready(const std::array<std::vector<float>, 2>& output) {
    const std::ptrdiff_t count = std::min(std::ssize(output[0]), taken - given);
    Waveform sound(2, count, rate_hz);
    for (int ear = 0; ear < 2; ++ear) {
      std::copy_n(output[ear].begin(), count, sound.channel(ear).begin());
    }
    given += count;
    return sound;
  }

  VoicePlacement placement;
  int rate_hz;
  BinauralPanner panner;
  std::ptrdiff_t skip;  ///< of the panner's delay
  std::vector<float> voice;
  std::ptrdiff_t taken = 0;
  std::ptrdiff_t panned = 0;
  std::ptrdiff_t given = 0;
};

VoicePlacer::VoicePlacer(VoicePlacement placement, const HrtfSet& head) {
  EARPOINT_CHECK(!placement.rows.empty());
  state_ = std::make_unique<State>(std::move(placement), head);
}
VoicePlacer::~VoicePlacer() = default;
VoicePlacer::VoicePlacer(VoicePlacer&&) noexcept = default;
VoicePlacer& VoicePlacer::operator=(VoicePlacer&&) noexcept = default;

Waveform VoicePlacer::process(const Waveform& block) {
  EARPOINT_CHECK(block.channels() == 2 && block.sample_rate_hz() == state_->rate_hz);
  const auto gains = channel_gains(state_->placement.kind);
  for (std::ptrdiff_t i = 0; i < block.samples(); ++i) {
    state_->voice.push_back(gains[0] * block.channel(0)[i] + gains[1] * block.channel(1)[i]);
  }
  state_->taken += block.samples();
  std::array<std::vector<float>, 2> output;
  while (std::ssize(state_->voice) >= state_->panner.block_size()) state_->pan(output);
  return state_->ready(output);
}

Waveform VoicePlacer::finish() {
  // Silence pushes out what the panner still holds: its delay and an incomplete block.
  std::array<std::vector<float>, 2> output;
  while (state_->given + std::ssize(output[0]) < state_->taken) {
    state_->voice.resize(std::max<std::size_t>(state_->voice.size(), state_->panner.block_size()),
                         0.0F);
    state_->pan(output);
  }
  return state_->ready(output);
}

}  // namespace earpoint
