#include <initializer_list>

#include <fmt/format.h>

#include <earpoint/core/quote.h>
#include <earpoint/error.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/vigas/description.h>

namespace earpoint {
namespace {

/// Options of the released code that change what the network computes or is fed, and the value
/// that the supported networks have. Where a checkpoint does not mention one, it had its default.
const std::map<std::string, HyperParameter>& supported_options() {
  static const std::map<std::string, HyperParameter> options{
      {"model", std::string("vigas")},
      {"wavenet_encoder", std::string("hyperconv")},
      {"num_channel", std::int64_t{2}},
      {"base_gain", std::int64_t{1}},
      {"remove_hyperconv", true},
      {"encode_sincos", true},
      {"decode_wav", true},
      {"denoise", false},
      {"dereverb_input", false},
      {"encode_wav", false},
      {"index_binaural", false},
      {"input_mono", false},
      {"mlp_fusion", false},
      {"no_stacking", false},
      {"normalize_input", false},
      {"normalize_src", false},
      {"output_mono", false},
      {"predict_mask", false},
      {"remove_wavenet", false},
      {"single_channel", false},
      {"subtract_mean", false},
      {"use_all_bboxes", false},
      {"use_avg_location", false},
      {"use_cam_index", false},
      {"use_clean_speech", false},
      {"use_depth", false},
      {"use_depth_mini", false},
      {"use_input_phase", false},
      {"use_last_output", false},
      {"use_local_conditioning", false},
      {"use_real_imag", false},
      {"use_speaker_location", false},
      {"use_tgt_bboxes_as_mask", false},
      {"use_tgt_depth", false},
      {"use_tgt_rgb", false},
      {"use_tgt_rgb_pano", false},
      {"use_warper", false},
  };
  return options;
}

std::string text_of(const HyperParameter& value) {
  return std::visit(
      [](const auto& v) {
        if constexpr (std::is_same_v<std::decay_t<decltype(v)>, std::string>) {
          return in_quotes(v);
        } else {
          return fmt::format("{}", v);
        }
      },
      value);
}

/// Equal, where the number 1 equals 1.0.
bool same(const HyperParameter& a, const HyperParameter& b) {
  const auto* whole = std::get_if<std::int64_t>(&b);
  const auto* real = std::get_if<double>(&a);
  return a == b || (whole != nullptr && real != nullptr && *real == static_cast<double>(*whole));
}

/// Hyper-parameters and shapes of one checkpoint, with messages that name what is missing.
class CheckpointView {
 public:
  CheckpointView(const Checkpoint& checkpoint, std::string_view where)
      : checkpoint_(checkpoint), where_(where) {}

  [[noreturn]] void fail(std::string_view name, std::string_view problem) const {
    throw InputError(fmt::format("{}: hparams: {}", where_, in_quotes(name)), problem);
  }

  template <typename T>
  [[nodiscard]] T option(const std::string& name) const {
    const auto found = checkpoint_.hparams.find(name);
    if (found == checkpoint_.hparams.end()) fail(name, "is missing");
    const T* value = std::get_if<T>(&found->second);
    if (value == nullptr) {
      fail(name, fmt::format("is of another type than expected: {}", text_of(found->second)));
    }
    return *value;
  }

  /// A flag that older versions of the code do not know is off.
  [[nodiscard]] bool flag(const std::string& name) const {
    return checkpoint_.hparams.contains(name) && option<bool>(name);
  }

  [[nodiscard]] int integer(const std::string& name) const {
    constexpr std::int64_t kMost = 1 << 30;
    const auto value = option<std::int64_t>(name);
    if (value < 0 || value > kMost) fail(name, fmt::format("is out of range: {}", value));
    return static_cast<int>(value);
  }

  /// Size `axis` of a tensor that must have `rank` axes.
  [[nodiscard]] int size(const std::string& name, std::size_t rank, std::size_t axis) const {
    constexpr std::int64_t kMost = 1 << 30;
    const auto found = checkpoint_.state_dict.find(name);
    if (found == checkpoint_.state_dict.end()) {
      throw InputError(where_, fmt::format("has no tensor '{}'", name),
                       "is it a checkpoint of a ViGAS network?");
    }
    const auto& shape = found->second.shape;
    if (shape.size() != rank || shape[axis] < 1 || shape[axis] > kMost) {
      throw InputError(fmt::format("{}: tensor '{}'", where_, name),
                       fmt::format("expected {} axes, found shape {}", rank, to_string(shape)));
    }
    return static_cast<int>(shape[axis]);
  }

  [[nodiscard]] bool has_tensor(const std::string& name) const {
    return checkpoint_.state_dict.contains(name);
  }

  void check_supported() const {
    for (const auto& [name, supported] : supported_options()) {
      const auto found = checkpoint_.hparams.find(name);
      if (found == checkpoint_.hparams.end() || same(found->second, supported)) continue;
      fail(name, fmt::format("expected {}, found {}", text_of(supported), text_of(found->second)));
    }
  }

