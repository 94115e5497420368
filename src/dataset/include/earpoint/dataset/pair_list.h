#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
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
/// anywhere in the speech.
/// @param speech_samples  how long a recording is, at 16 kHz
/// @param seed            the same gives the same pairs of a clip, whatever clips there are besides
PairList draw_pair_list(const std::string& split, std::span<const SoundSpacesClip> clips,
                        const std::function<std::ptrdiff_t(const std::string&)>& speech_samples,
                        std::uint64_t seed);

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
