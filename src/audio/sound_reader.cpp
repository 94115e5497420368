#include "open_wav.h"
#include "sound_container.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <sndfile.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/wav_data.h>
#include <earpoint/error.h>

namespace earpoint {
namespace fs = std::filesystem;

namespace {

/// Samples of all channels that are decoded at a time.
constexpr std::ptrdiff_t kBlockSamples = 1 << 18;
constexpr const char* kHintFormat = "convert it to WAV, W64, FLAC or OGG";
constexpr const char* kHintTruncated = "copy or export it again";

struct CloseSound {
  void operator()(SNDFILE* file) const { sf_close(file); }
};
using SoundHandle = std::unique_ptr<SNDFILE, CloseSound>;

void check_is_a_file(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw InputError(path.string(), "no such file");
  if (!fs::is_regular_file(status)) throw InputError(path.string(), "is not a file");
  if (fs::file_size(path, error) == 0) {
    throw InputError(path.string(), "is empty (0 bytes)", kHintTruncated);
  }
}

SoundHandle open_sound(const fs::path& path, SF_INFO& info) {
  check_is_a_file(path);
  info = {};
  SoundHandle file(sf_open(path.c_str(), SFM_READ, &info));
  if (!file) {
    const std::string reason = sf_strerror(nullptr);
    throw InputError(path.string(), "is not a readable sound file (" + reason + ")", kHintFormat);
  }
  return file;
}

/// For streams that do not say how long they are.
std::int64_t count_frames(const fs::path& path) {
  SF_INFO info;
  const SoundHandle file = open_sound(path, info);
  const std::ptrdiff_t block_frames = kBlockSamples / info.channels;
  std::vector<float> block(static_cast<std::size_t>(block_frames * info.channels));
  std::int64_t frames = 0;
  while (const sf_count_t got = sf_readf_float(file.get(), block.data(), block_frames)) {
    frames += got;
  }
  return frames;
}

}  // namespace

struct SoundReader::State {
  fs::path path;
  std::optional<OpenWav> open_wav;  ///< what `file` reads from, if its header gives no length
  SoundHandle file;
  SoundInfo info;
  std::int64_t position = 0;
  std::vector<float> interleaved;
};

SoundReader::SoundReader(const fs::path& path) : state_(std::make_unique<State>()) {
  SF_INFO info;
  state_->path = path;
  state_->file = open_sound(path, info);
  check_container_is_whole(path);
  if (const auto wav = find_wav_data(path); wav && wav->claimed == 0 && wav->goes_to_the_end()) {
    state_->open_wav.emplace(path, *wav);
    info = {};
    SoundHandle file(state_->open_wav->open(info));
    if (file) state_->file = std::move(file);
  }
  if (info.channels < 1 || info.samplerate < 1) {
    throw InputError(path.string(),
                     fmt::format("has {} channels at {} Hz", info.channels, info.samplerate));
  }
  const bool unknown_length = info.frames == SF_COUNT_MAX;
  state_->info = {info.channels, info.samplerate,
                  unknown_length ? count_frames(path) : std::int64_t{info.frames},
                  (info.format & SF_FORMAT_SUBMASK) == SF_FORMAT_PCM_16};
}
SoundReader::~SoundReader() = default;
SoundReader::SoundReader(SoundReader&&) noexcept = default;
SoundReader& SoundReader::operator=(SoundReader&&) noexcept = default;

const SoundInfo& SoundReader::info() const { return state_->info; }

Waveform SoundReader::read(std::ptrdiff_t frames) {
  EARPOINT_CHECK(frames > 0);
  State& s = *state_;
  const auto wanted =
      static_cast<std::ptrdiff_t>(std::min<std::int64_t>(frames, s.info.frames - s.position));
  Waveform result(s.info.channels, wanted, s.info.sample_rate_hz);
  for (std::ptrdiff_t done = 0; done < wanted;) {
    const std::ptrdiff_t ask = std::min(kBlockSamples / s.info.channels, wanted - done);
    s.interleaved.resize(static_cast<std::size_t>(ask * s.info.channels));
    const sf_count_t got = sf_readf_float(s.file.get(), s.interleaved.data(), ask);
    if (got <= 0 || sf_error(s.file.get()) != SF_ERR_NO_ERROR) {
      throw InputError(
          s.path.string(),
          fmt::format("is corrupt or truncated: can be read up to sample {} of {} ({})",
                      s.position + std::max<sf_count_t>(got, 0), s.info.frames,
                      sf_error(s.file.get()) != 0 ? sf_strerror(s.file.get()) : "the data ends"),
          kHintTruncated);
    }
    for (int c = 0; c < s.info.channels; ++c) {
      const std::span<float> channel = result.channel(c);
      for (std::ptrdiff_t i = 0; i < got; ++i) {
        const float sample = s.interleaved[i * s.info.channels + c];
        if (!std::isfinite(sample)) {
          throw InputError(s.path.string(),
                           fmt::format("sample {} of channel {} is not a finite number ({})",
                                       s.position + i, c, sample),
                           "export it again without them");
        }
        channel[done + i] = sample;
      }
    }
    done += got;
    s.position += got;
  }
  return result;
}

SoundInfo probe_sound(const fs::path& path) { return SoundReader(path).info(); }

Waveform read_sound(const fs::path& path) {
  SoundReader reader(path);
  const SoundInfo info = reader.info();
  if (info.frames == 0) throw InputError(path.string(), "holds no samples");
  // A corrupt header may promise far more than there is: memory is taken as samples arrive.
  std::vector<Waveform> blocks;
  for (;;) {
    Waveform block = reader.read(kBlockSamples * 16 / info.channels);
    if (block.empty()) break;
    blocks.push_back(std::move(block));
  }
  if (blocks.size() == 1) return std::move(blocks.front());
  Waveform whole(info.channels, info.frames, info.sample_rate_hz);
  std::ptrdiff_t start = 0;
  for (Waveform& block : blocks) {
    for (int c = 0; c < info.channels; ++c) {
      std::ranges::copy(block.channel(c), whole.channel(c).begin() + start);
    }
    start += block.samples();
    block = Waveform();
  }
  return whole;
}

}  // namespace earpoint
