#pragma once

#include <cstddef>

#include <earpoint/core/ears.h>
#include <earpoint/gtf/description.h>

namespace earpoint::training {

/// Frames lie side by side and their number is filled up to a multiple of this: whole vectors of
/// every instruction set.
inline constexpr std::ptrdiff_t kFrameStep = 16;
inline constexpr std::ptrdiff_t kBins = GtfDescription::kBins;

/// How a sound of some length lies in the short-time domain.
struct FrameExtent {
  std::ptrdiff_t samples = 0;

  [[nodiscard]] std::ptrdiff_t frames() const { return 1 + samples / GtfDescription::kHop; }
  /// Floats of a row: frames, and zeros up to whole vectors.
  [[nodiscard]] std::ptrdiff_t row() const {
    return (frames() + kFrameStep - 1) / kFrameStep * kFrameStep;
  }
  [[nodiscard]] std::ptrdiff_t plane() const { return kBins * row(); }
  /// Floats of a spectrum, [2 ears][real, imaginary][bins][row].
  [[nodiscard]] std::ptrdiff_t spectrum() const { return 2 * kEars * plane(); }
};

/// The short-time transform of Stft's default shape, of both ears at once.
/// @param sound     [2][samples]
/// @param spectrum  see FrameExtent; zeros where a row has no frames
void analyse(const FrameExtent& extent, const float* sound, float* spectrum);

/// The inverse transform by least squares: frames windowed, added up and divided by what the
/// windows add up to. Bins 0 and 256 count as real.
/// @param spectrum  what it holds beyond the frames is not read
/// @param sound     [2][samples]
void synthesise(const FrameExtent& extent, const float* spectrum, float* sound);

/// The gradient by the sound of what depends on analyse()'s spectrum.
/// @param by_spectrum  the gradient by real and imaginary parts
void analyse_back(const FrameExtent& extent, const float* by_spectrum, float* by_sound);

/// The gradient by the spectrum of what depends on synthesise()'s sound.
void synthesise_back(const FrameExtent& extent, const float* by_sound, float* by_spectrum);

}  // namespace earpoint::training
