// How fast views of conversations in homes are rendered on one core. Writes one JSON object per
// kind of home to standard output.
//
// usage: camera_bench [HOMES]

#include "conversation_views.h"

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>

#include <fmt/core.h>

#include <earpoint/camera/scene_drawer.h>
#include <earpoint/error.h>
#include <earpoint/scene/model_pack.h>

namespace {

using namespace earpoint;

constexpr int kViews = 4;           // of a conversation
constexpr int kConversations = 10;  // that share a home
constexpr int kMeasured = 2;        // conversations per home here
constexpr int kPixels = 256;

double processor_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Sums over homes, seconds of processor time.
struct Times {
  int homes = 0;
  int conversations = 0;
  int views = 0;
  double triangles = 0.0;
  double patches = 0.0;
  double make_home = 0.0;
  double home_light = 0.0;
  double people_light = 0.0;
  double draw = 0.0;
};

template <typename Body>
auto timed(double& sum, Body&& body) {
  const double start = processor_s();
  auto result = body();
  sum += processor_s() - start;
  return result;
}

void measure(std::uint64_t seed, std::size_t most_triangles, const FurnitureLibrary& furniture,
             const FigureLibrary& figures, Times& times) {
  RandomStream random(seed);
  const Home home = timed(times.make_home, [&] {
    return make_home(seed, {.most_triangles = most_triangles}, furniture);
  });
  const SceneDrawer empty = timed(times.home_light, [&] { return SceneDrawer(home.scene); });
  ++times.homes;
  for (int i = 0; i < kMeasured; ++i) {
    const bench::ConversationViews conversation =
        bench::draw_conversation(home, figures, kViews, kPixels, kPixels, random);
    const SceneDrawer drawer =
        timed(times.people_light, [&] { return empty.extended(conversation.scene); });
    ++times.conversations;
    times.triangles += static_cast<double>(conversation.scene.mesh.triangles.size());
    times.patches += static_cast<double>(drawer.patches());
    for (const Camera& camera : conversation.cameras) {
      timed(times.draw, [&] { return drawer.draw(camera, {}, seed); });
      ++times.views;
    }
  }
}

void report(const char* name, const Times& times) {
  const double view_s = times.draw / times.views;
  const double people_s = times.people_light / times.conversations / kViews;
  const double home_s = times.home_light / times.homes / (kViews * kConversations);
  fmt::print(R"({{"homes": "{}", "triangles": {:.0f}, "patches": {:.0f}, "make_home_s": {:.3f}, )"
             R"("home_light_s": {:.3f}, "people_light_s": {:.3f}, "view_s": {:.4f}, )"
             R"("views_per_s": {:.2f}, "views_per_s_with_light": {:.2f}}})"
             "\n",
             name, times.triangles / times.conversations, times.patches / times.conversations,
             times.make_home / times.homes, times.home_light / times.homes,
             times.people_light / times.conversations, view_s, 1.0 / view_s,
             1.0 / (view_s + people_s + home_s));
  std::fflush(stdout);
}

void measure_kind(const char* name, int homes, std::size_t most_triangles,
                  const FurnitureLibrary& furniture, const FigureLibrary& figures) {
  Times times;
  for (std::uint64_t seed = 0; times.homes < homes; ++seed) {
    try {
      measure(seed, most_triangles, furniture, figures, times);
    } catch (const InputError&) {
      continue;  // no room for a conversation: another home
    }
  }
  report(name, times);
}

}  // namespace

int main(int argc, char** argv) try {
  const int homes = argc > 1 ? std::atoi(argv[1]) : 8;
  measure_kind("stand-ins", homes, 60'000, FurnitureLibrary(), FigureLibrary());
  ModelPack pack = installed_models();
  if (pack.furniture.empty()) return 0;
  const FurnitureLibrary furniture(std::move(pack.furniture));
  const FigureLibrary figures(std::move(pack.figures));
  measure_kind("models, up to 60k triangles", homes, 60'000, furniture, figures);
  measure_kind("models, up to 200k triangles", homes, 200'000, furniture, figures);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "camera_bench: %s\n", error.what());
  return 1;
}
