#include <earpoint/vigas/checkpoint_export.h>

#include "released_options.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <map>
#include <optional>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/network/network_kind.h>
#include <earpoint/vigas/weights.h>
#include <earpoint/weights/pickle_writer.h>
#include <earpoint/weights/zip_writer.h>

namespace earpoint {
namespace {

using Json = nlohmann::ordered_json;
using Shapes = std::map<std::string, std::vector<std::int64_t>>;

constexpr std::string_view kCounter = ".num_batches_tracked";

/// Modules and parameters in the order in which the released class registers them; each name has
/// its rank among those beside it.
constexpr std::array<std::string_view, 26> kOrder{"visual_encoder",
                                                  "conv1x1",
                                                  "fusion",
                                                  "input",
                                                  "hyperconv_wavenet",
                                                  "output_net",
                                                  "layers",
                                                  "conv1",
                                                  "bn1",
                                                  "conv2",
                                                  "bn2",
                                                  "downsample",
                                                  "conv",
                                                  "w_f",
                                                  "w_g",
                                                  "v_f",
                                                  "v_g",
                                                  "residual",
                                                  "skip",
                                                  "first",
                                                  "second",
                                                  "weight",
                                                  "bias",
                                                  "running_mean",
                                                  "running_var",
                                                  "num_batches_tracked"};

/// Sorts as the state dict does: numbers by value, names by kOrder.
std::vector<std::size_t> place_of(std::string_view name) {
  std::vector<std::size_t> place;
  while (!name.empty()) {
    const std::string_view part = name.substr(0, name.find('.'));
    name.remove_prefix(std::min(name.size(), part.size() + 1));
    if (std::isdigit(static_cast<unsigned char>(part[0])) != 0) {
      place.push_back(std::stoul(std::string(part)));
    } else {
      const auto found = std::ranges::find(kOrder, part);
      EARPOINT_CHECK(found != kOrder.end());
      place.push_back(static_cast<std::size_t>(found - kOrder.begin()));
    }
  }
  return place;
}

/// All that the released class registers: what inference reads, and what it does not.
Shapes released_shapes(const ViGasDescription& d) {
  Shapes shapes = required_tensors(d);
  const std::int64_t channels = d.channels;
  const auto add = [&](const std::string& name, std::int64_t out) {
    shapes[name + ".weight"] = {out, channels, 1};
    shapes[name + ".bias"] = {out};
  };
  add(fmt::format("hyperconv_wavenet.layers.{}.residual", d.layers() - 1), channels);
  for (int head = 0; head + 1 < d.layers(); ++head) {
    add(fmt::format("output_net.{}.first", head), channels);
    add(fmt::format("output_net.{}.second", head), d.audio_channels);
  }
  Shapes counters;
  constexpr std::string_view kMean = ".running_mean";
  for (const auto& [name, shape] : shapes) {
    if (!name.ends_with(kMean)) continue;
    counters[name.substr(0, name.size() - kMean.size()) + std::string(kCounter)] = {};
  }
  shapes.merge(counters);
  return shapes;
}

Tensor zeros(const std::string& name, const std::vector<std::int64_t>& shape) {
  Tensor tensor{name.ends_with(kCounter) ? DType::i64 : DType::f32, shape, {}};
  tensor.data.resize(static_cast<std::size_t>(tensor.elements()) * size_of(tensor.dtype));
  return tensor;
}

void check_expressible(const ViGasDescription& d, std::string_view where) {
  const bool soundspaces = d.pose_encoding == PoseEncoding::soundspaces;
  const bool replay = d.pose_encoding == PoseEncoding::replay;
  const BoxEncoding box = soundspaces ? BoxEncoding::soundspaces : BoxEncoding::corners;
  if ((soundspaces || replay) && (!d.has_input("bboxes") || d.box_encoding == box)) return;
  throw InputError(where, "the released code has no such encoding of poses or boxes",
                   "train with \"pose_encoding\" \"soundspaces\" or \"replay\"");
}

/// Where this network differs from what is fixed in the released class.
std::vector<std::string> differences_of(const ViGasDescription& d) {
  ViGasDescription fixed;
  std::vector<std::string> differences;
  const auto compare = [&](const char* name, int there, int here) {
    if (there != here)
      differences.push_back(fmt::format("{}: {} there, {} here", name, there, here));
  };
  compare("channels", fixed.channels, d.channels);
  compare("fusion_width", fixed.fusion_width, d.fusion_width);
  compare("conditioning_width", fixed.conditioning_width, d.conditioning_width);
  compare("kernel_size", fixed.kernel_size, d.kernel_size);
  compare("dilation_base", d.acausal ? 3 : 2, d.dilation_base);
  compare("audio_channels", fixed.audio_channels, d.audio_channels);
  if (d.image_encoder) {
    const bool replay = d.pose_encoding == PoseEncoding::replay;
    compare("picture channels", 8, d.image_encoder->channels);
    compare("trunk_channels", 64, d.image_encoder->trunk_channels);
    compare("picture width", replay ? 384 : 256, d.image_encoder->width_px);
    compare("picture height", replay ? 216 : 256, d.image_encoder->height_px);
  }
  return differences;
}

HyperParameter option_of(const Json& value) {
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_number_integer()) return value.get<std::int64_t>();
  if (value.is_number()) return value.get<double>();
  return value.get<std::string>();
}

/// The published options, overridden by those of the file and then by those of the description.
Json options_of(const ViGasDescription& d, const std::map<std::string, std::string>& metadata,
                std::string_view where) {
  Json options = released_options(d.pose_encoding);
  const auto stored = metadata.find("earpoint.hparams");
  if (stored != metadata.end()) {
    const Json own = Json::parse(stored->second, nullptr, false);
    const bool is_plain = own.is_object() && std::ranges::none_of(own, [](const Json& value) {
                            return value.is_structured() || value.is_null();
                          });
    if (!is_plain) {
      throw InputError(fmt::format("{}: earpoint.hparams", where),
                       "expected an object of flags, numbers and texts");
    }
    options.update(own);
  }
  options["use_rgb"] = d.has_input("visual_feat");
  options["use_tgt_pose"] = d.has_input("tgt_pose");
  options["use_tgt_rotation"] = d.has_input("tgt_rotation");
  options["use_speaker_pose"] = d.has_input("speaker_pose");
  options["use_speaker_pose_wrt_tgt"] = d.has_input("speaker_pose_wrt_tgt");
  options["use_speaker_bboxes"] = d.has_input("bboxes");
  options["use_tgt_bboxes"] = d.has_input("tgt_bboxes");
  options["use_src_location"] = d.has_input("src_location");
  options["use_tgt_location"] = d.has_input("tgt_location");
  options["acausal"] = d.acausal;
  options["wavenet_blocks"] = d.blocks;
  options["layers_per_block"] = d.layers_per_block;
  options["sample_rate"] = d.sample_rate_hz;
  options["audio_len"] = d.window_samples;
  options["hop_length"] = d.hop_samples;
  options["highpass_filter"] = d.highpass_cutoff_hz.has_value();
  return options;
}

const char* storage_of(DType dtype) {
  switch (dtype) {
    case DType::f32:
      return "FloatStorage";
    case DType::i64:
      return "LongStorage";
    default:
      EARPOINT_CHECK(false);
  }
}

void write_shape(PickleWriter& pickle, std::span<const std::int64_t> numbers) {
  pickle.open();
  for (const std::int64_t number : numbers) pickle.integer(number);
  pickle.tuple();
}

/// `_rebuild_tensor_v2` of (storage, offset, size, stride, requires_grad, hooks).
void write_tensor(PickleWriter& pickle, const Tensor& tensor, std::size_t key) {
  pickle.global("torch._utils", "_rebuild_tensor_v2");
  pickle.open();
  pickle.open();
  pickle.text("storage");
  pickle.global("torch", storage_of(tensor.dtype));
  pickle.text(fmt::format("{}", key));
  pickle.text("cpu");
  pickle.integer(tensor.elements());
  pickle.tuple();
  pickle.persistent_id();
  pickle.integer(0);
  write_shape(pickle, tensor.shape);
  std::vector<std::int64_t> strides(tensor.shape.size(), 1);
  for (std::size_t i = strides.size(); i-- > 1;) strides[i - 1] = strides[i] * tensor.shape[i];
  write_shape(pickle, strides);
  pickle.boolean(false);
  pickle.global("collections", "OrderedDict");
  pickle.empty_tuple();
  pickle.call();
  pickle.tuple();
  pickle.call();
}

void write_option(PickleWriter& pickle, const HyperParameter& value) {
  if (const auto* flag = std::get_if<bool>(&value)) {
    pickle.boolean(*flag);
  } else if (const auto* whole = std::get_if<std::int64_t>(&value)) {
    pickle.integer(*whole);
  } else if (const auto* real = std::get_if<double>(&value)) {
    pickle.real(*real);
  } else {
    pickle.text(std::get<std::string>(value));
  }
}

std::vector<std::byte> pickle_of(const ReleasedCheckpoint& checkpoint) {
  PickleWriter pickle;
  pickle.empty_dict();
  pickle.open();
  pickle.text("state_dict");
  pickle.global("collections", "OrderedDict");
  pickle.empty_tuple();
  pickle.call();
  pickle.open();
  for (std::size_t i = 0; i < checkpoint.state_dict.size(); ++i) {
    const auto& [name, tensor] = checkpoint.state_dict[i];
    pickle.text(name);
    write_tensor(pickle, tensor, i);
  }
  pickle.set_items();
  pickle.text("hparams");
  pickle.global("argparse", "Namespace");
  pickle.empty_tuple();
  pickle.new_object();
  pickle.empty_dict();
  pickle.open();
  for (const auto& [name, value] : checkpoint.hparams) {
    pickle.text(name);
    write_option(pickle, value);
  }
  pickle.set_items();
  pickle.build();
  pickle.set_items();
  return pickle.finish();
}

}  // namespace

