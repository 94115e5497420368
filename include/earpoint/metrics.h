#pragma once

#include <optional>

#include <earpoint/error.h>
#include <earpoint/export.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Differences of a rendering from the true sound. Zero is best, except for the last two.
struct SoundDifference {
  /// Distance of the magnitudes of short-time spectra, mean over time and frequency, sum of ears.
  double mag = 0.0;
  /// Difference of the energy ratio of left and right, dB; nothing if a left ear is silent.
  std::optional<double> lre_db;
  double stft_distance = 0.0;  ///< of the complex spectra, sum of ears
  double l2 = 0.0;             ///< mean squared difference of the samples
  double delay_samples = 0.0;  ///< magnitude, by GCC-PHAT, mean of ears, at most 50
  /// Scale-invariant signal-to-distortion ratio, mean of ears, at most 100; nothing for silence.
  std::optional<double> si_sdr_db;
  /// Extended short-time objective intelligibility, mean of ears: 1 for the same sound; nothing
  /// for less than 0.4 s of speech, or a rate below 10 kHz.
  std::optional<double> estoi;
};

/// The metrics of `earpoint metrics`, at the sounds' own rate: resample to 16 kHz for numbers that
/// compare with published ones.
/// @param reference, estimate  two ears, left first, of one length and rate
/// @throws InputError if one has not two channels, is empty or has NaN, or if lengths or rates
///         differ
[[nodiscard]] EARPOINT_API SoundDifference compare_sounds(const Waveform& reference,
                                                          const Waveform& estimate);

/// The reverberation of one channel of an impulse response.
struct Reverberation {
  double t60_s = 0.0;   ///< from the decay between -5 and -35 dB
  double edt_s = 0.0;   ///< early decay time, from 0 to -10 dB
  double c50_db = 0.0;  ///< energy of the first 50 ms over the rest
};

/// @param response  an impulse response
/// @throws InputError if the channel does not decay by 35 dB
/// @throws std::logic_error if there is no such channel
[[nodiscard]] EARPOINT_API Reverberation measure_reverberation(const Waveform& response,
                                                               int channel = 0);

}  // namespace earpoint
