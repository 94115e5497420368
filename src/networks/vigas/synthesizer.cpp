#include <earpoint/vigas/synthesizer.h>

#include <algorithm>
#include <array>
#include <string_view>

#include <earpoint/error.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/vigas/description.h>

namespace earpoint {
namespace {

constexpr std::array<std::string_view, 4> kKnownInputs = {"visual_feat", "tgt_pose", "tgt_rotation",
                                                          "bboxes"};

void check_usable(const ViGasDescription& description, const std::string& where) {
  for (const ConditioningInput& input : description.inputs) {
    if (std::find(kKnownInputs.begin(), kKnownInputs.end(), input.name) == kKnownInputs.end()) {
      throw InputError(where, "the network asks for " + input.name + ", which a clip does not have",
                       "use `earpoint model run` with that input");
    }
  }
  if (description.has_input("visual_feat") && !description.image_encoder) {
    throw InputError(where, "the network has no image encoder",
                     "use `earpoint model run` with visual_feat");
  }
  if (description.audio_channels != 2) throw InputError(where, "the network is not binaural");
}

}  // namespace

ViGasSynthesizer::ViGasSynthesizer(const ViGasWeights& weights, const std::string& where,
                                   int threads)
    : network_((check_usable(weights.description, where), weights), threads),
      fused_(static_cast<std::size_t>(weights.description.conditioning_width)) {}

WindowShape ViGasSynthesizer::window_shape(int /*source_rate_hz*/) const {
  const std::ptrdiff_t samples = network_.description().window_samples;
  return {.sample_rate_hz = network_.description().sample_rate_hz,
          .samples = samples,
          .overlap = samples / 4,
          .context = 0};
}

double ViGasSynthesizer::ambient_cutoff_hz() const {
  return network_.description().highpass_cutoff_hz.value_or(0.0);
}

PictureUse ViGasSynthesizer::picture_use() const {
  return network_.description().image_encoder ? PictureUse::always : PictureUse::never;
}

std::vector<std::string> ViGasSynthesizer::warnings(const RenderOutline& /*outline*/) const {
  if (network_.description().pose_encoding != PoseEncoding::replay) return {};
  return {
      "this network was trained with the axes of the recorded room; the camera is assumed to look "
      "along the room's x axis"};
}

bool ViGasSynthesizer::needs_speaker_track() const {
  return network_.description().has_input("bboxes");
}

void ViGasSynthesizer::observe(const Observation& observation) {
  const ViGasDescription& description = network_.description();
  if (description.image_encoder) {
    EARPOINT_CHECK(observation.picture != nullptr);
    if (observation.picture != seen_)
      visual_feature_ = network_.image_feature(*observation.picture);
    seen_ = observation.picture;
  }
  if (description.has_input("bboxes")) {
    box_ = encode_box(description.box_encoding, observation.speaker_box);
  }
  sound_ = observation.sound;
  world_from_source_ = observation.world_from_source.value_or(Pose{});
}

Waveform ViGasSynthesizer::synthesize(const Pose& source_from_target) {
  const ViGasDescription& description = network_.description();
  const EncodedPose pose =
      encode_pose(description.pose_encoding, source_from_target, world_from_source_);
  const std::array<ConditioningValues, 4> known = {{{"visual_feat", visual_feature_},
                                                    {"tgt_pose", pose.tgt_pose},
                                                    {"tgt_rotation", pose.tgt_rotation},
                                                    {"bboxes", box_}}};
  std::vector<ConditioningValues> inputs;
  std::copy_if(known.begin(), known.end(), std::back_inserter(inputs),
               [&](const ConditioningValues& input) { return description.has_input(input.name); });
  network_.fuse(inputs, fused_);

  Waveform result(2, sound_.samples(), sound_.sample_rate_hz());
  network_.synthesize(sound_.planar(), fused_, result.planar());
  return result;
}

}  // namespace earpoint
