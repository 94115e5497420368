#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <sndfile.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/error.h>

namespace earpoint {
namespace fs = std::filesystem;

namespace {

constexpr std::ptrdiff_t kBlockFrames = 65536;
constexpr const char* kMendFormat = "convert it to WAV, W64, FLAC or OGG";
constexpr const char* kMendTruncated = "copy or export it again";

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
    throw InputError(path.string(), "is empty (0 bytes)", kMendTruncated);
  }
}

SoundHandle open_sound(const fs::path& path, SF_INFO& info) {
  check_is_a_file(path);
  info = {};
  SoundHandle file(sf_open(path.c_str(), SFM_READ, &info));
  if (!file) {
    const std::string reason = sf_strerror(nullptr);
    throw InputError(path.string(), "is not a sound file that can be read (" + reason + ")",
                     kMendFormat);
  }
  return file;
}

/// libsndfile shortens a sound whose file is shorter than its header says, and tells only its log.
/// Lengths that recorders write before they know better (all ones, or the largest even number of
/// 31 bits) are no mistake.
void check_data_is_whole(const fs::path& path, SNDFILE* file) {
  std::array<char, 16384> buffer{};
  sf_command(file, SFC_GET_LOG_INFO, buffer.data(), static_cast<int>(buffer.size()));
  const std::string_view log(buffer.data());
  const std::size_t mark = log.find("(should be ");
  if (mark == std::string_view::npos) return;
  const std::size_t line = log.rfind('\n', mark) + 1;
  const std::string_view text = log.substr(line, mark - line);
  if (text.find("data") == std::string_view::npos) return;
  long long claimed = 0;
  long long present = 0;
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos ||
      std::sscanf(std::string(text.substr(colon + 1)).c_str(), "%lld", &claimed) != 1 ||
      std::sscanf(std::string(log.substr(mark)).c_str(), "(should be %lld", &present) != 1) {
    return;
  }
  if (claimed <= present || claimed >= 0x7FFFF000LL) return;
  throw InputError(
      path.string(),
      fmt::format("is truncated: its header promises {} bytes of samples, {} are there", claimed,
                  present),
      kMendTruncated);
}

/// The last page of a whole Ogg stream carries a mark; without it the end is missing.
void check_ogg_ends(const fs::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(path.c_str(), "rb"),
                                                               std::fclose);
  if (!stream) throw InputError(path.string(), "cannot be opened");
  // A page has at most 65,307 bytes.
  const auto size = static_cast<long>(fs::file_size(path));
  std::vector<char> tail(static_cast<std::size_t>(std::min(size, 2 * 65307L)));
  std::fseek(stream.get(), size - static_cast<long>(tail.size()), SEEK_SET);
  tail.resize(std::fread(tail.data(), 1, tail.size(), stream.get()));
  const std::size_t page = std::string_view(tail.data(), tail.size()).rfind("OggS");
  constexpr std::size_t kFlags = 5;
  constexpr char kEndOfStream = 4;
  if (page == std::string_view::npos || page + kFlags >= tail.size() ||
      (tail[page + kFlags] & kEndOfStream) == 0) {
    throw InputError(path.string(), "is truncated: its last Ogg page is missing", kMendTruncated);
  }
}

/// For streams that do not say how long they are.
std::int64_t count_frames(const fs::path& path) {
  SF_INFO info;
  const SoundHandle file = open_sound(path, info);
  std::vector<float> block(static_cast<std::size_t>(kBlockFrames * info.channels));
  std::int64_t frames = 0;
  while (const sf_count_t got = sf_readf_float(file.get(), block.data(), kBlockFrames)) {
    frames += got;
  }
  return frames;
}

}  // namespace

struct SoundReader::State {
  fs::path path;
  SoundHandle file;
  SoundInfo info;
  std::int64_t position = 0;
  std::vector<float> interleaved;
};

SoundReader::SoundReader(const fs::path& path) : state_(std::make_unique<State>()) {
  SF_INFO info;
  state_->path = path;
  state_->file = open_sound(path, info);
  check_data_is_whole(path, state_->file.get());
  if ((info.format & SF_FORMAT_TYPEMASK) == SF_FORMAT_OGG) check_ogg_ends(path);
  if (info.channels < 1 || info.samplerate < 1) {
    throw InputError(path.string(),
                     fmt::format("has {} channels at {} Hz", info.channels, info.samplerate));
  }
  const bool unknown_length = info.frames == SF_COUNT_MAX;
  state_->info = {info.channels, info.samplerate,
                  unknown_length ? count_frames(path) : std::int64_t{info.frames}};
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
    const std::ptrdiff_t ask = std::min(kBlockFrames, wanted - done);
    s.interleaved.resize(static_cast<std::size_t>(ask * s.info.channels));
    const sf_count_t got = sf_readf_float(s.file.get(), s.interleaved.data(), ask);
    if (got <= 0 || sf_error(s.file.get()) != SF_ERR_NO_ERROR) {
      throw InputError(
          s.path.string(),
          fmt::format("is corrupt or truncated: can be read up to sample {} of {} ({})",
                      s.position + std::max<sf_count_t>(got, 0), s.info.frames,
                      sf_error(s.file.get()) != 0 ? sf_strerror(s.file.get()) : "the data ends"),
          kMendTruncated);
    }
    for (int c = 0; c < s.info.channels; ++c) {
      const std::span<float> channel = result.channel(c);
      for (std::ptrdiff_t i = 0; i < got; ++i) {
        const float sample = s.interleaved[i * s.info.channels + c];
        if (!std::isfinite(sample)) {
          throw InputError(s.path.string(),
                           fmt::format("sample {} of channel {} is not a finite number ({})",
                                       s.position + i, c, sample),
                           "export it again without such samples");
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
    Waveform block = reader.read(kBlockFrames * 16);
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
