#include <earpoint/train/vigas_learner.h>

#include "adam.h"
#include "conditioning_probe.h"
#include "graph.h"
#include "graph_tensors.h"
#include "stft_loss.h"
#include "torch_tensor.h"

#include <utility>

#include <ATen/Parallel.h>
#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <dlfcn.h>

#include <earpoint/core/error.h>
#include <earpoint/network/weights.h>

namespace earpoint {

struct ViGasLearner::State {
  State(const ViGasWeights& weights, const LearnerOptions& learner_options)
      : options(learner_options),
        device(device_named(options.device)),
        graph(weights, device),
        probe(graph.description().conditioning_width, graph.description().audio_channels, device),
        learned(parameters()),
        adam(learned),
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

  /// What the network learns, and the probe where it is asked.
  [[nodiscard]] std::map<std::string, at::Tensor> parameters() const {
    std::map<std::string, at::Tensor> all = graph.tensors().parameters;
    if (options.place > 0) all.insert(probe.parameters().begin(), probe.parameters().end());
    return all;
  }

  [[nodiscard]] at::Tensor sound_error(const at::Tensor& source, const at::Tensor& fused,
                                       const at::Tensor& target) {
    const at::Tensor prediction = graph.synthesize(source, fused);
    return options.loss == LossKind::magnitude ? magnitude_loss(magnitude, prediction, target)
                                               : log_magnitude_loss(magnitude, prediction, target);
  }

  [[nodiscard]] at::Tensor probe_error(const TrainingBatch& batch, const at::Tensor& fused,
                                       const at::Tensor& source, const at::Tensor& target) const {
    const auto found = batch.inputs.find(ConditioningProbe::kPlace);
    EARPOINT_CHECK(found != batch.inputs.end());
    const at::Tensor truth =
        to_torch(found->second, {batch.clips, ConditioningProbe::kPlaceWidth}, device);
    return probe.error(fused, truth, source, target);
  }

  LearnerOptions options;
  at::Device device;
  ViGasGraph graph;
  ConditioningProbe probe;
  std::map<std::string, at::Tensor> learned;
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
  forget_gradients(state.learned);
  const GraphInputs inputs = state.inputs(batch);
  const at::Tensor fused = state.graph.fuse(inputs, GraphMode::training);
  const at::Tensor target = state.sounds(batch, batch.target);
  at::Tensor loss;
  if (const double weight = state.options.place; weight > 0) {
    loss = state.probe_error(batch, fused, inputs.source, target) * weight;
  }
  if (steps() >= state.options.place_steps) {
    const at::Tensor error = state.sound_error(inputs.source, fused, target);
    loss = loss.defined() ? loss + error : error;
  }
  loss.backward();
  return loss.item<double>();
}

std::map<std::string, Tensor> ViGasLearner::gradients() const {
  return state_->graph.tensors().gradients();
}

void ViGasLearner::visit_gradients(const Visitor& visitor) {
  earpoint::visit_gradients(state_->learned, visitor);
}

void ViGasLearner::visit_statistics(const Visitor& visitor) {
  visit_values(state_->graph.tensors().buffers, visitor);
}

void ViGasLearner::apply_gradients(double learning_rate) { state_->adam.step(learning_rate); }

std::int64_t ViGasLearner::steps() const { return state_->adam.steps(); }

SafetensorsFile ViGasLearner::weight_file() const { return to_weight_file(weights()); }

SafetensorsFile ViGasLearner::checkpoint() const {
  SafetensorsFile file = to_weight_file(weights());
  if (state_->options.place > 0) state_->probe.save(file);
  state_->adam.save(file);
  return file;
}

ViGasLearner ViGasLearner::from_checkpoint(const SafetensorsFile& file, std::string_view where,
                                           LearnerOptions options) {
  ViGasLearner learner(vigas_weights(file, where), std::move(options));
  if (learner.state_->options.place > 0) learner.state_->probe.load(file, where);
  learner.state_->adam.load(file, where);
  return learner;
}

void set_learner_threads(int threads) {
  EARPOINT_CHECK(threads > 0);
  at::set_num_threads(threads);
  // OpenBLAS has threads of its own, which would compete with these. Whether it is there is known
  // only at run time: LibTorch may use another library.
  using SetThreads = void (*)(int);
  const auto set_blas_threads =
      reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  if (set_blas_threads != nullptr) set_blas_threads(1);
}

}  // namespace earpoint
