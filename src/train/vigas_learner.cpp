#include "adam.h"
#include "stft_loss.h"
#include "torch_tensor.h"
#include "vigas_graph.h"

#include <charconv>
#include <utility>

#include <ATen/Parallel.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/zeros.h>
#include <fmt/format.h>

#include <earpoint/core/error.h>
#include <earpoint/train/vigas_learner.h>

namespace earpoint {
namespace {

constexpr std::string_view kStepsKey = "earpoint.adam_steps";
constexpr std::string_view kFirst = "adam.first/";
constexpr std::string_view kSecond = "adam.second/";

at::Device device_named(const std::string& name) {
  try {
    const at::Device device(name);
    // Fails where LibTorch was built without it or no such card is there.
    static_cast<void>(at::zeros({1}, at::TensorOptions().device(device)));
    return device;
  } catch (const c10::Error&) {
    throw InputError("--device " + name, "LibTorch has no such device here", "use --device cpu");
  }
}

std::map<std::string, at::Tensor> moments(const SafetensorsFile& file, std::string_view where,
                                          std::string_view prefix,
                                          const std::map<std::string, at::Tensor>& parameters,
                                          const at::Device& device) {
  std::map<std::string, at::Tensor> found;
  for (const auto& [name, parameter] : parameters) {
    const std::string key = std::string(prefix) + name;
    const auto entry = file.tensors.find(key);
    if (entry == file.tensors.end() || entry->second.dtype != DType::f32 ||
        at::IntArrayRef(entry->second.shape) != parameter.sizes()) {
      throw InputError(
          where, fmt::format("has no tensor '{}' of type F32 and the shape of '{}'", key, name),
          "was it written by training?");
    }
    found[name] = to_torch(entry->second, device);
  }
  return found;
}

std::int64_t steps_in(const SafetensorsFile& file, std::string_view where) {
  const auto found = file.metadata.find(std::string(kStepsKey));
  std::int64_t steps = -1;
  if (found != file.metadata.end()) {
    const std::string& text = found->second;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), steps);
    if (error != std::errc() || end != text.data() + text.size()) steps = -1;
  }
  if (steps < 0) {
    throw InputError(where, fmt::format("has no '{}' that counts steps", kStepsKey),
                     "was it written by training?");
  }
  return steps;
}

}  // namespace

struct ViGasLearner::State {
  State(const ViGasWeights& weights, const LearnerOptions& options)
      : loss(options.loss),
        device(device_named(options.device)),
        graph(weights, device),
        adam(graph.parameters()),
        magnitude(weights.description.hop_samples, device) {}

  [[nodiscard]] at::Tensor sounds(const TrainingBatch& batch,
                                  const std::vector<float>& values) const {
    const std::int64_t channels = graph.description().audio_channels;
    EARPOINT_CHECK(batch.clips > 0 && !values.empty());
    const auto samples = static_cast<std::int64_t>(values.size()) / (batch.clips * channels);
    return to_torch(values, {batch.clips, channels, samples}, device);
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
  ViGasWeights weights{description(), {}, {}};
  for (const auto& [name, tensor] : state_->graph.parameters()) {
    weights.tensors[name] = from_torch(tensor);
  }
  for (const auto& [name, tensor] : state_->graph.buffers()) {
    weights.tensors[name] = from_torch(tensor);
  }
  return weights;
}

std::vector<float> ViGasLearner::predict(const TrainingBatch& batch) {
  const at::NoGradGuard no_gradients;
  const Tensor prediction =
      from_torch(state_->graph.forward(state_->inputs(batch), GraphMode::evaluation));
  const auto values = prediction.as<float>();
  return {values.begin(), values.end()};
}

std::vector<double> ViGasLearner::magnitude_distances(const TrainingBatch& batch) {
  const at::NoGradGuard no_gradients;
  const at::Tensor prediction = state_->graph.forward(state_->inputs(batch), GraphMode::evaluation);
  const Tensor distances = from_torch(
      magnitude_distance(state_->magnitude, prediction, state_->sounds(batch, batch.target)));
  const auto values = distances.as<float>();
  return {values.begin(), values.end()};
}

double ViGasLearner::compute_gradients(const TrainingBatch& batch) {
  State& state = *state_;
  for (auto& [name, parameter] : state.graph.parameters()) parameter.mutable_grad().reset();
  const at::Tensor prediction = state.graph.forward(state.inputs(batch), GraphMode::training);
  const at::Tensor target = state.sounds(batch, batch.target);
  const at::Tensor loss = state.loss == LossKind::magnitude
                              ? magnitude_loss(state.magnitude, prediction, target)
                              : log_magnitude_loss(state.magnitude, prediction, target);
  loss.backward();
  return loss.item<double>();
}

std::map<std::string, Tensor> ViGasLearner::gradients() const {
  std::map<std::string, Tensor> gradients;
  for (const auto& [name, parameter] : state_->graph.parameters()) {
    EARPOINT_CHECK(parameter.grad().defined());
    gradients[name] = from_torch(parameter.grad());
  }
  return gradients;
}

void ViGasLearner::apply_gradients(double learning_rate) { state_->adam.step(learning_rate); }

std::int64_t ViGasLearner::steps() const { return state_->adam.steps(); }

SafetensorsFile ViGasLearner::checkpoint() const {
  SafetensorsFile file =
      vigas_weight_file(weights(), {{std::string(kStepsKey), std::to_string(steps())}});
  for (const auto& [name, moment] : state_->adam.first_moments()) {
    file.tensors[std::string(kFirst) + name] = from_torch(moment);
  }
  for (const auto& [name, moment] : state_->adam.second_moments()) {
    file.tensors[std::string(kSecond) + name] = from_torch(moment);
  }
  return file;
}

ViGasLearner ViGasLearner::from_checkpoint(const SafetensorsFile& file, std::string_view where,
                                           LearnerOptions options) {
  ViGasLearner learner(vigas_weights(file, where), std::move(options));
  State& state = *learner.state_;
  const auto& parameters = state.graph.parameters();
  state.adam.restore(steps_in(file, where), moments(file, where, kFirst, parameters, state.device),
                     moments(file, where, kSecond, parameters, state.device));
  return learner;
}

void set_learner_threads(int threads) {
  EARPOINT_CHECK(threads > 0);
  at::set_num_threads(threads);
}

}  // namespace earpoint
