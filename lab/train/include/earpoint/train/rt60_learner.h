#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/rt60/description.h>
#include <earpoint/rt60/weights.h>
#include <earpoint/train/network_learner.h>
#include <earpoint/train/training_batch.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// The name of an example's time among TrainingExample::inputs: one number, seconds.
inline constexpr std::string_view kT60Input = "t60_s";

/// One second of speech and its time, as an example. @param sound  one channel
[[nodiscard]] TrainingExample rt60_example(std::vector<float> sound, double t60_s);

/// An estimator of reverberation time that learns by gradients, with its Adam optimizer. Of a batch
/// it looks at the sources, [clips][Rt60Description::kWindowSamples], and the times. The loss is
/// the mean absolute error in seconds. As ViGasLearner, in all else.
class Rt60Learner : public NetworkLearner<Rt60Description> {
 public:
  /// @throws InputError if LibTorch does not have the device
  explicit Rt60Learner(const Rt60EstimatorWeights& weights, const std::string& device = "cpu");
  ~Rt60Learner() override;
  Rt60Learner(Rt60Learner&&) noexcept;
  Rt60Learner& operator=(Rt60Learner&&) noexcept;

  /// What Rt60Estimator says of each second.
  [[nodiscard]] std::vector<double> estimate_s(const TrainingBatch& batch);

  /// Absolute errors of the estimates, seconds.
  [[nodiscard]] std::vector<double> errors(const TrainingBatch& batch) override;
  [[nodiscard]] std::string_view error_name() const override { return "t60_error_s"; }

  /// Computes the loss of a batch and its gradient by every parameter; replaces the last one;
  /// batch norms move their running statistics.
  /// @return the loss, seconds
  double compute_gradients(const TrainingBatch& batch) override;

  /// The learner that wrote `file`.
  /// @param where  the file, for messages
  /// @throws InputError if it is no such file
  [[nodiscard]] static Rt60Learner from_checkpoint(const SafetensorsFile& file,
                                                   std::string_view where,
                                                   const std::string& device = "cpu");

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
