#include "served_dataset.h"

#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/error.h>

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

TEST_F(ServedDataset, PlaysRecordingsOfManyCameras) {
  fs::remove_all(folder_);
  write_tiny_replay_dataset(folder_, {"SC-1027/3", "SC-1044/5"});
  ClipLibrary library;
  add_dataset(folder_, "test", library);
  const auto list = library.list();
  ASSERT_EQ(list.size(), 2U);
  EXPECT_TRUE(list[0].name.starts_with("SC-1027/3: camera ")) << list[0].name;
  const auto clip = library.open(list[0].id);
  ASSERT_NE(clip, nullptr);
  ASSERT_EQ(clip->places.size(), 1U);  // the other of two cameras
  EXPECT_EQ(clip->sound.sample_rate_hz(), 16000);
  EXPECT_EQ(clip->places[0].sound.samples(), clip->sound.samples());
  // One metre ahead of camera 1 and two to its left, or back from camera 2, which looks left.
  const Vector3& at = clip->places[0].source_from_target.position_m;
  EXPECT_NEAR(std::hypot(at.x, at.y), std::sqrt(5.0), 1e-6);
  EXPECT_EQ(clip->people.size(), 1U);
  EXPECT_FALSE(clip->speaker) << "recordings do not tell where the speaker stands";
  EXPECT_FALSE(clip->picture_png.empty());
}

TEST_F(ServedDataset, SaysWhatIsNoDataSet) {
  ClipLibrary library;
  EXPECT_THROW(add_dataset(folder_ / "nowhere", "test", library), InputError);
  EXPECT_THROW(add_dataset(folder_, "nosplit", library), InputError);
}

}  // namespace
}  // namespace earpoint
