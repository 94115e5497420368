#pragma once

#include <filesystem>
#include <memory>

#include <earpoint/image.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Writes an mp4 movie with binaural sound, whole or not at all: what is written before close()
/// lies aside and is removed if close() is never reached.
///
/// The sound becomes AAC with 192 kb/s (at rates below 24 kHz 8 bits a sample, near what AAC can
/// use); its encoder's delay is noted in the file, so that sample k plays at k / rate. The index
/// stands at the front, so that a browser can play while it loads.
/// Memory: blocks go to the encoder as they come; a ten-minute clip needs no more than a short one.
class MovieWriter {
 public:
  /// The picture of another movie with new sound.
  ///
  /// H.264, HEVC, AV1, VP9 and MPEG-4 pictures from mp4, mov, mkv and webm are copied as they are;
  /// others are encoded as H.264. The whole picture is kept, also where the sound is shorter.
  /// The sound's t = 0 is the source container's start, as in AudioReader.
  /// @param path    ends in .mp4, .m4v or .mov
  /// @param source  a movie; may be the same file as path
  /// @throws  InputError if the source has no picture, path cannot be written, or AAC does not know
  ///          the sample rate
  MovieWriter(const std::filesystem::path& path, const std::filesystem::path& source,
              int sample_rate_hz);

  /// A movie of pictures: H.264, 4:2:0, BT.709, near-transparent quality. Odd sizes grow by one
  /// pixel that repeats the edge.
  /// @param width, height  > 0, of every picture
  /// @param frame_rate_hz  > 0
  /// @throws  InputError as above
  MovieWriter(const std::filesystem::path& path, int width, int height, double frame_rate_hz,
              int sample_rate_hz);

  ~MovieWriter();
  MovieWriter(MovieWriter&&) noexcept;
  MovieWriter& operator=(MovieWriter&&) noexcept;

  /// Appends sound.
  /// @param block  shape [2][samples], left ear first, at the rate given to the constructor
  /// @throws  InputError if the disk is full, the source is damaged or a sample is not finite;
  ///          nothing can be written afterwards
  void write_sound(const Waveform& block);

  /// Appends a picture, shown from n / frame_rate_hz on, n counting from 0. Only for a movie of
  /// pictures. Pictures and sound may come in any order; what comes far ahead waits in memory,
  /// encoded.
  /// @param image  shape [height][width][3]
  /// @throws  InputError if the disk is full
  void write_picture(const Image& image);

  /// Finishes the movie and puts it into place. At least one sample and one picture are needed.
  /// @throws  InputError as above; nothing is left behind then
  void close();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
