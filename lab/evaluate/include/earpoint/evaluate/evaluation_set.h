#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <earpoint/audio/ambient_separation.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/dataset/pair_sample.h>

namespace earpoint {

/// The pairs that methods are compared on. Any thread may ask for samples.
class EvaluationSet {
 public:
  virtual ~EvaluationSet() = default;

  [[nodiscard]] virtual std::size_t size() const = 0;
  /// What messages and reports call a pair, e.g. "home-0003, clip 12: 0 -> 2, speaker 1".
  [[nodiscard]] virtual std::string name(std::size_t pair) const = 0;
  /// Where it is; of recordings, a session.
  [[nodiscard]] virtual std::string scene(std::size_t pair) const = 0;
  /// Pairs of one conversation have the same number; they are not independent of each other.
  [[nodiscard]] virtual int cluster(std::size_t pair) const = 0;
  /// The voice of the speaker; nothing where the data do not have it.
  [[nodiscard]] virtual std::optional<std::string> voice(std::size_t /*pair*/) const {
    return std::nullopt;
  }
  /// Where the pairs come from: a file, or how they were drawn.
  [[nodiscard]] virtual std::string pairs() const = 0;
  /// @throws InputError naming the file that is missing or malformed
  [[nodiscard]] virtual PairSample sample(std::size_t pair) const = 0;
  /// Whether samples have the speaker's position.
  [[nodiscard]] virtual bool knows_speaker() const { return true; }
  /// The simulator's truth; nothing for recordings.
  [[nodiscard]] virtual std::optional<PairTruth> truth(std::size_t pair) const = 0;

  /// What the released evaluation gives methods instead, if that is something else: on Replay it
  /// moves the source by a delay that it finds with the target's help.
  [[nodiscard]] virtual std::optional<PairSample> released_sample(std::size_t /*pair*/) const {
    return std::nullopt;
  }
};

/// Which pairs of a split in the SoundSpaces layout.
struct PairChoice {
  std::optional<std::filesystem::path> list{};  ///< nothing: pairs-<split>.json of the data set
  /// Drawn, and no list read. Without it pairs are drawn (every_target, seed 1) only where the data
  /// set has no list, as the published one has not.
  std::optional<PairDraw> draw{};
};

/// The pairs of a split in the SoundSpaces-NVAS layout.
/// @param folder      of the data set, as soundspaces_options() knows it
/// @param limit       take that many pairs, spread evenly over the list; nothing: all
/// @param cache_bytes that it may keep of files
/// @param target      near_microphone: the source of every pair is to be enhanced
/// @param context     samples that sources hold before the window (PairSample::context)
/// @throws InputError if a file is missing or malformed, or the list does not fit the data
[[nodiscard]] std::unique_ptr<EvaluationSet> soundspaces_evaluation_set(
    const std::filesystem::path& folder, const std::string& split, const PairChoice& pairs,
    std::optional<std::size_t> limit, std::size_t cache_bytes,
    PairTarget target = PairTarget::viewpoint, std::ptrdiff_t context = 0);

/// The same pairs in a room that is not silent. Sources get the noise of add_room_noise(), drawn by
/// the pair's number, so that every method hears the same, and are separated into the primary sound
/// (PairSample::source) and the rest (PairSample::ambient). Targets stay clean: what is compared is
/// the primary sound. What the source would hear without noise is kept beside (PairSample::clean).
/// @param level_db    of the noise, root mean square re full scale
/// @param separation  how the two are separated
[[nodiscard]] std::unique_ptr<EvaluationSet> with_ambient(
    std::unique_ptr<EvaluationSet> set, double level_db,
    AmbientSeparation separation = AmbientSeparation::bandpass);

/// The pairs that the released evaluation draws of a split of Replay-NVAS; a recording session is a
/// cluster. Where the speaker stands is not known. The released samples have their source moved by
/// a delay that was found against the target.
/// @param folder  as replay_options() knows it
/// @param target  near_microphone: the source of every pair is to be enhanced
/// @throws InputError as ReplayDataset
[[nodiscard]] std::unique_ptr<EvaluationSet> replay_evaluation_set(
    const std::filesystem::path& folder, const std::string& split, std::optional<std::size_t> limit,
    PairTarget target = PairTarget::viewpoint);

/// The poses of a split of RWAVS, each with the second of sound around it; a scene is a cluster.
/// Methods get the dry sound as RwavsDataset::sample() has it, and the loudspeaker's position, but
/// no picture.
/// @param folder  as rwavs_options() knows it
/// @param split   train or val
/// @throws InputError as RwavsDataset
[[nodiscard]] std::unique_ptr<EvaluationSet> rwavs_evaluation_set(
    const std::filesystem::path& folder, const std::string& split,
    std::optional<std::size_t> limit);

}  // namespace earpoint
