#pragma once

#include <filesystem>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include <earpoint/generate/generation.h>
#include <earpoint/generate/speech_corpus.h>

namespace earpoint {

/// Writes the speech that a data set uses, each recording once. Calls may come from many threads.
class SpeechWriter {
 public:
  SpeechWriter(std::filesystem::path folder, SpeechForm form)
      : folder_(std::move(folder)), form_(form) {}

  /// Writes a recording unless it is there.
  /// @return the speech as it is written
  Waveform write(std::string_view split, const SpeechRecording& recording);

  /// The same, but the corpus is not looked at if the recording is there.
  void write_missing(std::string_view split, const SpeechCorpus& corpus, const std::string& id);

 private:
  [[nodiscard]] std::filesystem::path path_of(std::string_view split, const std::string& id) const;

  std::filesystem::path folder_;
  SpeechForm form_;
  std::mutex mutex_;
  std::set<std::filesystem::path> begun_;  // by this process; guarded by mutex_
};

}  // namespace earpoint
