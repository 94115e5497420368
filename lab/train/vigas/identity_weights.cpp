#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/train/initial_weights.h>
#include <earpoint/vigas/description.h>
#include <earpoint/vigas/weights.h>

namespace earpoint {
namespace {

/// Gain of the ears' sounds at the input. The distortion of tanh is a third of the squared
/// amplitude; a larger gain reduces the relative size of the optimizer's steps.
constexpr double kScale = 0.3;
/// Leakage of other channels into the ears', relative to a full mixture.
constexpr double kLeak = 0.05;
/// How strongly the conditioning vector moves the ears' gates at first.
constexpr double kConditioningGain = 0.1;
/// The gates halve a small sound: sigmoid(0).
constexpr double kGateGain = 0.5;
/// Standard deviation of the target's coordinates around the source.
constexpr double kPoseSpread_m = 2.0;

/// One layer's weights, filled element by element.
class Layer {
 public:
  Layer(ViGasWeights& weights, const std::string& name, std::uint64_t seed)
      : weight_(weights.tensors.at(name + ".weight")), bias_(weights.tensors.at(name + ".bias")) {
    random_ = RandomStream(seed);
    taps_ = weight_.shape.size() > 2 ? weight_.shape[2] : 1;
  }

  /// @param value  by output, input and tap; layers that fuse the inputs have one tap
  void fill(const std::function<double(std::int64_t, std::int64_t, std::int64_t)>& value) {
    const std::vector<std::int64_t> shape = weight_.shape;
    std::vector<float> values;
    for (std::int64_t out = 0; out < shape[0]; ++out) {
      for (std::int64_t in = 0; in < shape[1]; ++in) {
        for (std::int64_t tap = 0; tap < taps_; ++tap) {
          values.push_back(static_cast<float>(value(out, in, tap)));
        }
      }
    }
    weight_ = make_tensor<float>(values, shape);
    bias_ = make_tensor<float>(std::vector<float>(static_cast<std::size_t>(shape[0])), {shape[0]});
  }

  double normal() { return random_.normal(); }

  /// Normal, so that an output has `gain` times the size of independent inputs.
  double mixture(double gain) {
    return gain / std::sqrt(static_cast<double>(weight_.shape[1] * taps_)) * random_.normal();
  }

 private:
  Tensor& weight_;
  Tensor& bias_;
  std::int64_t taps_ = 1;
  RandomStream random_{0};
};

class IdentityMaker {
 public:
  IdentityMaker(ViGasWeights& weights, std::uint64_t seed)
      : weights_(weights), d_(weights.description), seeds_(seed) {}

  void make() {
    fill("input", [&](Layer& layer, auto out, auto in, auto) {
      return is_ear(out) ? (out == in ? kScale : 0.0) : layer.mixture(kScale);
    });
    make_fusion();
    for (int i = 0; i < d_.layers(); ++i) make_layer(i);
    const std::string head = fmt::format("output_net.{}.", d_.layers() - 1);
    carry(head + "first", 1.0, 1.0);
    fill(head + "second", [&](Layer& layer, auto out, auto in, auto) {
      return is_ear(in) ? (out == in ? 1.0 / kScale : 0.0) : layer.mixture(kLeak / kScale);
    });
  }

 private:
  bool is_ear(std::int64_t channel) const { return channel < d_.audio_channels; }

  template <typename Value>
  void fill(const std::string& name, Value value) {
    Layer layer(weights_, name, seeds_.next());
    layer.fill([&](auto out, auto in, auto tap) { return value(layer, out, in, tap); });
  }

  /// A layer of one tap that passes the ears' channels with `gain` and mixes the others.
  void carry(const std::string& name, double gain, double mixing_gain) {
    fill(name, [&](Layer& layer, auto out, auto in, auto) {
      if (!is_ear(out)) return layer.mixture(mixing_gain);
      if (is_ear(in)) return out == in ? gain : 0.0;
      return layer.mixture(gain * leak());
    });
  }

  /// Leakage per layer, as the layers add up.
  double leak() const { return kLeak / std::sqrt(d_.layers()); }

  /// All kinds of input have equal weight, for any number of values and any spread, and z has the
  /// size of one. Otherwise a box of four numbers would have no effect beside the picture.
  void make_fusion() {
    std::vector<double> gains;
    for (const ConditioningInput& input : d_.inputs) {
      const double spread = input.name == "tgt_pose" ? kPoseSpread_m : 1.0;
      const auto share = static_cast<double>(d_.inputs.size()) * input.width;
      gains.insert(gains.end(), input.width, std::sqrt(2.0 / share) / spread);
    }
    fill("fusion.0", [&](Layer& layer, auto, auto in, auto) {
      return gains.at(static_cast<std::size_t>(in)) * layer.normal();
    });
    fill("fusion.2", [](Layer& layer, auto, auto, auto) { return layer.mixture(std::sqrt(2.0)); });
  }

  void make_layer(int index) {
    const std::string name = fmt::format("hyperconv_wavenet.layers.{}.", index);
    const std::int64_t centre = d_.acausal ? (d_.kernel_size - 1) / 2 : d_.kernel_size - 1;
    fill(name + "conv.w_f", [&](Layer& layer, auto out, auto in, auto tap) {
      if (!is_ear(out)) return layer.mixture(1.0);
      if (is_ear(in)) return out == in && tap == centre ? 1.0 : 0.0;
      return layer.mixture(leak());
    });
    fill(name + "conv.w_g", [&](Layer& layer, auto out, auto, auto) {
      return layer.mixture(is_ear(out) ? leak() : 1.0);
    });
    // A constant would dominate such small sounds.
    fill(name + "conv.v_f", [](Layer&, auto, auto, auto) { return 0.0; });
    fill(name + "conv.v_g",
         [](Layer& layer, auto, auto, auto) { return layer.mixture(kConditioningGain); });
    // The gates halve a layer's output and its input: 3 + 1 parts of energy in 4 keep the level.
    if (index + 1 < d_.layers()) {
      carry(name + "residual", 1.0 / kGateGain, std::sqrt(3.0) / kGateGain);
    }
    carry(name + "skip", 1.0 / kGateGain, 1.0 / kGateGain);
  }

  ViGasWeights& weights_;
  const ViGasDescription& d_;
  RandomStream seeds_;
};

}  // namespace

ViGasWeights identity_vigas_weights(const ViGasDescription& description, std::uint64_t seed) {
  EARPOINT_CHECK(description.channels >= description.audio_channels);
  ViGasWeights weights = initial_vigas_weights(description, seed);
  IdentityMaker(weights, seed).make();
  return weights;
}

}  // namespace earpoint
