#pragma once

#include <vector>

#include <earpoint/generate/generation.h>

namespace earpoint {

/// Makes the data set's folder and writes down in dataset.json what it is made of, or checks that
/// it was begun with the same options.
/// @throws InputError if it was not, or the folder cannot be written
void begin_dataset(const GenerationOptions& options, const SceneSource& scenes,
                   const SpeechCorpus& corpus);

/// Puts every scene's metadata together from the conversations that are there, makes sure that
/// their speech is there, and counts them. May be done by several processes at once: the last one
/// to finish leaves the metadata of all.
/// @param items    of the whole data set
/// @param summary  is added to
void complete_dataset(const GenerationOptions& options, const SceneSource& scenes,
                      const SpeechCorpus& corpus, const std::vector<WorkItem>& items,
                      GenerationSummary& summary);

}  // namespace earpoint
