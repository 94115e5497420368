#pragma once

#include <array>
#include <span>

#include <earpoint/audio/butterworth.h>
#include <earpoint/gtf/level.h>

namespace earpoint {

/// limit_level() for a stream: holds the power of the last second within bounds that may change at
/// every hop.
class StreamLevel {
 public:
  /// @param hop_s  length of a hop
  explicit StreamLevel(double hop_s);

  /// @param source  the power of what the hop's result was made of, both ears together
  /// @param bounds  of the result's power over the source's
  /// @param result  the power of the hop's result
  /// @return the gain of the amplitude that keeps the last second's result within bounds
  float next(double source, const LevelBounds& bounds, double result);
  void reset();

 private:
  double kept_;
  LevelBounds sum_;
  double result_ = 0.0;
};

/// BandExtension for a stream: by what the network does to its own top octave, per ear, over the
/// last quarter of a second.
class StreamBandGain {
 public:
  /// @param sample_rate_hz  the model's
  /// @param hop_s           length of a hop
  StreamBandGain(int sample_rate_hz, double hop_s);

  /// @param source, result  planar, [2][hop samples], of the same moment
  /// @return gains of the band above the model's, per ear
  std::array<float, 2> next(std::span<const float> source, std::span<const float> result);
  void reset();

 private:
  double kept_;
  double floor_;
  std::array<SectionFilter, 2> before_;  // the top octave of both ears
  std::array<SectionFilter, 2> after_;
  std::array<double, 2> source_{};
  std::array<double, 2> result_{};
};

}  // namespace earpoint
