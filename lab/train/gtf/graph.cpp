#include "graph.h"

#include "phase_pass.h"
#include "torch_tensor.h"
#include "trunk_pass.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/conv2d.h>
#include <ATen/ops/full.h>
#include <ATen/ops/group_norm.h>
#include <ATen/ops/linear.h>
#include <ATen/ops/matmul.h>
#include <ATen/ops/silu.h>
#include <ATen/ops/zeros.h>
#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/gtf/constants.h>
#include <earpoint/gtf/sight.h>
#include <earpoint/kernels/norms.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

using D = GtfDescription;

/// Gives every bin the value of its band of the head tables.
/// @param bands  [clips][2][bands of the head]
/// @return       [clips][2][bins]
at::Tensor spread_over_bins(const at::Tensor& bands) {
  std::vector<at::Tensor> parts;
  for (int band = 0; band < D::kHeadBands; ++band) {
    parts.push_back(
        bands.narrow(2, band, 1)
            .expand({bands.size(0), bands.size(1), kGtfHeadEdges[band + 1] - kGtfHeadEdges[band]}));
  }
  return at::cat(parts, 2);
}

/// What each clip is divided by: [clips][1][1].
at::Tensor level_of(const at::Tensor& source) {
  return source.square().mean(at::IntArrayRef({1, 2}), true).sqrt().clamp_min(gtf::kQuietest) /
         gtf::kHeardLevel;
}

}  // namespace

GtfGraph::GtfGraph(const GtfWeights& weights) : description_(weights.description) {
  for (const auto& [name, tensor] : weights.tensors) {
    at::Tensor values = to_torch(tensor, at::kCPU);
    if (is_gtf_table(name)) {
      buffers_[name] = values;
    } else {
      parameters_[name] = values.set_requires_grad(true);
    }
  }
}

GtfGraph GtfGraph::twin() const {
  GtfGraph twin = *this;
  for (auto& [name, parameter] : twin.parameters_) {
    parameter = parameter.detach().set_requires_grad(true);
  }
  return twin;
}

at::Tensor GtfGraph::linear(const std::string& name, const at::Tensor& x) const {
  return at::linear(x, parameter(name + ".weight"), parameter(name + ".bias"));
}

FrameLayer GtfGraph::modulated(const std::string& name, const at::Tensor& conditions) const {
  return {parameter(name + ".weight"),
          linear(name + ".static", conditions) + parameter(name + ".bias")};
}

GtfGraph::Seen GtfGraph::encode(const at::Tensor& picture, const at::Tensor& box) const {
  // A fourth channel marks the box.
  const std::int64_t size = description_.picture_px;
  const at::Tensor middles =
      (at::arange(size, at::TensorOptions().dtype(at::kFloat)).to(picture.device()) + 0.5) / size;
  const auto side = [&](std::int64_t i) { return box.narrow(1, i, 1); };
  const at::Tensor across = (middles >= side(1)).logical_and(middles <= side(3)).to(at::kFloat);
  const at::Tensor down = (middles >= side(2)).logical_and(middles <= side(4)).to(at::kFloat);
  const at::Tensor mask = down.unsqueeze(2) * across.unsqueeze(1) * side(0).unsqueeze(2);
  at::Tensor x = at::cat({picture - gtf::kMiddleGrey, mask.unsqueeze(1)}, 1);
  Seen seen;
  for (int i = 0; i < D::kPictureLayers; ++i) {
    const std::string name = fmt::format("picture.{}", i);
    x = at::conv2d(x, parameter(name + ".weight"), parameter(name + ".bias"), 2, 1);
    x = at::silu(at::group_norm(x, D::kNormGroups, parameter(name + ".norm.weight"),
                                parameter(name + ".norm.bias"), kernels::kGroupNormEpsilon));
    if (i + 1 == D::kSightLayer) seen.map = x;
  }
  seen.feature = at::silu(linear("picture.output", x.flatten(1)));
  return seen;
}

