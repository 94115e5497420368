#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string_view>

#include <earpoint/dataset/pair_sample.h>

namespace earpoint {

/// What methods get of the speaker.
enum class SpeakerBoxes {
  truth,     ///< where they are seen and stand, as the data set has it
  detected,  ///< the person in the picture who is found to speak, by picture and sound
  none,      ///< nothing
};

/// @param name  "true", "detected" or "none"
/// @throws InputError naming boxes if it is none of them
[[nodiscard]] SpeakerBoxes boxes_named(std::string_view name);

/// Replaces what the data set knows of the speaker by what a method gets: speaker_box and
/// speaker_m. One object per thread.
using SpeakerTelling = std::function<void(PairSample&)>;

/// A maker of such; empty for `truth`.
///
/// `detected` looks for people in the source's picture and listens to the source's sound. The mouth
/// is where speaker_direction_from_box() takes it from the box, or 1.5 m away in the direction that
/// is heard where the speaker is not in the picture.
/// @param detector  a detector's file; nothing: the shipped one
/// @throws InputError if the detector is missing or damaged; it is read here, before any work is
///         done
[[nodiscard]] std::function<SpeakerTelling()> telling_maker(
    SpeakerBoxes boxes, const std::optional<std::filesystem::path>& detector);

}  // namespace earpoint
