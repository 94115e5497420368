#include <earpoint/train/vigas_learner.h>

#include "conditioning_probe.h"
#include "graph.h"
#include "learned_tensors.h"
#include "stft_loss.h"
#include "torch_tensor.h"

#include <utility>

#include <ATen/Parallel.h>
#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <dlfcn.h>

#include <earpoint/error.h>

namespace earpoint {

struct ViGasLearner::State {
  State(const ViGasWeights& weights, const LearnerOptions& learner_options)
      : options(learner_options),
        device(device_named(options.device)),
        graph(weights, device),
        probe(graph.description().conditioning_width, graph.description().audio_channels, device),
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

  /// The network's tensors, with those of the probe if it is used.
  [[nodiscard]] LearnedTensors learned() const {
    return options.place > 0 ? LearnedTensors(graph.tensors(), probe.parameters())
                             : LearnedTensors(graph.tensors());
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
  ShortTimeMagnitude magnitude;
};

ViGasLearner::ViGasLearner(const ViGasWeights& weights, LearnerOptions options)
    : NetworkLearner(weights.description), state_(std::make_unique<State>(weights, options)) {
  set_tensors(state_->learned());
}
ViGasLearner::~ViGasLearner() = default;
ViGasLearner::ViGasLearner(ViGasLearner&&) noexcept = default;
ViGasLearner& ViGasLearner::operator=(ViGasLearner&&) noexcept = default;

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
  forget_gradients();
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

SafetensorsFile ViGasLearner::checkpoint() const {
  SafetensorsFile file = NetworkLearner::checkpoint();
  if (state_->options.place > 0) state_->probe.save(file);
  return file;
}

ViGasLearner ViGasLearner::from_checkpoint(const SafetensorsFile& file, std::string_view where,
                                           LearnerOptions options) {
  ViGasLearner learner(vigas_weights(file, where), std::move(options));
  if (learner.state_->options.place > 0) learner.state_->probe.load(file, where);
  learner.resume_optimizer(file, where);
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
