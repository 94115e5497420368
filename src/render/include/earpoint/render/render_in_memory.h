#pragma once

#include <memory>
#include <optional>

#include <earpoint/image.h>
#include <earpoint/pose.h>
#include <earpoint/render/clip_rendering.h>
#include <earpoint/synthesis/earpoint_path.h>
#include <earpoint/synthesis/synthesizer.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// A sound in memory, and what is known of the moment.
struct SoundInMemory {
  Waveform sound;                        ///< 2 ears, at the synthesizer's rate or above
  std::shared_ptr<const Image> picture;  ///< a still one; null: none
  std::optional<Box> speaker_box;
  std::optional<Vector3> speaker_m;
  std::optional<Pose> world_from_source;  ///< as Observation has it
};

/// Renders a sound in memory as render() of render_files does a file: the same windows and
/// cross-fades, the same ambient sound, the same band above the model's.
/// @return 2 ears, as long as the sound and at its rate
/// @throws InputError if something that the synthesizer needs is missing
[[nodiscard]] Waveform render_in_memory(const SoundInMemory& source,
                                        AcousticSynthesizer& synthesizer, const EarpointPath& path,
                                        const ClipRenderOptions& options);

}  // namespace earpoint
