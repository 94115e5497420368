#include "conversation_folder.h"

#include <array>
#include <system_error>

#include <fmt/format.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/atomic_folder.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kClip = "clip.json";
constexpr const char* kReport = "report.json";

std::string image_name(std::size_t viewpoint) { return fmt::format("view_{}.png", viewpoint); }

std::string response_name(std::size_t viewpoint, std::size_t speaker) {
  return fmt::format("rir_{}_{}.wav", viewpoint, speaker);
}

std::string heard_name(std::size_t viewpoint, std::size_t speaker) {
  return fmt::format("heard_{}_{}.wav", viewpoint, speaker);
}

SoundSpacesClip clip_of(const SimulatedConversation& conversation, const std::string& path,
                        const std::vector<std::string>& voices) {
  SoundSpacesClip clip;
  for (std::size_t v = 0; v < conversation.viewpoints.size(); ++v) {
    const SimulatedViewpoint& seen = conversation.viewpoints[v];
    SoundSpacesViewpoint& viewpoint = clip.viewpoints.emplace_back();
    viewpoint.location = to_soundspaces(seen.world_from_listener.position_m);
    viewpoint.rotation_rad = soundspaces_heading_rad(seen.world_from_listener.orientation);
    viewpoint.image = path + image_name(v);
    for (std::size_t s = 0; s < seen.responses.size(); ++s) {
      viewpoint.rir[static_cast<int>(s)] = path + response_name(v, s);
      viewpoint.bboxes[static_cast<int>(s)] = soundspaces_box(seen.boxes[s]);
    }
  }
  for (std::size_t s = 0; s < conversation.people.size(); ++s) {
    const Person& person = conversation.people[s];
    SoundSpacesSpeaker& speaker = clip.speakers.emplace_back();
    speaker.id = static_cast<int>(s);
    speaker.speech = voices.at(s);
    speaker.location = to_soundspaces(person.world_from_head.position_m);
    speaker.rotation_rad = soundspaces_heading_rad(person.world_from_head.orientation);
    speaker.gender = name_of(person.gender);
    speaker.figure = person.name;
  }
  return clip;
}

bool is_there(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  return !error && size > 0;
}

/// Whether every picture and sound of the clip is in the folder.
bool has_its_files(const fs::path& folder, const SoundSpacesClip& clip, bool heard) {
  for (std::size_t v = 0; v < clip.viewpoints.size(); ++v) {
    if (!is_there(folder / image_name(v))) return false;
    for (std::size_t s = 0; s < clip.speakers.size(); ++s) {
      if (!is_there(folder / response_name(v, s))) return false;
      if (heard && !is_there(folder / heard_name(v, s))) return false;
    }
  }
  return true;
}

/// @throws InputError if a file of it is missing or malformed
StoredConversation read_conversation(const fs::path& folder, const std::string& scene) {
  StoredConversation stored;
  const std::string clip_path = (folder / kClip).string();
  auto clips = parse_soundspaces_metadata(read_text_file(clip_path), clip_path, scene);
  if (clips.size() != 1) throw InputError(clip_path, "expected one clip");
  stored.clip = std::move(clips.front());
  stored.report =
      parse_conversation_report(read_text_file(folder / kReport), (folder / kReport).string());
  return stored;
}

}  // namespace

fs::path conversation_folder(const WorkItem& item, const std::string& scene) {
  return fs::path(item.split) / scene / std::to_string(item.folder);
}

void write_conversation(const fs::path& root, const WorkItem& item, const std::string& scene,
                        const std::string& prefix, const SimulatedConversation& conversation,
                        const std::vector<std::string>& voices, const ConversationReport& report) {
  const fs::path place = conversation_folder(item, scene);
  AtomicFolder folder(root / place);
  for (std::size_t v = 0; v < conversation.viewpoints.size(); ++v) {
    const SimulatedViewpoint& viewpoint = conversation.viewpoints[v];
    write_image(folder.aside() / image_name(v), viewpoint.rgb);
    for (std::size_t s = 0; s < viewpoint.responses.size(); ++s) {
      write_sound(folder.aside() / response_name(v, s), viewpoint.responses[s],
                  SampleFormat::float32);
      if (viewpoint.heard[s].empty()) continue;
      write_sound(folder.aside() / heard_name(v, s), viewpoint.heard[s], SampleFormat::float32);
    }
  }
  const std::string path = (fs::path(prefix) / place).generic_string() + "/";
  const SoundSpacesClip clip = clip_of(conversation, path, voices);
  write_file(folder.aside() / kClip, soundspaces_metadata({&clip, 1}));
  write_file(folder.aside() / kReport, json_of(report));
  folder.commit();
}

std::optional<StoredConversation> stored_conversation(const fs::path& root, const WorkItem& item,
                                                      const std::string& scene, bool heard) {
  const fs::path folder = root / conversation_folder(item, scene);
  if (!is_there(folder / kReport) || !is_there(folder / kClip)) return std::nullopt;
  try {
    StoredConversation stored = read_conversation(folder, scene);
    if (!has_its_files(folder, stored.clip, heard)) return std::nullopt;
    return stored;
  } catch (const InputError&) {
    return std::nullopt;  // simulated again, as if it were missing
  }
}

}  // namespace earpoint
