#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <sndfile.h>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace fs = std::filesystem;

namespace {

constexpr std::ptrdiff_t kBlockFrames = 4096;
/// From 0 to 1; transparent for speech and rooms at about 190 kbit/s in stereo.
constexpr double kVorbisQuality = 0.6;
/// From 0 (best) to 1: LAME's V2, about as many bits.
constexpr double kMp3Level = 0.2;
/// Samples in a plain WAV file: its lengths have 32 bits, and the header needs some of the 4 GB.
constexpr std::int64_t kMostWavBytes = 0xFFFFFFFFLL - 4096;

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

int subtype_of(SampleFormat format) {
  switch (format) {
    case SampleFormat::pcm16:
      return SF_FORMAT_PCM_16;
    case SampleFormat::pcm24:
      return SF_FORMAT_PCM_24;
    case SampleFormat::float32:
      return SF_FORMAT_FLOAT;
  }
  return 0;
}

int bytes_of(SampleFormat format) {
  return format == SampleFormat::pcm16 ? 2 : format == SampleFormat::pcm24 ? 3 : 4;
}

/// @return 0 for float samples
int integer_bits_of(SampleFormat format) {
  return format == SampleFormat::pcm16 ? 16 : format == SampleFormat::pcm24 ? 24 : 0;
}

/// Rounded to the nearest step (libsndfile's own conversion truncates where it clamps).
/// @return  left-justified in 32 bits
int quantize(float sample, int bits) {
  const double steps = std::ldexp(1.0, bits - 1);
  const double step = std::clamp(std::nearbyint(double{sample} * steps), -steps, steps - 1);
  return static_cast<int>(step) * (1 << (32 - bits));
}

/// @return libsndfile's format number
int format_of(const fs::path& path, SampleFormat format) {
  const std::string extension = lower_extension(path);
  if (extension == ".wav" || path == "-") return SF_FORMAT_WAV | subtype_of(format);
  if (extension == ".w64") return SF_FORMAT_W64 | subtype_of(format);
  if (extension == ".ogg") return SF_FORMAT_OGG | SF_FORMAT_VORBIS;
  if (extension == ".mp3") return SF_FORMAT_MPEG | SF_FORMAT_MPEG_LAYER_III;
  if (extension == ".flac") {
    if (format == SampleFormat::float32) {
      throw InputError(path.string(), "FLAC cannot hold 32-bit float samples",
                       "choose 16 or 24 bits, or the extension .wav");
    }
    return SF_FORMAT_FLAC | subtype_of(format);
  }
  throw InputError(path.string(),
                   fmt::format("'{}' is not a sound format that can be written", extension),
                   "use the extension .wav, .w64, .flac, .ogg or .mp3");
}

/// The file below libsndfile. It remembers the first failure, which the encoders may swallow.
struct Sink {
  int descriptor = -1;
  int error = 0;

  ~Sink() {
    if (descriptor >= 0) ::close(descriptor);
  }

  static sf_count_t length(void* user) {
    const Sink& sink = *static_cast<Sink*>(user);
    const off_t here = ::lseek(sink.descriptor, 0, SEEK_CUR);
    const off_t end = ::lseek(sink.descriptor, 0, SEEK_END);
    ::lseek(sink.descriptor, here, SEEK_SET);
    return end;
  }
  static sf_count_t seek(sf_count_t offset, int whence, void* user) {
    return ::lseek(static_cast<Sink*>(user)->descriptor, offset, whence);
  }
  static sf_count_t read(void* target, sf_count_t count, void* user) {
    return ::read(static_cast<Sink*>(user)->descriptor, target, static_cast<std::size_t>(count));
  }
  static sf_count_t write(const void* source, sf_count_t count, void* user) {
    Sink& sink = *static_cast<Sink*>(user);
    sf_count_t done = 0;
    while (done < count) {
      const ssize_t got = ::write(sink.descriptor, static_cast<const char*>(source) + done,
                                  static_cast<std::size_t>(count - done));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) {
        if (sink.error == 0) sink.error = got < 0 ? errno : ENOSPC;
        break;
      }
      done += got;
    }
    return done;
  }
  static sf_count_t tell(void* user) {
    return ::lseek(static_cast<Sink*>(user)->descriptor, 0, SEEK_CUR);
  }
};

}  // namespace