at::Tensor GtfGraph::encode_towards(const at::Tensor& map, const at::Tensor& target_m) const {
  const std::int64_t clips = map.size(0);
  const int side = static_cast<int>(map.size(3));
  std::vector<GtfSight> places(std::size_t{2} * description_.sight_points);
  const auto count = static_cast<std::int64_t>(places.size());
  // Interpolation of a map between its pixels is a product with the weight of each pixel.
  at::Tensor shares = at::zeros({clips, count, std::int64_t{side} * side});
  at::Tensor is_seen = at::zeros({clips, count, 1});
  auto share = shares.accessor<float, 3>();
  auto seen = is_seen.accessor<float, 3>();
  const at::Tensor targets = target_m.contiguous();
  const auto target = targets.accessor<float, 2>();
  for (std::int64_t clip = 0; clip < clips; ++clip) {
    find_sights({target[clip][0], target[clip][1], target[clip][2]}, side, places);
    for (std::int64_t i = 0; i < count; ++i) {
      const GtfSight& place = places[static_cast<std::size_t>(i)];
      if (!place.is_seen) continue;
      seen[clip][i][0] = 1.0F;
      for (std::size_t k = 0; k < place.pixels.size(); ++k) {
        share[clip][i][place.pixels[k]] += place.weights[k];
      }
    }
  }
  const at::Tensor there = at::matmul(shares, map.flatten(2).transpose(1, 2));
  return at::cat({at::silu(linear("sight", there)) * is_seen, is_seen}, 2).flatten(1);
}

SpeakerPlace GtfGraph::locate(const at::Tensor& picture, const at::Tensor& box,
                              const at::Tensor& summary) const {
  std::vector<at::Tensor> known;
  if (picture.defined()) known.push_back(picture);
  const auto side = [&](std::int64_t i) { return box.narrow(1, i, 1); };
  const at::Tensor seen = side(0);
  // The camera has a horizontal field of view of 90 degrees.
  const at::Tensor azimuth = (1 - (side(1) + side(3))).atan() * seen;
  if (description_.box) {
    const at::Tensor height = (side(4) - side(2)) * seen;
    const at::Tensor width = (side(3) - side(1)) * seen;
    known.push_back(at::cat({seen, azimuth, (1 - 2 * side(2)) * seen, height, width,
                             (side(4) > gtf::kLowestEdge).to(at::kFloat) * seen,
                             (height + gtf::kBoxSizeFloor).log() * seen,
                             (width + gtf::kBoxSizeFloor).log() * seen, (1 - 2 * side(4)) * seen},
                            1));
  }
  known.push_back(summary);
  at::Tensor x = at::silu(linear("locator.0", at::cat(known, 1)));
  x = linear("locator.2", at::silu(linear("locator.1", x)));

  // The direction starts from the box, if there is one.
  const auto output = [&](std::int64_t i) { return x.narrow(1, i, 1); };
  const at::Tensor front = output(0) + gtf::kTrustInBox * seen * azimuth.cos();
  const at::Tensor left = output(1) + gtf::kTrustInBox * seen * azimuth.sin();
  const at::Tensor distance =
      (gtf::kLogDistance + output(2).clamp(gtf::kLeastLogRatio, gtf::kMostLogRatio)).exp();
  const at::Tensor scale =
      distance / (front.square() + left.square() + gtf::kDirectionFloor).sqrt();
  return {
      at::cat({front * scale, left * scale, output(3) * gtf::kHeightScale_m + gtf::kUsualHeight_m},
              1),
      x.narrow(1, 4, 2), x.select(1, 6)};
}

at::Tensor GtfGraph::told_box(const GtfInputs& inputs) const {
  return description_.box ? inputs.box : inputs.box * 0;
}

GtfGraph::Seen GtfGraph::look(const GtfInputs& inputs) const {
  return description_.picture_px > 0 ? encode(inputs.picture, told_box(inputs)) : Seen();
}

