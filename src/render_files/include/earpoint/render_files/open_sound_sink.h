#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>

#include <earpoint/render/sound_sink.h>

namespace earpoint {

/// Opens the sink that fits the output's extension: .wav (32-bit float, RF64 beyond 4 GB; also for
/// "-", standard output), .flac (24 bit), .ogg, .mp3, .w64 (32-bit float), or .mp4, .m4v, .mov and
/// .mkv with the picture of `movie`.
///
/// @param movie    the source movie; empty if the source has no moving picture
/// @param samples   that will be written, per ear
/// @param channels  2, or 1: both channels are the same, and a sound file gets one of them
/// @throws InputError if the extension is not known, the file cannot be written, or a movie is
///         asked for without one
std::unique_ptr<SoundSink> open_sound_sink(const std::filesystem::path& output, int sample_rate_hz,
                                           const std::filesystem::path& movie,
                                           std::ptrdiff_t samples, int channels = 2);

}  // namespace earpoint
