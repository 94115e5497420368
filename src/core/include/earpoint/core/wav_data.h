#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace earpoint {

/// Where the samples of a WAV file (RIFF or RF64) lie, and which values of its header are valid.
/// One rule for all who read WAV files.
struct WavData {
  std::uint64_t start = 0;    ///< of the samples, bytes
  std::uint64_t claimed = 0;  ///< bytes of samples that the header promises
  std::uint64_t present = 0;  ///< bytes behind the header

  /// Whether the sound goes to the end of the file, whatever the header says: written to a pipe,
  /// the length stays 0 or a very large number, and some programs count a few bytes of the header
  /// in.
  [[nodiscard]] bool goes_to_the_end() const;
  /// Whether samples are missing.
  [[nodiscard]] bool is_cut() const { return claimed > present && !goes_to_the_end(); }
};

/// @return nothing if the file is no WAV file or has no data chunk
[[nodiscard]] std::optional<WavData> find_wav_data(const std::filesystem::path& path);

}  // namespace earpoint
