#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/dataset/numpy_random.h>
#include <earpoint/dataset/sample.h>
#include <earpoint/vector3.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// The released loader's high-pass of the recordings.
inline constexpr double kReplayCutoffHz = 150.0;

/// Where a camera of the Replay recordings stands and looks.
struct ReplayCamera {
  Vector3 centre;     ///< their frame and unit: z up, centimetres
  Vector3 direction;  ///< where it looks, unit length
};

/// Cameras by scene (e.g. "SC-1027") and name ("DSLR-1" to "DSLR-8").
using ReplayCameras = std::map<std::string, std::map<std::string, ReplayCamera>>;

/// Reads a camera file of the authors: objects `centers` and `rotations`, scene -> camera -> three
/// numbers, a unit viewing direction in `rotations`. Cameras with NaN, which could not be placed,
/// are left out.
/// @throws InputError naming the field
[[nodiscard]] ReplayCameras read_replay_cameras(const std::filesystem::path& path);

/// One clip of the Replay-NVAS data set: several cameras' view of the same second.
struct ReplayClip {
  std::string folder;               ///< relative to the root
  std::string scene;                ///< e.g. "SC-1027"
  std::vector<std::string> images;  ///< e.g. "1.png"; the camera's number is the name
  /// Where the speaker's mouth is: metres, in the cameras' frame; of data that
  /// `earpoint record prepare` made, where it was found.
  std::optional<Vector3> mouth_m;
  /// Horizontal fields of view by image, of such data; empty or nothing where they are not known.
  std::vector<std::optional<double>> fov_rad;
};

/// Which sample is made of a clip: two of its images, by index.
struct ReplayChoice {
  int source = 0;
  int target = 0;
};

/// Scene and number of a clip: "data/appen_dataset/v3/SC-1027/3" is called SC-1027/3.
[[nodiscard]] std::string name_of(const ReplayClip& clip);

/// The camera of one of a clip's views: "3.png" is that of camera 3.
[[nodiscard]] std::string camera_of(const ReplayClip& clip, int view);

/// What one camera of a clip recorded.
struct ReplayView {
  ImagePlanes rgb;  ///< resized as the released loader does, 0 to 1
  Waveform sound;   ///< 2 ears, 16 kHz, high-passed, as long as the file
};

/// A split of the Replay-NVAS data set (v3 layout).
class ReplayDataset {
 public:
  struct Options {
    std::filesystem::path root;
    std::filesystem::path folder = "data/appen_dataset/v3";  ///< under root
    std::string split = "test";                              ///< train, val or test
    std::string metadata_file = "metadata_v2.json";
    /// Of prepared data, beside the metadata: which scenes are in which split, and what is known of
    /// clips. Without them, as in the download, splits are the published ones.
    std::string splits_file = "splits.json";
    std::string clips_file = "clips.json";
    std::string camera_file = "camera_positions_fixed_rotation.json";  ///< beside the folder
    /// As the released loader: a view that cannot be read becomes a black picture and six seconds
    /// of silence. Without it such a view is an error, since a data set with holes should be
    /// corrected.
    bool blank_unreadable = false;
  };

  /// @throws InputError naming file and field if one is malformed, or the split is empty
  explicit ReplayDataset(Options options);

  [[nodiscard]] const std::vector<ReplayClip>& clips() const { return clips_; }

  /// Draws what the released loader draws for an item.
  [[nodiscard]] ReplayChoice draw(const ReplayClip& clip, NumpyRandom& random) const;

  /// The pair of every clip, in the order of clips(), as the released test draws them.
  [[nodiscard]] std::vector<ReplayChoice> released_choices() const;

  /// Makes the sample as the released loader does, the source moved by the delay that it finds
  /// against the target included (`align`); a fair evaluation leaves that out.
  /// @throws InputError naming what is missing or malformed
  [[nodiscard]] NvasSample sample(const ReplayClip& clip, const ReplayChoice& choice,
                                  bool align) const;

  /// One of the clip's views. @throws InputError naming the file if it is missing or malformed
  [[nodiscard]] ReplayView view(const ReplayClip& clip, int view) const;

  /// The speaker's box in that view: x_min, y_min, x_max, y_max as shares of the picture; four
  /// zeros if the speaker is not in it. @throws InputError naming the file if it is missing or
  /// malformed
  [[nodiscard]] std::vector<double> box(const ReplayClip& clip, int view) const;

  /// What the speaker's near microphone recorded in that second, `near.wav` beside the views: one
  /// channel at 16 kHz, high-passed like the views; nothing where the clip has none.
  /// @throws InputError naming the file if it is malformed
  [[nodiscard]] std::optional<Waveform> near_sound(const ReplayClip& clip) const;

  /// @throws InputError if the camera file does not know that scene and camera
  [[nodiscard]] ReplayCamera camera(const std::string& scene, const std::string& image) const;

 private:
  void read_clips();
  void read_known();
  [[nodiscard]] std::filesystem::path path_of(const ReplayClip& clip, int view) const;

  Options options_;
  std::vector<ReplayClip> clips_;
  ReplayCameras cameras_;
};

/// The source, moved by the delay that GCC-PHAT finds against the target, at most 200 samples, as
/// the released loader does.
[[nodiscard]] Waveform aligned_source(const Waveform& source, const Waveform& target);

/// The loader's `rotate-rel-pose` form: horizontal distance turned by 90 (taken as radians) minus
/// the angle between view and target, and the height difference; centimetres.
std::array<double, 3> replay_pose(const ReplayCamera& source, const ReplayCamera& target);
/// Sine and cosine of the differences of atan2(y, x), atan2(z, y), atan2(z, x).
std::array<double, 6> replay_rotation(const ReplayCamera& source, const ReplayCamera& target);

}  // namespace earpoint
