#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <earpoint/waveform.h>

namespace earpoint {

/// The decay range that a reverberation time is read from.
enum class DecayRange { t30, t20 };

/// What earpoint/audio/decay.h measures of one channel of an impulse response.
struct ChannelDecay {
  double t60_s = 0.0;  ///< over the DecayRange of the comparison
  double edt_s = 0.0;
  double c50_db = 0.0;
};

/// Two impulse responses compared, channel by channel; errors are means over the channels of
/// absolute differences.
struct DecayComparison {
  /// T30 if every channel of both decays that far, otherwise T20 for all.
  DecayRange range = DecayRange::t30;
  std::vector<ChannelDecay> reference;  ///< shape [channels]
  std::vector<ChannelDecay> estimate;   ///< shape [channels]
  double t60_error_s = 0.0;
  double t60_error_percent = 0.0;  ///< of the reference's, before the mean
  double edt_error_s = 0.0;
  double c50_error_db = 0.0;
};

/// @param reference, estimate            impulse responses with the same number of channels; rates
///                                       and lengths may differ
/// @param reference_name, estimate_name  stand for the two in messages, e.g. their files
/// @throws InputError if the numbers of channels differ, or a channel has no such decay (it is
///         named)
[[nodiscard]] DecayComparison compare_decays(const Waveform& reference,
                                             std::string_view reference_name,
                                             const Waveform& estimate,
                                             std::string_view estimate_name);

}  // namespace earpoint