GtfGraph::Conditions GtfGraph::condition(const GtfInputs& inputs, const SoundFeatures& heard,
                                         std::optional<SpeakerPlace>& speaker) const {
  Conditions conditions;
  const Seen seen = look(inputs);
  const at::Tensor& picture = seen.feature;
  std::vector<at::Tensor> known;
  if (description_.geometry) {
    speaker = locate(picture, told_box(inputs), heard.summary);
    conditions.move = move_geometry(
        {buffers_.at("head.power"), buffers_.at("head.diffuse_power"), buffers_.at("head.delay_s")},
        *speaker, inputs.target_m, inputs.target_yaw_rad);
    known.push_back(conditions.move.features);
  } else {
    known.push_back(pose_features(inputs.target_m, inputs.target_yaw_rad));
  }
  if (picture.defined()) known.push_back(picture);
  known.push_back(at::silu(linear("summary", heard.summary)));
  if (description_.texture) {
    known.push_back(at::full({heard.summary.size(0), 1}, inputs.texture));
  }
  if (description_.sight_points > 0) known.push_back(encode_towards(seen.map, inputs.target_m));
  const at::Tensor hidden = at::silu(linear("conditioning.0", at::cat(known, 1)));
  conditions.vector = at::silu(linear("conditioning.1", hidden));
  return conditions;
}

at::Tensor GtfGraph::trunk(const SoundFeatures& heard, const at::Tensor& conditions) const {
  TrunkTensors tensors;
  tensors.input_weight = parameter("trunk.input.weight");
  tensors.input_bias = parameter("trunk.input.bias");
  for (int i = 0; i < description_.layers; ++i) {
    const std::string name = fmt::format("trunk.{}", i);
    tensors.weights.push_back(parameter(name + ".weight"));
    tensors.biases.push_back(parameter(name + ".bias"));
    tensors.films.push_back(linear(name + ".film", conditions));
    tensors.dilations.push_back(description_.dilation(i));
  }
  const std::int64_t frames = 1 + heard.samples / D::kHop;
  return trunk_pass(tensors, heard.features, frames, description_.look_ahead_frames);
}

at::Tensor GtfGraph::filter(const SoundFeatures& heard, const at::Tensor& state,
                            const Conditions& conditions) const {
  const std::int64_t clips = state.size(0);
  // Without delays the phase is the source's.
  at::Tensor share = at::zeros({clips, 2, description_.bands});
  at::Tensor source_delay_s = at::zeros({clips, 2});
  at::Tensor target_delay_s = source_delay_s;
  if (description_.delays) {
    share = linear("phase", conditions.vector).sigmoid().unflatten(1, {2, description_.bands});
    source_delay_s = conditions.move.source_delay_s;
    target_delay_s = conditions.move.target_delay_s;
  }
  FrameLayer gain = modulated("gain", conditions.vector);
  if (description_.expected_level) {
    gain.still = gain.still + spread_over_bins(conditions.move.expected_log_gain).flatten(1);
  }
  const at::Tensor spectrum = filter_pass(
      description_, {heard.spectrum, heard.magnitude, heard.samples}, state,
      modulated("kernel", conditions.vector), gain, share, source_delay_s, target_delay_s);
  return phase_pass(spectrum, description_.phase_rounds, heard.samples);
}

at::Tensor GtfGraph::dry_magnitude(const SoundFeatures& heard, const at::Tensor& state,
                                   const at::Tensor& conditions) const {
  const std::int64_t frames = 1 + heard.samples / D::kHop;
  const FrameLayer gain = modulated("dry", conditions);
  const at::Tensor log_gain =
      at::matmul(gain.weight, state.narrow(2, 0, frames)) + gain.still.unsqueeze(2);
  return (heard.magnitude.mean(at::IntArrayRef({1})).narrow(2, 0, frames) + gtf::kMagnitudeFloor) *
         log_gain.clamp(gtf::kLeastDryLogGain, gtf::kMostDryLogGain).exp();
}

SpeakerPlace GtfGraph::locate(const GtfInputs& inputs) {
  EARPOINT_CHECK(description_.geometry);
  const SoundFeatures heard = sound_features(description_, inputs.source / level_of(inputs.source));
  return locate(look(inputs).feature, told_box(inputs), heard.summary);
}

GtfOutput GtfGraph::forward(const GtfInputs& inputs) {
  const at::Tensor level = level_of(inputs.source);
  const SoundFeatures heard = sound_features(description_, inputs.source / level);
  GtfOutput output;
  const Conditions conditions = condition(inputs, heard, output.speaker);
  const at::Tensor state = trunk(heard, conditions.vector);
  output.sound = filter(heard, state, conditions) * level;
  if (description_.dry_voice) {
    output.dry_magnitude = dry_magnitude(heard, state, conditions.vector) * level;
  }
  return output;
}

}  // namespace earpoint
