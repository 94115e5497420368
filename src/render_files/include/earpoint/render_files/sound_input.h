#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>

#include <earpoint/render/source_stream.h>
#include <earpoint/render/voice_placer.h>

namespace earpoint {

/// Which sound of which file.
struct SoundInput {
  std::filesystem::path path;                           ///< a sound file or a movie
  std::optional<std::array<int, 2>> binaural_channels;  ///< left, right; needed beyond two channels
  std::optional<int> audio_stream;  ///< StreamInfo::index; by default the preferred
  /// Of a recording that is not binaural: where its voice is put before anything else. Null: the
  /// channels are taken for two ears as they are.
  std::shared_ptr<const VoicePlacement> placement{};
};

/// Reads the recording once from end to end, so that nothing is written for a bad one.
/// @throws InputError if it has no sound, or as survey_blocks()
SoundSurvey survey_sound(const SoundInput& source);

/// Reads that sound from its beginning. @throws InputError as AudioReader
[[nodiscard]] BlockReader read_blocks(const SoundInput& source);

}  // namespace earpoint