ReleasedCheckpoint released_checkpoint(SafetensorsFile file, std::string_view where) {
  if (network_kind(file, where) != NetworkKind::vigas) {
    throw InputError(where, "is not a ViGAS network, the only kind in the released code");
  }
  std::map<std::string, Tensor> tensors = file.tensors;
  const std::map<std::string, std::string> metadata = file.metadata;
  ViGasWeights weights = vigas_weights(std::move(file), where);
  const ViGasDescription& d = weights.description;
  check_expressible(d, where);
  // The checked tensors, float32, replace those of the file.
  for (auto& [name, tensor] : weights.tensors) tensors[name] = std::move(tensor);

  ReleasedCheckpoint checkpoint;
  checkpoint.differences = differences_of(d);
  const Json options = options_of(d, metadata, where);
  for (const auto& [name, value] : options.items()) {
    checkpoint.hparams.emplace_back(name, option_of(value));
  }
  for (const auto& [name, shape] : released_shapes(d)) {
    const auto found = tensors.find(name);
    const DType dtype = name.ends_with(kCounter) ? DType::i64 : DType::f32;
    const bool is_there =
        found != tensors.end() && found->second.dtype == dtype && found->second.shape == shape;
    if (!is_there) checkpoint.filled.push_back(name);
    checkpoint.state_dict.emplace_back(name,
                                       is_there ? std::move(found->second) : zeros(name, shape));
  }
  std::ranges::sort(checkpoint.state_dict, {},
                    [](const auto& entry) { return place_of(entry.first); });
  return checkpoint;
}

std::vector<std::byte> serialize_checkpoint(const ReleasedCheckpoint& checkpoint,
                                            std::string_view folder) {
  ZipWriter archive;
  archive.add(fmt::format("{}/data.pkl", folder), pickle_of(checkpoint));
  for (std::size_t i = 0; i < checkpoint.state_dict.size(); ++i) {
    archive.add(fmt::format("{}/data/{}", folder, i), checkpoint.state_dict[i].second.data);
  }
  constexpr std::array kVersion{std::byte{'3'}, std::byte{'\n'}};
  archive.add(fmt::format("{}/version", folder), kVersion);
  return archive.finish();
}

}  // namespace earpoint
