#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/image.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Times in this header are seconds since the container's start: the earliest beginning among its
/// pictures and sounds, encoder priming not counted. Streams that begin later keep their offset.

enum class StreamKind {
  video,
  audio,
  attached_picture,  ///< a cover: one still picture beside the sound
  other,             ///< subtitles, data
};

/// One stream of a container.
struct StreamInfo {
  int index = 0;  ///< in the container; what AudioReader's audio_stream means
  StreamKind kind = StreamKind::other;
  std::string codec;                 ///< FFmpeg's name, e.g. "h264", "aac"
  double start_s = 0.0;              ///< >= 0
  std::optional<double> duration_s;  ///< unless the container does not say
  bool is_default = false;           ///< marked as the one to choose

  // Pictures.
  int width = 0;  ///< pixels, after rotation
  int height = 0;
  double frame_rate_hz = 0.0;  ///< average; 0 if unknown or a still picture
  int rotation_deg = 0;        ///< clockwise turn that shows it upright: 0, 90, 180 or 270
  /// The camera's angle of view, if the file has lens data (Exif, QuickTime), after rotation.
  std::optional<double> horizontal_fov_rad;

  // Sound.
  int channels = 0;
  std::string channel_layout;  ///< e.g. "stereo", "5.1(side)"
  int sample_rate_hz = 0;
};

enum class MediaKind { movie, sound, picture };

struct MediaInfo {
  MediaKind kind = MediaKind::movie;
  std::string format;                ///< FFmpeg's name of the container, e.g. "matroska,webm"
  std::optional<double> duration_s;  ///< from the start to the end of the last stream
  std::vector<StreamInfo> streams;

  /// @return the stream that is read if none is named: of that kind, the first that is marked as
  ///         default, else the first; nullptr if there is none
  [[nodiscard]] const StreamInfo* preferred(StreamKind wanted) const;
};

/// What a file holds: movies (mp4, mov, mkv, webm, avi, ts), sound files (wav, w64, aiff, flac,
/// ogg, mp3, aac, m4a) and pictures (PNG, JPEG). Transport streams state no duration.
/// @throws  InputError if it is missing, none of these, or damaged so far that it does not open
[[nodiscard]] MediaInfo probe_media(const std::filesystem::path& path);

/// The pictures of a movie, by time. Made for going forward: then every frame is decoded once.
/// Memory: a few frames. Not for use from two threads at once.
class FrameReader {
 public:
  /// @throws  InputError as probe_media, or if there is no video stream
  explicit FrameReader(const std::filesystem::path& path);
  ~FrameReader();
  FrameReader(FrameReader&&) noexcept;
  FrameReader& operator=(FrameReader&&) noexcept;

  /// The frame whose presentation time is nearest, the earlier one on a tie; before the first and
  /// after the last frame, that frame. Rotation that the file asks for is applied.
  /// Going back, or forward by more than two seconds past a key frame, seeks.
  /// @param time_s  finite
  /// @return  RGB, shape [height][width][3]
  /// @throws  InputError naming stream and time if the data are damaged on the way there
  [[nodiscard]] Image frame_nearest(double time_s);

  /// Presentation time of the frame returned last. @throws std::logic_error before the first
  [[nodiscard]] double frame_time_s() const;
  /// Frames decoded so far, wanted or not: the cost so far.
  [[nodiscard]] std::int64_t frames_decoded() const;

  [[nodiscard]] const StreamInfo& info() const;
  [[nodiscard]] double frame_rate_hz() const { return info().frame_rate_hz; }
  /// From t = 0 to the end of the last frame, as the container states it (some state only that of
  /// the whole movie); if it does not, found by reading the file once.
  /// @throws  InputError if it must be read and is damaged
  [[nodiscard]] double duration_s() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The two ears' sound of a movie or sound file, from beginning to end.
///
/// Sample k is at time k / rate: a stream that starts after the container does begins with silence,
/// encoder priming is dropped, and a gap between timestamps is filled with silence. Where the clock
/// of a transport stream (mpegts, mpeg) jumped, back by more than half a second or forward by
/// more than ten, what follows is joined. Samples come as they are stored: values beyond [-1, 1],
/// NaN and silence are the caller's to judge. Memory: one block. Not for use from two threads at
/// once.
class AudioReader {
 public:
  /// @param path              movie or sound file
  /// @param binaural_channels which channels are the left and the right ear, counted from 0; needed
  ///                          unless the stream has exactly two
  /// @param audio_stream      StreamInfo::index; by default MediaInfo::preferred, or the first that
  ///                          can be decoded
  /// @throws  InputError as probe_media; if there is no (such) audio stream; if it is mono or has
  ///          more than two channels and binaural_channels is not given (the message names the
  ///          stream and asks for the channel of each ear); if it holds no sample at all
  explicit AudioReader(const std::filesystem::path& path,
                       std::optional<std::array<int, 2>> binaural_channels = std::nullopt,
                       std::optional<int> audio_stream = std::nullopt);
  ~AudioReader();
  AudioReader(AudioReader&&) noexcept;
  AudioReader& operator=(AudioReader&&) noexcept;

  [[nodiscard]] int sample_rate_hz() const;
  [[nodiscard]] const StreamInfo& info() const;
  /// What the user should know of what was read so far, each one line without the file's name: time
  /// that jumps, gaps of a second or more, another audio stream taken than the preferred one.
  [[nodiscard]] const std::vector<std::string>& warnings() const;
  /// As the container states it, from t = 0; the number of samples that read() gives may differ.
  [[nodiscard]] std::optional<double> duration_s() const;

  /// The next samples.
  /// @param frames  > 0, samples per ear
  /// @return  shape [2][frames]; fewer at the end; none after the end
  /// @throws  InputError naming stream and time if the data are damaged
  [[nodiscard]] Waveform read(std::ptrdiff_t frames);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
