#include <earpoint/vigas/description.h>

#include <limits>
#include <utility>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/network/checked_tensors.h>
#include <earpoint/network/layer_shapes.h>
#include <earpoint/network/pose_encoding.h>

namespace earpoint {
namespace {

constexpr int kLargestWidth = 1 << 16;

/// The inputs that a network may have, in the order of concatenation; width 0 stands for any.
std::vector<ConditioningInput> known_inputs(PoseEncoding pose) {
  const int rotation = pose == PoseEncoding::soundspaces ? 2 : 6;
  return {
      {"visual_feat", 0},          {"tgt_pose", 3}, {"tgt_rotation", rotation}, {"speaker_pose", 3},
      {"speaker_pose_wrt_tgt", 3}, {"bboxes", 4},   {"tgt_bboxes", 4},          {"src_location", 2},
      {"tgt_location", 2}};
}

void check_inputs(const ViGasDescription& d, std::string_view where) {
  const std::vector<ConditioningInput> known = known_inputs(d.pose_encoding);
  std::size_t next = 0;
  for (const ConditioningInput& input : d.inputs) {
    while (next < known.size() && known[next].name != input.name) ++next;
    if (next == known.size()) {
      throw InputError(
          where, fmt::format("inputs: '{:.40}' is unknown, repeated or out of order", input.name));
    }
    check_range(where, fmt::format("inputs: width of '{}'", input.name), input.width,
                known[next].width == 0 ? 1 : known[next].width,
                known[next].width == 0 ? kLargestWidth : known[next].width);
    ++next;
  }
  if (!d.image_encoder) return;
  const int width = d.image_encoder->feature_width();
  if (d.inputs.empty() || d.inputs[0].name != "visual_feat" || d.inputs[0].width != width) {
    throw InputError(where, fmt::format("inputs: expected 'visual_feat' of width {} first, which "
                                        "the image encoder makes",
                                        width));
  }
}

}  // namespace

int ImageEncoderDescription::feature_width() const {
  return channels * ((height_px + 31) / 32) * ((width_px + 31) / 32);
}

int ViGasDescription::layers() const { return blocks * layers_per_block; }

int ViGasDescription::dilation(int layer) const {
  EARPOINT_CHECK(layer >= 0 && layer < layers());
  int dilation = 1;
  for (int i = 0; i < layer % layers_per_block; ++i) dilation *= dilation_base;
  return dilation;
}

int ViGasDescription::input_width() const {
  int width = 0;
  for (const ConditioningInput& input : inputs) width += input.width;
  return width;
}

bool ViGasDescription::has_input(std::string_view name) const {
  for (const ConditioningInput& input : inputs) {
    if (input.name == name) return true;
  }
  return false;
}

void check_description(const ViGasDescription& d, std::string_view where) {
  check_range(where, "sample_rate_hz", d.sample_rate_hz, 1000, 384'000);
  check_range(where, "window_samples", d.window_samples, 1, 1 << 26);
  check_range(where, "hop_samples", d.hop_samples, 1, 1 << 20);
  // Written so that NaN fails.
  if (d.highpass_cutoff_hz &&
      !(*d.highpass_cutoff_hz > 0 && *d.highpass_cutoff_hz < 0.5 * d.sample_rate_hz)) {
    throw InputError(where, fmt::format("highpass_cutoff_hz: expected more than 0 and less than "
                                        "half of the sample rate, found {}",
                                        *d.highpass_cutoff_hz));
  }
  if (d.image_encoder) {
    check_range(where, "image_encoder: width_px", d.image_encoder->width_px, 1, 1 << 13);
    check_range(where, "image_encoder: height_px", d.image_encoder->height_px, 1, 1 << 13);
    check_range(where, "image_encoder: channels", d.image_encoder->channels, 1, 512);
    check_range(where, "image_encoder: trunk_channels", d.image_encoder->trunk_channels, 1, 512);
  }
  check_inputs(d, where);
  check_range(where, "fusion_width", d.fusion_width, 1, kLargestWidth);
  check_range(where, "conditioning_width", d.conditioning_width, 1, kLargestWidth);
  check_range(where, "audio_channels", d.audio_channels, 1, 64);
  check_range(where, "channels", d.channels, 1, 4096);
  check_range(where, "blocks", d.blocks, 1, 1024);
  check_range(where, "layers_per_block", d.layers_per_block, 1, 64);
  check_range(where, "blocks times layers_per_block", d.layers(), 1, 1024);
  check_range(where, "kernel_size", d.kernel_size, 1, 1024);
  check_range(where, "dilation_base", d.dilation_base, 1, 64);
  if (d.acausal && d.kernel_size % 2 == 0) {
    throw InputError(where, fmt::format("kernel_size: expected an odd number, as the network is "
                                        "acausal, found {}",
                                        d.kernel_size));
  }
  std::int64_t reach = d.kernel_size;
  for (int i = 1; i < d.layers_per_block; ++i) {
    reach *= d.dilation_base;
    check_range(where, "dilation_base: reach of the last layer in samples", reach, 1, 1 << 30);
  }
}

TensorShapes required_tensors(const ViGasDescription& d) {
  TensorShapes shapes;
  if (d.image_encoder) {
    add_resnet18(shapes, "visual_encoder", 3, d.image_encoder->trunk_channels);
    add_layer(shapes, "conv1x1.0",
              {d.image_encoder->channels, d.image_encoder->map_channels(), 1, 1});
    add_batch_norm(shapes, "conv1x1.1", d.image_encoder->channels);
  }
  add_layer(shapes, "fusion.0", {d.fusion_width, d.input_width()});
  add_layer(shapes, "fusion.2", {d.conditioning_width, d.fusion_width});
  add_layer(shapes, "input", {d.channels, d.audio_channels, 1});
  for (int i = 0; i < d.layers(); ++i) {
    const std::string layer = fmt::format("hyperconv_wavenet.layers.{}", i);
    for (const char* gate : {"f", "g"}) {
      add_layer(shapes, fmt::format("{}.conv.w_{}", layer, gate),
                {d.channels, d.channels, d.kernel_size});
      add_layer(shapes, fmt::format("{}.conv.v_{}", layer, gate),
                {d.channels, d.conditioning_width, 1});
    }
    if (i + 1 < d.layers()) add_layer(shapes, layer + ".residual", {d.channels, d.channels, 1});
    add_layer(shapes, layer + ".skip", {d.channels, d.channels, 1});
  }
  const std::string head = fmt::format("output_net.{}", d.layers() - 1);
  add_layer(shapes, head + ".first", {d.channels, d.channels, 1});
  add_layer(shapes, head + ".second", {d.audio_channels, d.channels, 1});
  return shapes;
}

}  // namespace earpoint
