#pragma once

#include <cstddef>
#include <vector>

#include <earpoint/core/resize.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// One training or test example as the released loaders make it: what the source view knows, and
/// what the target view hears. The order and meaning of the numbers are the loaders' own.
struct NvasSample {
  Waveform source;  ///< 2 ears, [16000] at 16 kHz, high-passed
  Waveform target;
  ImagePlanes source_rgb;  ///< 0 to 1: 256 x 256 (SoundSpaces) or 216 x 384 (Replay)
  ImagePlanes target_rgb;
  std::vector<double> bboxes;        ///< 4
  std::vector<double> tgt_pose;      ///< 3
  std::vector<double> tgt_rotation;  ///< 2 (SoundSpaces) or 6 (Replay)
};

/// The high-pass that the released loaders apply to speech and recordings: order 5 from
/// `cutoff_hz` to one hertz below Nyquist, run both ways.
Waveform highpass(const Waveform& sound, double cutoff_hz);

/// Mean of the two channels. @return [samples]
std::vector<float> mean_of_channels(const Waveform& sound);

/// Later by so many samples, or earlier if negative; the length stays, zeros fill the gap.
Waveform shifted(const Waveform& sound, int delay_samples);

}  // namespace earpoint
