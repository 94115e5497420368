#include "parameters.h"

#include "model_search.h"

#include <algorithm>
#include <array>

namespace earpoint::plugin {
namespace {

constexpr float kFarthest_m = 20.0F;
constexpr float kHighest_m = 5.0F;

constexpr std::array kPlain{
    ParameterDescription{kEarpointX, "earpoint_x", "Earpoint front", "m", -kFarthest_m, kFarthest_m,
                         0.0F, false, "Position of the new head in front of the recording one"},
    ParameterDescription{kEarpointY, "earpoint_y", "Earpoint left", "m", -kFarthest_m, kFarthest_m,
                         0.0F, false, "Position of the new head to the left of the recording one"},
    ParameterDescription{kEarpointZ, "earpoint_z", "Earpoint up", "m", -kHighest_m, kHighest_m,
                         0.0F, false, "Position of the new head above the recording one"},
    ParameterDescription{kYaw, "yaw", "Yaw", "deg", -180.0F, 180.0F, 0.0F, false,
                         "Turn of the new head; positive turns to the left"},
    ParameterDescription{kPitch, "pitch", "Pitch", "deg", -90.0F, 90.0F, 0.0F, false,
                         "Turn of the new head; positive looks up"},
    ParameterDescription{kSpeakerGiven, "speaker_given", "Speaker given", "", 0.0F, 1.0F, 0.0F,
                         true,
                         "On: the speaker is at the position below. Off: located from the sound"},
    ParameterDescription{kSpeakerX, "speaker_x", "Speaker front", "m", -kFarthest_m, kFarthest_m,
                         2.0F, false, "Position of the mouth in front of the recording head"},
    ParameterDescription{kSpeakerY, "speaker_y", "Speaker left", "m", -kFarthest_m, kFarthest_m,
                         0.0F, false, "Position of the mouth to the left of the recording head"},
    ParameterDescription{kSpeakerZ, "speaker_z", "Speaker up", "m", -kHighest_m, kHighest_m, 0.0F,
                         false, "Position of the mouth above the recording head"},
    ParameterDescription{kNaturalTexture, "natural_texture", "Natural texture", "", 0.0F, 1.0F,
                         1.0F, true,
                         "On: modulation and decay of such a room. Off: the mean, with the "
                         "least error. Only for models trained for both"},
    ParameterDescription{kLocatedX, "located_x", "Located front", "m", -kFarthest_m, kFarthest_m,
                         0.0F, false, "Where the model takes the mouth to be"},
    ParameterDescription{kLocatedY, "located_y", "Located left", "m", -kFarthest_m, kFarthest_m,
                         0.0F, false, "Where the model takes the mouth to be"},
    ParameterDescription{kLocatedZ, "located_z", "Located up", "m", -kHighest_m, kHighest_m, 0.0F,
                         false, "Where the model takes the mouth to be"},
};

}  // namespace

std::span<const ParameterDescription> plain_parameters() { return kPlain; }

float within_range(ParameterId id, float value) {
  const auto* const plain = std::ranges::find(kPlain, id, &ParameterDescription::id);
  if (plain != kPlain.end()) return std::clamp(value, plain->least, plain->most);
  return std::clamp(value, 0.0F, id == kModel ? static_cast<float>(kMostModels - 1) : 1.0F);
}

}  // namespace earpoint::plugin
