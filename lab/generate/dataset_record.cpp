#include "dataset_record.h"

#include "conversation_folder.h"
#include "dataset_lock.h"
#include "speech_writer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/core/json_file.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kRecord = "dataset.json";

Json record_of(const GenerationOptions& options, const SceneMaker& scenes,
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
  // Left out where they are the defaults, so that older data sets without these keys can be
  // continued.
  if (options.conversation.viewpoint_reach_m != ConversationOptions{}.viewpoint_reach_m) {
    json["viewpoints_reach_m"] = options.conversation.viewpoint_reach_m;
  }
  if (options.conversation.other_room_share > 0.0) {
    json["other_rooms"] = options.conversation.other_room_share;
    json["other_rooms_reach_m"] = options.conversation.other_room_reach_m;
  }
  if (options.conversation.height_spread_m > 0.0) {
    json["height_spread_m"] = options.conversation.height_spread_m;
  }
  json["sample_rate_hz"] = options.quality.sample_rate_hz;
  json["duration_s"] = options.quality.duration_s;
  json["rays"] = options.quality.rays;
  json["image"] = {options.quality.image_width, options.quality.image_height};
  json["horizontal_fov_deg"] = degrees_from_radians(options.quality.horizontal_fov_rad);
  json["voices"] = corpus.speakers().size();
  json["recordings"] = recordings;
  json["speech_folder"] = speech_folder_of(options.speech_form);
  json["heard"] = options.write_heard;
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

/// The stored clips, by scene.
std::map<SceneKey, std::vector<StoredConversation>> stored_conversations(
    const fs::path& root, const SceneMaker& scenes, const std::vector<WorkItem>& items,
    bool heard) {
  std::map<SceneKey, std::vector<StoredConversation>> stored;
  for (const WorkItem& item : items) {
    const std::string scene = scenes.name(item.scene);
    auto conversation = stored_conversation(root, item, scene, heard);
    if (conversation) stored[{item.split, scene}].push_back(std::move(*conversation));
  }
  return stored;
}

void write_if_new(const fs::path& path, const std::string& text) {
  if (!fs::exists(path) || read_text_file(path) != text) write_file(path, text);
}

void write_metadata(const fs::path& root,
                    const std::map<SceneKey, std::vector<StoredConversation>>& stored) {
  for (const auto& [key, conversations] : stored) {
    std::vector<SoundSpacesClip> clips;
    clips.reserve(conversations.size());
    for (const StoredConversation& conversation : conversations) clips.push_back(conversation.clip);
    const fs::path path = root / key.first / key.second / kSoundSpacesMetadata;
    write_if_new(path, soundspaces_metadata(clips));
  }
}

/// Writes the pair lists of the held-out splits that are complete.
void write_pair_lists(const fs::path& root, const std::vector<WorkItem>& items, std::uint64_t seed,
                      const std::map<SceneKey, std::vector<StoredConversation>>& stored) {
  std::map<std::string, std::size_t> missing;
  for (const WorkItem& item : items) ++missing[item.split];
  std::map<std::string, std::vector<SoundSpacesClip>> clips;
  std::map<std::string, double> speech_s;
  for (const auto& [key, conversations] : stored) {
    for (const StoredConversation& conversation : conversations) {
      SoundSpacesClip clip = conversation.clip;
      clip.index = static_cast<int>(&conversation - conversations.data());
      for (std::size_t i = 0; i < clip.speakers.size(); ++i) {
        speech_s[*clip.speakers[i].speech] = conversation.report.speech_s.at(i);
      }
      clips[key.first].push_back(std::move(clip));
      --missing[key.first];
    }
  }
  for (const auto& [split, list] : clips) {
    if (voices_of_split(split) == DataSplit::train || missing[split] > 0) continue;
    const PairList pairs = draw_pair_list(
        split, list,
        [&](const std::string& speech) { return std::lround(speech_s.at(speech) * 16000.0); },
        seed);
    write_if_new(root / fmt::format("pairs-{}.json", split), text_of(pairs));
  }
}

/// Removes unfinished files and folders: ".name.partial.ext" and, for folders, ".name.partial".
template <typename Iterator>
void remove_partial(Iterator entries) {
  std::vector<fs::path> left;
  for (const fs::directory_entry& entry : entries) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.') && name.find(".partial") != std::string::npos) {
      left.push_back(entry.path());
    }
  }
  std::error_code ignored;
  for (const fs::path& path : left) fs::remove_all(path, ignored);
}

}  // namespace

void begin_dataset(const GenerationOptions& options, const SceneMaker& scenes,
                   const SpeechCorpus& corpus, bool others_work) {
  const fs::path path = options.folder / kRecord;
  const Json wanted = record_of(options, scenes, corpus);
  // If a run failed before it made anything, its options do not matter (a wrong unit, for
  // instance).
  const bool holds_more =
      others_work || std::any_of(fs::directory_iterator(options.folder), fs::directory_iterator(),
                                 [&](const fs::directory_entry& entry) {
                                   const fs::path name = entry.path().filename();
                                   return name != kRecord && name != DatasetLock::kFile;
                                 });
  if (!fs::exists(path) || !holds_more) {
    write_file(path, wanted.dump(1) + "\n");
    return;
  }
  const Json found = read_ordered_json(path);
  if (found == wanted) return;
  throw InputError(path.string(),
                   "this data set was started with other options: " + difference(found, wanted),
                   "use the same options, or another folder");
}

void complete_dataset(const GenerationOptions& options, const SceneMaker& scenes,
                      const SpeechCorpus& corpus, const std::vector<WorkItem>& items,
                      bool others_work, GenerationSummary& summary) {
  const auto stored = stored_conversations(options.folder, scenes, items, options.write_heard);
  write_metadata(options.folder, stored);
  write_pair_lists(options.folder, items, options.seed, stored);
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
  if (others_work) return;
  remove_partial(fs::directory_iterator(options.folder));
  for (const auto& [key, conversations] : stored) {
    remove_partial(fs::directory_iterator(options.folder / key.first / key.second));
  }
  const fs::path speech_folder = options.folder / speech_folder_of(options.speech_form);
  if (fs::exists(speech_folder)) remove_partial(fs::recursive_directory_iterator(speech_folder));
}

}  // namespace earpoint
