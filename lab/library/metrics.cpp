#include <earpoint/metrics.h>

#include <earpoint/audio/decay.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/metrics.h>
#include <earpoint/evaluate/speech_metrics.h>

namespace earpoint {
namespace {

/// The mean over both ears; nothing if one of them has no value.
template <class Measure>
std::optional<double> mean_of_ears(const Waveform& reference, const Waveform& estimate,
                                   const Measure& measure) {
  double sum = 0.0;
  for (int ear = 0; ear < 2; ++ear) {
    const std::optional<double> value = measure(reference.channel(ear), estimate.channel(ear));
    if (!value) return std::nullopt;
    sum += *value;
  }
  return sum / 2.0;
}

}  // namespace

SoundDifference compare_sounds(const Waveform& reference, const Waveform& estimate) {
  const BinauralMetrics metrics = binaural_metrics(reference, estimate);
  SoundDifference difference{.mag = metrics.mag,
                             .lre_db = metrics.lre_db,
                             .stft_distance = metrics.stft_distance,
                             .l2 = metrics.l2,
                             .delay_samples = metrics.delay_samples,
                             .si_sdr_db = mean_of_ears(reference, estimate, si_sdr_db),
                             .estoi = std::nullopt};
  if (reference.sample_rate_hz() < Estoi::kLowestRate_hz) return difference;
  Estoi estoi;
  difference.estoi = mean_of_ears(reference, estimate,
                                  [&](std::span<const float> theirs, std::span<const float> ours) {
                                    return estoi.measure(theirs, ours, reference.sample_rate_hz());
                                  });
  return difference;
}

Reverberation measure_reverberation(const Waveform& response, int channel) {
  EARPOINT_CHECK(channel >= 0 && channel < response.channels());
  const std::span<const float> samples = response.channel(channel);
  const double rate_hz = response.sample_rate_hz();
  return {.t60_s = reverberation_time_t30_s(samples, rate_hz),
          .edt_s = early_decay_time_s(samples, rate_hz),
          .c50_db = clarity_c50_db(samples, rate_hz)};
}

}  // namespace earpoint
