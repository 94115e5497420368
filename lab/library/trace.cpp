#include <earpoint/trace.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <earpoint/core/octave_bands.h>
#include <earpoint/core/parallel.h>
#include <earpoint/error.h>
#include <earpoint/scene/import.h>
#include <earpoint/scene/mesh.h>
#include <earpoint/scene/scene.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/trace/acoustic_scene.h>
#include <earpoint/trace/response_synthesizer.h>
#include <earpoint/trace/source.h>
#include <earpoint/trace/tracer.h>

namespace earpoint {
namespace {

constexpr double kNearest_m = 1e-3;

void check_range(const char* what, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw InputError(what, fmt::format("expected {:g} to {:g}, found {:g}", least, most, value));
}

void check_request(const TraceRequest& request, const Bounds& box) {
  EARPOINT_CHECK(request.threads > 0);
  check_range("sampling rate, Hz", request.sample_rate_hz, 8000, 192000);
  check_range("duration, s", request.duration_s, 0.01, 30.0);
  check_range("rays", request.rays, 1, 100e6);
  check_inside("source", request.source.position_m, box);
  check_inside("listener", request.listener.position_m, box);
  if (norm(request.listener.position_m - request.source.position_m) < kNearest_m) {
    throw InputError("listener", "is at the position of the source", "move one of them");
  }
}

}  // namespace

struct TraceScene::State {
  State(const Scene& scene, const Vector3& origin, std::vector<std::string> lines)
      : acoustic(scene), origin_m(origin), warnings(std::move(lines)), box(bounds(scene.mesh)) {
    box = {box.low + origin_m, box.high + origin_m};
  }

  AcousticScene acoustic;
  Vector3 origin_m;  ///< of the traced scene, in the file's coordinates
  std::vector<std::string> warnings;
  Bounds box;  ///< in the file's coordinates
};

TraceScene::TraceScene(std::unique_ptr<State> state) : state_(std::move(state)) {}
TraceScene::~TraceScene() = default;
TraceScene::TraceScene(TraceScene&&) noexcept = default;
TraceScene& TraceScene::operator=(TraceScene&&) noexcept = default;

TraceScene TraceScene::open(const std::filesystem::path& model) {
  const ImportedScene imported = import_scene(model);
  return TraceScene(
      std::make_unique<State>(imported.scene, imported.origin_m, imported.report.warnings()));
}

TraceScene TraceScene::box(const Vector3& lengths_m, double absorption, double scattering) {
  EARPOINT_CHECK(lengths_m.x > 0.0 && lengths_m.y > 0.0 && lengths_m.z > 0.0);
  check_range("absorption", absorption, 0.0, 1.0);
  check_range("scattering", scattering, 0.0, 1.0);
  const Scene scene = make_shoebox(lengths_m, all_bands(static_cast<float>(absorption)),
                                   all_bands(static_cast<float>(scattering)));
  return TraceScene(std::make_unique<State>(scene, Vector3{}, std::vector<std::string>{}));
}

const std::vector<std::string>& TraceScene::warnings() const { return state_->warnings; }

Waveform TraceScene::response(const TraceRequest& request) const {
  check_request(request, state_->box);
  Source source{.world_from_source = request.source};
  if (request.talks) source.directivity = speech_directivity();
  source.world_from_source.position_m = request.source.position_m - state_->origin_m;
  const Vector3 listener_m = request.listener.position_m - state_->origin_m;
  TraceOptions options;
  options.rays = request.rays;
  options.duration_s = request.duration_s;
  options.seed = request.seed;
  ThreadPool pool(request.threads);
  const TraceResult traced = trace(state_->acoustic, {&source, 1}, {&listener_m, 1}, options, pool);
  const PointResponse& response = traced.responses[0][0];
  const ResponseSynthesizer synthesizer({.sample_rate_hz = request.sample_rate_hz,
                                         .duration_s = request.duration_s,
                                         .seed = request.seed});
  Waveform sound = request.microphone == TraceMicrophone::omni
                       ? synthesizer.mono(response, 0)
                       : synthesizer.binaural(response, request.listener.orientation,
                                              HrtfSet::load(request.sample_rate_hz), 0);
  if (std::ranges::all_of(sound.planar(), [](float sample) { return sample == 0.0F; })) {
    throw InputError("listener", "no sound reaches it",
                     "place it in the room of the source, or give a longer duration");
  }
  return sound;
}

}  // namespace earpoint
