#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Gains that let the band above a model's Nyquist frequency follow the model.
///
/// A network at 16 kHz says nothing about the sound above 8 kHz. That band is taken from the
/// recording and scaled, per ear, by what the network did to its own top octave (from half to nine
/// tenths of its Nyquist frequency), window by window, fading where the windows overlap.
class BandExtension {
 public:
  /// @param window, overlap  samples at the model's rate, as the windows are cut
  BandExtension(std::ptrdiff_t window, std::ptrdiff_t overlap);

  /// Notes the next window's gain: sqrt of the top octave's energy at the output over that at the
  /// input, between 0 and 4; 1 where the input has nothing there.
  /// @param input, output  2 ears, [window] samples at the model's rate
  void add_window(const Waveform& input, const Waveform& output);

  /// @param ear            0 left, 1 right
  /// @param model_samples  time in samples at the model's rate, >= 0, within the windows added
  [[nodiscard]] float gain(int ear, double model_samples) const;

  /// Adds to each of `samples` that of `high` at its gain.
  /// @param model_start, model_step  when the first is heard and how far apart they are, in samples
  ///                                 at the model's rate
  void add(int ear, double model_start, double model_step, std::span<const float> high,
           std::span<float> samples) const;

 private:
  struct Place {
    std::ptrdiff_t window = 0;
    double into = 0.0;  ///< samples since it began
  };
  [[nodiscard]] Place place_of(double model_samples) const;
  [[nodiscard]] float gain_at(int ear, Place place) const;
  [[nodiscard]] double top_octave_energy(std::span<const float> samples);

  std::ptrdiff_t window_;
  std::ptrdiff_t overlap_;
  RealFft<float> fft_;
  std::vector<float> taper_;
  std::vector<float> tapered_;
  std::vector<std::complex<float>> spectrum_;
  std::vector<float> rising_;  // how much of a window is heard, by samples into the overlap
  std::vector<std::array<float, 2>> gains_;
};

}  // namespace earpoint
