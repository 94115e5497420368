#include "convert.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/version.h>

namespace earpoint::c_api {
namespace {

// Sizes in version 0.1. They never change: later members come after these and after the padding
// behind them, which old callers leave undefined.
constexpr std::size_t kFirstRendererOptions_bytes =
    offsetof(earpoint_renderer_options, threads) + sizeof(int);
constexpr std::size_t kFirstRequest_bytes = offsetof(earpoint_request, no_limiter) + sizeof(int);
constexpr std::size_t kFirstStreamOptions_bytes =
    offsetof(earpoint_stream_options, phase_rounds) + sizeof(const int*);

/// What a double holds after rounding to float, and no more.
constexpr double kUnitLengthTolerance = 1e-6;
/// As large as cameras and file formats go; keeps products of sizes within 64 bits.
constexpr int kMostPixelsPerSide = 65535;

}  // namespace

void check_struct_size(const void* bytes, std::size_t size, std::size_t smallest, std::size_t known,
                       const char* name) {
  if (size < smallest) {
    throw UsageError(std::string(name) + ".struct_size",
                     fmt::format("expected {} or more (sizeof), found {}", smallest, size));
  }
  const auto* const all = static_cast<const unsigned char*>(bytes);
  for (std::size_t i = known; i < size; ++i) {
    if (all[i] == 0) continue;
    throw InputError(
        name,
        fmt::format("sets members that version {} of the library does not know", library_version()),
        "install the version that the program was compiled with");
  }
}

Pose pose_from(const earpoint_pose& pose, const char* name) {
  const earpoint_quaternion& q = pose.orientation;
  const Vector3 position_m{pose.position_m.x, pose.position_m.y, pose.position_m.z};
  if (q.w == 0.0 && q.x == 0.0 && q.y == 0.0 && q.z == 0.0) return {position_m, {}};
  const double length = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  if (!(std::abs(length - 1.0) <= kUnitLengthTolerance)) {
    throw InputError(std::string(name) + ".orientation",
                     fmt::format("expected a unit quaternion, found one of length {:g}", length));
  }
  return {position_m, {q.w, q.x, q.y, q.z}};
}

Image image_from(const earpoint_picture& picture) {
  not_null(picture.rgb, "picture.rgb");
  for (const int side : {picture.width, picture.height}) {
    if (side > 0 && side <= kMostPixelsPerSide) continue;
    throw UsageError("picture",
                     fmt::format("expected a width and height from 1 to {}, found {} x {}",
                                 kMostPixelsPerSide, picture.width, picture.height));
  }
  const std::size_t row_bytes = std::size_t{3} * static_cast<std::size_t>(picture.width);
  const std::size_t stride = picture.row_bytes == 0 ? row_bytes : picture.row_bytes;
  if (stride < row_bytes) {
    throw UsageError("picture.row_bytes",
                     fmt::format("expected {} (3 * width) or more, found {}", row_bytes, stride));
  }
  Image image(picture.width, picture.height, 3);
  for (int y = 0; y < picture.height; ++y) {
    std::copy_n(picture.rgb + stride * y, row_bytes, &image.at(0, y));
  }
  return image;
}

Waveform waveform_from(const earpoint_sound& sound) {
  if (sound.channel_count != 1 && sound.channel_count != 2) {
    throw UsageError("sound.channel_count",
                     fmt::format("expected 1 or 2, found {}", sound.channel_count));
  }
  constexpr std::size_t kMostFrames =
      std::numeric_limits<std::ptrdiff_t>::max() / (2 * sizeof(float));
  if (sound.frames > kMostFrames) {
    throw UsageError("sound.frames", fmt::format("{} is more than memory holds", sound.frames));
  }
  if (sound.sample_rate_hz <= 0) {
    throw UsageError("sound.sample_rate_hz",
                     fmt::format("expected a positive number, found {}", sound.sample_rate_hz));
  }
  not_null(sound.channels, "sound.channels");
  Waveform waveform(sound.channel_count, static_cast<std::ptrdiff_t>(sound.frames),
                    sound.sample_rate_hz);
  for (int channel = 0; channel < sound.channel_count; ++channel) {
    const float* samples = not_null(sound.channels[channel], "a channel of the sound");
    std::copy_n(samples, sound.frames, waveform.channel(channel).begin());
  }
  return waveform;
}

std::optional<Box> box_from(const earpoint_box* box) {
  if (box == nullptr) return std::nullopt;
  return Box{box->x_min, box->y_min, box->x_max, box->y_max};
}

std::optional<Vector3> vector_from(const earpoint_vector3* vector) {
  if (vector == nullptr) return std::nullopt;
  return Vector3{vector->x, vector->y, vector->z};
}

RendererOptions renderer_options_from(const earpoint_renderer_options* options) {
  const auto known = read_options(options, kFirstRendererOptions_bytes, "options");
  RendererOptions result;
  if (known.horizontal_fov_rad != 0.0) result.horizontal_fov_rad = known.horizontal_fov_rad;
  if (known.texture != nullptr) result.texture = *known.texture;
  if (known.hrtf != nullptr) result.hrtf = known.hrtf;
  if (known.threads < 0) {
    throw UsageError("options.threads", fmt::format("expected 0 or more, found {}", known.threads));
  }
  if (known.threads > 0) result.threads = known.threads;
  return result;
}

StreamOptions stream_options_from(const earpoint_stream_options* options) {
  const auto known = read_options(options, kFirstStreamOptions_bytes, "options");
  StreamOptions result;
  if (known.sample_rate_hz != 0) result.sample_rate_hz = known.sample_rate_hz;
  result.extend_band = known.no_band_extension == 0;
  result.limit = known.no_limiter == 0;
  if (known.phase_rounds != nullptr) result.phase_rounds = *known.phase_rounds;
  return result;
}

Request::Request(const earpoint_request* request) {
  const auto known = read_options(request, kFirstRequest_bytes, "request");
  if (known.picture != nullptr) {
    picture = image_from(*known.picture);
    contents.picture = &picture;
  }
  contents.speaker_box = box_from(known.speaker_box);
  contents.speaker_m = vector_from(known.speaker_m);
  contents.target = pose_from(known.target, "target");
  if (known.path_count > 0) not_null(known.path, "request.path");
  for (std::size_t i = 0; i < known.path_count; ++i) {
    contents.path.push_back(
        {known.path[i].time_s, pose_from(known.path[i].source_from_target,
                                         fmt::format("path, point {}", i + 1).c_str())});
  }
  contents.gain_db = known.gain_db;
  contents.extend_band = known.no_band_extension == 0;
  contents.limit = known.no_limiter == 0;
}

}  // namespace earpoint::c_api
