#pragma once

#include <optional>
#include <span>
#include <string>

#include <earpoint/image.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// A sound as the plots of a report call it.
struct NamedSound {
  std::string name;
  Waveform wave;
};

/// Both ears of every sound over time, an <img>.
[[nodiscard]] std::string waveform_plot(std::span<const NamedSound> sounds);

/// The spectrogram of one ear of every sound with one scale of colours, an <img>.
[[nodiscard]] std::string spectrogram_plot(std::span<const NamedSound> sounds, int ear);

/// The square part of a picture around a box, as far as the picture reaches.
[[nodiscard]] Image cut_out(const Image& picture, const Box& box);

/// The picture with the speaker's box, if there is one, drawn on it.
[[nodiscard]] Image boxed(Image picture, const std::optional<Box>& speaker_box);

}  // namespace earpoint
