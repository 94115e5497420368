// How long homes drawn from seeds reverberate: by Eyring's formula, and traced. Writes one JSON
// object per home to standard output.
//
// usage: home_reverberation [HOMES [TRACE_EVERY]]

#include <cmath>
#include <cstdlib>
#include <optional>
#include <span>
#include <vector>

#include <fmt/core.h>

#include <earpoint/audio/butterworth.h>
#include <earpoint/audio/decay.h>
#include <earpoint/error.h>
#include <earpoint/scene/homes.h>
#include <earpoint/scene/model_pack.h>
#include <earpoint/scene/reverberation_estimate.h>
#include <earpoint/trace/response_synthesizer.h>
#include <earpoint/trace/tracer.h>

namespace {

using namespace earpoint;

constexpr double kHeadHeight_m = 1.5;
constexpr double kNearest_m = 1.0;
constexpr int kRate_hz = 16000;
constexpr double kDuration_s = 2.0;
// The octaves around 500 and 1000 Hz.
constexpr double kLow_hz = 353.6;
constexpr double kHigh_hz = 1414.2;

double middle_bands_s(const ReverberationEstimate& room) {
  return (room.eyring_s[3] + room.eyring_s[4]) / 2.0;
}

/// The mean over rooms, weighted by their volume.
double eyring_s(const std::vector<ReverberationEstimate>& rooms) {
  double sum = 0.0;
  double volume_m3 = 0.0;
  for (const ReverberationEstimate& room : rooms) {
    sum += room.volume_m3 * middle_bands_s(room);
    volume_m3 += room.volume_m3;
  }
  return sum / volume_m3;
}

int largest_room(const FloorPlan& plan) {
  int largest = 0;
  for (std::size_t i = 0; i < plan.rooms.size(); ++i) {
    if (plan.rooms[i].floor.area_m2() > plan.rooms[largest].floor.area_m2()) {
      largest = static_cast<int>(i);
    }
  }
  return largest;
}

/// A free place for a head in a room.
std::optional<Vector3> free_place(const Home& home, int room, RandomStream& random) {
  const FloorRectangle& floor = home.plan.rooms[static_cast<std::size_t>(room)].floor;
  for (int i = 0; i < 500; ++i) {
    const double x = random.uniform(floor.x_min, floor.x_max);
    const double y = random.uniform(floor.y_min, floor.y_max);
    if (is_free(home, x, y, 0.25)) return Vector3{x, y, kHeadHeight_m};
  }
  return std::nullopt;
}

/// T30 of the middle octaves between two places; nothing if a flutter echo between bare walls keeps
/// the response from falling by 35 dB within its length.
std::optional<double> traced_s(const AcousticScene& scene, const Vector3& from, const Vector3& to,
                               std::uint64_t seed, ThreadPool& pool) {
  const Source source{.world_from_source = {from, Quaternion{}}};
  const TraceResult traced =
      trace(scene, {&source, 1}, {&to, 1}, {.duration_s = kDuration_s, .seed = seed}, pool);
  const ResponseSynthesizer synthesizer(
      {.sample_rate_hz = kRate_hz, .duration_s = kDuration_s, .seed = seed});
  const Waveform mono = synthesizer.mono(traced.responses[0][0], 0);
  std::vector<double> samples(mono.channel(0).begin(), mono.channel(0).end());
  filter_zero_phase(butterworth_bandpass(kLow_hz, kHigh_hz, kRate_hz, 3), samples, samples);
  const std::vector<float> band(samples.begin(), samples.end());
  try {
    return reverberation_time_t30_s(band, kRate_hz);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

void measure(std::uint64_t seed, bool with_trace, const FurnitureLibrary& library,
             ThreadPool& pool) {
  const Home home = make_home(seed, {}, library);
  const std::vector<ReverberationEstimate> rooms = estimate_reverberation(home);
  fmt::print(R"({{"seed": {}, "models": {}, "softness": {:.3f}, "furnishing": {:.3f}, )"
             R"("rooms": {}, "area_m2": {:.1f}, "eyring_s": {:.3f})",
             seed, library.models().size(), home.softness, home.furnishing, home.plan.rooms.size(),
             home.plan.area_m2(), eyring_s(rooms));
  const int room = largest_room(home.plan);
  RandomStream random(seed);
  const auto from = with_trace ? free_place(home, room, random) : std::nullopt;
  auto to = from;
  for (int i = 0; i < 100 && to && norm(*to - *from) < kNearest_m; ++i) {
    to = free_place(home, room, random);
  }
  if (to && norm(*to - *from) >= kNearest_m) {
    const auto t30_s = traced_s(AcousticScene(home.scene), *from, *to, seed, pool);
    if (t30_s) {
      fmt::print(R"(, "room_eyring_s": {:.3f}, "room_t30_s": {:.3f})",
                 middle_bands_s(rooms[static_cast<std::size_t>(room)]), *t30_s);
    }
  }
  fmt::print("}}\n");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int homes = argc > 1 ? std::atoi(argv[1]) : 120;
  const int trace_every = argc > 2 ? std::atoi(argv[2]) : 3;
  const FurnitureLibrary library(installed_models().furniture);
  ThreadPool pool(available_cores());
  for (int seed = 0; seed < homes; ++seed) {
    measure(static_cast<std::uint64_t>(seed), trace_every > 0 && seed % trace_every == 0, library,
            pool);
  }
}
