#pragma once

#include <filesystem>
#include <optional>
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

/// Reads a conversation back.
/// @param heard  whether what is heard at every viewpoint belongs to it
/// @return nothing unless every file of it is there and none is empty or malformed
std::optional<StoredConversation> stored_conversation(const std::filesystem::path& root,
                                                      const WorkItem& item,
                                                      const std::string& scene, bool heard);

}  // namespace earpoint