 private:
  const Checkpoint& checkpoint_;
  std::string where_;
};

void describe_dataset(const CheckpointView& view, ViGasDescription& d) {
  const auto dataset = view.option<std::string>("dataset");
  const bool replay = dataset == "replay_nvas";
  if (!replay && dataset != "soundspaces_nvas") {
    view.fail("dataset", fmt::format("expected 'soundspaces_nvas' or 'replay_nvas', found {}",
                                     in_quotes(dataset)));
  }
  d.pose_encoding = replay ? PoseEncoding::replay : PoseEncoding::soundspaces;
  d.box_encoding = replay ? BoxEncoding::corners : BoxEncoding::soundspaces;
  if (replay && view.flag("use_tgt_pose") && !view.flag("rotate_rel_pose")) {
    view.fail("rotate_rel_pose", "expected true, as for the released Replay network");
  }
  if (replay && view.flag("use_tgt_rotation") &&
      view.option<std::string>("cam_position_file").find("fixed_rotation") == std::string::npos) {
    view.fail("cam_position_file",
              "expected one with 'fixed_rotation' in its name, as for the "
              "released Replay network");
  }
  d.sample_rate_hz = view.integer("sample_rate");
  d.window_samples = view.integer("audio_len");
  d.hop_samples = view.integer("hop_length");
  if (view.flag("highpass_filter")) d.highpass_cutoff_hz = replay ? 150.0 : 80.0;
}

void describe_inputs(const CheckpointView& view, ViGasDescription& d, std::string_view where) {
  const int rotation = d.pose_encoding == PoseEncoding::soundspaces ? 2 : 6;
  struct Option {
    const char* flag;
    const char* name;
    int width;
  };
  for (const Option& option :
       std::initializer_list<Option>{{"use_tgt_pose", "tgt_pose", 3},
                                     {"use_tgt_rotation", "tgt_rotation", rotation},
                                     {"use_speaker_pose", "speaker_pose", 3},
                                     {"use_speaker_pose_wrt_tgt", "speaker_pose_wrt_tgt", 3},
                                     {"use_speaker_bboxes", "bboxes", 4},
                                     {"use_tgt_bboxes", "tgt_bboxes", 4},
                                     {"use_src_location", "src_location", 2},
                                     {"use_tgt_location", "tgt_location", 2}}) {
    if (view.flag(option.flag)) d.inputs.push_back({option.name, option.width});
  }

  // What the other inputs leave of the fusion layer's width is the visual feature.
  const int columns = view.size("fusion.0.weight", 2, 1);
  const int width = columns - d.input_width();
  const bool sees = view.flag("use_rgb");
  if (sees ? width < 1 : width != 0) {
    throw InputError(fmt::format("{}: tensor 'fusion.0.weight'", where),
                     fmt::format("expected {}{} columns for the inputs that hparams name, found {}",
                                 sees ? "more than " : "", d.input_width(), columns));
  }
  if (!sees) return;
  if (view.has_tensor("conv1x1.0.weight")) {
    const bool replay = d.pose_encoding == PoseEncoding::replay;
    d.image_encoder = ImageEncoderDescription{replay ? 384 : 256, replay ? 216 : 256,
                                              view.size("conv1x1.0.weight", 4, 0)};
  }
  d.inputs.insert(d.inputs.begin(), ConditioningInput{"visual_feat", width});
}

void describe_core(const CheckpointView& view, ViGasDescription& d, std::string_view where) {
  d.fusion_width = view.size("fusion.0.weight", 2, 0);
  d.conditioning_width = view.size("fusion.2.weight", 2, 0);
  d.channels = view.size("input.weight", 3, 0);
  d.audio_channels = view.size("input.weight", 3, 1);
  d.kernel_size = view.size("hyperconv_wavenet.layers.0.conv.w_f.weight", 3, 2);
  d.acausal = view.flag("acausal");
  d.dilation_base = d.acausal ? 3 : 2;
  d.blocks = view.integer("wavenet_blocks");
  d.layers_per_block = view.integer("layers_per_block");

  std::int64_t layers = 0;
  while (view.has_tensor(fmt::format("hyperconv_wavenet.layers.{}.conv.w_f.weight", layers))) {
    ++layers;
  }
  if (std::int64_t{d.blocks} * d.layers_per_block != layers) {
    throw InputError(where, fmt::format("hparams name {} blocks of {} layers, but the tensors are "
                                        "of {} layers",
                                        d.blocks, d.layers_per_block, layers));
  }
}

}  // namespace

ViGasDescription describe_vigas(const Checkpoint& checkpoint, std::string_view where) {
  const CheckpointView view(checkpoint, where);
  view.check_supported();
  ViGasDescription d;
  describe_dataset(view, d);
  describe_inputs(view, d, where);
  describe_core(view, d, where);
  check_description(d, where);
  return d;
}

}  // namespace earpoint
