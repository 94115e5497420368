#include <earpoint/generate/conversation.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/decay.h>
#include <earpoint/error.h>
#include <earpoint/spatial/air_absorption.h>
#include <earpoint/trace/tracer.h>

namespace earpoint {
namespace {

// A person with fewer visible pixels gets no box: 8 x 8 of 256 x 256.
constexpr int kLeastPixels = 64;
constexpr double kBeforeArrival_s = 0.002;

std::array<Source, 2> mouths(const std::array<Person, 2>& people) {
  std::array<Source, 2> sources;
  for (std::size_t i = 0; i < 2; ++i) {
    sources[i].world_from_source = people[i].world_from_head;
    sources[i].directivity = speech_directivity();
    sources[i].body = people[i].instance;
  }
  return sources;
}

/// trace() on this thread alone; errors name the scene.
TraceResult trace_scene(const std::string& name, const AcousticScene& scene,
                        std::span<const Source> sources, std::span<const Vector3> listeners,
                        const TraceOptions& options) {
  ThreadPool pool(1);
  try {
    return trace(scene, sources, listeners, options, pool);
  } catch (const InputError& error) {
    throw InputError("scene '" + name + "'", error.what(),
                     "if its ceiling is missing, close the ceiling");
  }
}

std::optional<double> reverberation_of(const Waveform& response) {
  try {
    return reverberation_time_t20_s(response.channel(0), response.sample_rate_hz());
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// Moves a scene so that its floor lies at height 0, where people are put.
Scene on_the_floor(Scene scene) {
  const double floor_m = FloorMap(scene, RayCaster(scene.mesh)).floor_m();
  for (auto& position : scene.mesh.positions) position[2] -= static_cast<float>(floor_m);
  for (Lamp& lamp : scene.lamps) lamp.position_m.z -= floor_m;
  return scene;
}

}  // namespace

PreparedScene::PreparedScene(std::string scene_name, Scene scene_on_the_floor)
    : name(std::move(scene_name)),
      scene(std::move(scene_on_the_floor)),
      caster(scene.mesh),
      floor(scene, caster),
      drawer(scene) {}

std::shared_ptr<const PreparedScene> prepare_home(std::string name, Scene scene) {
  return std::make_shared<const PreparedScene>(std::move(name), std::move(scene));
}

std::shared_ptr<const PreparedScene> prepare_scan(std::string name, Scene scene) {
  return std::make_shared<const PreparedScene>(std::move(name), on_the_floor(std::move(scene)));
}

ConversationSimulator::ConversationSimulator(const ConversationQuality& quality)
    : quality_(quality),
      hrtf_(HrtfSet::load(quality.sample_rate_hz)),
      synthesizer_({.sample_rate_hz = quality.sample_rate_hz, .duration_s = quality.duration_s}) {}

SimulatedConversation ConversationSimulator::simulate(const PreparedScene& prepared,
                                                      const ConversationPlan& plan,
                                                      std::uint64_t seed, StageClock& clock) const {
  SimulatedConversation result;
  Scene scene = prepared.scene;
  for (std::size_t i = 0; i < 2; ++i) {
    const PlannedPerson& person = plan.people[i];
    result.people[i] = add_person(*person.figure, person.at.x, person.at.y, person.yaw_rad, scene);
  }
  for (const Pose& viewpoint : plan.viewpoints) {
    result.viewpoints.emplace_back().world_from_listener = viewpoint;
  }
  hear(prepared.name, scene, seed, result, clock);
  ThreadPool pool(1);
  const SceneDrawer camera = prepared.drawer.extended(scene, pool);
  clock.charge(Stage::light);
  see(camera, seed, result);
  clock.charge(Stage::pictures);
  return result;
}

void ConversationSimulator::hear(const std::string& name, const Scene& scene, std::uint64_t seed,
                                 SimulatedConversation& conversation, StageClock& clock) const {
  std::vector<Vector3> listeners;
  for (const SimulatedViewpoint& viewpoint : conversation.viewpoints) {
    listeners.push_back(viewpoint.world_from_listener.position_m);
  }
  const AcousticScene acoustics(scene);
  clock.charge(Stage::acoustics);
  const TraceResult traced =
      trace_scene(name, acoustics, mouths(conversation.people), listeners,
                  {.rays = quality_.rays, .duration_s = quality_.duration_s, .seed = seed});
  clock.charge(Stage::trace);
  for (std::size_t i = 0; i < 2; ++i) {
    conversation.escape_fractions[i] = traced.escape_fraction[i];
    for (std::size_t v = 0; v < listeners.size(); ++v) {
      const PointResponse& response = traced.responses[i][v];
      SimulatedViewpoint& viewpoint = conversation.viewpoints[v];
      // The noise of a tail must not repeat elsewhere, or a network could learn it.
      viewpoint.responses[i] = synthesizer_.binaural(
          response, viewpoint.world_from_listener.orientation, hrtf_, seed + 2 * v + i);
      silence_before_arrival(viewpoint.responses[i], response.distance_m);
    }
  }
  conversation.reverberation_s = reverberation_of(synthesizer_.mono(traced.responses[0][0], seed));
  clock.charge(Stage::responses);
}

void ConversationSimulator::see(const SceneDrawer& camera, std::uint64_t seed,
                                SimulatedConversation& conversation) const {
  ThreadPool pool(1);
  for (std::size_t v = 0; v < conversation.viewpoints.size(); ++v) {
    SimulatedViewpoint& viewpoint = conversation.viewpoints[v];
    View view = camera.draw({.world_from_camera = viewpoint.world_from_listener,
                             .horizontal_fov_rad = quality_.horizontal_fov_rad,
                             .width = quality_.image_width,
                             .height = quality_.image_height},
                            {.samples_per_side = quality_.samples_per_side}, seed + v, pool);
    for (std::size_t i = 0; i < 2; ++i) {
      viewpoint.boxes[i] =
          visible_box(view, static_cast<int>(conversation.people[i].instance), kLeastPixels);
    }
    viewpoint.rgb = std::move(view.rgb);
    viewpoint.depth_m = std::move(view.depth_m);
  }
}

Waveform heard_speech(const Waveform& speech, const Waveform& response) {
  EARPOINT_CHECK(speech.sample_rate_hz() == response.sample_rate_hz());
  Waveform heard(response.channels(), speech.samples() + response.samples() - 1,
                 response.sample_rate_hz());
  for (int ear = 0; ear < response.channels(); ++ear) {
    std::ranges::copy(convolve(speech.channel(0), response.channel(ear)),
                      heard.channel(ear).begin());
  }
  return heard;
}

void silence_before_arrival(Waveform& response, double distance_m) {
  const double arrival_s = distance_m / speed_of_sound_m_per_s(Air{}) - kBeforeArrival_s;
  const auto silent = std::clamp<std::ptrdiff_t>(
      static_cast<std::ptrdiff_t>(std::floor(arrival_s * response.sample_rate_hz())), 0,
      response.samples());
  for (int ear = 0; ear < response.channels(); ++ear) {
    std::fill_n(response.channel(ear).begin(), silent, 0.0F);
  }
}

}  // namespace earpoint
