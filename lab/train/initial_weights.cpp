#include <earpoint/train/initial_weights.h>

#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/weights/checkpoint.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

using Shapes = std::map<std::string, std::vector<std::int64_t>>;

/// Initial output of an estimator of reverberation time.
constexpr double kUsualT60_s = 0.5;
/// Initial logit of people in a cell: most cells have none.
constexpr float kUnsure = -3.0F;
constexpr double kSmallOutput = 0.01;
/// Size of the position embedding of a picture.
constexpr double kPositionSize = 0.02;

/// How the values of one tensor are drawn.
struct Rule {
  enum class Kind { constant, uniform, normal };
  Kind kind = Kind::constant;
  double size = 0.0;  ///< the constant, the bound, or the standard deviation
};

std::string_view layer_of(std::string_view name) { return name.substr(0, name.rfind('.')); }

bool is_batch_norm(const Shapes& shapes, std::string_view name) {
  return shapes.contains(std::string(layer_of(name)) + ".running_mean");
}

/// Number of inputs of one output of the layer.
double fan_in(const std::vector<std::int64_t>& weight) {
  double product = 1.0;
  for (std::size_t axis = 1; axis < weight.size(); ++axis) {
    product *= static_cast<double>(weight[axis]);
  }
  return product;
}

Rule batch_norm_rule(std::string_view name) {
  const bool is_one = name.ends_with(".weight") || name.ends_with(".running_var");
  return {Rule::Kind::constant, is_one ? 1.0 : 0.0};
}

/// Of a convolution of ResNet-18.
Rule resnet_rule(const std::vector<std::int64_t>& weight) {
  const double outputs =
      fan_in(weight) / static_cast<double>(weight[1]) * static_cast<double>(weight[0]);
  return {Rule::Kind::normal, std::sqrt(2.0 / outputs)};
}

Rule rule_of(const Shapes& shapes, const ViGasDescription& description, const std::string& name) {
  if (is_batch_norm(shapes, name)) return batch_norm_rule(name);
  const std::vector<std::int64_t>& weight = shapes.at(std::string(layer_of(name)) + ".weight");
  const double inputs = fan_in(weight);
  const bool is_bias = name.ends_with(".bias");
  if (name.starts_with("visual_encoder.")) return resnet_rule(weight);
  if (name.find(".conv.") != std::string::npos) {
    if (!is_bias) return {Rule::Kind::constant, 0.0};
    return {Rule::Kind::uniform, std::sqrt(6.0 / (description.channels * description.kernel_size))};
  }
  const std::string_view layer = layer_of(name);
  const bool is_he = layer.ends_with("residual") || layer.ends_with("skip") ||
                     layer.ends_with("first") || layer == "input";
  return {Rule::Kind::uniform,
          is_he && !is_bias ? std::sqrt(6.0 / inputs) : 1.0 / std::sqrt(inputs)};
}

Rule vam_rule(const Shapes& shapes, const std::string& name) {
  if (is_batch_norm(shapes, name)) return batch_norm_rule(name);
  if (name == "image_position") return {Rule::Kind::normal, kPositionSize};
  if (layer_of(name).ends_with("norm")) return batch_norm_rule(name);
  if (name == "output.bias") return {Rule::Kind::constant, 0.0};
  const std::vector<std::int64_t>& weight = shapes.at(std::string(layer_of(name)) + ".weight");
  if (name.starts_with("visual_encoder.")) return resnet_rule(weight);
  // A transposed convolution has its inputs on the first axis; each output gets one or two taps of
  // each input.
  if (name.starts_with("decoder.")) {
    return {Rule::Kind::uniform, 1.0 / std::sqrt(2.0 * static_cast<double>(weight[0]))};
  }
  return {Rule::Kind::uniform, 1.0 / std::sqrt(fan_in(weight))};
}

Tensor draw(const Rule& rule, std::vector<std::int64_t> shape, RandomStream random) {
  std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()));
  for (float& value : values) {
    switch (rule.kind) {
      case Rule::Kind::constant:
        value = static_cast<float>(rule.size);
        break;
      case Rule::Kind::uniform:
        value = static_cast<float>(random.uniform(-rule.size, rule.size));
        break;
      case Rule::Kind::normal:
        value = static_cast<float>(rule.size * random.normal());
        break;
    }
  }
  return make_tensor<float>(values, std::move(shape));
}

/// "visual_encoder.4.0.conv1.weight" -> "layer1.0.conv1.weight".
std::string torchvision_name(std::string_view name) {
  name.remove_prefix(std::string_view("visual_encoder.").size());
  const std::string_view rest = name.substr(1);
  if (name[0] == '0') return fmt::format("conv1{}", rest);
  if (name[0] == '1') return fmt::format("bn1{}", rest);
  return fmt::format("layer{}{}", name[0] - '3', rest);
}

}  // namespace

