#pragma once

#include <vector>

#include <earpoint/generate/generation.h>

namespace earpoint {

/// Writes down in the folder's dataset.json what the set is made of, or checks that it was begun
/// with the same options.
/// @param others_work  other processes make conversations of it at this moment
/// @throws InputError if it was not, or the folder cannot be written
void begin_dataset(const GenerationOptions& options, const SceneMaker& scenes,
                   const SpeechCorpus& corpus, bool others_work);

/// Puts every scene's metadata together from the conversations that are there, makes sure that
/// their speech is there, and counts them. The last of several processes leaves the metadata of
/// all. Without others, what killed processes left half-written is removed.
/// @param items        of the whole data set
/// @param others_work  other processes make conversations of it at this moment
/// @param summary      is added to
void complete_dataset(const GenerationOptions& options, const SceneMaker& scenes,
                      const SpeechCorpus& corpus, const std::vector<WorkItem>& items,
                      bool others_work, GenerationSummary& summary);

}  // namespace earpoint
