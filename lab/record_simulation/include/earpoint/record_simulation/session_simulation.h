#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/generate/conversation.h>
#include <earpoint/generate/speech_corpus.h>
#include <earpoint/record_simulation/session_pictures.h>
#include <earpoint/record_simulation/session_plan.h>
#include <earpoint/record_simulation/session_speech.h>
#include <earpoint/scene/furniture.h>
#include <earpoint/scene/people.h>

namespace earpoint {

/// What sessions are simulated.
struct SessionSimulationOptions {
  std::filesystem::path
      folder;  ///< of the session; with several, of their folders; made if missing
  std::uint64_t seed = 1;
  int scenarios = 1;                   ///< several are split 90 : 10 : 20 into train, val and test
  DataSplit split = DataSplit::train;  ///< of a single one: whose voices and figures
  SessionOptions session;
  SessionSoundQuality sound;
  SessionPictureQuality picture;
  double snr_db = 20.0;  ///< speech at the cameras over ambient noise; infinite: no noise
  int jobs = 1;          ///< threads, > 0; has no effect on what is written
};

/// @return the folder of one of them: the folder itself if it is alone, else scenario-0000, ...
std::filesystem::path session_folder(const SessionSimulationOptions& options, int scenario);

/// A furnished flat that has room for a ring of cameras: the first of the homes drawn from the seed
/// in which all stand 1.9 m or more from the middle, else the roomiest of eight.
/// @param cameras  in the ring
std::shared_ptr<const PreparedScene> draw_flat(std::uint64_t seed, const FurnitureLibrary& library,
                                               int cameras);

/// Simulates sessions of a conversation in one scene, as real ones are recorded: docs/formats.md,
/// "Simulated sessions". Every session has its own people, voices, cameras and clocks.
///
/// Files appear when they are whole, session.json last. A run that is started again with the same
/// options goes on where the last one ended: with the sessions, the sound or the pictures that are
/// missing.
/// @return the sessions, by their session.json
/// @throws InputError if the folder was begun with other options, the scene has no room, the corpus
///         too few voices, or the disk is full
std::vector<std::filesystem::path> simulate_sessions(const SessionSimulationOptions& options,
                                                     const PreparedScene& scene,
                                                     const FigureLibrary& figures,
                                                     const SpeechCorpus& corpus,
                                                     ProgressSink& progress);

}  // namespace earpoint
