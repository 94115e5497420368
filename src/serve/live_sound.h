#pragma once

#include <cstddef>
#include <memory>

#include <earpoint/pose.h>
#include <earpoint/render/make_synthesizer.h>
#include <earpoint/render/render_in_memory.h>
#include <earpoint/serve/listen_method.h>
#include <earpoint/serve/served_clip.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// A part of a clip's recording; silence before its beginning and after its end.
[[nodiscard]] Waveform recorded(const ServedClip& clip, std::ptrdiff_t start,
                                std::ptrdiff_t samples);

/// A sound with all that is known of the clip.
[[nodiscard]] SoundInMemory in_memory(const ServedClip& clip, Waveform sound);

[[nodiscard]] SynthesizerOptions seen_with(double horizontal_fov_rad);

/// `before` fades into `after`.
[[nodiscard]] Waveform crossfaded(const Waveform& before, const Waveform& after);

/// What one method makes of a clip, asked for part by part.
class LiveSound {
 public:
  virtual ~LiveSound() = default;

  /// Parts that follow one another join without a click, wherever the earpoint has moved meanwhile.
  /// @param start    sample of the clip
  /// @param samples  > 0
  /// @return 2 ears, [samples], at the clip's rate
  /// @throws InputError if the method lacks what it needs, e.g. a speaker's box
  [[nodiscard]] virtual Waveform part(std::ptrdiff_t start, std::ptrdiff_t samples,
                                      const Pose& source_from_target) = 0;
};

/// @param clip    must outlive it, and the method too
[[nodiscard]] std::unique_ptr<LiveSound> make_live_sound(const ServedClip& clip,
                                                         const ListenMethod& method);

/// What was truly heard at the known place that is nearest.
/// @param clip  must outlive it and have places
[[nodiscard]] std::unique_ptr<LiveSound> make_live_truth(const ServedClip& clip);

}  // namespace earpoint
