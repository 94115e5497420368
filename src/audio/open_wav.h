#pragma once

// A WAV file whose header says 0 where the length was not known. Private to the module.

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include <sndfile.h>

#include <earpoint/core/wav_data.h>

namespace earpoint {

/// Such a file as libsndfile is to see it: the lengths in its header filled in.
class OpenWav {
 public:
  OpenWav(const std::filesystem::path& path, const WavData& data);

  /// @return null if it is no sound file
  SNDFILE* open(SF_INFO& info);

 private:
  static sf_count_t length(void* self);
  static sf_count_t seek(sf_count_t offset, int whence, void* self);
  static sf_count_t read(void* target, sf_count_t count, void* self);
  static sf_count_t tell(void* self);

  struct Patch {
    std::int64_t position;
    std::array<unsigned char, 4> bytes;
  };
  std::ifstream file_;
  std::int64_t size_;
  std::int64_t position_ = 0;
  std::array<Patch, 2> patches_;
};

}  // namespace earpoint
