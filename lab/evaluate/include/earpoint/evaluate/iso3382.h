#pragma once

#include <optional>
#include <span>
#include <vector>

#include <earpoint/evaluate/metric_convention.h>

namespace earpoint {

/// Room acoustic parameters of an impulse response in one octave band, after ISO 3382-1:2009.
struct IsoBand {
  double centre_hz = 0.0;
  /// Reverberation times as in earpoint/audio/decay.h, of the filtered response; nothing if it does
  /// not decay that far above its noise.
  std::optional<double> edt_s;
  std::optional<double> t20_s;
  std::optional<double> t30_s;
  double c50_db = 0.0;  ///< energy of the first 50 ms over the rest
  double c80_db = 0.0;  ///< of the first 80 ms
  double d50 = 0.0;     ///< share of the first 50 ms in the whole, 0 to 1
  double ts_s = 0.0;    ///< centre of gravity of the squared response
};

/// The octaves from 125 Hz to 4 kHz whose upper edge lies below half the sample rate.
/// Filters are Butterworth band-passes of order 3, -3 dB at the edges, run backwards in time, as
/// the standard recommends, so that their ringing does not prolong the decay. Early and late parts
/// are separated before they are filtered, at the given time after the direct sound: the first
/// sample within 20 dB of the largest.
/// @param response  one channel, shape [samples]
/// @throws InputError if it is silent, not finite, or a band has no energy after 50 or 80 ms
[[nodiscard]] std::vector<IsoBand> iso_bands(std::span<const float> response, int sample_rate_hz);

/// Differences of two responses. Zero is best throughout.
struct IsoMetrics {
  std::vector<std::vector<IsoBand>> reference;  ///< [channels][bands]
  std::vector<std::vector<IsoBand>> estimate;
  /// Mean over the channels of absolute differences; each parameter is first averaged over the
  /// bands of 500 Hz and 1 kHz, the single-number value of the standard's table A.1. Nothing if a
  /// band has no value.
  std::optional<double> edt_error_percent;
  std::optional<double> t20_error_percent;
  std::optional<double> t30_error_percent;
  double c50_error_db = 0.0;
  double c80_error_db = 0.0;
  double d50_error = 0.0;
  double ts_error_ms = 0.0;
};

/// @throws InputError as iso_bands(), or if the rate is too low for the 1 kHz octave
[[nodiscard]] IsoMetrics iso_metrics(const ResponsePair& pair);

}  // namespace earpoint
