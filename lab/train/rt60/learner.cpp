#include <earpoint/train/rt60_learner.h>

#include "adam.h"
#include "graph.h"
#include "graph_tensors.h"
#include "torch_tensor.h"

#include <cmath>
#include <utility>

#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>

#include <earpoint/core/error.h>
#include <earpoint/network/weights.h>

namespace earpoint {

struct Rt60Learner::State {
  State(const Rt60EstimatorWeights& weights, const std::string& device_name)
      : device(device_named(device_name)), graph(weights, device), adam(graph.tensors.parameters) {}

  at::Tensor forward(const TrainingBatch& batch, GraphMode mode) const {
    return graph.estimate_s(
        to_torch(batch.source, {batch.clips, Rt60Description::kWindowSamples}, device), mode);
  }

  at::Tensor wanted(const TrainingBatch& batch) const {
    return to_torch(batch.inputs.at(std::string(kT60Input)), {batch.clips}, device);
  }

  at::Device device;
  Rt60Graph graph;
  Adam adam;
};

TrainingExample rt60_example(std::vector<float> sound, double t60_s) {
  EARPOINT_CHECK(std::ssize(sound) == Rt60Description::kWindowSamples);
  return {std::move(sound), {}, {}, {{std::string(kT60Input), {static_cast<float>(t60_s)}}}};
}

Rt60Learner::Rt60Learner(const Rt60EstimatorWeights& weights, const std::string& device)
    : state_(std::make_unique<State>(weights, device)) {}
Rt60Learner::~Rt60Learner() = default;
Rt60Learner::Rt60Learner(Rt60Learner&&) noexcept = default;
Rt60Learner& Rt60Learner::operator=(Rt60Learner&&) noexcept = default;

const Rt60Description& Rt60Learner::description() const { return state_->graph.description; }

Rt60EstimatorWeights Rt60Learner::weights() const {
  return {state_->graph.description, state_->graph.tensors.weights(), {}};
}

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
  forget_gradients(state.graph.tensors.parameters);
  const at::Tensor loss =
      (state.forward(batch, GraphMode::training) - state.wanted(batch)).abs().mean();
  loss.backward();
  return loss.item<double>();
}

std::map<std::string, Tensor> Rt60Learner::gradients() const {
  return state_->graph.tensors.gradients();
}

void Rt60Learner::visit_gradients(const Visitor& visitor) {
  earpoint::visit_gradients(state_->graph.tensors.parameters, visitor);
}

void Rt60Learner::visit_statistics(const Visitor& visitor) {
  visit_values(state_->graph.tensors.buffers, visitor);
}

void Rt60Learner::apply_gradients(double learning_rate) { state_->adam.step(learning_rate); }

std::int64_t Rt60Learner::steps() const { return state_->adam.steps(); }

SafetensorsFile Rt60Learner::weight_file() const { return to_weight_file(weights()); }

SafetensorsFile Rt60Learner::checkpoint() const {
  SafetensorsFile file = weight_file();
  state_->adam.save(file);
  return file;
}

Rt60Learner Rt60Learner::from_checkpoint(const SafetensorsFile& file, std::string_view where,
                                         const std::string& device) {
  Rt60Learner learner(rt60_estimator_weights(file, where), device);
  learner.state_->adam.load(file, where);
  return learner;
}

}  // namespace earpoint
