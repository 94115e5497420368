#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/dataset/pair_sample.h>
#include <earpoint/train/network_learner.h>
#include <earpoint/train/training_batch.h>
#include <earpoint/vam/description.h>
#include <earpoint/vam/weights.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// The name of the target's pose among TrainingExample::inputs.
inline constexpr std::string_view kVamPoseInput = "pose";

/// A sample as a visual acoustic matching network is trained on it.
[[nodiscard]] TrainingExample vam_example(const VamDescription& description,
                                          const PairSample& sample);

/// A visual acoustic matching network that learns by gradients, with its Adam optimizer. Its loss
/// is ViGAS's, the mean difference of STFT magnitudes; the original's adversarial loss is left out.
/// As ViGasLearner, in all else.
class VamLearner : public NetworkLearner<VamDescription> {
 public:
  /// @throws InputError if LibTorch does not have the device
  explicit VamLearner(const VamWeights& weights, const std::string& device = "cpu");
  ~VamLearner() override;
  VamLearner(VamLearner&&) noexcept;
  VamLearner& operator=(VamLearner&&) noexcept;

  /// @param batch  its targets are not looked at
  /// @return       the sound at the targets, shape of batch.source
  [[nodiscard]] std::vector<float> predict(const TrainingBatch& batch);

  /// The metric Mag of each clip.
  [[nodiscard]] std::vector<double> errors(const TrainingBatch& batch) override;
  [[nodiscard]] std::string_view error_name() const override { return "mag"; }

  /// Computes the loss of a batch and its gradient by every parameter; replaces the last one;
  /// batch norms move their running statistics.
  /// @return the loss
  double compute_gradients(const TrainingBatch& batch) override;

  /// The learner that wrote `file`.
  /// @param where  the file, for messages
  /// @throws InputError if it is no such file
  [[nodiscard]] static VamLearner from_checkpoint(const SafetensorsFile& file,
                                                  std::string_view where,
                                                  const std::string& device = "cpu");

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
