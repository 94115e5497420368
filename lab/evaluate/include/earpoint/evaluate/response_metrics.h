#pragma once

#include <optional>

#include <earpoint/evaluate/metric_convention.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Errors of an impulse response as published with Real Acoustic Fields. Zero is best throughout.
struct RafMetrics {
  /// Mean of | ln(|S| + 1e-3) - ln(|S'| + 1e-3) |, S with 1024 points, a window of 512 and a hop
  /// of 256 at 48 kHz (half of these at 16 kHz); the last frame is left out.
  double stft_error = 0.0;
  /// 100 |T - T'| / T, mean of the channels; T from the time between -5 and -15 dB after a
  /// high-pass at 200 Hz. 100 if t60_invalid. Nothing if a reference's T is 0.
  std::optional<double> t60_error_percent;
  bool t60_invalid = false;  ///< a channel of either does not decay by 15 dB
  /// Difference of EDT, six times the time from the first sample to -10 dB, mean of the channels.
  /// Nothing if one has none (where the published evaluation stops, or gives NaN).
  std::optional<double> edt_error_s;
  /// Difference of C50, divided after 50 ms and one sample from the first; nothing if it is
  /// infinite.
  std::optional<double> c50_error_db;
};

/// @param pair  at 48 or 16 kHz, at least 513 (257) samples
/// @throws InputError if it has another rate or fewer samples
/// Source: Chen et al., Real Acoustic Fields (CVPR 2024). The repository has no evaluation; its
/// authors described theirs in its issue 4, and NeRAF's RAFEvaluator follows that.
[[nodiscard]] RafMetrics raf_metrics(const ResponsePair& pair);

/// Errors of an impulse response as published with Neural Acoustic Fields. Zero is best.
struct NafMetrics {
  /// Mean of | ln(|S| + 1e-3) - ln(|S'| + 1e-3) |, S with 512 points and a hop of 128, all bins
  /// but the highest; 256 zeros follow the response.
  double spectral_loss = 0.0;
  /// As RafMetrics, but from the time between -5 and -35 dB, without a high-pass.
  std::optional<double> t60_error_percent;
  bool t60_invalid = false;
};

/// @param pair  at 22,050 Hz; samples beyond +-1 are clamped
/// @throws InputError if it has another rate
/// Source: Luo et al., Learning Neural Acoustic Fields (NeurIPS 2022) and its released evaluation
/// of baselines, which compares waveforms. (Its network has no phases, so the released evaluation
/// of the network gives both responses random ones before it measures T60.)
[[nodiscard]] NafMetrics naf_metrics(const ResponsePair& pair);

/// Errors of an impulse response as published with Acoustic Volume Rendering. Zero is best.
/// Channels count as responses of one batch.
struct AvrMetrics {
  double phase = 0.0;  ///< mean |cos a - cos a'| + mean |sin a - sin a'|, a the angle of the
                       ///< Fourier transform
  double amp = 0.0;    ///< mean |A - A'| / A, A the magnitudes summed over 32 bins
  double env = 0.0;    ///< mean difference of Hilbert envelopes over the reference's largest value
  /// 100 |T - T'| / T, mean of the channels; T from the regression over -5 to -25 dB. Nothing if a
  /// decay has a single sample there. A decay that does not reach -25 dB is measured as far as it
  /// goes, without a warning.
  std::optional<double> t60_error_percent;
  double edt_error_s = 0.0;            ///< six times the sample nearest to -10 dB
  std::optional<double> c50_error_db;  ///< nothing if it is infinite
  /// Mean over three resolutions of spectral convergence, and mean differences of logarithmic and
  /// of linear magnitudes, as auraloss's MultiResolutionSTFTLoss.
  double multi_stft = 0.0;
};

/// Decays are integrated in single precision with 1e-9 added to every squared sample, as released:
/// T60 and EDT depend on the level.
/// @param pair  at least 257 samples
/// @throws InputError if it has fewer samples, or is silent
/// Source: Lan et al., Acoustic Volume Rendering for Neural Impulse Response Fields (NeurIPS 2024)
/// and its released utils/metric.py.
[[nodiscard]] AvrMetrics avr_metrics(const ResponsePair& pair);

}  // namespace earpoint
