#pragma once

#include <cstdint>
#include <span>

namespace earpoint::plugin {

/// The parameters in the order in which hosts number them. Saved sessions hold these numbers: new
/// ones go to the end of the inputs of a later major version only.
enum ParameterId : std::uint32_t {
  kEarpointX,
  kEarpointY,
  kEarpointZ,
  kYaw,
  kPitch,
  kSpeakerGiven,
  kSpeakerX,
  kSpeakerY,
  kSpeakerZ,
  kModel,
  kNaturalTexture,
  kBypass,
  kStatus,  // from here on outputs
  kLocatedX,
  kLocatedY,
  kLocatedZ,
  kParameterCount,
};

/// What an output says of the plugin.
enum class Status : std::uint8_t {
  renders,             ///< all is well
  rate_not_supported,  ///< the sound passes unchanged
  no_model,            ///< the same
};

/// How a parameter appears in the host.
struct ParameterDescription {
  ParameterId id = kParameterCount;
  const char* symbol = "";  ///< by which ffmpeg and LV2 hosts name it
  const char* name = "";
  const char* unit = "";  ///< "m", "deg" or nothing
  float least = 0.0F;
  float most = 1.0F;
  float standard = 0.0F;
  bool is_switch = false;
  const char* comment = "";
};

/// All but kModel, kBypass and kStatus, which have labels or a meaning of their own.
[[nodiscard]] std::span<const ParameterDescription> plain_parameters();

/// The value within the range of an input. Hosts do not keep to it: ffmpeg sends what it is told.
/// @param value  finite
[[nodiscard]] float within_range(ParameterId id, float value);

}  // namespace earpoint::plugin
