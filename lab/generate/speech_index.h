#pragma once

#include <filesystem>
#include <vector>

#include <earpoint/generate/speech_corpus.h>

namespace earpoint {

/// What an index lists.
struct SpeechIndex {
  std::vector<SpeechSpeaker> speakers;  ///< sorted by name
  bool has_splits = false;              ///< otherwise all are train
};

/// Reads an index with the columns file, speaker, gender[, split].
/// @throws InputError naming the line
SpeechIndex read_speech_csv(const std::filesystem::path& path);

/// Reads LibriSpeech: SPEAKERS.TXT and the subsets that lie beside it. Subsets of one split alone
/// are no splits.
/// @throws InputError naming the line
SpeechIndex read_librispeech(const std::filesystem::path& folder);

}  // namespace earpoint
