#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/scene/people.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Which part of a data set: voices, and homes, are in one of them only.
enum class DataSplit { train, val, test };

std::string_view name_of(DataSplit split);
std::optional<DataSplit> data_split_named(std::string_view name);

/// A recording of one person's speech.
struct SpeechRecording {
  std::string id;  ///< "speaker-chapter-section", unique in its corpus
  std::filesystem::path path;
};

/// One voice.
struct SpeechSpeaker {
  std::string name;
  Gender gender = Gender::female;
  DataSplit split = DataSplit::train;
  std::vector<SpeechRecording> recordings;  ///< at least one, sorted by id
};

/// What was drawn; both are the corpus'.
struct SpeechDraw {
  const SpeechSpeaker* speaker = nullptr;
  const SpeechRecording* recording = nullptr;
};

/// Recorded speech by speaker, ready to be drawn from. Nothing is decoded when it is loaded.
class SpeechCorpus {
 public:
  /// Reads a folder's index:
  /// - `speech.csv` with the columns file, speaker, gender and perhaps split (train, val, test);
  ///   files are relative to the folder; or
  /// - `SPEAKERS.TXT` of LibriSpeech, with subsets like train-clean-360/, dev-clean/, test-clean/
  ///   beside it (reader/chapter/reader-chapter-section.flac).
  /// Where the index names no splits, or LibriSpeech's subsets are of one alone, the speakers of
  /// each gender are split 90 : 10 : 20, in the order of their names.
  /// @throws InputError naming file and line if there is no index, it is malformed, names a file
  ///         that is missing, or holds no speech
  static SpeechCorpus load(const std::filesystem::path& folder);

  /// Sorted by name.
  [[nodiscard]] const std::vector<SpeechSpeaker>& speakers() const { return speakers_; }

  /// Draws a speaker of that gender and split, then one of the recordings.
  /// @throws InputError if there is no such speaker
  [[nodiscard]] SpeechDraw draw(Gender gender, DataSplit split, RandomStream& random) const;

  /// @throws InputError if there is no recording of that id
  [[nodiscard]] const SpeechRecording& recording(const std::string& id) const;

 private:
  explicit SpeechCorpus(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::filesystem::path folder_;
  std::vector<SpeechSpeaker> speakers_;
};

/// Where `./dev speech` puts the gathered corpus: speech/ in the folder of the model pack.
std::filesystem::path default_speech_folder();

/// Reads a recording as simulation wants it: one channel at 16 kHz, silence at both ends cut down
/// to 0.1 s, and the level of its speech (the root mean square of what lies within 15.9 dB of the
/// long-term level, close to ITU-T P.56) at -26 dB re full scale, lower where a peak would clip.
/// @throws InputError if it cannot be read, is silent, or shorter than 0.5 s
Waveform read_speech(const std::filesystem::path& path);

/// The same for sound in memory. @param where  what errors call it
Waveform prepare_speech(const Waveform& sound, std::string_view where);

}  // namespace earpoint
