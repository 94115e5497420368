#include "clap_times.h"

#include "clock_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kBefore_s = 0.03;
constexpr double kLength_s = 0.08;
/// A rise begins where this share of the loudest step is reached first.
constexpr std::array<float, 5> kShares{0.8F, 0.5F, 0.35F, 0.25F, 0.15F};
constexpr double kTolerance_s = 0.12e-3;  ///< of the time between the ears
constexpr float kLeastRise = 1.3F;        ///< over the loudest step in the time before
constexpr double kQuiet_s = 1.5e-3;       ///< length of the time before

struct Rise {
  double time_s = 0.0;
  float steepness = 0.0F;
};

std::vector<Rise> rises_of(const Waveform& sound, int ear, double about_s) {
  const double rate = sound.sample_rate_hz();
  const auto begin =
      std::max(std::ptrdiff_t{1}, static_cast<std::ptrdiff_t>((about_s - kBefore_s) * rate));
  const auto end = std::min(sound.samples(), begin + static_cast<std::ptrdiff_t>(kLength_s * rate));
  std::vector<Rise> rises;
  if (end <= begin) return rises;
  std::vector<float> steps;
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    steps.push_back(std::abs(sound.channel(ear)[i] - sound.channel(ear)[i - 1]));
  }
  const float loudest = *std::ranges::max_element(steps);
  const auto quiet = static_cast<std::ptrdiff_t>(kQuiet_s * rate);
  std::ptrdiff_t last = -1;
  for (const float share : kShares) {
    const auto first = std::ranges::find_if(steps, [&](float x) { return x >= share * loudest; });
    const auto at = first - steps.begin();
    if (at == last || at <= 2) continue;
    last = at;
    const float before =
        *std::max_element(steps.begin() + std::max<std::ptrdiff_t>(0, at - quiet), first - 2);
    rises.push_back({static_cast<double>(begin + at) / rate, *first / std::max(before, 1e-9F)});
  }
  return rises;
}

}  // namespace

std::optional<std::array<double, 2>> clap_at_ears(const Waveform& sound, double about_s,
                                                  double interaural_s) {
  EARPOINT_CHECK(sound.channels() == 2);
  std::optional<std::array<double, 2>> found;
  float best = kLeastRise;
  const std::vector<Rise> right = rises_of(sound, 1, about_s);
  for (const Rise& left : rises_of(sound, 0, about_s)) {
    for (const Rise& other : right) {
      const float steepness = std::min(left.steepness, other.steepness);
      if (steepness < best) continue;
      if (std::abs(left.time_s - other.time_s - interaural_s) > kTolerance_s) continue;
      best = steepness;
      found = std::array{left.time_s, other.time_s};
    }
  }
  return found;
}

std::optional<double> clap_emitted_s(const Waveform& sound, double about_s, const Vector3& clap_m,
                                     const Pose& world_from_head) {
  const double left_s = travel_time_s(clap_m, world_from_head, 0);
  const double right_s = travel_time_s(clap_m, world_from_head, 1);
  const auto heard = clap_at_ears(sound, about_s, left_s - right_s);
  if (!heard) return std::nullopt;
  return 0.5 * ((*heard)[0] - left_s + (*heard)[1] - right_s);
}

}  // namespace earpoint
