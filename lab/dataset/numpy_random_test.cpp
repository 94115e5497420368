#include <cstdlib>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/dataset/numpy_random.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

TEST(NumpyRandom, DrawsWhatNumpyDraws) {
  std::vector<fs::path> files{fs::path(EARPOINT_SOURCE_DIR) /
                              "lab/dataset/testdata/numpy_random.json"};
  if (const char* whole = std::getenv("EARPOINT_ORACLE_DIR")) {
    files.push_back(fs::path(whole) / "D_signal/numpy_rng.json");
  }
  for (const fs::path& file : files) {
    const auto document = nlohmann::json::parse(read_text_file(file));
    NumpyRandom random(document["seed"].get<std::uint32_t>());
    ASSERT_GT(document["ops"].size(), 50U);
    for (const auto& operation : document["ops"]) {
      if (operation[0] == "permutation") {
        EXPECT_EQ(random.permutation(operation[1].get<int>()),
                  operation[2].get<std::vector<int>>());
      } else {
        EXPECT_EQ(random.index(operation[1].get<std::uint32_t>()),
                  operation[2].get<std::uint32_t>());
      }
    }
  }
}

TEST(NumpyRandom, OneThingNeedsNoDraw) {
  NumpyRandom a(0);
  NumpyRandom b(0);
  EXPECT_EQ(a.index(1), 0U);
  EXPECT_EQ(a.permutation(1), std::vector<int>{0});
  EXPECT_EQ(a.permutation(9), b.permutation(9));
}

}  // namespace
}  // namespace earpoint
