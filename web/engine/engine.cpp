// What a page's script calls: live streams behind plain functions, for WebAssembly.
// web/engine/src/engine.ts is the other side. Nothing is thrown across: a function that fails gives
// null or a status, and earpoint_error() says why.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/image.h>
#include <earpoint/pose.h>
#include <earpoint/render/dsp_stream.h>
#include <earpoint/render/head_file.h>
#include <earpoint/render/render_stream.h>
#include <earpoint/render/stream_rates.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/synthesis/speaker_track.h>

#ifdef __EMSCRIPTEN__
#define EARPOINT_EXPORT(name) extern "C" __attribute__((export_name(#name), used))
#else
#define EARPOINT_EXPORT(name) extern "C"
#endif

using namespace earpoint;

namespace {

/// As engine.ts tells them apart.
enum Status : int { kDone = 0, kBadInput = 1, kFailure = 2 };

std::string& last_error() {
  static std::string text;
  return text;
}

/// Runs `work`; what it throws becomes a status and a text.
template <typename Work>
Status attempt(const Work& work) {
  try {
    work();
    return kDone;
  } catch (const InputError& error) {
    last_error() = error.what();
    return kBadInput;
  } catch (const std::exception& error) {
    last_error() = error.what();
    return kFailure;
  }
}

Status& last_status() {
  static Status status = kDone;
  return status;
}

/// Makes something; null if that throws.
template <typename Make>
auto made_by(const Make& make) -> decltype(make()) {
  decltype(make()) made = nullptr;
  last_status() = attempt([&] { made = make(); });
  return made;
}

/// A gtf network, or a head for the signal-processing baseline.
using Model = std::variant<GtfWeights, SofaFile>;

Model model_of(SafetensorsFile file) {
  constexpr const char* kWhere = "weights";
  if (is_head_file(file)) return read_head_file(file, kWhere);
  return gtf_weights(std::move(file), kWhere);
}

using LiveStream = std::variant<RenderStream, DspStream>;

// Rounding may take a hair off either end.
constexpr double kNarrowestViewDeg = 10.0 - 1e-9;
constexpr double kWidestViewDeg = 170.0 + 1e-9;

struct Options {
  int sample_rate_hz;
  double horizontal_fov_rad;
  int phase_rounds;  ///< negative: the network's own
  double texture;    ///< negative: the network's own
  bool extend_band;
  bool limit;
};

/// As the library's front door checks them.
void check_options(const Options& options) {
  check_stream_rate(options.sample_rate_hz);
  const double fov_deg = degrees_from_radians(options.horizontal_fov_rad);
  if (!(fov_deg > kNarrowestViewDeg && fov_deg < kWidestViewDeg)) {
    throw InputError("field of view", fmt::format("{:.3g} degrees is not a camera's", fov_deg),
                     "give degrees, from 10 to 170");
  }
  if (!(options.texture <= 1.0)) {
    throw InputError("texture", fmt::format("expected 0 to 1, found {:g}", options.texture));
  }
}

LiveStream open_stream(const GtfWeights& weights, const Options& options) {
  const int trained = weights.description.phase_rounds;
  if (options.phase_rounds > trained) {
    throw InputError("phase rounds",
                     fmt::format("expected 0 to {}, found {}", trained, options.phase_rounds));
  }
  RenderStream::Options how;
  how.sample_rate_hz = options.sample_rate_hz;
  how.horizontal_fov_rad = options.horizontal_fov_rad;
  how.extend_band = options.extend_band;
  how.limit = options.limit;
  if (options.phase_rounds >= 0) how.phase_rounds = options.phase_rounds;
  if (options.texture >= 0.0) how.texture = options.texture;
  return RenderStream(weights, how);
}

LiveStream open_stream(const SofaFile& head, const Options& options) {
  return DspStream(HrtfSet(head, options.sample_rate_hz),
                   {.horizontal_fov_rad = options.horizontal_fov_rad, .limit = options.limit});
}

/// Calls a function on the stream, whichever it is.
template <typename Call>
auto on(LiveStream& stream, const Call& call) {
  return std::visit([&](auto& of_kind) { return call(of_kind); }, stream);
}

std::optional<Box> box_of(const double* box, std::optional<std::array<int, 2>> picture) {
  if (box == nullptr) return std::nullopt;
  return SpeakerTrack(Box{box[0], box[1], box[2], box[3]}, picture).at(0.0);
}

}  // namespace

EARPOINT_EXPORT(earpoint_error) const char* earpoint_error() { return last_error().c_str(); }
/// Of the last call that gave null.
EARPOINT_EXPORT(earpoint_status) int earpoint_status() { return last_status(); }

