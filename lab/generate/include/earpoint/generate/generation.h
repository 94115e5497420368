#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/generate/conversation.h>
#include <earpoint/generate/conversation_plan.h>
#include <earpoint/generate/generation_summary.h>
#include <earpoint/generate/speech_corpus.h>
#include <earpoint/generate/work_plan.h>
#include <earpoint/scene/people.h>

namespace earpoint {

/// In which form the used speech is written beside a data set.
enum class SpeechForm {
  flac,      ///< speech/, 24-bit FLAC
  released,  ///< LibriSpeech-wav/, as the released loader reads it: WAV in files named .flac
};

/// @return the folder's name: "speech" or "LibriSpeech-wav"
std::string_view speech_folder_of(SpeechForm form);

/// What a data set is made of.
struct GenerationOptions {
  std::filesystem::path folder;  ///< the data set's root; made if it is not there
  std::uint64_t seed = 1;
  WorkOrder order;
  ConversationOptions conversation;
  ConversationQuality quality;
  SpeechForm speech_form = SpeechForm::flac;
  bool write_heard = false;  ///< also what every viewpoint hears of every speaker
  /// Before every path in the metadata, e.g. "data/synthetic_dataset/v16".
  std::string path_prefix;
  Shard shard;
  int jobs = 1;  ///< threads, > 0; has no effect on what is written
};

/// Where the scenes of a data set come from.
class SceneMaker {
 public:
  virtual ~SceneMaker() = default;
  /// Makes a scene; the same index gives the same scene. Called from many threads at once.
  [[nodiscard]] virtual std::shared_ptr<const PreparedScene> make(int scene) const = 0;
  /// @return the folder's name
  [[nodiscard]] virtual std::string name(int scene) const = 0;
  /// @return one line that tells one source from another
  [[nodiscard]] virtual std::string description() const = 0;
};

/// Simulates a data set in the SoundSpaces-NVAS layout, as docs/formats.md describes it.
///
/// A conversation is written aside and renamed when it is whole; a run that is started again with
/// the same options goes on where the last one ended, however that was. Every conversation draws
/// from a random stream of its own, named by seed, scene and conversation: the bytes do not depend
/// on jobs, shards or interruptions. Conversations that lack a file are made again. Metadata is put
/// together at the end, from whatever is there. Several processes may share the folder if each
/// makes other conversations.
/// @throws InputError if the folder holds a data set that was begun with other options, another
///         process makes one of these conversations, the corpus lacks speakers, a scene has no
///         room, or the disk is full
GenerationSummary generate_dataset(const GenerationOptions& options, const SceneMaker& scenes,
                                   const FigureLibrary& figures, const SpeechCorpus& corpus,
                                   ProgressSink& progress);

}  // namespace earpoint