ViGasWeights initial_vigas_weights(const ViGasDescription& description, std::uint64_t seed) {
  const Shapes shapes = required_tensors(description);
  ViGasWeights weights{description, {}, {}};
  std::uint64_t index = 0;
  for (const auto& [name, shape] : shapes) {
    weights.tensors[name] =
        draw(rule_of(shapes, description, name), shape, RandomStream(seed, {index++}));
  }
  return weights;
}

Rt60EstimatorWeights initial_rt60_weights(const Rt60Description& description, std::uint64_t seed) {
  const Shapes shapes = required_tensors(description);
  Rt60EstimatorWeights weights{description, {}, {}};
  std::uint64_t index = 0;
  for (const auto& [name, shape] : shapes) {
    Rule rule;
    if (is_batch_norm(shapes, name)) {
      rule = batch_norm_rule(name);
    } else if (name.starts_with("feature_extraction.")) {
      rule = resnet_rule(shape);
    } else if (name.ends_with(".weight")) {
      rule = {Rule::Kind::uniform, 1.0 / std::sqrt(fan_in(shape))};
    } else {
      rule = {Rule::Kind::constant, kUsualT60_s};
    }
    weights.tensors[name] = draw(rule, shape, RandomStream(seed, {index++}));
  }
  return weights;
}

PeopleWeights initial_people_weights(const PeopleDescription& description, std::uint64_t seed) {
  const Shapes shapes = required_tensors(description);
  PeopleWeights weights{description, {}, {}};
  std::uint64_t index = 0;
  for (const auto& [name, shape] : shapes) {
    Rule rule{Rule::Kind::constant, 0.0};
    if (is_batch_norm(shapes, name)) {
      rule = batch_norm_rule(name);
    } else if (name == "output.weight") {
      rule = {Rule::Kind::normal, kSmallOutput};
    } else if (name.ends_with(".weight")) {
      rule = {Rule::Kind::normal, std::sqrt(2.0 / fan_in(shape))};
    }
    weights.tensors[name] = draw(rule, shape, RandomStream(seed, {index++}));
  }
  std::vector<float> bias(PeopleDescription::kOutputs, 0.0F);
  bias[0] = kUnsure;
  weights.tensors["output.bias"] = make_tensor<float>(bias, {PeopleDescription::kOutputs});
  return weights;
}

VamWeights initial_vam_weights(const VamDescription& description, std::uint64_t seed) {
  const Shapes shapes = required_tensors(description);
  VamWeights weights{description, {}, {}};
  std::uint64_t index = 0;
  for (const auto& [name, shape] : shapes) {
    weights.tensors[name] = draw(vam_rule(shapes, name), shape, RandomStream(seed, {index++}));
  }
  // Passes the sound itself, past all layers.
  const Tensor& output = weights.at("output.weight");
  std::vector<float> values(static_cast<std::size_t>(output.elements()));
  const std::int64_t inputs = output.shape[1];
  const std::int64_t taps = output.shape[2];
  for (std::int64_t ear = 0; ear < output.shape[0]; ++ear) {
    const std::int64_t sound = inputs - output.shape[0] + ear;
    values[static_cast<std::size_t>((ear * inputs + sound) * taps + taps / 2)] = 1.0F;
  }
  weights.tensors["output.weight"] = make_tensor<float>(values, output.shape);
  return weights;
}

void load_image_trunk(const std::filesystem::path& path, ViGasWeights& weights) {
  EARPOINT_CHECK(weights.description.image_encoder.has_value());
  SafetensorsFile trunk;
  if (path.extension() == ".safetensors") {
    trunk = read_safetensors(path);
  } else {
    trunk.tensors = import_checkpoint(path).state_dict;
  }
  std::map<std::string, Tensor> tensors = weights.tensors;
  for (auto& [name, tensor] : tensors) {
    if (!name.starts_with("visual_encoder.")) continue;
    const std::string theirs = torchvision_name(name);
    const auto found = trunk.tensors.find(theirs);
    if (found == trunk.tensors.end()) {
      throw InputError(path.string(), fmt::format("has no tensor '{}'", theirs),
                       "give a ResNet-18 with torchvision's names");
    }
    if (found->second.shape != tensor.shape || found->second.dtype != DType::f32) {
      throw InputError(
          path.string(),
          fmt::format("tensor '{}': expected F32 {}, found {} {}", theirs, to_string(tensor.shape),
                      name_of(found->second.dtype), to_string(found->second.shape)));
    }
    tensor = found->second;
  }
  weights.tensors = std::move(tensors);
}

}  // namespace earpoint
