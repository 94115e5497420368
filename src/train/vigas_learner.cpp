#include "adam.h"
#include "graph_tensors.h"
#include "stft_loss.h"
#include "torch_tensor.h"
#include "vigas_graph.h"

#include <utility>

#include <ATen/Parallel.h>
#include <ATen/core/grad_mode.h>

#include <earpoint/core/error.h>
#include <earpoint/train/vigas_learner.h>

namespace earpoint {

struct ViGasLearner::State {
  State(const ViGasWeights& weights, const LearnerOptions& options)
      : loss(options.loss),
        device(device_named(options.device)),
        graph(weights, device),
        adam(graph.parameters()),
        magnitude(weights.description.hop_samples, device) {}

  [[nodiscard]] at::Tensor sounds(const TrainingBatch& batch,
                                  const std::vector<float>& values) const {
    return sounds_to_torch(values, batch.clips, graph.description().audio_channels, device);
  }

  [[nodiscard]] GraphInputs inputs(const TrainingBatch& batch) const {
    const ViGasDescription& d = graph.description();
    GraphInputs inputs;
    inputs.source = sounds(batch, batch.source);
    if (d.image_encoder) {
      inputs.picture =
          to_torch(batch.pictures,
                   {batch.clips, 3, d.image_encoder->height_px, d.image_encoder->width_px}, device);
    }
    for (const ConditioningInput& input : d.inputs) {
      if (input.name == "visual_feat" && d.image_encoder) continue;
      const auto found = batch.inputs.find(input.name);
      EARPOINT_CHECK(found != batch.inputs.end());
      inputs.values[input.name] = to_torch(found->second, {batch.clips, input.width}, device);
    }
    return inputs;
  }

  LossKind loss;
  at::Device device;
  ViGasGraph graph;
  Adam adam;
  ShortTimeMagnitude magnitude;
};

ViGasLearner::ViGasLearner(const ViGasWeights& weights, LearnerOptions options)
    : state_(std::make_unique<State>(weights, options)) {}
ViGasLearner::~ViGasLearner() = default;
ViGasLearner::ViGasLearner(ViGasLearner&&) noexcept = default;
ViGasLearner& ViGasLearner::operator=(ViGasLearner&&) noexcept = default;

const ViGasDescription& ViGasLearner::description() const { return state_->graph.description(); }

ViGasWeights ViGasLearner::weights() const {
  return {description(), state_->graph.tensors().weights(), {}};
}

std::vector<float> ViGasLearner::predict(const TrainingBatch& batch) {
  const at::NoGradGuard no_gradients;
  return numbers_of<float>(state_->graph.forward(state_->inputs(batch), GraphMode::evaluation));
}

std::vector<double> ViGasLearner::errors(const TrainingBatch& batch) {
  const at::NoGradGuard no_gradients;
  const at::Tensor prediction = state_->graph.forward(state_->inputs(batch), GraphMode::evaluation);
  return numbers_of<double>(
      magnitude_distance(state_->magnitude, prediction, state_->sounds(batch, batch.target)));
}

double ViGasLearner::compute_gradients(const TrainingBatch& batch) {
  State& state = *state_;
  forget_gradients(state.graph.parameters());
  const at::Tensor prediction = state.graph.forward(state.inputs(batch), GraphMode::training);
  const at::Tensor target = state.sounds(batch, batch.target);
  const at::Tensor loss = state.loss == LossKind::magnitude
                              ? magnitude_loss(state.magnitude, prediction, target)
                              : log_magnitude_loss(state.magnitude, prediction, target);
  loss.backward();
  return loss.item<double>();
}

std::map<std::string, Tensor> ViGasLearner::gradients() const {
  return state_->graph.tensors().gradients();
}

void ViGasLearner::visit_gradients(const Visitor& visitor) {
  earpoint::visit_gradients(state_->graph.tensors().parameters, visitor);
}

void ViGasLearner::visit_statistics(const Visitor& visitor) {
  visit_values(state_->graph.tensors().buffers, visitor);
}

void ViGasLearner::apply_gradients(double learning_rate) { state_->adam.step(learning_rate); }

std::int64_t ViGasLearner::steps() const { return state_->adam.steps(); }

SafetensorsFile ViGasLearner::weight_file() const { return vigas_weight_file(weights()); }

SafetensorsFile ViGasLearner::checkpoint() const {
  SafetensorsFile file = vigas_weight_file(weights());
  state_->adam.save(file);
  return file;
}

ViGasLearner ViGasLearner::from_checkpoint(const SafetensorsFile& file, std::string_view where,
                                           LearnerOptions options) {
  ViGasLearner learner(vigas_weights(file, where), std::move(options));
  learner.state_->adam.load(file, where);
  return learner;
}

void set_learner_threads(int threads) {
  EARPOINT_CHECK(threads > 0);
  at::set_num_threads(threads);
}

}  // namespace earpoint
