#include "headphone_tones.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/waveform.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 44100;
constexpr double kTone_hz = 200.0;
constexpr std::ptrdiff_t kTone = kRate_hz;
constexpr std::ptrdiff_t kPause = kRate_hz / 2;
constexpr std::ptrdiff_t kRamp = kRate_hz / 10;
constexpr double kLevel = 0.1;          // amplitude, about as loud as the clips
constexpr double kQuietLevel = 0.0501;  // 6 dB less

double ramp(std::ptrdiff_t i) {
  const std::ptrdiff_t to_edge = std::min({i, kTone - 1 - i, kRamp});
  return 0.5 * (1.0 - std::cos(std::numbers::pi * static_cast<double>(to_edge) / kRamp));
}

Waveform tones(int quietest, int opposite) {
  Waveform sound(2, 3 * kTone + 2 * kPause, kRate_hz);
  for (int tone = 0; tone < 3; ++tone) {
    const std::ptrdiff_t start = tone * (kTone + kPause);
    const double level = tone == quietest ? kQuietLevel : kLevel;
    for (std::ptrdiff_t i = 0; i < kTone; ++i) {
      const double phase = 2.0 * std::numbers::pi * kTone_hz * static_cast<double>(i) / kRate_hz;
      const auto value = static_cast<float>(level * ramp(i) * std::sin(phase));
      sound.channel(0)[start + i] = value;
      sound.channel(1)[start + i] = tone == opposite ? -value : value;
    }
  }
  return sound;
}

}  // namespace

std::vector<HeadphoneTrial> write_headphone_trials(const std::filesystem::path& folder) {
  create_folder(folder / "headphones");
  std::vector<HeadphoneTrial> trials;
  for (int quietest = 0; quietest < 3; ++quietest) {
    for (int opposite = 0; opposite < 3; ++opposite) {
      if (opposite == quietest) continue;
      const std::string file = fmt::format("headphones/{}.wav", trials.size() + 1);
      write_sound(folder / file, tones(quietest, opposite), SampleFormat::pcm16);
      trials.push_back({file, quietest});
    }
  }
  return trials;
}

}  // namespace earpoint
