#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace earpoint {

/// The estimator of reverberation time in the released evaluation: a ResNet-18 with one input
/// channel on log(1 + |STFT|) of one second at 16 kHz (Stft's default shape), the mean over its
/// map, and a linear layer; it gives seconds.
struct Rt60Description {
  int channels = 64;  ///< of the first stage; the four stages have 1, 2, 4 and 8 times as many
  /// Root mean square that every sound is scaled to first, so that its level does not matter;
  /// nothing: sounds are taken as they are, as in the released code.
  std::optional<double> input_rms;

  static constexpr int kSampleRateHz = 16000;
  static constexpr int kWindowSamples = 16000;
};

/// Limits of an estimator's description. @throws InputError naming the field, what was expected and
/// what was found
void check_description(const Rt60Description& description, std::string_view where);
[[nodiscard]] std::string to_json(const Rt60Description& description);
/// Also reads descriptions without `channels` and `input_rms`, which are of the released network.
[[nodiscard]] Rt60Description rt60_description_from_json(std::string_view json,
                                                         std::string_view where);

/// Name and shape of every tensor of the estimator; with the default description those of the
/// released code.
/// Source: docs/released-code.md, metrics.
[[nodiscard]] std::map<std::string, std::vector<std::int64_t>> required_tensors(
    const Rt60Description& description);

}  // namespace earpoint
