#include <cmath>
#include <filesystem>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/dataset/raf.h>
#include <earpoint/dataset_testing/tiny_published.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class RafDatasetTest : public ::testing::Test {
 protected:
  void SetUp() override {
    room_ = fs::path(testing::TempDir()) /
            (std::string("raf_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(room_);
    write_tiny_raf(room_);
  }
  void TearDown() override { fs::remove_all(room_); }

  [[nodiscard]] RafDataset read(const std::string& split) const {
    return RafDataset({.folder = room_, .split = split, .split_file = {}});
  }

  /// What reading the split test says, its response included.
  [[nodiscard]] std::string refusal() const {
    try {
      const RafDataset dataset = read("test");
      (void)dataset.response(dataset.items().front());
      return "no error";
    } catch (const InputError& error) {
      return error.what();
    }
  }

  void expect_refusal(const std::string& part) const {
    const std::string text = refusal();
    EXPECT_NE(text.find(part), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  }

  fs::path room_;
};

TEST_F(RafDatasetTest, PositionsAreInOurFrame) {
  const RafDataset dataset = read("test");
  ASSERT_EQ(dataset.items().size(), 2U);
  const RafItem& item = dataset.items().front();
  EXPECT_EQ(item.id, "000005");
  EXPECT_EQ(item.receiver_m, (Vector3{0.0, 2.5, 1.5}));
  EXPECT_EQ(item.world_from_speaker.position_m, (Vector3{2.0, 0.0, 1.0}));
  // It faces the origin.
  const Vector3 front = rotate(item.world_from_speaker.orientation, {1.0, 0.0, 0.0});
  EXPECT_NEAR(front.x, -1.0, 1e-12);
  EXPECT_NEAR(front.y, 0.0, 1e-12);
  const Waveform response = dataset.response(item);
  EXPECT_EQ(response.sample_rate_hz(), 48000);
  EXPECT_EQ(response.samples(), 19200);
}

TEST_F(RafDatasetTest, TheQuaternionTurnsAboutTheUprightAxis) {
  // A quarter turn about y takes -z to -x, which is our right.
  const double half = std::sqrt(0.5);
  EXPECT_NEAR(yaw_from_raf(0.0, half, 0.0, half), -kPi / 2.0, 1e-12);
  EXPECT_NEAR(yaw_from_raf(0.0, -half, 0.0, half), kPi / 2.0, 1e-12);
  EXPECT_NEAR(yaw_from_raf(0.0, 0.0, 0.0, 2.0), kPi, 1e-12);
  EXPECT_THROW((void)yaw_from_raf(0.0, 0.0, 0.0, 0.0), InputError);
  EXPECT_THROW((void)yaw_from_raf(half, 0.0, 0.0, half), InputError);
}

TEST_F(RafDatasetTest, SplitsMayBeFlatOrNested) {
  EXPECT_EQ(read("train").items().size(), 4U);
  EXPECT_EQ(read("validation").items().size(), 2U);
  EXPECT_EQ(read("all").items().size(), 8U);
  fs::remove(room_ / "metadata" / "data-split.json");
  EXPECT_EQ(read("all").items().size(), 8U);
  expect_refusal("data-split.json: no such file");
}

TEST_F(RafDatasetTest, TheNearestItemIsFound) {
  const RafDataset test = read("test");
  const RafDataset train = read("train");
  EXPECT_EQ(nearest_item(test.items()[0], train.items()).id, "000004");
  EXPECT_EQ(nearest_item(test.items()[1], train.items()).id, "000006");
  RafItem turned = train.items()[2];
  turned.world_from_speaker.orientation = quaternion_from_euler({.yaw_rad = kPi / 2.0});
  RafItem shifted = train.items()[2];
  shifted.receiver_m.y += 1.0;
  EXPECT_EQ(nearest_item(train.items()[2], {turned, shifted}).receiver_m, shifted.receiver_m);
}

TEST_F(RafDatasetTest, DamagedAndMissingFilesGiveOneLine) {
  const fs::path item = room_ / "data" / "000005";
  const auto with_text = [&](const char* name, const char* text) {
    const std::string before = read_text_file(item / name);
    write_file(item / name, std::string_view(text));
    const std::string message = refusal();
    write_file(item / name, std::string_view(before));
    return message;
  };
  EXPECT_NE(with_text("rx_pos.txt", "1,2\n").find("rx_pos.txt: expected 3 numbers, found 2"),
            std::string::npos);
  EXPECT_NE(with_text("rx_pos.txt", "1,2,x").find("rx_pos.txt: number 3 cannot be read"),
            std::string::npos);
  EXPECT_NE(with_text("tx_pos.txt", "0,0,0,0,1,2,3").find("tx_pos.txt: quaternion: is zero"),
            std::string::npos);
  EXPECT_NE(with_text("tx_pos.txt", "0,0,0,1,1,2,nan").find("tx_pos.txt: number 7"),
            std::string::npos);
  EXPECT_EQ(refusal(), "no error");

  write_sound(item / "rir.wav", Waveform(2, 100, 48000), SampleFormat::float32);
  expect_refusal("rir.wav: has 2 channels, expected 1");
  write_file(item / "rir.wav", std::string_view("RIFF"));
  expect_refusal("rir.wav: ");
  fs::remove(item / "rir.wav");
  expect_refusal("rir.wav: no such file");
  fs::remove_all(item);
  expect_refusal("000005: no such folder");
  write_file(room_ / "metadata" / "data-split.json", std::string_view("{\"test\": [[1]]}"));
  expect_refusal("data-split.json: test[0][0]");
  write_file(room_ / "metadata" / "data-split.json", std::string_view("{\"test\": []}"));
  expect_refusal("has no items in the split test");
  write_file(room_ / "metadata" / "data-split.json", std::string_view("{"));
  expect_refusal("data-split.json: is not valid JSON");
  constexpr std::size_t kDepth = 1'000'000;  // more than the stack has room for
  write_file(
      room_ / "metadata" / "data-split.json",
      std::string_view("{\"test\": " + std::string(kDepth, '[') + std::string(kDepth, ']') + "}"));
  expect_refusal("data-split.json: is nested too deeply");
}

TEST_F(RafDatasetTest, TheFolderOfBothRoomsIsNotARoom) {
  fs::create_directories(room_ / "both" / "EmptyRoom");
  try {
    (void)RafDataset({.folder = room_ / "both", .split = "all", .split_file = {}});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("EmptyRoom or FurnishedRoom"), std::string::npos);
  }
}

}  // namespace
}  // namespace earpoint
