#include "adam.h"
#include "graph_tensors.h"
#include "gtf_graph.h"
#include "gtf_loss.h"
#include "stft_loss.h"
#include "torch_tensor.h"

#include <optional>
#include <utility>

#include <ATen/core/grad_mode.h>
#include <ATen/ops/zeros_like.h>

#include <earpoint/core/error.h>
#include <earpoint/train/gtf_learner.h>

namespace earpoint {

struct GtfLearner::State {
  State(const GtfWeights& weights, const GtfLearnerOptions& learner_options)
      : options(learner_options),
        estimator(frozen(learner_options)),
        graph(weights, at::kCPU),
        adam(graph.parameters(), {.second = learner_options.second_decay}),
        magnitude(GtfDescription::kHop, at::kCPU) {}

  /// The estimator of the options, which does not learn.
  [[nodiscard]] static std::optional<Rt60Graph> frozen(const GtfLearnerOptions& options) {
    if (options.loss.reverberation <= 0) return std::nullopt;
    EARPOINT_CHECK(options.estimator.has_value());
    Rt60Graph graph(*options.estimator, at::kCPU);
    for (auto& [name, parameter] : graph.tensors.parameters) parameter.requires_grad_(false);
    return graph;
  }

  [[nodiscard]] static at::Tensor sounds(const TrainingBatch& batch,
                                         const std::vector<float>& values) {
    return sounds_to_torch(values, batch.clips, 2, at::kCPU);
  }

  [[nodiscard]] static at::Tensor values(const TrainingBatch& batch, const std::string& name,
                                         std::int64_t width) {
    const auto found = batch.inputs.find(name);
    EARPOINT_CHECK(found != batch.inputs.end());
    return to_torch(found->second, {batch.clips, width}, at::kCPU);
  }

  [[nodiscard]] GtfOutput forward(const TrainingBatch& batch) {
    GtfInputs inputs;
    inputs.source = sounds(batch, batch.source);
    if (const std::int64_t size = graph.description().picture_px; size > 0) {
      inputs.picture = to_torch(batch.pictures, {batch.clips, 3, size, size}, at::kCPU);
    }
    inputs.box = values(batch, "speaker_box", 5);
    inputs.target_m = values(batch, "target_m", 3);
    inputs.target_yaw_rad = values(batch, "target_yaw_rad", 1);
    return graph.forward(inputs);
  }

  GtfLearnerOptions options;
  std::optional<Rt60Graph> estimator;
  GtfGraph graph;
  Adam adam;
  ShortTimeMagnitude magnitude;
};

GtfLearner::GtfLearner(const GtfWeights& weights, GtfLearnerOptions options)
    : state_(std::make_unique<State>(weights, options)) {}
GtfLearner::~GtfLearner() = default;
GtfLearner::GtfLearner(GtfLearner&&) noexcept = default;
GtfLearner& GtfLearner::operator=(GtfLearner&&) noexcept = default;

const GtfDescription& GtfLearner::description() const { return state_->graph.description(); }

GtfWeights GtfLearner::weights() const {
  GtfWeights weights{description(), {}, {}};
  for (const auto& [name, tensor] : state_->graph.parameters()) {
    weights.tensors[name] = from_torch(tensor);
  }
  for (const auto& [name, tensor] : state_->graph.buffers()) {
    weights.tensors[name] = from_torch(tensor);
  }
  return weights;
}

std::vector<float> GtfLearner::predict(const TrainingBatch& batch) {
  const at::NoGradGuard no_gradients;
  return numbers_of<float>(state_->forward(batch).sound);
}

std::vector<float> GtfLearner::locate(const TrainingBatch& batch) {
  const at::NoGradGuard no_gradients;
  const GtfOutput output = state_->forward(batch);
  if (!output.speaker) return {};
  return numbers_of<float>(output.speaker->position_m);
}

std::vector<double> GtfLearner::errors(const TrainingBatch& batch) {
  const at::NoGradGuard no_gradients;
  return numbers_of<double>(magnitude_distance(state_->magnitude, state_->forward(batch).sound,
                                               State::sounds(batch, batch.target)));
}

double GtfLearner::compute_gradients(const TrainingBatch& batch) {
  State& state = *state_;
  forget_gradients(state.graph.parameters());
  GtfTruth truth{State::sounds(batch, batch.target),
                 {},
                 State::values(batch, "speaker_m", 3),
                 State::values(batch, "speaker_heading", 2)};
  if (state.options.loss.decay > 0) {
    truth.dry = State::values(batch, "dry", truth.target.size(2));
  }
  const at::Tensor loss = gtf_loss(state.options.loss, state.forward(batch), truth,
                                   state.estimator ? &*state.estimator : nullptr);
  loss.backward();
  return loss.item<double>();
}

std::map<std::string, Tensor> GtfLearner::gradients() const {
  std::map<std::string, Tensor> gradients;
  for (const auto& [name, parameter] : state_->graph.parameters()) {
    const at::Tensor gradient = parameter.grad();
    gradients[name] = from_torch(gradient.defined() ? gradient : at::zeros_like(parameter));
  }
  return gradients;
}

void GtfLearner::visit_gradients(const Visitor& visitor) {
  earpoint::visit_gradients(state_->graph.parameters(), visitor);
}

void GtfLearner::visit_statistics(const Visitor& /*visitor*/) {}

void GtfLearner::apply_gradients(double learning_rate) {
  clip_gradients(state_->graph.parameters(), state_->options.longest_gradient);
  state_->adam.step(learning_rate);
}

std::int64_t GtfLearner::steps() const { return state_->adam.steps(); }

SafetensorsFile GtfLearner::weight_file() const { return gtf_weight_file(weights()); }

SafetensorsFile GtfLearner::checkpoint() const {
  SafetensorsFile file = weight_file();
  state_->adam.save(file);
  return file;
}

GtfLearner GtfLearner::from_checkpoint(const SafetensorsFile& file, std::string_view where,
                                       GtfLearnerOptions options) {
  GtfLearner learner(gtf_weights(file, where), options);
  learner.state_->adam.load(file, where);
  return learner;
}

}  // namespace earpoint
