#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/evaluate/method.h>
#include <earpoint/evaluate/view_figure.h>
#include <earpoint/image.h>

namespace earpoint {

/// What a viewpoint sees.
struct SeenView {
  std::shared_ptr<const Image> picture;
  std::vector<FigureBox> people;
};

/// One moment of a clip from one source and several targets.
struct ViewedClip {
  struct Target {
    std::string name;   ///< of the viewpoint
    PairSample sample;  ///< from the source to this target
    SeenView seen;
  };
  std::string name;
  std::string scene;
  SeenView source;
  std::vector<Target> targets;  ///< at least one
  /// What a microphone close before the mouth recorded at the same time, 1 channel, where the data
  /// have that.
  std::optional<Waveform> near_microphone;
  bool knows_speaker = true;  ///< samples tell where the speaker stands
};

/// Which clips of a data set.
struct ViewedClipChoice {
  std::filesystem::path data{};
  DatasetLayout layout = DatasetLayout::soundspaces;
  std::string split = "test";
  /// Each SCENE/CLIP or SCENE/CLIP:SOURCE, e.g. "home-100/3:2"; of Replay-NVAS the source is a
  /// camera. Empty: the first ones whose source sees the speaker.
  std::vector<std::string> names{};
  std::size_t count = 1;  ///< without names, > 0
  std::size_t most_targets = 3;
};

/// Reads clips with everything that a figure shows of them.
/// @throws InputError if a name fits no clip or source, or a file is missing or malformed
[[nodiscard]] std::vector<ViewedClip> read_viewed_clips(const ViewedClipChoice& choice);

/// What methods make of a clip: the source, every target as rendered by each method and as it truly
/// is, and the enhanced speech at the right.
/// @param methods   no oracles
/// @param enhancer  a method that answers speech (SynthesizerOptions::enhances); null: no column
/// @throws InputError if a method lacks what it needs
[[nodiscard]] FigureRow figure_row(const ViewedClip& clip, std::span<const MethodEntry> methods,
                                   const MethodEntry* enhancer);

}  // namespace earpoint
