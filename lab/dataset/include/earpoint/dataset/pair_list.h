#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/dataset/soundspaces.h>

namespace earpoint {

/// One pair of viewpoints to evaluate on, and who speaks when.
struct ViewPair {
  std::string scene;
  int clip = 0;              ///< within the scene
  SoundSpacesChoice choice;  ///< viewpoints and speaker by index, the window's start in samples
};

/// Pairs of a split, drawn once and for all: results on the same list can be compared. The released
/// evaluation draws its pairs at random.
struct PairList {
  std::string split;
  std::vector<ViewPair> pairs;
};

/// Draws as many pairs of every clip as it has viewpoints: each is the target once, the source is
/// one of the others, the speaker one of those who have speech, and the window of a second starts
/// anywhere in the speech. Clips of one viewpoint, or without speech, give none.
/// @param speech_samples  how long a recording is, at 16 kHz
/// @param seed            the same gives the same pairs of a clip, whatever clips there are besides
PairList draw_pair_list(const std::string& split, std::span<const SoundSpacesClip> clips,
                        const std::function<std::ptrdiff_t(const std::string&)>& speech_samples,
                        std::uint64_t seed);

/// How the pairs of a list are drawn.
enum class PairDraw {
  every_target,  ///< draw_pair_list(): as frozen lists are drawn
  /// As the released test draws them, one pair a clip and the first second of its speech: NumPy's
  /// generator of seed 0 runs through the clips, scenes in the order of their names (the released
  /// loader takes them as the file system lists them). A training split has random seconds there
  /// too.
  released,
};

/// @param name  "every-target" or "released". @throws InputError naming draw if it is neither
PairDraw draw_named(std::string_view name);

/// Draws pairs of a data set on disk. Speech whose file cannot be opened is taken from its first
/// second on: who reads it says what is wrong.
/// @param seed  of every_target; the released draw knows 0 only
/// @throws InputError if no clip has two viewpoints and speech, and as SoundSpacesDataset::draw()
PairList draw_pair_list(const SoundSpacesDataset& dataset, PairDraw draw, std::uint64_t seed);

/// The frozen list of a split: pairs-<split>.json in the folder, else beside its scenes.
/// @param folder   as soundspaces_options() knows it
/// @return nothing if there is none
std::optional<std::filesystem::path> find_pair_list(const std::filesystem::path& folder,
                                                    const std::string& split);

/// Seed of pairs that are drawn because a data set has no list.
inline constexpr std::uint64_t kPairDrawSeed = 1;

/// The frozen list of the data set's split; without one, a list drawn with kPairDrawSeed, every
/// target once.
/// @param folder  as soundspaces_options() knows it
/// @throws InputError as read_pair_list() and draw_pair_list()
PairList frozen_or_drawn_pairs(const SoundSpacesDataset& dataset,
                               const std::filesystem::path& folder);

/// @return the file's text: JSON, one pair a line; docs/formats.md describes it
std::string text_of(const PairList& list);

/// @throws InputError naming file and field if it is missing, malformed or of another version
PairList read_pair_list(const std::filesystem::path& path);

/// The clip that a pair is of.
/// @param where  what errors call the list, e.g. its file
/// @throws InputError if the data set has no such clip, viewpoint or speaker
const SoundSpacesClip& clip_of(const ViewPair& pair, std::span<const SoundSpacesClip> clips,
                               std::string_view where);

}  // namespace earpoint
