#include <earpoint/serve/listener.h>

#include "live_sound.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <earpoint/audio/energy.h>
#include <earpoint/error.h>
#include <earpoint/synthesis/earpoint_path.h>

namespace earpoint {
namespace {

constexpr double kLevelMemory_s = 2.0;
constexpr double kLargestGain = 10.0;  // 20 dB either way
constexpr double kSilentPower = 1e-10;

}  // namespace

Listener::Listener(std::shared_ptr<const ServedClip> clip, std::span<const ListenMethod> methods)
    : clip_(std::move(clip)), methods_(methods) {}
Listener::~Listener() = default;

LiveSound& Listener::sound_of(const std::string& method) {
  if (const auto known = sounds_.find(method); known != sounds_.end()) return *known->second;
  std::unique_ptr<LiveSound> sound;
  if (method == kTruthName && !clip_->places.empty()) {
    sound = make_live_truth(*clip_);
  } else {
    const auto found = std::ranges::find(methods_, method, &ListenMethod::name);
    if (found == methods_.end()) throw InputError("method", "is not available for this clip");
    sound = make_live_sound(*clip_, *found);
  }
  return *sounds_.emplace(method, std::move(sound)).first->second;
}

void Listener::match_level(Waveform& sound, std::ptrdiff_t start, bool matches) {
  const double part_s = static_cast<double>(sound.samples()) / sound.sample_rate_hz();
  const double keep = std::exp(-part_s / kLevelMemory_s);
  power_recorded_ =
      keep * power_recorded_ + energy(recorded(*clip_, start, sound.samples()).planar());
  power_heard_ = keep * power_heard_ + energy(sound.planar());
  const float before = gain_;
  if (!matches) {
    gain_ = 1.0F;
  } else if (power_recorded_ > kSilentPower && power_heard_ > kSilentPower) {
    gain_ = static_cast<float>(
        std::clamp(std::sqrt(power_recorded_ / power_heard_), 1.0 / kLargestGain, kLargestGain));
  }
  if (before == 1.0F && gain_ == 1.0F) return;
  for (int ear = 0; ear < 2; ++ear) {
    const auto samples = sound.channel(ear);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const float share = static_cast<float>(i + 1) / static_cast<float>(samples.size());
      samples[i] = std::clamp(samples[i] * std::lerp(before, gain_, share), -1.0F, 1.0F);
    }
  }
}

Waveform Listener::listen(std::ptrdiff_t start, std::ptrdiff_t samples, const ListenWish& wish) {
  EARPOINT_CHECK(samples > 0 && samples <= clip_->sound.sample_rate_hz());
  check_place(wish.source_from_target.position_m, "position_m");
  Waveform sound = sound_of(wish.method).part(start, samples, wish.source_from_target);
  if (start != next_) {
    power_recorded_ = power_heard_ = 0.0;
  } else if (method_ != wish.method) {
    sound = crossfaded(sound_of(method_).part(start, samples, wish.source_from_target), sound);
    power_recorded_ = power_heard_ = 0.0;
  }
  next_ = start + samples;
  method_ = wish.method;
  match_level(sound, start, wish.matches_level);
  return sound;
}

}  // namespace earpoint
