#include <earpoint/train/people_learner.h>

#include "graph.h"
#include "learned_tensors.h"
#include "loss.h"
#include "torch_tensor.h"

#include <span>
#include <utility>

#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>

#include <earpoint/error.h>
#include <earpoint/locate/decode_people.h>
#include <earpoint/locate/detection_count.h>
#include <earpoint/train/people_example.h>

namespace earpoint {
namespace {

using D = PeopleDescription;

// Limit of the norm of a step's gradient, as single pictures full of people have large gradients.
constexpr double kLongestGradient = 10.0;

std::vector<TruePerson> true_people(std::span<const float> rows) {
  std::vector<TruePerson> people;
  for (std::size_t i = 0; i < kMostTruths; ++i) {
    const std::span<const float> row = rows.subspan(5 * i, 5);
    if (row[4] == 0.0F) continue;
    people.push_back(
        {{.x_min = row[0], .y_min = row[1], .x_max = row[2], .y_max = row[3]}, row[4] == 1.0F});
  }
  return people;
}

}  // namespace

struct PeopleLearner::State {
  State(const PeopleWeights& weights, int width_px, int height_px, const std::string& device_name)
      : width(width_px),
        height(height_px),
        device(device_named(device_name)),
        graph(weights, device) {
    EARPOINT_CHECK(width % D::kCoarsest == 0 && height % D::kCoarsest == 0);
  }

  [[nodiscard]] std::int64_t rows() const { return height / D::kCell; }
  [[nodiscard]] std::int64_t columns() const { return width / D::kCell; }

  [[nodiscard]] at::Tensor forward(const TrainingBatch& batch, GraphMode mode) const {
    return graph.run(to_torch(batch.pictures, {batch.clips, 3, height, width}, device), mode);
  }

  [[nodiscard]] PeopleTargets targets(const TrainingBatch& batch) const {
    const auto input = [&](std::string_view name, std::vector<std::int64_t> shape) {
      return to_torch(batch.inputs.at(std::string(name)), std::move(shape), device);
    };
    const std::vector<std::int64_t> cells{batch.clips, rows(), columns()};
    return {input(kMiddlesInput, cells), input(kBoxesInput, {batch.clips, 4, rows(), columns()}),
            input(kBoxWeightsInput, cells), input(kBackgroundInput, cells)};
  }

  int width;
  int height;
  at::Device device;
  PeopleGraph graph;
};

PeopleLearner::PeopleLearner(const PeopleWeights& weights, int width_px, int height_px,
                             const std::string& device)
    : NetworkLearner(weights.description),
      state_(std::make_unique<State>(weights, width_px, height_px, device)) {
  LearnedTensors tensors(state_->graph.tensors);
  tensors.longest_gradient = kLongestGradient;
  set_tensors(std::move(tensors));
}
PeopleLearner::~PeopleLearner() = default;
PeopleLearner::PeopleLearner(PeopleLearner&&) noexcept = default;
PeopleLearner& PeopleLearner::operator=(PeopleLearner&&) noexcept = default;

std::vector<float> PeopleLearner::maps(const TrainingBatch& batch) {
  const at::NoGradGuard no_gradients;
  return numbers_of<float>(state_->forward(batch, GraphMode::evaluation));
}

std::vector<double> PeopleLearner::errors(const TrainingBatch& batch) {
  const std::vector<float> found = maps(batch);
  const std::size_t picture = found.size() / static_cast<std::size_t>(batch.clips);
  const std::vector<float>& truths = batch.inputs.at(std::string(kTruthInput));
  std::vector<double> errors;
  for (std::size_t i = 0; i < static_cast<std::size_t>(batch.clips); ++i) {
    const std::vector<DetectedPerson> people =
        decode_people(std::span(found).subspan(i * picture, picture),
                      static_cast<int>(state_->rows()), static_cast<int>(state_->columns()));
    const DetectionCount count = count_detections(
        people, true_people(std::span(truths).subspan(5 * kMostTruths * i, 5 * kMostTruths)));
    const int all = 2 * count.found + count.missed + count.wrong;
    errors.push_back(all == 0 ? 0.0 : static_cast<double>(count.missed + count.wrong) / all);
  }
  return errors;
}

double PeopleLearner::compute_gradients(const TrainingBatch& batch) {
  State& state = *state_;
  forget_gradients();
  const at::Tensor loss =
      people_loss(state.forward(batch, GraphMode::training), state.targets(batch));
  loss.backward();
  return loss.item<double>();
}

PeopleLearner PeopleLearner::from_checkpoint(const SafetensorsFile& file, std::string_view where,
                                             int width_px, int height_px,
                                             const std::string& device) {
  PeopleLearner learner(people_weights(file, where), width_px, height_px, device);
  learner.resume_optimizer(file, where);
  return learner;
}

}  // namespace earpoint
