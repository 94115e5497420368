#include "dataset_record.h"

#include "conversation_folder.h"
#include "speech_writer.h"

#include <map>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include <earpoint/core/error.h>
#include <earpoint/core/file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kRecord = "dataset.json";

Json record_of(const GenerationOptions& options, const SceneSource& scenes,
               const SpeechCorpus& corpus) {
  std::size_t recordings = 0;
  for (const SpeechSpeaker& speaker : corpus.speakers()) recordings += speaker.recordings.size();
  Json json;
  json["format"] = "earpoint-dataset-1";
  json["seed"] = options.seed;
  json["scenes"] = options.order.scenes;
  json["scene_source"] = scenes.description();
  json["conversations"] = options.order.conversations;
  json["split"] = options.order.split ? Json(*options.order.split) : Json();
  json["viewpoints"] = options.conversation.viewpoints;
  json["sample_rate_hz"] = options.quality.sample_rate_hz;
  json["duration_s"] = options.quality.duration_s;
  json["rays"] = options.quality.rays;
  json["image"] = {options.quality.image_width, options.quality.image_height};
  json["horizontal_fov_deg"] = degrees_from_radians(options.quality.horizontal_fov_rad);
  json["voices"] = corpus.speakers().size();
  json["recordings"] = recordings;
  json["speech_folder"] = speech_folder_of(options.speech_form);
  json["path_prefix"] = options.path_prefix;
  return json;
}

/// The first field that differs.
std::string difference(const Json& found, const Json& wanted) {
  for (const auto& [key, value] : wanted.items()) {
    if (!found.contains(key)) return key + " is missing";
    if (found[key] != value)
      return key + " is " + found[key].dump() + " there, " + value.dump() + " here";
  }
  return "it has other fields";
}

using SceneKey = std::pair<std::string, std::string>;  // split, scene

/// The clips that are there, by scene.
std::map<SceneKey, std::vector<StoredConversation>> stored_conversations(
    const fs::path& root, const SceneSource& scenes, const std::vector<WorkItem>& items) {
  std::map<SceneKey, std::vector<StoredConversation>> stored;
  for (const WorkItem& item : items) {
    const std::string scene = scenes.name(item.scene);
    if (!is_stored(root, item, scene)) continue;
    stored[{item.split, scene}].push_back(read_conversation(root, item, scene));
  }
  return stored;
}

void write_metadata(const fs::path& root,
                    const std::map<SceneKey, std::vector<StoredConversation>>& stored) {
  for (const auto& [key, conversations] : stored) {
    std::vector<SoundSpacesClip> clips;
    clips.reserve(conversations.size());
    for (const StoredConversation& conversation : conversations) clips.push_back(conversation.clip);
    const fs::path path = root / key.first / key.second / kSoundSpacesMetadata;
    const std::string text = soundspaces_metadata(clips);
    if (!fs::exists(path) || read_text_file(path) != text) write_file(path, text);
  }
}

std::size_t count(const std::map<SceneKey, std::vector<StoredConversation>>& stored) {
  std::size_t conversations = 0;
  for (const auto& [key, list] : stored) conversations += list.size();
  return conversations;
}

}  // namespace

void begin_dataset(const GenerationOptions& options, const SceneSource& scenes,
                   const SpeechCorpus& corpus) {
  std::error_code error;
  fs::create_directories(options.folder, error);
  if (error) throw InputError(options.folder.string(), "cannot be made: " + error.message());
  const fs::path path = options.folder / kRecord;
  const Json wanted = record_of(options, scenes, corpus);
  if (!fs::exists(path)) {
    write_file(path, wanted.dump(1) + "\n");
    return;
  }
  const Json found = Json::parse(read_text_file(path), nullptr, false);
  if (found.is_discarded()) throw InputError(path.string(), "is not valid JSON");
  if (found == wanted) return;
  throw InputError(path.string(),
                   "this data set was begun with other options: " + difference(found, wanted),
                   "use the same, or another folder");
}

void complete_dataset(const GenerationOptions& options, const SceneSource& scenes,
                      const SpeechCorpus& corpus, const std::vector<WorkItem>& items,
                      GenerationSummary& summary) {
  auto stored = stored_conversations(options.folder, scenes, items);
  // Another shard may have finished more while this one wrote, and have written before it.
  while (true) {
    write_metadata(options.folder, stored);
    auto again = stored_conversations(options.folder, scenes, items);
    if (count(again) == count(stored)) break;
    stored = std::move(again);
  }
  SpeechWriter speech(options.folder / speech_folder_of(options.speech_form), options.speech_form);
  for (const auto& [key, conversations] : stored) {
    ++summary.scenes[key.first];
    for (const StoredConversation& conversation : conversations) {
      for (const SoundSpacesSpeaker& speaker : conversation.clip.speakers) {
        speech.write_missing(key.first, corpus, *speaker.speech);
      }
      summary.add(conversation.report);
    }
  }
  summary.missing = static_cast<int>(items.size()) - summary.conversations;
}

}  // namespace earpoint
