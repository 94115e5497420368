#include <earpoint/generate/speech_corpus.h>

#include "speech_index.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include <fmt/format.h>

#include <earpoint/core/data_folder.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

// The paper's scenes: 90 train, 10 val, 20 test.
constexpr double kValShare = 10.0 / 120.0;
constexpr double kTestShare = 20.0 / 120.0;

std::size_t share_of(std::size_t speakers, double share) {
  const auto wanted = static_cast<std::size_t>(std::lround(static_cast<double>(speakers) * share));
  return std::max<std::size_t>(1, wanted);
}

void split_speakers(std::vector<SpeechSpeaker>& speakers) {
  for (const Gender gender : {Gender::female, Gender::male}) {
    std::vector<SpeechSpeaker*> group;
    for (SpeechSpeaker& speaker : speakers) {
      if (speaker.gender == gender) group.push_back(&speaker);
    }
    for (SpeechSpeaker* speaker : group) speaker->split = DataSplit::train;
    if (group.size() < 2) continue;
    const std::size_t test = share_of(group.size(), kTestShare);
    const std::size_t val = group.size() < 3 ? 0 : share_of(group.size(), kValShare);
    for (std::size_t i = 0; i < test; ++i) group[group.size() - 1 - i]->split = DataSplit::test;
    for (std::size_t i = 0; i < val; ++i)
      group[group.size() - 1 - test - i]->split = DataSplit::val;
  }
}

}  // namespace

std::string_view name_of(DataSplit split) {
  switch (split) {
    case DataSplit::train:
      return "train";
    case DataSplit::val:
      return "val";
    case DataSplit::test:
      return "test";
  }
  return "test";
}

std::optional<DataSplit> data_split_named(std::string_view name) {
  for (const DataSplit split : {DataSplit::train, DataSplit::val, DataSplit::test}) {
    if (name == name_of(split)) return split;
  }
  return std::nullopt;
}

SpeechCorpus SpeechCorpus::load(const fs::path& folder) {
  SpeechCorpus corpus(folder);
  SpeechIndex index;
  if (fs::is_regular_file(folder / "speech.csv")) {
    index = read_speech_csv(folder / "speech.csv");
  } else if (fs::is_regular_file(folder / "SPEAKERS.TXT")) {
    index = read_librispeech(folder);
  } else {
    throw InputError(folder.string(), "holds neither speech.csv nor SPEAKERS.TXT",
                     "run ./dev speech, or give another folder of speech");
  }
  corpus.speakers_ = std::move(index.speakers);
  if (corpus.speakers_.empty()) throw InputError(folder.string(), "holds no speech");
  if (!index.has_splits) split_speakers(corpus.speakers_);
  return corpus;
}

SpeechDraw SpeechCorpus::draw(Gender gender, DataSplit split, RandomStream& random) const {
  std::vector<const SpeechSpeaker*> fitting;
  for (const SpeechSpeaker& speaker : speakers_) {
    if (speaker.gender == gender && speaker.split == split) fitting.push_back(&speaker);
  }
  if (fitting.empty()) {
    throw InputError(
        folder_.string(),
        fmt::format("has no {} speaker for the split {}", name_of(gender), name_of(split)),
        "add speakers, at least three of each gender");
  }
  const SpeechSpeaker& speaker = *fitting[random.index(fitting.size())];
  return {&speaker, &speaker.recordings[random.index(speaker.recordings.size())]};
}

const SpeechRecording& SpeechCorpus::recording(const std::string& id) const {
  for (const SpeechSpeaker& speaker : speakers_) {
    const auto found = std::lower_bound(speaker.recordings.begin(), speaker.recordings.end(), id,
                                        [](const SpeechRecording& recording,
                                           const std::string& key) { return recording.id < key; });
    if (found != speaker.recordings.end() && found->id == id) return *found;
  }
  throw InputError(folder_.string(), "has no recording '" + id + "'",
                   "use the corpus that the data set was started with");
}

fs::path default_speech_folder() { return data_folder().value_or(".") / "speech"; }

}  // namespace earpoint
