#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/dataset/numpy_random.h>

namespace earpoint {
namespace {

TEST(NumpyRandom, DrawsWhatNumpyDraws) {
  const char* folder = std::getenv("EARPOINT_ORACLE_DIR");
  if (folder == nullptr) GTEST_SKIP() << "EARPOINT_ORACLE_DIR is not set";
  const auto document = nlohmann::json::parse(
      read_text_file(std::filesystem::path(folder) / "D_signal/numpy_rng.json"));
  NumpyRandom random(document["seed"].get<std::uint32_t>());
  ASSERT_GT(document["ops"].size(), 50U);
  for (const auto& operation : document["ops"]) {
    if (operation[0] == "permutation") {
      EXPECT_EQ(random.permutation(operation[1].get<int>()), operation[2].get<std::vector<int>>());
    } else {
      EXPECT_EQ(random.index(operation[1].get<std::uint32_t>()), operation[2].get<std::uint32_t>());
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

// The first draws of the sequence above, so that something is tested where the oracle is not.
TEST(NumpyRandom, FirstDrawsOfSeedZero) {
  NumpyRandom random(0);
  EXPECT_EQ(random.permutation(5), (std::vector<int>{2, 0, 1, 3, 4}));
  EXPECT_EQ(random.index(6), 3U);
  EXPECT_EQ(random.permutation(10), (std::vector<int>{8, 6, 4, 0, 2, 5, 9, 1, 7, 3}));
}

}  // namespace
}  // namespace earpoint