/// @param bytes  a weight file of a gtf network, or a head file (head_file.h)
EARPOINT_EXPORT(earpoint_model_open)
Model* earpoint_model_open(const std::byte* bytes, std::size_t size) {
  return made_by([&] { return new Model(model_of(parse_safetensors({bytes, size}, "weights"))); });
}

EARPOINT_EXPORT(earpoint_model_close) void earpoint_model_close(Model* model) { delete model; }

/// The stream may outlive the model.
/// @param phase_rounds  negative: the network's own
/// @param texture       negative: the network's own
EARPOINT_EXPORT(earpoint_stream_open)
LiveStream* earpoint_stream_open(const Model* model, int sample_rate_hz, double fov_rad,
                                 int phase_rounds, double texture, bool extend_band, bool limit) {
  const Options options{sample_rate_hz, fov_rad, phase_rounds, texture, extend_band, limit};
  return made_by([&] {
    check_options(options);
    return new LiveStream(
        std::visit([&](const auto& of_kind) { return open_stream(of_kind, options); }, *model));
  });
}

EARPOINT_EXPORT(earpoint_stream_close) void earpoint_stream_close(LiveStream* stream) {
  delete stream;
}

/// @param rgb  [height][width][3]; null: no picture
/// @param box  of the speaker: x_min, y_min, x_max, y_max; null: unknown
EARPOINT_EXPORT(earpoint_stream_see)
int earpoint_stream_see(LiveStream* stream, const std::uint8_t* rgb, int width, int height,
                        const double* box) {
  return attempt([&] {
    if (rgb == nullptr) {
      const auto speaker_box = box_of(box, std::nullopt);
      on(*stream, [&](auto& of_kind) { of_kind.see(nullptr, speaker_box); });
      return;
    }
    Image picture(width, height, 3);
    std::copy_n(rgb, picture.pixels().size(), picture.pixels().begin());
    const auto speaker_box = box_of(box, std::array{width, height});
    on(*stream, [&](auto& of_kind) { of_kind.see(&picture, speaker_box); });
  });
}

/// @param mouth_m  x, y, z; null: to be located
EARPOINT_EXPORT(earpoint_stream_place_speaker)
int earpoint_stream_place_speaker(LiveStream* stream, const double* mouth_m) {
  return attempt([&] {
    std::optional<Vector3> mouth;
    if (mouth_m != nullptr) mouth = Vector3{mouth_m[0], mouth_m[1], mouth_m[2]};
    on(*stream, [&](auto& of_kind) { of_kind.place_speaker(mouth); });
  });
}

/// Metres and radians, as earpoint::Pose and EulerAngles.
EARPOINT_EXPORT(earpoint_stream_move_to)
int earpoint_stream_move_to(LiveStream* stream, double x, double y, double z, double yaw_rad,
                            double pitch_rad, double roll_rad) {
  return attempt([&] {
    const Pose pose{{x, y, z}, quaternion_from_euler({yaw_rad, pitch_rad, roll_rad})};
    on(*stream, [&](auto& of_kind) { of_kind.move_to(pose); });
  });
}

/// @param ears  [2][stride], `frames` of each are replaced by the earpoint's
EARPOINT_EXPORT(earpoint_stream_process)
int earpoint_stream_process(LiveStream* stream, float* ears, std::size_t stride,
                            std::size_t frames) {
  return attempt([&] {
    const std::span<float> left(ears, frames);
    const std::span<float> right(ears + stride, frames);
    on(*stream, [&](auto& of_kind) { of_kind.process({left, right}, {left, right}); });
  });
}

EARPOINT_EXPORT(earpoint_stream_latency) int earpoint_stream_latency(LiveStream* stream) {
  return static_cast<int>(on(*stream, [](auto& of_kind) { return of_kind.latency_samples(); }));
}

/// @param mouth_m  receives x, y, z
/// @return whether the speaker's position is known
EARPOINT_EXPORT(earpoint_stream_speaker)
bool earpoint_stream_speaker(LiveStream* stream, double* mouth_m) {
  const auto mouth = on(*stream, [](auto& of_kind) { return of_kind.speaker_m(); });
  if (mouth) {
    mouth_m[0] = mouth->x;
    mouth_m[1] = mouth->y;
    mouth_m[2] = mouth->z;
  }
  return mouth.has_value();
}

EARPOINT_EXPORT(earpoint_stream_reset) void earpoint_stream_reset(LiveStream* stream) {
  on(*stream, [](auto& of_kind) { of_kind.reset(); });
}
