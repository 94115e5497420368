#pragma once

#include <span>
#include <vector>

namespace earpoint {

/// What near microphones say of one second.
enum class WindowKind {
  speech,
  silent,  ///< nobody speaks
  noisy,   ///< a knock or a clap
};

struct SpeechWindow {
  WindowKind kind = WindowKind::silent;
  int speaker = 0;           ///< the microphone that is loudest, each re its own loud speech
  bool overlapping = false;  ///< somebody else speaks too
};

/// A second of one near microphone.
struct NearLevel {
  float level_db = 0.0F;  ///< root mean square
  float peak_db = 0.0F;
};

/// Judges windows by the energy of near microphones, as the paper does; its thresholds are not
/// published. Levels are compared re each wearer's own voice (own_voice_levels). Somebody speaks
/// above the middle between that and what 10 % of the windows stay below. A second one speaks too
/// where their microphone is besides less than half as far below the speaker's, in decibels, as the
/// speaker's crosstalk usually is. A window is noisy where a microphone's peak is 6 dB above what
/// 99 % of the peaks stay below.
/// @param levels  [microphone][window], at least one microphone
[[nodiscard]] std::vector<SpeechWindow> judge_windows(
    std::span<const std::vector<NearLevel>> levels);

}  // namespace earpoint
