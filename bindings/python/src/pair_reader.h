#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/core/resize.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/vigas/description.h>

namespace earpoint::python {

/// One example.
struct PairItem {
  std::string name;  ///< scene, clip and viewpoints
  PairSample sample;
  EncodedPose pose;
  std::vector<float> box;  ///< [4]
  /// The picture as the network is shown it; nothing: as the file has it.
  std::optional<ImagePlanes> view;
};

/// Which pairs, and in what form.
struct PairOptions {
  std::string split = "train";
  /// "soundspaces" or "replay"; nothing: whichever the folder holds.
  std::optional<std::string> layout;
  /// "frozen": frozen_or_drawn_pairs(); "every-target": drawn like such a list, with `seed`;
  /// "released": as the released test draws. Of Replay the first two mean the last one.
  std::string draw = "frozen";
  std::uint64_t seed = 0;
  /// Description of a ViGAS network as JSON: poses, boxes and pictures as it takes them. Nothing:
  /// as the released loader of the layout has them, and pictures of their own size.
  std::optional<std::string> network;
  /// Replay: moves the source by its delay to the target, as the released loader does.
  bool align = false;
};

/// The pairs of viewpoints of a data set's split, by number; a second of sound each. Const calls
/// may be made from many threads.
class PairReader {
 public:
  /// @throws InputError if there is no such data set, split, draw or network
  PairReader(const std::filesystem::path& folder, const PairOptions& options);
  ~PairReader();

  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] std::string layout() const;

  /// @param index  < size(), else std::out_of_range
  /// @throws InputError naming the file that is missing or malformed
  [[nodiscard]] PairItem item(std::size_t index) const;

  /// The same clip and target, but another source, speaker and second; of Replay another pair of
  /// the clip.
  /// @param seed  the same gives the same
  /// @throws as item()
  [[nodiscard]] PairItem drawn(std::size_t index, std::uint64_t seed) const;

 private:
  class Pairs;
  class SoundSpacesPairs;
  class ReplayPairs;
  [[nodiscard]] PairItem finished(PairItem item) const;

  std::unique_ptr<Pairs> pairs_;
  PoseEncoding pose_encoding_;
  BoxEncoding box_encoding_;
  std::optional<ImageEncoderDescription> encoder_;
};

}  // namespace earpoint::python
