#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace earpoint {

/// The network that finds people in a picture. Residual blocks shrink the picture to a 32nd; a
/// pyramid brings their features to an eighth; two convolutions there give, for every cell of
/// 8 x 8 pixels, whether the middle of a person lies in it, and the person's box.
/// Sources: He et al., CVPR 2016 (blocks); Lin et al., CVPR 2017 (pyramid); Zhou et al., "Objects
/// as points", 2019 (middles).
struct PeopleDescription {
  int longest_px = 256;  ///< the longer side of what it looks at; a multiple of 32
  int channels = 16;     ///< of the first convolution

  static constexpr int kCell = 8;       ///< pixels of an output along each axis
  static constexpr int kCoarsest = 32;  ///< pixels of the coarsest map's places
  static constexpr int kStages = 4;
  /// Of each stage, in `channels`, and its blocks; every stage halves the map.
  static constexpr std::array<int, kStages> kWidths{2, 3, 6, 8};
  static constexpr std::array<int, kStages> kBlocks{1, 2, 2, 2};
  static constexpr int kNeckWidth = 3;  ///< of the pyramid, in `channels`
  static constexpr int kHeadLayers = 2;
  /// How sure it is (before the logistic function); the middle's offset from the cell's, in cells,
  /// x and y; logarithms of the width and the height in units of kBoxUnit pixels.
  static constexpr int kOutputs = 5;
  static constexpr int kBoxUnit = 32;
  /// Of those logarithms: e^4 kBoxUnit is more than any view.
  static constexpr float kLargestLog = 4.0F;
  static constexpr float kMiddleGrey = 0.5F;  ///< is subtracted from pixels of 0 to 1

  [[nodiscard]] int stage_channels(int stage) const { return channels * kWidths.at(stage); }
  [[nodiscard]] int neck_channels() const { return channels * kNeckWidth; }
};

/// @param where  the file, for messages
/// @throws InputError naming the field, what was expected and what was found
void check_description(const PeopleDescription& description, std::string_view where);
[[nodiscard]] std::string to_json(const PeopleDescription& description);
[[nodiscard]] PeopleDescription people_description_from_json(std::string_view json,
                                                             std::string_view where);

/// Name and shape of every tensor of the network.
[[nodiscard]] std::map<std::string, std::vector<std::int64_t>> required_tensors(
    const PeopleDescription& description);

}  // namespace earpoint
