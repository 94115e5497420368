#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <earpoint/dataset/soundspaces_metadata.h>
#include <earpoint/generate/conversation.h>
#include <earpoint/generate/generation_summary.h>
#include <earpoint/generate/work_plan.h>

namespace earpoint {

/// A finished conversation as its folder holds it.
struct StoredConversation {
  SoundSpacesClip clip;
  ConversationReport report;
};

/// @return where a conversation lies, below the data set's root: split/scene/number
std::filesystem::path conversation_folder(const WorkItem& item, const std::string& scene);

/// Writes pictures, responses, clip.json and report.json into a folder aside and renames it when it
/// is whole and flushed.
/// @param root    of the data set
/// @param prefix  before the paths in the clip; may be empty
/// @param voices  ids of the speakers' recordings
void write_conversation(const std::filesystem::path& root, const WorkItem& item,
                        const std::string& scene, const std::string& prefix,
                        const SimulatedConversation& conversation,
                        const std::vector<std::string>& voices, const ConversationReport& report);

/// @return whether the conversation is there, whole
bool is_stored(const std::filesystem::path& root, const WorkItem& item, const std::string& scene);

/// @throws InputError if a file of it is missing or malformed
StoredConversation read_conversation(const std::filesystem::path& root, const WorkItem& item,
                                     const std::string& scene);

}  // namespace earpoint
