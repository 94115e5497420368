#pragma once

#include <optional>

#include <earpoint/audio/ambient_separation.h>

namespace earpoint {

/// What a synthesizer's answer is.
enum class RenderAnswer {
  place,  ///< what both ears hear at the target; ambient sound is added
  /// The speaker's voice, of a network that was trained for enhancement: without ambient sound, the
  /// mean of both channels; sound files have one channel.
  voice,
};

struct ClipRenderOptions {
  RenderAnswer answer = RenderAnswer::place;
  /// Carry the band above the model's Nyquist frequency along (BandExtension). Without it the
  /// output has the model's band only, at the recording's rate.
  bool extend_band = true;
  AmbientSeparation ambient = AmbientSeparation::bandpass;
  /// In place of the synthesizer's own.
  std::optional<double> ambient_cutoff_hz;
  double gain_db = 0.0;
  /// Keep the output within full scale (PeakLimiter).
  bool limit = true;
  /// With two or more, windows are rendered while others are read and written; several at once if
  /// the synthesizer has twins. The samples are the same for any number.
  int threads = 1;
};

}  // namespace earpoint
