#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/people/description.h>
#include <earpoint/people/weights.h>
#include <earpoint/train/network_learner.h>
#include <earpoint/train/training_batch.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// A network that finds people and learns by gradients, with its Adam optimizer. Of a batch it
/// looks at the pictures and the inputs of people_example(). As ViGasLearner, in all else.
class PeopleLearner : public NetworkLearner<PeopleDescription> {
 public:
  /// @param width_px, height_px  of the views; multiples of PeopleDescription::kCoarsest
  /// @throws InputError if LibTorch does not have the device
  PeopleLearner(const PeopleWeights& weights, int width_px, int height_px,
                const std::string& device = "cpu");
  ~PeopleLearner() override;
  PeopleLearner(PeopleLearner&&) noexcept;
  PeopleLearner& operator=(PeopleLearner&&) noexcept;

  /// What PeopleNetwork says of each view: [pictures][kOutputs][height / kCell][width / kCell].
  [[nodiscard]] std::vector<float> maps(const TrainingBatch& batch);

  /// 1 - F1 of each picture: people missed and false detections over these and twice the people
  /// found, where boxes overlap by one half or more; 0 where there is nobody and nobody is found.
  [[nodiscard]] std::vector<double> errors(const TrainingBatch& batch) override;
  [[nodiscard]] std::string_view error_name() const override { return "people_error"; }

  /// Computes the loss of a batch and its gradient by every parameter; replaces the last one;
  /// batch norms move their running statistics.
  double compute_gradients(const TrainingBatch& batch) override;

  /// The learner that wrote `file`.
  /// @param where  the file, for messages
  /// @throws InputError if it is no such file
  [[nodiscard]] static PeopleLearner from_checkpoint(const SafetensorsFile& file,
                                                     std::string_view where, int width_px,
                                                     int height_px,
                                                     const std::string& device = "cpu");

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
