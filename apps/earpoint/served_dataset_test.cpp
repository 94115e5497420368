#include "served_dataset.h"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/core/error.h>
#include <earpoint/dataset_testing/tiny_dataset.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class ServedDataset : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("served_dataset." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    write_tiny_dataset(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(ServedDataset, ListsWhatEachViewpointHearsOnce) {
  ClipLibrary library;
  add_dataset(folder_, "test", library);
  // Two conversations, three viewpoints, each the target of one pair.
  EXPECT_GE(library.list().size(), 2U);
  EXPECT_LE(library.list().size(), 6U);
  for (const auto& [id, name] : library.list()) {
    EXPECT_NE(name.find("viewpoint"), std::string::npos);
    const auto clip = library.open(id);
    ASSERT_NE(clip, nullptr);
    EXPECT_EQ(clip->places.size(), 2U);  // the others
    EXPECT_TRUE(clip->speaker_m);
    EXPECT_FALSE(clip->picture_png.empty());
    EXPECT_EQ(clip->sound.samples(), 24000);  // the whole speech of 1.5 s at 16 kHz
    for (const KnownPlace& place : clip->places) {
      EXPECT_EQ(place.sound.samples(), clip->sound.samples());
    }
  }
}

TEST_F(ServedDataset, SaysWhatIsNoDataSet) {
  ClipLibrary library;
  EXPECT_THROW(add_dataset(folder_ / "nowhere", "test", library), InputError);
  EXPECT_THROW(add_dataset(folder_, "nosplit", library), InputError);
}

}  // namespace
}  // namespace earpoint
