// The cost of tracing: rays per second against a bare Embree loop on the same mesh in the same run,
// the core-seconds of one binaural response of a conversation, and the growth of the cost with
// triangles, rays and pairs. Prints JSON to standard output; `--plot FILE` draws the growth.
//
// usage: trace_bench [--quick] [--plot cost.png]
//   --quick  leaves out the growth

#include "bare_rays.h"
#include "cost_plot.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/parallel.h>
#include <earpoint/core/random.h>
#include <earpoint/scene/homes.h>
#include <earpoint/scene/model_pack.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/trace/response_synthesizer.h>
#include <earpoint/trace/tracer.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 16000;
constexpr int kSources = 2;    // the two people of a conversation
constexpr int kListeners = 4;  // its viewpoints
constexpr int kRuns = 5;       // medians

double core_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// A home and places to stand in it.
struct BenchStage {
  Home home;
  std::vector<Source> sources;
  std::vector<Vector3> listeners;
};

BenchStage make_stage(std::uint64_t seed, std::size_t most_triangles,
                      const FurnitureLibrary& library, int sources, int listeners) {
  HomeOptions options;
  options.furnishing = 1.0;
  options.softness = 0.5;
  options.most_triangles = most_triangles;
  BenchStage stage{.home = make_home(seed, options, library), .sources = {}, .listeners = {}};
  const Bounds box = bounds(stage.home.scene.mesh);
  RandomStream random(seed, {99});
  // A conversation stands in one room, with some of its listeners around a corner.
  std::vector<Vector3> places;
  while (std::ssize(places) < sources + listeners) {
    const double x = random.uniform(box.low.x, box.high.x);
    const double y = random.uniform(box.low.y, box.high.y);
    if (!is_free(stage.home, x, y, 0.3)) continue;
    if (!places.empty() && std::hypot(x - places[0].x, y - places[0].y) > 4.0) continue;
    places.push_back({x, y, 1.5});
  }
  for (int i = 0; i < sources; ++i) {
    Source source{.world_from_source = {.position_m = places[i], .orientation = {}}};
    source.directivity = speech_directivity();
    stage.sources.push_back(source);
  }
  stage.listeners.assign(places.begin() + sources, places.end());
  return stage;
}

struct Cost {
  double build_s = 0.0;   ///< of the acoustic scene, once per home
  double trace_s = 0.0;   ///< all pairs
  double render_s = 0.0;  ///< all pairs
  std::int64_t rays = 0;
  std::size_t triangles = 0;
};

Cost measure(const BenchStage& stage, const TraceOptions& options,
             const ResponseSynthesizer& synthesizer, const HrtfSet& hrtf, int runs) {
  ThreadPool pool(1);
  Cost cost;
  std::vector<double> builds;
  std::vector<double> traces;
  std::vector<double> renders;
  for (int run = 0; run < runs; ++run) {
    const double start = core_seconds();
    const AcousticScene scene(stage.home.scene);
    const double built = core_seconds();
    const TraceResult traced = trace(scene, stage.sources, stage.listeners, options, pool);
    const double done = core_seconds();
    std::uint64_t stream = 0;
    for (const auto& of_source : traced.responses) {
      for (const PointResponse& response : of_source) {
        const Waveform brir = synthesizer.binaural(response, Quaternion{}, hrtf, stream++);
        if (brir.samples() == 0) std::abort();
      }
    }
    renders.push_back(core_seconds() - done);
    traces.push_back(done - built);
    builds.push_back(built - start);
    cost.rays = traced.rays_cast;
  }
  cost.build_s = median(builds);
  cost.trace_s = median(traces);
  cost.render_s = median(renders);
  cost.triangles = stage.home.scene.mesh.triangles.size();
  return cost;
}

nlohmann::json to_json(const Cost& cost, int rays, int pairs) {
  return {{"triangles", cost.triangles},
          {"rays", rays},
          {"pairs", pairs},
          {"core_s_per_pair", (cost.trace_s + cost.render_s) / pairs},
          {"trace_s", cost.trace_s},
          {"render_s", cost.render_s},
          {"build_s", cost.build_s},
          {"rays_cast", cost.rays}};
}

void measure_growth(const BenchStage& stage, std::uint64_t seed, const FurnitureLibrary& library,
                    const TraceOptions& options, const ResponseSynthesizer& synthesizer,
                    const HrtfSet& hrtf, nlohmann::json& report) {
  constexpr int kPairs = kSources * kListeners;
  for (const std::size_t most : {5000, 10000, 20000, 40000}) {
    const BenchStage other = make_stage(seed, most, library, kSources, kListeners);
    report["over_triangles"].push_back(
        to_json(measure(other, options, synthesizer, hrtf, 3), options.rays, kPairs));
  }
  for (const int rays : {1000, 2000, 5000, 10000, 20000, 50000}) {
    TraceOptions more = options;
    more.rays = rays;
    report["over_rays"].push_back(
        to_json(measure(stage, more, synthesizer, hrtf, 3), rays, kPairs));
  }
  for (const int listeners : {1, 2, 4, 8, 16}) {
    const BenchStage other = make_stage(seed, 60000, library, kSources, listeners);
    report["over_pairs"].push_back(
        to_json(measure(other, options, synthesizer, hrtf, 3), options.rays, kSources * listeners));
  }
}

}  // namespace
}  // namespace earpoint

int main(int argc, char** argv) {
  using namespace earpoint;
  const FurnitureLibrary library(installed_models().furniture);
  const HrtfSet hrtf = HrtfSet::load(kRate_hz);
  const ResponseSynthesizer synthesizer({.sample_rate_hz = kRate_hz});
  const TraceOptions options{.rays = 5000, .max_bounces = 60};

  // The home of the claim: the first one with enough triangles.
  constexpr std::size_t kLeastTriangles = 20000;
  std::uint64_t seed = 1;
  BenchStage stage = make_stage(seed, 60000, library, kSources, kListeners);
  while (stage.home.scene.mesh.triangles.size() < kLeastTriangles) {
    stage = make_stage(++seed, 60000, library, kSources, kListeners);
  }
  nlohmann::json report;
  const double bare =
      bare_rays_per_s(stage.home.scene.mesh, stage.sources[0].world_from_source.position_m);
  const Cost cost = measure(stage, options, synthesizer, hrtf, kRuns);
  const double bare_again =
      bare_rays_per_s(stage.home.scene.mesh, stage.sources[0].world_from_source.position_m);
  constexpr int kPairs = kSources * kListeners;
  report["home"] = to_json(cost, options.rays, kPairs);
  report["home"]["seed"] = seed;
  report["bare_rays_per_s"] = std::max(bare, bare_again);
  report["rays_per_s"] = static_cast<double>(cost.rays) / (cost.trace_s + cost.render_s);

  if (argc == 2 && std::strcmp(argv[1], "--quick") == 0) {
    fmt::print("{}\n", report.dump(2));
    return 0;
  }
  measure_growth(stage, seed, library, options, synthesizer, hrtf, report);
  fmt::print("{}\n", report.dump(2));
  if (argc == 3 && std::strcmp(argv[1], "--plot") == 0) draw_costs(report, argv[2]);
  return 0;
}
