// The shipped network on the demo's clip.
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/evaluate/earpoint_comparison.h>
#include <earpoint/locate/people_detector.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

TEST(ShippedGtfDemo, ToldNothingItBeatsACopyAtEachEarpoint) {
  // If the copy's level difference is this close to the truth, there is nothing to improve.
  constexpr double kWrongSide_db = 2.0;
  const fs::path folder = fs::path(testing::TempDir()) / "shipped_gtf_demo";
  fs::create_directories(folder);
  const EarpointClip clip = read_earpoint_clip(EARPOINT_SOURCE_DIR "/examples/earpoints.json");
  const std::vector<ClipMethod> methods{{"input", "input"},
                                        {"gtf", EARPOINT_SOURCE_DIR "/models/gtf.safetensors"}};
  SilentProgress progress;
  const auto detector = make_people_detector(EARPOINT_SOURCE_DIR "/models/people.safetensors");
  const EarpointComparison comparison =
      compare_earpoints(clip, methods, folder, {.detector = detector.get()}, progress);
  for (std::size_t i = 0; i < clip.earpoints.size(); ++i) {
    const ClipMetrics& copy = comparison.earpoints[i].renderings[0].metrics;
    const ClipMetrics& gtf = comparison.earpoints[i].renderings[1].metrics;
    EXPECT_LT(*gtf[Metric::mag], *copy[Metric::mag]) << clip.earpoints[i].name;
    EXPECT_LT(*gtf[Metric::level], *copy[Metric::level]) << clip.earpoints[i].name;
    if (*copy[Metric::lre] > kWrongSide_db) {
      EXPECT_LT(*gtf[Metric::lre], *copy[Metric::lre]) << clip.earpoints[i].name;
    }
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace earpoint
