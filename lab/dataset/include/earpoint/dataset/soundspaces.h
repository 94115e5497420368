#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <earpoint/dataset/numpy_random.h>
#include <earpoint/dataset/sample.h>
#include <earpoint/dataset/soundspaces_metadata.h>

namespace earpoint {

/// Which sample is made of a clip.
struct SoundSpacesChoice {
  int source = 0;                   ///< index of the source viewpoint
  int target = 0;                   ///< index of the target viewpoint
  int speaker = 0;                  ///< index of the one who speaks
  std::ptrdiff_t window_start = 0;  ///< samples at 16 kHz
};

/// A split of the SoundSpaces-NVAS data set (v16 layout), or of one written in its form.
class SoundSpacesDataset {
 public:
  struct Options {
    std::filesystem::path root;  ///< the folder that the paths in the files start from
    std::filesystem::path folder = "data/synthetic_dataset/v16";  ///< under root
    std::string split = "test";
    std::string metadata_file{kSoundSpacesMetadata};
    std::filesystem::path speech_folder = "data/LibriSpeech-wav";  ///< under root
  };

  /// Reads every scene's metadata, scenes in the order of their names. Scenes without the metadata
  /// file are passed over, as the released loader does.
  /// @throws InputError naming file and field if one is malformed or no scene is found
  explicit SoundSpacesDataset(Options options);

  [[nodiscard]] const std::string& split() const { return options_.split; }
  [[nodiscard]] const std::vector<SoundSpacesClip>& clips() const { return clips_; }

  /// Draws what the released loader draws for an item: permutation of the viewpoints, one of the
  /// speakers who have speech, and in training a window of longer speech.
  /// @throws InputError if the clip has fewer than two viewpoints, or nobody has speech
  [[nodiscard]] SoundSpacesChoice draw(const SoundSpacesClip& clip, NumpyRandom& random) const;

  /// Makes the sample as the released loader does.
  /// @throws InputError naming the file that is missing or malformed
  [[nodiscard]] NvasSample sample(const SoundSpacesClip& clip,
                                  const SoundSpacesChoice& choice) const;

  /// Where a speaker's speech lies.
  [[nodiscard]] std::filesystem::path speech_path(const std::string& speech) const;

  /// A recording as samples are made of it: high-passed, 1 channel, 16 kHz.
  /// @throws InputError naming the file
  [[nodiscard]] Waveform read_speech(const std::string& speech) const;

  /// How many samples read_speech() gives, by the file's header. @throws InputError naming the file
  [[nodiscard]] std::ptrdiff_t speech_samples(const std::string& speech) const;

  /// A binaural response at 16 kHz, and where it begins.
  struct Response {
    Waveform sound;            ///< 2 ears, its delay dropped: what samples are made of
    std::ptrdiff_t delay = 0;  ///< samples that were dropped
  };

  /// @param rir  as a viewpoint names it
  /// @throws InputError naming the file
  [[nodiscard]] Response read_response(const std::string& rir) const;

  /// Where a file lies that the metadata name, e.g. a viewpoint's picture.
  [[nodiscard]] std::filesystem::path path_of(const std::string& name) const {
    return options_.root / name;
  }

 private:
  Options options_;
  std::vector<SoundSpacesClip> clips_;
};

/// [d, sin a, cos a] and the turn [sin r, cos r] from one viewpoint to another: see
/// PoseEncoding::soundspaces, but from the file's numbers, coincident points included.
std::array<double, 3> soundspaces_pose(const SoundSpacesViewpoint& from, const Vector3& to);
std::array<double, 2> soundspaces_rotation(const SoundSpacesViewpoint& from,
                                           const SoundSpacesViewpoint& to);

}  // namespace earpoint
