#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <earpoint/pose.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// One measured room impulse response of Real Acoustic Fields.
struct RafItem {
  std::string id;           ///< name of its folder, e.g. "004568"
  Vector3 receiver_m;       ///< an omnidirectional microphone; our frame: x front, y left, z up
  Pose world_from_speaker;  ///< the loudspeaker, level; its yaw is where it faces
};

/// A room of the Real Acoustic Fields data set: data/<id>/{rir.wav,rx_pos.txt,tx_pos.txt} and a
/// split file, metres.
/// Positions are converted as import_scene() converts the room's model: y is up, z becomes our x
/// and x our y. The data set's description calls x front and z left, which would be a left-handed
/// frame; its model is right-handed, and so is this.
class RafDataset {
 public:
  struct Options {
    std::filesystem::path folder;  ///< of one room: it holds `data`
    std::string split = "test";    ///< train, validation, test, or all
    /// The published list of a room (data-split_emptyroom.json); empty: metadata/data-split.json
    /// of the folder. Not read for all.
    std::filesystem::path split_file;
  };

  /// Reads the positions of every item of the split.
  /// @throws InputError naming file and field if one is missing or malformed, or the split is empty
  explicit RafDataset(Options options);

  [[nodiscard]] const std::vector<RafItem>& items() const { return items_; }

  /// @return 1 channel, at the file's rate (48 kHz as published)
  /// @throws InputError naming the file if it is missing, damaged, empty or has more channels
  [[nodiscard]] Waveform response(const RafItem& item) const;

 private:
  Options options_;
  std::vector<RafItem> items_;
};

/// The item of `others` that is nearest to one: the distance between the receivers, plus that
/// between the loudspeakers, plus a metre for every radian between where they face.
/// @param others  not empty; the first of equally near ones is taken
[[nodiscard]] const RafItem& nearest_item(const RafItem& item, const std::vector<RafItem>& others);

/// A published position (y up) in our frame.
[[nodiscard]] Vector3 position_from_raf(const Vector3& raf);

/// The yaw of a loudspeaker from its quaternion in RAF's frame: it faces along its negative z axis,
/// as the released loader of Acoustic Volume Rendering has it; the height is left out.
/// @param x, y, z, w  as tx_pos.txt has them
/// @throws InputError naming quaternion if it is zero or faces straight up or down
[[nodiscard]] double yaw_from_raf(double x, double y, double z, double w);

}  // namespace earpoint
