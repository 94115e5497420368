#pragma once

#include <memory>
#include <span>
#include <vector>

#include <earpoint/rt60/description.h>
#include <earpoint/rt60/weights.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// A network that hears how long the room rings behind speech. Its estimate of a sound is what the
/// metric RTE compares: it needs no impulse response.
/// Source: Novel-View Acoustic Synthesis, CVPR 2023, section 5.1, and its released code.
/// One caller at a time.
class Rt60Estimator {
 public:
  /// Packs the weights, which are not needed afterwards.
  /// @param threads  > 0
  explicit Rt60Estimator(const Rt60EstimatorWeights& weights, int threads = 1);
  ~Rt60Estimator();
  Rt60Estimator(Rt60Estimator&&) noexcept;
  Rt60Estimator& operator=(Rt60Estimator&&) noexcept;

  [[nodiscard]] const Rt60Description& description() const;

  /// T60 of each channel, in seconds, as the network says it: nothing keeps it from being negative.
  /// The network hears one second. Of a longer sound every whole second is heard, and the mean
  /// returned; the rest at the end is left out. Zeros follow a shorter one.
  /// @param sound  at 16 kHz, at least one sample
  /// @throws std::logic_error if it is not
  [[nodiscard]] std::vector<double> estimate_s(const Waveform& sound);

  /// The same for one channel of exactly one second.
  /// @param second  [Rt60Description::kWindowSamples]
  [[nodiscard]] double estimate_second_s(std::span<const float> second);

  /// What the ResNet made of the last second, averaged over its map: [8 * channels].
  [[nodiscard]] std::span<const float> feature() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
