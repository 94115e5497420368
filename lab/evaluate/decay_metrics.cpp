#include <earpoint/evaluate/decay_metrics.h>

#include <cmath>
#include <functional>

#include <fmt/format.h>

#include <earpoint/audio/decay.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

/// Runs one measure on a channel and names the channel in its errors.
double measure(const Waveform& wave, std::string_view name, int channel,
               double (*function)(std::span<const float>, double)) {
  try {
    return function(wave.channel(channel), wave.sample_rate_hz());
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: channel {}", name, channel), error.what());
  }
}

bool reaches_t30(const Waveform& wave) {
  try {
    for (int c = 0; c < wave.channels(); ++c) {
      (void)reverberation_time_t30_s(wave.channel(c), wave.sample_rate_hz());
    }
    return true;
  } catch (const InputError&) {
    return false;
  }
}

std::vector<ChannelDecay> decays_of(const Waveform& wave, std::string_view name, DecayRange range) {
  std::vector<ChannelDecay> result;
  result.reserve(static_cast<std::size_t>(wave.channels()));
  for (int c = 0; c < wave.channels(); ++c) {
    result.push_back(
        {measure(wave, name, c,
                 range == DecayRange::t30 ? reverberation_time_t30_s : reverberation_time_t20_s),
         measure(wave, name, c, early_decay_time_s), measure(wave, name, c, clarity_c50_db)});
  }
  return result;
}

}  // namespace

DecayComparison compare_decays(const Waveform& reference, std::string_view reference_name,
                               const Waveform& estimate, std::string_view estimate_name) {
  if (reference.channels() != estimate.channels() || reference.channels() == 0) {
    throw InputError(estimate_name, fmt::format("has {} channels, {} has {}", estimate.channels(),
                                                reference_name, reference.channels()));
  }
  DecayComparison result;
  result.range =
      reaches_t30(reference) && reaches_t30(estimate) ? DecayRange::t30 : DecayRange::t20;
  result.reference = decays_of(reference, reference_name, result.range);
  result.estimate = decays_of(estimate, estimate_name, result.range);
  const double share = 1.0 / reference.channels();
  for (std::size_t c = 0; c < result.reference.size(); ++c) {
    const ChannelDecay& a = result.reference[c];
    const ChannelDecay& b = result.estimate[c];
    result.t60_error_s += share * std::abs(a.t60_s - b.t60_s);
    result.t60_error_percent += share * 100.0 * std::abs(a.t60_s - b.t60_s) / a.t60_s;
    result.edt_error_s += share * std::abs(a.edt_s - b.edt_s);
    result.c50_error_db += share * std::abs(a.c50_db - b.c50_db);
  }
  return result;
}

}  // namespace earpoint