struct SoundWriter::State {
  explicit State(const fs::path& path_in) : path(path_in), target(path_in) {}
  ~State() {
    if (file != nullptr) sf_close(file);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void check_written(bool ok) const {
    if (sink.error == 0 && ok) return;
    const int error = sink.error != 0 ? sink.error : EIO;
    throw InputError(path.string(),
                     fmt::format("cannot be written ({})", std::generic_category().message(error)),
                     error == ENOSPC ? "free some space, or choose another disk" : "");
  }

  void write_some(const Waveform& block, std::ptrdiff_t start, std::ptrdiff_t frames) {
    const auto count = static_cast<std::size_t>(frames * channels);
    integers.resize(integer_bits != 0 ? count : 0);
    floats.resize(integer_bits != 0 ? 0 : count);
    for (int c = 0; c < channels; ++c) {
      const std::span<const float> channel = block.channel(c);
      for (std::ptrdiff_t i = 0; i < frames; ++i) {
        const float sample = channel[start + i];
        EARPOINT_CHECK(std::isfinite(sample));
        if (integer_bits != 0) {
          if (std::abs(sample) > 1.0F) ++clamped;
          integers[i * channels + c] = quantize(sample, integer_bits);
        } else {
          floats[i * channels + c] = sample;
        }
      }
    }
    const sf_count_t written = integer_bits != 0 ? sf_writef_int(file, integers.data(), frames)
                                                 : sf_writef_float(file, floats.data(), frames);
    check_written(written == frames);
  }

  fs::path path;
  AtomicFile target;
  Sink sink;
  SNDFILE* file = nullptr;
  int channels = 0;
  int sample_rate_hz = 0;
  int integer_bits = 0;  ///< 16 or 24; 0 for formats that take float samples
  /// Frames that the format can count.
  std::int64_t frames_left = 0;
  std::int64_t clamped = 0;
  std::vector<int> integers;
  std::vector<float> floats;
};

SoundWriter::SoundWriter(const fs::path& path, int channels, int sample_rate_hz,
                         SampleFormat format, std::int64_t expected_samples) {
  EARPOINT_CHECK(channels > 0 && sample_rate_hz > 0 && expected_samples >= 0);
  SF_INFO info{};
  info.channels = channels;
  info.samplerate = sample_rate_hz;
  info.format = format_of(path, format);
  std::int64_t most_frames = INT64_MAX;
  if ((info.format & SF_FORMAT_TYPEMASK) == SF_FORMAT_WAV) {
    // RF64 (EBU Tech 3306) is WAV with lengths of 64 bits; files that do not need them stay plain.
    const std::int64_t most_wav_frames =
        kMostWavBytes / (bytes_of(format) * std::int64_t{channels});
    if (expected_samples > most_wav_frames) {
      info.format = SF_FORMAT_RF64 | subtype_of(format);
    } else {
      most_frames = most_wav_frames;
    }
  }
  if (sf_format_check(&info) == 0) {
    throw InputError(path.string(),
                     fmt::format("{} channels at {} Hz do not fit into a {} file", channels,
                                 sample_rate_hz, lower_extension(path)),
                     "use the extension .wav");
  }
  state_ = std::make_unique<State>(path);
  State& s = *state_;
  s.channels = channels;
  s.sample_rate_hz = sample_rate_hz;
  const int subtype = info.format & SF_FORMAT_SUBMASK;
  const bool vorbis = subtype == SF_FORMAT_VORBIS;
  const bool mp3 = subtype == SF_FORMAT_MPEG_LAYER_III;
  if (!vorbis && !mp3) s.integer_bits = integer_bits_of(format);
  s.frames_left = most_frames;

  s.sink.descriptor =
      ::open(s.target.temporary_path().c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (s.sink.descriptor < 0) s.sink.error = errno;
  s.check_written(true);
  SF_VIRTUAL_IO io{Sink::length, Sink::seek, Sink::read, Sink::write, Sink::tell};
  s.file = sf_open_virtual(&io, SFM_WRITE, &info, &s.sink);
  s.check_written(s.file != nullptr);
  // No peak chunk: it holds the time of day, and equal sound must give equal bytes.
  sf_command(s.file, SFC_SET_ADD_PEAK_CHUNK, nullptr, SF_FALSE);
  double quality = kVorbisQuality;
  if (vorbis) sf_command(s.file, SFC_SET_VBR_ENCODING_QUALITY, &quality, sizeof(quality));
  if (mp3) {
    int mode = SF_BITRATE_MODE_VARIABLE;
    double level = kMp3Level;
    sf_command(s.file, SFC_SET_BITRATE_MODE, &mode, sizeof(mode));
    sf_command(s.file, SFC_SET_COMPRESSION_LEVEL, &level, sizeof(level));
  }
}
SoundWriter::~SoundWriter() = default;
SoundWriter::SoundWriter(SoundWriter&&) noexcept = default;
SoundWriter& SoundWriter::operator=(SoundWriter&&) noexcept = default;

void SoundWriter::write(const Waveform& block) {
  State& s = *state_;
  EARPOINT_CHECK(s.file != nullptr);
  if (block.empty()) return;
  EARPOINT_CHECK(block.channels() == s.channels && block.sample_rate_hz() == s.sample_rate_hz);
  s.frames_left -= block.samples();
  if (s.frames_left < 0) {
    throw InputError(s.path.string(), "a WAV file holds at most 4 GB", "use the extension .w64");
  }
  for (std::ptrdiff_t start = 0; start < block.samples(); start += kBlockFrames) {
    s.write_some(block, start, std::min(kBlockFrames, block.samples() - start));
  }
}

std::int64_t SoundWriter::clamped_samples() const { return state_->clamped; }

void SoundWriter::close() {
  State& s = *state_;
  EARPOINT_CHECK(s.file != nullptr);
  const bool closed = sf_close(std::exchange(s.file, nullptr)) == 0;
  s.check_written(closed);
  s.target.commit();
}

void write_sound(const fs::path& path, const Waveform& waveform, SampleFormat format) {
  SoundWriter writer(path, waveform.channels(), waveform.sample_rate_hz(), format,
                     waveform.samples());
  writer.write(waveform);
  writer.close();
}

}  // namespace earpoint
