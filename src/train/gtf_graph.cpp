#include "gtf_graph.h"

#include "band_kernels.h"
#include "short_time.h"
#include "torch_tensor.h"

#include <cmath>
#include <cstdint>

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/baddbmm.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/constant_pad_nd.h>
#include <ATen/ops/conv2d.h>
#include <ATen/ops/group_norm.h>
#include <ATen/ops/linear.h>
#include <ATen/ops/matmul.h>
#include <ATen/ops/ones_like.h>
#include <ATen/ops/polar.h>
#include <ATen/ops/silu.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/view_as_real.h>
#include <ATen/ops/zeros.h>
#include <fmt/format.h>

#include <earpoint/core/error.h>
#include <earpoint/core/pose.h>

namespace earpoint {
namespace {

using D = GtfDescription;

constexpr double kHeardLevel = 0.05;  // the root mean square that every sound is brought to
constexpr double kQuietest = 1e-4;    // below it a sound counts as silence
constexpr double kBandFloor = 1e-3;   // of a band's power, before its logarithm
constexpr double kCrossFloor = 1e-4;  // of the product of the ears' powers
constexpr double kNormEpsilon = 1e-5;

/// What turns every bin by a delay: e^(-i omega delay). @param delay_s  [clips][ears]
at::Tensor delaying(const at::Tensor& delay_s) {
  const at::Tensor omega =
      at::arange(D::kBins, at::TensorOptions().dtype(at::kFloat)).to(delay_s.device()) *
      (2.0 * kPi * D::kSampleRateHz / D::kFftSize);
  const at::Tensor angle = delay_s.unsqueeze(2) * omega * -1.0;
  return at::polar(at::ones_like(angle), angle).unsqueeze(3);
}

/// The frame `offset` earlier, zeros before the first. 0 < offset
at::Tensor delayed(const at::Tensor& x, std::int64_t offset) {
  const std::int64_t frames = x.size(2);
  if (offset >= frames) return x * 0;
  return at::constant_pad_nd(x.narrow(2, 0, frames - offset), {offset, 0});
}

at::Tensor per_clip(const at::Tensor& weight, std::int64_t clips) {
  return weight.unsqueeze(0).expand({clips, weight.size(0), weight.size(1)});
}

}  // namespace

GtfGraph::GtfGraph(const GtfWeights& weights, const at::Device& device)
    : description_(weights.description) {
  for (const auto& [name, tensor] : weights.tensors) {
    at::Tensor values = to_torch(tensor, device);
    if (is_gtf_table(name)) {
      buffers_[name] = values;
    } else {
      parameters_[name] = values.set_requires_grad(true);
    }
  }
  in_band_ = at::zeros({D::kBins, description_.bands});
  band_of_bin_ = at::zeros({D::kBins}, at::TensorOptions().dtype(at::kLong));
  const std::vector<int> edges = gtf_band_edges(description_.bands).value();
  for (int band = 0; band < description_.bands; ++band) {
    in_band_.narrow(0, edges[band], edges[band + 1] - edges[band]).select(1, band).fill_(1);
    band_of_bin_.narrow(0, edges[band], edges[band + 1] - edges[band]).fill_(band);
  }
  const at::TensorOptions real = at::TensorOptions().dtype(at::kDouble);
  const at::Tensor angle = at::arange(D::kBins, real).unsqueeze(1) *
                           at::arange(-D::kLags, D::kLags + 1, real).unsqueeze(0) *
                           (2.0 * kPi / D::kFftSize);
  lag_cosine_ = angle.cos().to(at::kFloat).to(device);
  lag_sine_ = angle.sin().to(at::kFloat).to(device);
  in_band_ = in_band_.to(device);
  band_of_bin_ = band_of_bin_.to(device);
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

at::Tensor GtfGraph::per_frame(const std::string& name, const at::Tensor& x) const {
  return at::baddbmm(parameter(name + ".bias").unsqueeze(1),
                     per_clip(parameter(name + ".weight"), x.size(0)), x);
}

at::Tensor GtfGraph::modulated(const std::string& name, const at::Tensor& state,
                               const at::Tensor& conditions) const {
  return per_frame(name, state) + linear(name + ".static", conditions).unsqueeze(2);
}

at::Tensor GtfGraph::correlation_over_lags(const at::Tensor& cross) const {
  // The phase transform of the window's mean cross-spectrum.
  constexpr double kScale = 40.0;
  const at::Tensor strength =
      at::view_as_real(cross).square().sum(at::IntArrayRef({-1})).sqrt().sum(at::IntArrayRef({2}));
  const at::Tensor mean =
      at::view_as_real(cross.sum(at::IntArrayRef({2}))) / (strength.unsqueeze(2) + 1e-6);
  return (at::matmul(mean.select(2, 0), lag_cosine_) - at::matmul(mean.select(2, 1), lag_sine_)) /
         kScale;
}

GtfGraph::Heard GtfGraph::hear(const at::Tensor& sound) const {
  Heard heard;
  heard.spectrum = short_time_spectrum(sound);
  heard.magnitude = magnitude_of(heard.spectrum);

  // Band by band: power of each ear, and what the ears have in common.
  const at::Tensor cross = heard.spectrum.select(1, 0) * heard.spectrum.select(1, 1).conj();
  const at::Tensor common =
      at::matmul(at::view_as_real(cross).permute({0, 3, 2, 1}), in_band_);  // [clips][2][t][bands]
  const at::Tensor power = at::matmul(heard.magnitude.square().transpose(2, 3), in_band_);
  const at::Tensor scale = (power.select(1, 0) * power.select(1, 1) + kCrossFloor).sqrt();
  const at::Tensor likeness = common / scale.unsqueeze(1);
  heard.features = at::cat({(power + kBandFloor).log().div(4).transpose(2, 3).flatten(1, 2),
                            likeness.transpose(2, 3).flatten(1, 2)},
                           1);

  // The window as a whole: loud frames count more.
  at::Tensor loudness = power.sum(at::IntArrayRef({1}));
  loudness = loudness / (loudness.sum(at::IntArrayRef({1}), true) + 1e-6);
  const at::Tensor mean = power.mean(at::IntArrayRef({2}));
  const at::Tensor between = ((mean.select(1, 0) + 1e-4) / (mean.select(1, 1) + 1e-4)).log().div(2);
  const at::Tensor together = (mean.sum(at::IntArrayRef({1})) + kBandFloor).log().div(4);
  heard.summary = at::cat({(likeness * loudness.unsqueeze(1)).sum(at::IntArrayRef({2})).flatten(1),
                           between, together, correlation_over_lags(cross)},
                          1);
  return heard;
}

at::Tensor GtfGraph::look(const at::Tensor& picture, const at::Tensor& box) const {
  // A fourth channel marks the box.
  const std::int64_t size = description_.picture_px;
  const at::Tensor middles =
      (at::arange(size, at::TensorOptions().dtype(at::kFloat)).to(picture.device()) + 0.5) / size;
  const auto side = [&](std::int64_t i) { return box.narrow(1, i, 1); };
  const at::Tensor across = (middles >= side(1)).logical_and(middles <= side(3)).to(at::kFloat);
  const at::Tensor down = (middles >= side(2)).logical_and(middles <= side(4)).to(at::kFloat);
  const at::Tensor mask = down.unsqueeze(2) * across.unsqueeze(1) * side(0).unsqueeze(2);
  at::Tensor x = at::cat({picture - 0.5, mask.unsqueeze(1)}, 1);
  for (int i = 0; i < D::kPictureLayers; ++i) {
    const std::string name = fmt::format("picture.{}", i);
    x = at::conv2d(x, parameter(name + ".weight"), parameter(name + ".bias"), 2, 1);
    x = at::silu(at::group_norm(x, D::kNormGroups, parameter(name + ".norm.weight"),
                                parameter(name + ".norm.bias"), kNormEpsilon));
  }
  return at::silu(linear("picture.output", x.flatten(1)));
}

SpeakerPlace GtfGraph::locate(const at::Tensor& picture, const at::Tensor& box,
                              const at::Tensor& summary) const {
  std::vector<at::Tensor> known;
  if (picture.defined()) known.push_back(picture);
  const auto side = [&](std::int64_t i) { return box.narrow(1, i, 1); };
  const at::Tensor seen = side(0);
  // The camera sees 90 degrees across.
  const at::Tensor azimuth = (1 - (side(1) + side(3))).atan() * seen;
  if (description_.box) {
    const at::Tensor height = (side(4) - side(2)) * seen;
    const at::Tensor width = (side(3) - side(1)) * seen;
    known.push_back(at::cat({seen, azimuth, (1 - 2 * side(2)) * seen, height, width,
                             (side(4) > 0.99).to(at::kFloat) * seen, (height + 0.02).log() * seen,
                             (width + 0.02).log() * seen, (1 - 2 * side(4)) * seen},
                            1));
  }
  known.push_back(summary);
  at::Tensor x = at::silu(linear("locator.0", at::cat(known, 1)));
  x = linear("locator.2", at::silu(linear("locator.1", x)));

  // The direction starts from the box where there is one.
  constexpr double kTrustInBox = 3.0;
  const auto output = [&](std::int64_t i) { return x.narrow(1, i, 1); };
  const at::Tensor front = output(0) + kTrustInBox * seen * azimuth.cos();
  const at::Tensor left = output(1) + kTrustInBox * seen * azimuth.sin();
  const at::Tensor distance = (0.6 + output(2).clamp(-2, 1.5)).exp();
  const at::Tensor scale = distance / (front.square() + left.square() + 1e-4).sqrt();
  return {at::cat({front * scale, left * scale, output(3) * 0.3 - 0.1}, 1), x.narrow(1, 4, 2),
          x.select(1, 6)};
}

GtfGraph::Conditions GtfGraph::condition(const GtfInputs& inputs, const Heard& heard,
                                         std::optional<SpeakerPlace>& speaker) const {
  Conditions conditions;
  const at::Tensor box = description_.box ? inputs.box : inputs.box * 0;
  const at::Tensor picture = description_.picture_px > 0 ? look(inputs.picture, box) : at::Tensor();
  std::vector<at::Tensor> known;
  if (description_.geometry) {
    speaker = locate(picture, box, heard.summary);
    conditions.move = move_geometry(
        {buffers_.at("head.power"), buffers_.at("head.diffuse_power"), buffers_.at("head.delay_s")},
        *speaker, inputs.target_m, inputs.target_yaw_rad);
    known.push_back(conditions.move.features);
  } else {
    known.push_back(pose_features(inputs.target_m, inputs.target_yaw_rad));
  }
  if (picture.defined()) known.push_back(picture);
  known.push_back(at::silu(linear("summary", heard.summary)));
  const at::Tensor hidden = at::silu(linear("conditioning.0", at::cat(known, 1)));
  conditions.vector = at::silu(linear("conditioning.1", hidden));
  return conditions;
}

at::Tensor GtfGraph::trunk(const at::Tensor& features, const at::Tensor& conditions) const {
  const std::int64_t ahead = description_.look_ahead_frames;
  EARPOINT_CHECK(features.size(2) > ahead);
  at::Tensor x =
      at::constant_pad_nd(features.narrow(2, ahead, features.size(2) - ahead), {0, ahead});
  x = at::silu(per_frame("trunk.input", x));
  for (int i = 0; i < description_.layers; ++i) {
    const std::string name = fmt::format("trunk.{}", i);
    const std::int64_t step = description_.dilation(i);
    const at::Tensor weight = parameter(name + ".weight");  // [out][in][3], the last tap is now
    const at::Tensor flat =
        at::cat({weight.select(2, 0), weight.select(2, 1), weight.select(2, 2)}, 1);
    const at::Tensor seen = at::cat({delayed(x, 2 * step), delayed(x, step), x}, 1);
    const at::Tensor y =
        at::baddbmm(parameter(name + ".bias").unsqueeze(1), per_clip(flat, x.size(0)), seen);
    const std::vector<at::Tensor> film = linear(name + ".film", conditions).chunk(2, 1);
    x = x + at::silu(y * (1 + film[0].unsqueeze(2)) + film[1].unsqueeze(2));
  }
  return x;
}

at::Tensor GtfGraph::magnitudes(const Heard& heard, const at::Tensor& state,
                                const at::Tensor& conditions) const {
  const at::Tensor filtered =
      apply_band_kernels(description_, heard.magnitude, modulated("kernel", state, conditions));
  const at::Tensor gains =
      modulated("gain", state, conditions).unflatten(1, {2, D::kBins}).clamp(-3, 2);
  return (filtered.relu() + 1e-3) * gains.exp();
}

at::Tensor GtfGraph::phases(const Heard& heard, const Conditions& conditions) const {
  if (!description_.delays) return heard.spectrum / heard.magnitude;
  // The ears aligned on the speaker and summed are the voice; the target's ears hear it delayed.
  const at::Tensor voice =
      (heard.spectrum * delaying(-conditions.move.source_delay_s)).sum(at::IntArrayRef({1}), true);
  const at::Tensor moved = voice * delaying(conditions.move.target_delay_s);
  const at::Tensor share = linear("phase", conditions.vector)
                               .sigmoid()
                               .unflatten(1, {2, description_.bands})
                               .index_select(2, band_of_bin_)
                               .unsqueeze(3);
  const at::Tensor mixed = moved * share * 0.5 + heard.spectrum * (1 - share);
  return mixed / magnitude_of(mixed);
}

GtfOutput GtfGraph::forward(const GtfInputs& inputs) {
  const at::Tensor level =
      inputs.source.square().mean(at::IntArrayRef({1, 2}), true).sqrt().clamp_min(kQuietest) /
      kHeardLevel;
  const Heard heard = hear(inputs.source / level);
  GtfOutput output;
  const Conditions conditions = condition(inputs, heard, output.speaker);
  const at::Tensor state = trunk(heard.features, conditions.vector);
  const at::Tensor spectrum =
      magnitudes(heard, state, conditions.vector) * phases(heard, conditions);
  output.sound = sound_of_spectrum(spectrum, inputs.source.size(2)) * level;
  return output;
}

}  // namespace earpoint
