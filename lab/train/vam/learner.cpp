#include <earpoint/train/vam_learner.h>

#include "graph.h"
#include "learned_tensors.h"
#include "stft_loss.h"
#include "torch_tensor.h"

#include <utility>

#include <ATen/core/grad_mode.h>

#include <earpoint/error.h>
#include <earpoint/network/picture_planes.h>
#include <earpoint/vam/encoding.h>

namespace earpoint {

struct VamLearner::State {
  State(const VamWeights& weights, const std::string& device_name)
      : device(device_named(device_name)),
        graph(weights, device),
        magnitude(weights.description.hop_samples, device) {}

  [[nodiscard]] at::Tensor sounds(const TrainingBatch& batch,
                                  const std::vector<float>& values) const {
    return sounds_to_torch(values, batch.clips, graph.description().audio_channels, device);
  }

  at::Tensor forward(const TrainingBatch& batch, GraphMode mode) {
    const VamDescription& d = graph.description();
    const auto pose = batch.inputs.find(std::string(kVamPoseInput));
    EARPOINT_CHECK(pose != batch.inputs.end());
    return graph.forward(
        sounds(batch, batch.source),
        to_torch(batch.pictures, {batch.clips, 3, d.image_height_px, d.image_width_px}, device),
        to_torch(pose->second, {batch.clips, VamDescription::kPoseWidth}, device), mode);
  }

  at::Device device;
  VamGraph graph;
  ShortTimeMagnitude magnitude;
};

TrainingExample vam_example(const VamDescription& description, const PairSample& sample) {
  EARPOINT_CHECK(sample.picture != nullptr);
  TrainingExample example;
  example.source.assign(sample.source.planar().begin(), sample.source.planar().end());
  example.target.assign(sample.target.planar().begin(), sample.target.planar().end());
  example.picture =
      picture_planes(*sample.picture, description.image_width_px, description.image_height_px);
  example.inputs[std::string(kVamPoseInput)] = vam_pose(sample.source_from_target);
  return example;
}

VamLearner::VamLearner(const VamWeights& weights, const std::string& device)
    : NetworkLearner(weights.description), state_(std::make_unique<State>(weights, device)) {
  set_tensors(LearnedTensors(state_->graph.tensors()));
}
VamLearner::~VamLearner() = default;
VamLearner::VamLearner(VamLearner&&) noexcept = default;
VamLearner& VamLearner::operator=(VamLearner&&) noexcept = default;

std::vector<float> VamLearner::predict(const TrainingBatch& batch) {
  const at::NoGradGuard no_gradients;
  return numbers_of<float>(state_->forward(batch, GraphMode::evaluation));
}

std::vector<double> VamLearner::errors(const TrainingBatch& batch) {
  const at::NoGradGuard no_gradients;
  const at::Tensor prediction = state_->forward(batch, GraphMode::evaluation);
  return numbers_of<double>(
      magnitude_distance(state_->magnitude, prediction, state_->sounds(batch, batch.target)));
}

double VamLearner::compute_gradients(const TrainingBatch& batch) {
  State& state = *state_;
  forget_gradients();
  const at::Tensor loss = magnitude_loss(state.magnitude, state.forward(batch, GraphMode::training),
                                         state.sounds(batch, batch.target));
  loss.backward();
  return loss.item<double>();
}

VamLearner VamLearner::from_checkpoint(const SafetensorsFile& file, std::string_view where,
                                       const std::string& device) {
  VamLearner learner(vam_weights(file, where), device);
  learner.resume_optimizer(file, where);
  return learner;
}

}  // namespace earpoint
