#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace earpoint {

/// What a tiny data set has in each split.
struct TinyDataset {
  int clips = 2;
  int viewpoints = 3;
  double speech_s = 1.5;
  double response_s = 0.1;
  std::uint64_t seed = 1;
};

/// Test support: writes a data set in the form of `earpoint simulate` with the splits train, val
/// and test, in milliseconds and without tracing. Two people talk in noise pulses; a response is
/// the direct sound, louder at the nearer ear and falling with distance, and a short diffuse tail;
/// pictures are one colour with the speakers' boxes, and speaker 1 is out of sight at viewpoint 0.
/// Pair lists lie beside.
/// @param folder  is made
void write_tiny_dataset(const std::filesystem::path& folder, const TinyDataset& options = {});

/// The same in the form of a download of SoundSpaces-NVAS: data/synthetic_dataset/v16 and
/// data/LibriSpeech-wav (WAV files named .flac) in the folder, and no pair lists.
/// @param pcm16  the speech is stored as 16-bit integers
void write_published_dataset(const std::filesystem::path& folder, const TinyDataset& options = {},
                             bool pcm16 = false);

/// Test support: a data set in the form of Replay-NVAS, each clip of two cameras. Camera 1 stands
/// at (1, 0, 1.5) m and looks along x; camera 2 stands 1 m ahead and 2 m to the left of it, looks
/// left and hears the same noise 20 samples later. Pictures are of one colour, (200, 10, 30); the
/// speaker is seen in a box from (1/8, 1/4) to (1/2, 3/4).
/// @param folder  the root; data/appen_dataset is made in it
/// @param clips   e.g. "SC-1027/3"; the scene decides the split
void write_tiny_replay_dataset(const std::filesystem::path& folder,
                               const std::vector<std::string>& clips);

}  // namespace earpoint
