#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

#include <earpoint/waveform.h>

namespace earpoint {

/// Properties of a sound file, from its header.
struct SoundInfo {
  int channels = 0;
  int sample_rate_hz = 0;
  std::int64_t frames = 0;  ///< samples per channel
  bool is_pcm16 = false;    ///< stored as 16-bit integers
};

/// Opens a sound file just far enough to describe it. WAV, W64, FLAC, OGG and whatever else the
/// libsndfile in use can read.
/// @throws InputError if it is missing, empty, truncated, corrupt or of an unknown format
[[nodiscard]] SoundInfo probe_sound(const std::filesystem::path& path);

/// Reads a sound file block by block; integer samples are scaled to [-1, 1).
class SoundReader {
 public:
  /// @throws InputError as probe_sound
  explicit SoundReader(const std::filesystem::path& path);
  ~SoundReader();
  SoundReader(SoundReader&&) noexcept;
  SoundReader& operator=(SoundReader&&) noexcept;

  [[nodiscard]] const SoundInfo& info() const;

  /// The next samples of all channels.
  /// @param frames  how many, > 0
  /// @return  shape [channels][min(frames, what is left)]; 0 samples at the end
  /// @throws  InputError if the file ends early, is corrupt, or holds a sample that is not a finite
  ///          number (the message says which)
  [[nodiscard]] Waveform read(std::ptrdiff_t frames);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The whole file. @throws InputError as SoundReader, and if it holds no samples
[[nodiscard]] Waveform read_sound(const std::filesystem::path& path);

/// How samples are stored. FLAC holds the integer formats only; OGG (Vorbis) has no sample format
/// and ignores it.
enum class SampleFormat { pcm16, pcm24, float32 };

/// Writes a sound file block by block, aside and renamed when whole: without close() nothing is
/// left. The format follows the extension: .wav (RF64 if it is to hold over 4 GB), .w64, .flac,
/// .ogg or .mp3. Equal samples give equal bytes, except for OGG, whose streams carry a random
/// serial number.
class SoundWriter {
 public:
  /// @param channels        > 0
  /// @param sample_rate_hz  > 0
  /// @param expected_samples  about how many will be written, per channel; 0 if that is not known
  /// @throws InputError for an unknown extension, a sample format that the file format cannot hold,
  ///         or a place that cannot be written
  SoundWriter(const std::filesystem::path& path, int channels, int sample_rate_hz,
              SampleFormat format = SampleFormat::pcm24, std::int64_t expected_samples = 0);
  ~SoundWriter();
  SoundWriter(SoundWriter&&) noexcept;
  SoundWriter& operator=(SoundWriter&&) noexcept;

  /// @param block  channels and rate as given to the constructor, all samples finite. The integer
  ///               formats round to the nearest step and clamp to [-1, 1).
  /// @throws InputError if it cannot be written, e.g. on a full disk, or beyond the 4 GB of a .wav
  ///         that was not expected to hold more
  void write(const Waveform& block);

  /// How many samples the integer formats have clamped so far.
  [[nodiscard]] std::int64_t clamped_samples() const;

  /// Completes the file and puts it in place; nothing can be written afterwards.
  /// @throws InputError if that fails
  void close();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Writes a whole file by SoundWriter. @throws InputError as SoundWriter
void write_sound(const std::filesystem::path& path, const Waveform& waveform,
                 SampleFormat format = SampleFormat::pcm24);

}  // namespace earpoint
