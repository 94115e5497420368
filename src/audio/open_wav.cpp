#include "open_wav.h"

#include <algorithm>

namespace earpoint {
namespace {

std::array<unsigned char, 4> little_endian(std::uint64_t value) {
  // A length that does not fit becomes the largest one: libsndfile then reads to the end.
  value = std::min<std::uint64_t>(value, 0xFFFFFFFF);
  std::array<unsigned char, 4> bytes{};
  for (unsigned char& byte : bytes) {
    byte = static_cast<unsigned char>(value & 0xff);
    value >>= 8;
  }
  return bytes;
}

}  // namespace

OpenWav::OpenWav(const std::filesystem::path& path, const WavData& data)
    : file_(path, std::ios::binary),
      size_(static_cast<std::int64_t>(data.start + data.present)),
      patches_{{{4, little_endian(data.start + data.present - 8)},
                {static_cast<std::int64_t>(data.start) - 4, little_endian(data.present)}}} {}

SNDFILE* OpenWav::open(SF_INFO& info) {
  SF_VIRTUAL_IO io{length, seek, read, nullptr, tell};
  return sf_open_virtual(&io, SFM_READ, &info, this);
}

sf_count_t OpenWav::length(void* self) { return static_cast<OpenWav*>(self)->size_; }

sf_count_t OpenWav::tell(void* self) { return static_cast<OpenWav*>(self)->position_; }

sf_count_t OpenWav::seek(sf_count_t offset, int whence, void* self) {
  OpenWav& wav = *static_cast<OpenWav*>(self);
  const std::int64_t from = whence == SEEK_SET ? 0 : whence == SEEK_CUR ? wav.position_ : wav.size_;
  wav.position_ = std::clamp<std::int64_t>(from + offset, 0, wav.size_);
  return wav.position_;
}

sf_count_t OpenWav::read(void* target, sf_count_t count, void* self) {
  OpenWav& wav = *static_cast<OpenWav*>(self);
  wav.file_.clear();
  wav.file_.seekg(wav.position_);
  auto* const bytes = static_cast<char*>(target);
  wav.file_.read(bytes, count);
  const std::int64_t got = wav.file_.gcount();
  for (const Patch& patch : wav.patches_) {
    for (std::int64_t i = 0; i < 4; ++i) {
      const std::int64_t at = patch.position + i - wav.position_;
      if (at >= 0 && at < got) bytes[at] = static_cast<char>(patch.bytes[i]);
    }
  }
  wav.position_ += got;
  return got;
}

}  // namespace earpoint
