#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/error.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/evaluate/evaluation.h>
#include <earpoint/evaluate/evaluation_set.h>
#include <earpoint/video/draw.h>
#include <earpoint/video/image_file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// A table of 1 x 5 numbers as NumPy writes it.
std::string npy(const std::array<double, 5>& row) {
  std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 5), }";
  header.resize(117, ' ');
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00\x76\x00", 10);
  bytes += header;
  const std::size_t begin = bytes.size();
  bytes.resize(begin + sizeof(row));
  std::memcpy(bytes.data() + begin, row.data(), sizeof(row));
  return bytes;
}

class ReplayEvaluationSetTest : public ::testing::Test {
 protected:
  /// Two clips of two cameras; the second camera hears the same, 20 samples later.
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) / ("replay_set." + std::to_string(::getpid()));
    fs::remove_all(root_);
    const fs::path folder = root_ / "data/appen_dataset/v3";
    RandomStream random(1);
    for (const char* clip : {"SC-1027/3", "SC-1044/5"}) {
      fs::create_directories(folder / clip);
      Waveform sound(2, 16020, 16000);
      for (float& x : sound.planar()) x = static_cast<float>(0.1 * random.normal());
      for (int camera = 1; camera <= 2; ++camera) {
        Waveform heard(2, 16000, 16000);
        for (int ear = 0; ear < 2; ++ear) {
          std::copy_n(sound.channel(ear).begin() + (camera == 1 ? 20 : 0), 16000,
                      heard.channel(ear).begin());
        }
        const fs::path stem = folder / clip / std::to_string(camera);
        write_sound(stem.string() + ".wav", heard, SampleFormat::float32);
        write_image(stem.string() + ".png", filled_image(64, 36, {200, 10, 30}));
        write_file(stem.string() + ".npy", std::string_view(npy({0.125, 0.25, 0.5, 0.75, 3.0})));
      }
    }
    write_file(folder / "metadata_v2.json",
               std::string_view(R"({"data/appen_dataset/v3/SC-1027/3": ["1.png", "2.png"],
                                    "data/appen_dataset/v3/SC-1044/5": ["1.png", "2.png"]})"));
    // Camera 1 looks along x; camera 2 stands 1 m ahead and 2 m to the left of it and looks left.
    write_file(folder.parent_path() / "camera_positions_fixed_rotation.json", std::string_view(R"({
      "centers": {"SC-1027": {"DSLR-1": [100, 0, 150], "DSLR-2": [200, 200, 150]},
                  "SC-1044": {"DSLR-1": [100, 0, 150], "DSLR-2": [200, 200, 150]}},
      "rotations": {"SC-1027": {"DSLR-1": [1, 0, 0], "DSLR-2": [0, 1, 0]},
                    "SC-1044": {"DSLR-1": [1, 0, 0], "DSLR-2": [0, 1, 0]}}})"));
  }
  void TearDown() override { fs::remove_all(root_); }

  fs::path root_;
};

TEST_F(ReplayEvaluationSetTest, PairsHaveOurFrame) {
  EXPECT_TRUE(is_replay_folder(root_));
  EXPECT_FALSE(is_replay_folder(root_ / "data"));
  const auto set = replay_evaluation_set(root_, "test", {});
  ASSERT_EQ(set->size(), 2U);
  EXPECT_NE(set->cluster(0), set->cluster(1));
  EXPECT_EQ(set->scene(0), "SC-1027");
  for (std::size_t pair = 0; pair < 2; ++pair) {
    const PairSample sample = set->sample(pair);
    const Vector3 target_m = sample.source_from_target.position_m;
    const double yaw_rad = euler_from_quaternion(sample.source_from_target.orientation).yaw_rad;
    const bool from_first = set->name(pair).find("1.png -> 2.png") != std::string::npos;
    // From camera 2, which looks to the left, camera 1 is 2 m behind and 1 m to the left.
    EXPECT_NEAR(target_m.x, from_first ? 1.0 : -2.0, 1e-9);
    EXPECT_NEAR(target_m.y, from_first ? 2.0 : 1.0, 1e-9);
    EXPECT_NEAR(yaw_rad, from_first ? kPi / 2 : -kPi / 2, 1e-9);
    EXPECT_EQ(sample.speaker_box, (Box{0.125, 0.25, 0.5, 0.75}));
    EXPECT_EQ(sample.picture->at(10, 10, 0), 200);
    EXPECT_FALSE(set->truth(pair).has_value());
  }
}

TEST_F(ReplayEvaluationSetTest, OnlyTheReleasedColumnIsAlignedByTheTarget) {
  const auto set = replay_evaluation_set(root_, "test", {});
  SilentProgress silent;
  const std::vector<MethodEntry> methods{input_method()};
  for (const ClipResult& clip : evaluate(*set, methods, {}, silent).clips) {
    EXPECT_EQ(clip.honest[0][Metric::delay], 20.0);
    EXPECT_EQ(clip.released[0][Metric::delay], 0.0);
    EXPECT_LT(clip.released[0][Metric::mag].value(), 0.1 * clip.honest[0][Metric::mag].value());
    EXPECT_FALSE(clip.speaker_m.has_value());
  }
}

TEST_F(ReplayEvaluationSetTest, MethodsThatMustKnowTheSpeakerAreRefused) {
  const auto set = replay_evaluation_set(root_, "test", 1);
  SilentProgress silent;
  const std::vector<MethodEntry> methods{dsp_method()};
  EXPECT_THROW((void)evaluate(*set, methods, {}, silent), InputError);
}

}  // namespace
}  // namespace earpoint
