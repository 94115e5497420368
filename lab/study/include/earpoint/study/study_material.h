#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/image.h>

namespace earpoint {

/// The pairs that clips of a study are drawn from.
class StudyMaterial {
 public:
  virtual ~StudyMaterial() = default;

  [[nodiscard]] virtual std::size_t size() const = 0;
  [[nodiscard]] virtual std::string name(std::size_t pair) const = 0;
  [[nodiscard]] virtual std::string scene(std::size_t pair) const = 0;
  /// Pairs of one conversation share voices and places.
  [[nodiscard]] virtual int conversation(std::size_t pair) const = 0;
  /// Where the pairs are from.
  [[nodiscard]] virtual std::string pairs() const = 0;
  /// @return nothing if the pair's recording is shorter than the study's sounds
  /// @throws InputError naming a file that is missing or malformed
  [[nodiscard]] virtual std::optional<PairSample> sample(std::size_t pair) const = 0;
  /// What the target sees. @throws InputError as sample()
  [[nodiscard]] virtual std::shared_ptr<const Image> target_picture(std::size_t pair) const = 0;
  /// Whether samples tell where the speaker stands.
  [[nodiscard]] virtual bool knows_speaker() const = 0;
};

/// Pairs of a split: of the SoundSpaces layout the frozen list, or, where there is none, every
/// viewpoint once the target in windows drawn by seed 1; of the Replay layout one of every clip, as
/// the released test draws them.
/// @param list        of pairs, in place of pairs-<split>.json; SoundSpaces alone
/// @param duration_s  of the sounds, > 0; clips of the Replay layout have one second
/// @throws InputError if the data set is not there or malformed, or has no pairs
[[nodiscard]] std::unique_ptr<StudyMaterial> study_material(
    const std::filesystem::path& folder, DatasetLayout layout, const std::string& split,
    const std::optional<std::filesystem::path>& list, double duration_s);

}  // namespace earpoint
