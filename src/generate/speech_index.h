#pragma once

#include <filesystem>
#include <vector>

#include <earpoint/generate/speech_corpus.h>

namespace earpoint {

/// Reads an index with the columns file, speaker, gender[, split]. Without splits all are train.
/// @throws InputError naming the line
std::vector<SpeechSpeaker> read_speech_csv(const std::filesystem::path& path);

/// Reads LibriSpeech: SPEAKERS.TXT and the subsets that lie beside it.
/// @throws InputError naming the line
std::vector<SpeechSpeaker> read_librispeech(const std::filesystem::path& folder);

}  // namespace earpoint
