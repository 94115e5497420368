#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <earpoint/image.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// The course of a binaural sound, small enough to keep for any length: for each ear the extremes
/// and the energy over at most 8192 equal spans of time. Fed block by block.
class WaveformOutline {
 public:
  /// One span of one ear.
  struct Span {
    float low = 0.0F;
    float high = 0.0F;
    double energy = 0.0;  ///< sum of squares
  };

  /// @param sample_rate_hz  > 0
  explicit WaveformOutline(int sample_rate_hz);
  /// Of a whole sound, shape [2][samples].
  explicit WaveformOutline(const Waveform& sound);

  /// Appends sound. Samples that are not finite count as 0.
  /// @param block  shape [2][samples], at the rate given to the constructor
  void add(const Waveform& block);

  [[nodiscard]] double duration_s() const;
  /// Samples in each span but the last.
  [[nodiscard]] std::int64_t samples_per_span() const { return samples_per_span_; }
  [[nodiscard]] int sample_rate_hz() const { return sample_rate_hz_; }
  [[nodiscard]] std::span<const Span> spans(int ear) const;
  /// Largest magnitude of both ears.
  [[nodiscard]] double peak() const;
  /// 10 log10 of the mean square; -infinity for silence.
  [[nodiscard]] double level_db(int ear) const;

 private:
  void halve_resolution();

  int sample_rate_hz_;
  std::int64_t samples_ = 0;
  std::int64_t samples_per_span_ = 1;
  std::array<std::vector<Span>, 2> spans_;
};

/// One earpoint's sound in a plot.
struct WaveformPanel {
  std::string label;  ///< ASCII, e.g. "1.0 m left, yaw 90 deg"
  WaveformOutline sound;
};

/// Panels one below the other, one per earpoint, over a common time axis and with one common
/// amplitude scale: the left ear in blue above the right ear in orange, extremes pale and RMS
/// solid, each ear's level in dB re full scale at the right.
/// @param panels  at least one
/// @param title   ASCII; may be empty
/// @param width   pixels, >= 400
/// @return  RGB; its height grows with the number of panels
[[nodiscard]] Image plot_waveforms(std::span<const WaveformPanel> panels, const std::string& title,
                                   int width = 1200);

/// A matrix over time and frequency, e.g. a spectrogram in dB.
struct SpectrogramPanel {
  std::string label;              ///< ASCII
  std::span<const float> levels;  ///< shape [frames][bins], dB; -infinity is allowed
  int frames = 0;
  int bins = 0;
  double duration_s = 0.0;        ///< of all frames together
  double max_frequency_hz = 0.0;  ///< of the last bin; the first is at 0
};

/// Panels one below the other over a common time axis, frequency upwards, level as colour: `top_db`
/// is the brightest, `top_db - range_db` and below black; a scale stands at the right.
/// @param panels  at least one, none empty
/// @param width   pixels, >= 400
[[nodiscard]] Image plot_spectrograms(std::span<const SpectrogramPanel> panels,
                                      const std::string& title, double top_db,
                                      double range_db = 80.0, int width = 1200);

/// The largest finite level of all panels, rounded up to a multiple of 5 dB: a good top_db.
[[nodiscard]] double top_level_db(std::span<const SpectrogramPanel> panels);

}  // namespace earpoint
