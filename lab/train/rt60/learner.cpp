#include <earpoint/train/rt60_learner.h>

#include "graph.h"
#include "learned_tensors.h"
#include "torch_tensor.h"

#include <cmath>
#include <utility>

#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>

#include <earpoint/error.h>

namespace earpoint {

struct Rt60Learner::State {
  State(const Rt60EstimatorWeights& weights, const std::string& device_name)
      : device(device_named(device_name)), graph(weights, device) {}

  at::Tensor forward(const TrainingBatch& batch, GraphMode mode) const {
    return graph.estimate_s(
        to_torch(batch.source, {batch.clips, Rt60Description::kWindowSamples}, device), mode);
  }

  at::Tensor wanted(const TrainingBatch& batch) const {
    return to_torch(batch.inputs.at(std::string(kT60Input)), {batch.clips}, device);
  }

  at::Device device;
  Rt60Graph graph;
};

TrainingExample rt60_example(std::vector<float> sound, double t60_s) {
  EARPOINT_CHECK(std::ssize(sound) == Rt60Description::kWindowSamples);
  return {std::move(sound), {}, {}, {{std::string(kT60Input), {static_cast<float>(t60_s)}}}};
}

Rt60Learner::Rt60Learner(const Rt60EstimatorWeights& weights, const std::string& device)
    : NetworkLearner(weights.description), state_(std::make_unique<State>(weights, device)) {
  set_tensors(LearnedTensors(state_->graph.tensors));
}
Rt60Learner::~Rt60Learner() = default;
Rt60Learner::Rt60Learner(Rt60Learner&&) noexcept = default;
Rt60Learner& Rt60Learner::operator=(Rt60Learner&&) noexcept = default;

std::vector<double> Rt60Learner::estimate_s(const TrainingBatch& batch) {
  const at::NoGradGuard no_gradients;
  return numbers_of<double>(state_->forward(batch, GraphMode::evaluation));
}

std::vector<double> Rt60Learner::errors(const TrainingBatch& batch) {
  std::vector<double> errors = estimate_s(batch);
  const std::vector<float>& times = batch.inputs.at(std::string(kT60Input));
  for (std::size_t i = 0; i < errors.size(); ++i) errors[i] = std::abs(errors[i] - times[i]);
  return errors;
}

double Rt60Learner::compute_gradients(const TrainingBatch& batch) {
  State& state = *state_;
  forget_gradients();
  const at::Tensor loss =
      (state.forward(batch, GraphMode::training) - state.wanted(batch)).abs().mean();
  loss.backward();
  return loss.item<double>();
}

Rt60Learner Rt60Learner::from_checkpoint(const SafetensorsFile& file, std::string_view where,
                                         const std::string& device) {
  Rt60Learner learner(rt60_estimator_weights(file, where), device);
  learner.resume_optimizer(file, where);
  return learner;
}

}  // namespace earpoint
