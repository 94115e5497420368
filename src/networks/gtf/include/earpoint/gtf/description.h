#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/gtf/training_range.h>

namespace earpoint {

/// A geometric time-frequency synthesizer: it finds the speaker in space, computes what the move to
/// the target does to direction, distance and delay, and filters short-time magnitudes by kernels
/// over frames and ears. docs/formats.md has the fields of its JSON.
struct GtfDescription {
  static constexpr int kSampleRateHz = 16000;
  // The short-time transform: Stft's default shape.
  static constexpr int kFftSize = 512;
  static constexpr int kFrameSamples = 400;
  static constexpr int kHop = 160;
  static constexpr int kBins = kFftSize / 2 + 1;
  /// Frames to either side that share samples with one.
  static constexpr int kOverlappingFrames = (kFrameSamples - 1) / kHop;
  /// Momentum of the phase rounds; 0.99 as in Perraudin, Balazs and Sondergaard, WASPAA 2013.
  static constexpr float kPhaseMomentum = 0.99F;
  /// Delays between the ears that the summary listens for: -kLags to kLags samples.
  static constexpr int kLags = 16;
  // The tables of the head: its level in bands of the short-time transform, and its delays.
  static constexpr int kHeadAzimuths = 72;
  static constexpr int kHeadBands = 8;
  /// Dilations of the trunk's layers: 1, 2, 4, 8, 16, 1, ...
  static constexpr int kDilations = 5;
  static constexpr int kNormGroups = 8;
  static constexpr int kBoxFeatures = 9;
  /// Channels of the picture encoder's layers, each of which halves width and height.
  static constexpr int kPictureChannels[] = {4, 16, 32, 48, 64, 64};
  static constexpr int kPictureLayers = 5;
  /// After so many of those layers the map is read along the way to the target.
  static constexpr int kSightLayer = 3;
  static constexpr int kSightWidth = 16;             ///< what is kept of each place there
  static constexpr double kNearestSpeaker_m = 0.25;  ///< nearer nothing gets louder

  int window_samples = kSampleRateHz;        ///< length of the clips that it was trained on
  std::optional<double> highpass_cutoff_hz;  ///< its training sounds have nothing below

  int channels = 96;                           ///< of the trunk
  int layers = 6;                              ///< of the trunk
  int bands = 40;                              ///< in which it hears and filters
  int past_frames = 6;                         ///< of the kernels
  int future_frames = 2;                       ///< of the kernels
  int look_ahead_frames = 2;                   ///< of the trunk
  std::vector<double> tails_s = {0.08, 0.25};  ///< time constants of the kernels' decays

  int picture_px = 64;  ///< width and height of what it looks at; 0: it does not look
  bool box = true;      ///< whether it is told where the speaker is seen
  /// Whether it finds the speaker and computes what the move does; else it knows the bare pose.
  bool geometry = true;
  bool delays = true;  ///< whether the ears' delays are moved to the target's; needs geometry
  /// What is mixed with the moved voice: each ear's sound, moved by its own delay, or unmoved;
  /// needs delays.
  bool ear_delays = false;
  /// Whether gains start from the levels that geometry expects at the target's ears over those at
  /// the source's; needs geometry.
  bool expected_level = false;

  /// Rounds of fast Griffin-Lim that make the phases of neighbouring frames agree; each needs two
  /// frames ahead.
  int phase_rounds = 0;
  /// Whether it is told which texture to render: 0 the mean of what is possible, 1 a natural one.
  bool texture = false;
  /// Whether it also tells the magnitudes of the dry voice, as a microphone at the mouth hears it.
  bool dry_voice = false;

  /// Places on the way to the target, and as many on the floor below, where the picture's map is
  /// read, so that walls in between are seen; needs a picture.
  int sight_points = 0;

  int picture_width = 96;   ///< of the picture's feature
  int locator_width = 128;  ///< of the layers that find the speaker
  int summary_width = 32;   ///< of the sound's summary, as conditioning
  int conditioning_width = 128;

  GtfTrainingRange training_range;  ///< stands beside the JSON, in the metadata

  /// Distance between two samples that a layer of the trunk sees, in frames.
  [[nodiscard]] int dilation(int layer) const { return 1 << (layer % kDilations); }
  /// Magnitudes of one ear that a kernel weighs: frames and tails.
  [[nodiscard]] int taps() const {
    return past_frames + future_frames + 1 + static_cast<int>(tails_s.size());
  }
  /// Frames that filtering one needs beyond it.
  [[nodiscard]] int needed_ahead() const {
    return look_ahead_frames > future_frames ? look_ahead_frames : future_frames;
  }
  /// Frames that the rounds need beyond those.
  [[nodiscard]] int phase_ahead() const { return kOverlappingFrames * phase_rounds; }
  /// What the trunk hears in a frame: power of both ears and their cross-spectrum.
  [[nodiscard]] int frame_features() const { return 4 * bands; }
  /// What is known of the whole window: the mean of that, and the correlation over lags.
  [[nodiscard]] int summary_features() const { return 4 * bands + 2 * kLags + 1; }
  [[nodiscard]] int geometry_features() const { return geometry ? 52 : 5; }
  [[nodiscard]] int picture_features() const { return picture_px > 0 ? picture_width : 0; }
  /// Of each place, what is seen there and whether it is in the picture.
  [[nodiscard]] int sight_features() const { return 2 * sight_points * (kSightWidth + 1); }
  [[nodiscard]] int locator_inputs() const {
    return picture_features() + (box ? kBoxFeatures : 0) + summary_features();
  }
  [[nodiscard]] int conditioning_inputs() const {
    return geometry_features() + picture_features() + summary_width + (texture ? 1 : 0) +
           sight_features();
  }

  friend bool operator==(const GtfDescription&, const GtfDescription&) = default;
};

/// First bins of the bands and, last, the number of bins: nearly even on a scale that is linear up
/// to a tenth of the bins and then four times coarser.
/// @return strictly growing, [bands + 1]; nothing if there are too many bands for that
[[nodiscard]] std::optional<std::vector<int>> gtf_band_edges(int bands);

/// First bins of the head tables' bands and, last, the number of bins.
inline constexpr int kGtfHeadEdges[GtfDescription::kHeadBands + 1] = {0,  8,  16,  32, 48,
                                                                      64, 96, 160, 257};

/// Checks that a description is of a network that can exist.
/// @param where  the file, for messages
/// @throws InputError naming the field, what was expected and what was found
void check_description(const GtfDescription& description, std::string_view where);

/// The description as JSON, one line, keys sorted.
[[nodiscard]] std::string to_json(const GtfDescription& description);

/// The inverse of to_json, checked. Unknown, missing and repeated keys are errors.
/// @throws InputError naming the field, what was expected and what was found
[[nodiscard]] GtfDescription gtf_description_from_json(std::string_view json,
                                                       std::string_view where);

/// Name and shape of every tensor of the network; all are float32. Those under "head." are no
/// weights but tables of the head that it was trained with.
[[nodiscard]] std::map<std::string, std::vector<std::int64_t>> required_tensors(
    const GtfDescription& description);

/// Whether a tensor is a table that does not learn.
[[nodiscard]] bool is_gtf_table(std::string_view name);

}  // namespace earpoint
