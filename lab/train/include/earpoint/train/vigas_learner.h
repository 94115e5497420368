#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/train/network_learner.h>
#include <earpoint/train/training_batch.h>
#include <earpoint/vigas/description.h>
#include <earpoint/vigas/weights.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// How far a predicted sound is from the true one, as training sees it.
enum class LossKind {
  magnitude,      ///< mean | |X| - |Y| | of the STFTs: the paper's
  log_magnitude,  ///< the same, plus mean | log |X| - log |Y| |
};

struct LearnerOptions {
  LossKind loss = LossKind::magnitude;
  /// Weight, beside the loss, of how well a linear layer reads from the conditioning vector where
  /// the speaker is from the target and how each ear's level changes; 0 asks nothing. Batches then
  /// have an input "place".
  double place = 0.0;
  /// So many steps learn only that and make no sound: many times as fast.
  std::int64_t place_steps = 0;
  std::string device = "cpu";  ///< or "cuda", "cuda:1", where LibTorch has it
};

/// A ViGAS network that learns by gradients, with its Adam optimizer. Every example is a clip of
/// any length; batch norms follow the batch they are given in compute_gradients() and use their
/// running statistics elsewhere.
///
/// Its weights are those of a weight file, so what was trained renders at once, and the result of
/// predict() is that of the inference engine.
/// The same numbers come out on the same machine with the same number of threads.
/// Source: Novel-View Acoustic Synthesis, CVPR 2023, section 5, and its released code.
class ViGasLearner : public NetworkLearner<ViGasDescription> {
 public:
  /// @throws InputError if LibTorch does not have the device
  explicit ViGasLearner(const ViGasWeights& weights, LearnerOptions options = {});
  ~ViGasLearner() override;
  ViGasLearner(ViGasLearner&&) noexcept;
  ViGasLearner& operator=(ViGasLearner&&) noexcept;

  /// @param batch  its targets are not looked at
  /// @return       the sound at the targets, shape of batch.source
  [[nodiscard]] std::vector<float> predict(const TrainingBatch& batch);

  /// The metric Mag of each clip: the sum over the ears of mean | |S| - |S'| |.
  [[nodiscard]] std::vector<double> errors(const TrainingBatch& batch) override;
  [[nodiscard]] std::string_view error_name() const override { return "mag"; }

  /// Computes the loss of a batch and its gradient by every parameter; replaces the last one;
  /// batch norms move their running statistics.
  /// @return the loss
  double compute_gradients(const TrainingBatch& batch) override;

  /// With the weights of the conditioning probe, where there is one.
  [[nodiscard]] SafetensorsFile checkpoint() const override;

  /// The learner that wrote `file`.
  /// @param where  the file, for messages
  /// @throws InputError if it is no such file
  [[nodiscard]] static ViGasLearner from_checkpoint(const SafetensorsFile& file,
                                                    std::string_view where,
                                                    LearnerOptions options = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Makes LibTorch compute with that many threads from here on, in the whole process.
/// @param threads  > 0
void set_learner_threads(int threads);

}  // namespace earpoint
