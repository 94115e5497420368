#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/dataset/pair_sample.h>
#include <earpoint/pose.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// One second of the Real-World Audio-Visual Scenes: where the head was when a frame was taken.
struct RwavsMoment {
  std::string scene;         ///< name of its folder, e.g. "1"
  std::string frame;         ///< as its pose file names it, e.g. "frames/00012.png"
  int time_s = 0;            ///< of the frame, and the middle of the second
  Pose world_from_listener;  ///< our axes, z up; metres by RwavsScene::metres_per_unit
};

/// What is known of a scene.
struct RwavsScene {
  Vector3 speaker_m;  ///< the loudspeaker, in the frame of the moments
  /// Published coordinates are scaled to [-1, 1] and have no unit. They are multiplied by this,
  /// such that the mean distance from the loudspeaker in training is kRwavsMeanDistance_m.
  /// Directions do not depend on it, nor ratios of distances.
  double metres_per_unit = 1.0;
};
inline constexpr double kRwavsMeanDistance_m = 2.0;

/// A split of RWAVS: position.json and, for each scene, transforms_scale_{train,val}.json,
/// source_syn_re.wav (dry, one channel) and binaural_syn_re.wav.
class RwavsDataset {
 public:
  struct Options {
    std::filesystem::path root;        ///< holds position.json and the scenes
    std::string split = "val";         ///< train or val
    std::optional<std::string> scene;  ///< only this one
  };

  /// @throws InputError naming file and field if one is missing or malformed, or nothing is found
  explicit RwavsDataset(Options options);

  /// By scene, and in the order of the pose files. Moments with less than half a second of sound
  /// are left out, as by the released loader.
  [[nodiscard]] const std::vector<RwavsMoment>& moments() const { return moments_; }
  [[nodiscard]] const RwavsScene& scene(const std::string& name) const;

  /// What was played and what was heard in the second around a moment, at 16 kHz. The data have no
  /// other listener, so the source is the dry sound in both ears, as a head would hear it that
  /// faces the loudspeaker from kRwavsMeanDistance_m. It is scaled by one gain a scene, so that
  /// it is as loud as the recordings are in the training split on average. Any thread may call
  /// this; sounds of the last scene are kept.
  /// @return  no picture and no box; PairSample::dry is the scaled dry sound
  /// @throws InputError naming the sound file that is missing, damaged, too short or has the wrong
  ///         number of channels
  [[nodiscard]] PairSample sample(const RwavsMoment& moment) const;

 private:
  struct Sounds;
  void read_scene(const std::string& name, const Vector3& position);
  [[nodiscard]] std::shared_ptr<const Sounds> sounds_of(const std::string& scene) const;

  Options options_;
  std::map<std::string, RwavsScene> scenes_;
  std::map<std::string, std::vector<int>> training_times_s_;
  std::vector<RwavsMoment> moments_;
  struct Cache;
  std::shared_ptr<Cache> cache_;
};

/// The root of a download, if the folder is that, or one of its scenes.
[[nodiscard]] std::optional<std::filesystem::path> rwavs_root(const std::filesystem::path& folder);

}  // namespace earpoint
