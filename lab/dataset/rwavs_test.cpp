#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/rwavs.h>
#include <earpoint/dataset_testing/tiny_published.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class RwavsDatasetTest : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) /
            (std::string("rwavs_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(root_);
    write_tiny_rwavs(root_);
  }
  void TearDown() override { fs::remove_all(root_); }

  [[nodiscard]] std::string refusal() const {
    try {
      const RwavsDataset dataset(rwavs_options(root_, "val"));
      (void)dataset.sample(dataset.moments().front());
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

  fs::path root_;
};

TEST_F(RwavsDatasetTest, IsFoundFromItsRootAndFromAScene) {
  EXPECT_EQ(dataset_layout(root_, std::nullopt), DatasetLayout::rwavs);
  EXPECT_EQ(dataset_layout(root_ / "2", std::nullopt), DatasetLayout::rwavs);
  EXPECT_EQ(RwavsDataset(rwavs_options(root_, "val")).moments().size(), 4U);
  EXPECT_EQ(RwavsDataset(rwavs_options(root_, "train")).moments().size(), 12U);
  const RwavsDataset one(rwavs_options(root_ / "2", "val"));
  ASSERT_EQ(one.moments().size(), 2U);
  EXPECT_EQ(one.moments()[0].scene, "2");
  EXPECT_THROW((void)rwavs_options(root_ / "1" / "frames", "val"), InputError);
  EXPECT_THROW((void)RwavsDataset(rwavs_options(root_, "test")), InputError);
}

TEST_F(RwavsDatasetTest, PosesAreInOurAxesAndTwoMetresOnAverage) {
  const RwavsDataset dataset(rwavs_options(root_, "val"));
  for (const RwavsMoment& moment : dataset.moments()) {
    const RwavsScene& scene = dataset.scene(moment.scene);
    // All poses lie on one circle.
    EXPECT_NEAR(norm(moment.world_from_listener.position_m - scene.speaker_m), kRwavsMeanDistance_m,
                1e-9);
    // Seconds 4 and 8 look along -x, level.
    const Vector3 front = rotate(moment.world_from_listener.orientation, {1.0, 0.0, 0.0});
    const Vector3 up = rotate(moment.world_from_listener.orientation, {0.0, 0.0, 1.0});
    EXPECT_NEAR(front.x, -1.0, 1e-12);
    EXPECT_NEAR(up.z, 1.0, 1e-12);
  }
}

TEST_F(RwavsDatasetTest, ASampleIsTheSecondAroundAFrame) {
  const RwavsDataset dataset(rwavs_options(root_, "val"));
  for (const RwavsMoment& moment : dataset.moments()) {
    const PairSample sample = dataset.sample(moment);
    EXPECT_EQ(sample.target.samples(), kPairSamples);
    EXPECT_EQ(sample.target.sample_rate_hz(), 16000);
    // The ear on the loudspeaker's side is the louder one, and our frame agrees on which that is.
    const Vector3 speaker = transform_point(inverse(sample.source_from_target), sample.speaker_m);
    EXPECT_EQ(speaker.y > 0.0, energy(sample.target.channel(0)) > energy(sample.target.channel(1)));
    EXPECT_NEAR(norm(speaker), kRwavsMeanDistance_m, 1e-9);
    // Both sounds are the same noise, at the same time; 16 bits round them.
    double product = 0.0;
    for (std::ptrdiff_t n = 0; n < kPairSamples; ++n) {
      product += double{sample.dry.channel(0)[n]} * sample.target.channel(0)[n];
    }
    const double likeness =
        product / std::sqrt(energy(sample.dry.channel(0)) * energy(sample.target.channel(0)));
    EXPECT_GT(likeness, 0.999);
    // One gain a scene brings the dry sound to the level of the ears: sounds are stored in 16 bits.
    const double level = energy(sample.target.channel(0)) + energy(sample.target.channel(1));
    EXPECT_NEAR(2.0 * energy(sample.dry.channel(0)) / level, 1.0, 1e-3);
  }
}

TEST_F(RwavsDatasetTest, AMomentAfterTheSoundIsLeftOutAndOneAtItsEndFilledWithZeros) {
  const fs::path file = root_ / "1" / "transforms_scale_val.json";
  auto json = nlohmann::json::parse(read_text_file(file));
  json["camera_path"].push_back(json["camera_path"][0]);
  json["camera_path"][2]["file_path"] = "frames/00009.png";
  write_file(file, std::string_view(json.dump()));
  const RwavsDataset dataset(rwavs_options(root_ / "1", "val"));
  ASSERT_EQ(dataset.moments().size(), 2U);
  const PairSample last = dataset.sample(dataset.moments()[1]);  // 7.5 to 8.4 s of sound
  EXPECT_GT(energy(last.target.channel(0).subspan(12000, 2000)), 0.0);
  EXPECT_EQ(energy(last.target.channel(0).subspan(14400)), 0.0);
}

TEST_F(RwavsDatasetTest, DamagedAndMissingFilesGiveOneLine) {
  const fs::path scene = root_ / "1";
  const fs::path poses = scene / "transforms_scale_val.json";
  const std::string before = read_text_file(poses);
  const auto with_pose = [&](const auto& change) {
    auto json = nlohmann::json::parse(before);
    change(json["camera_path"][0]);
    write_file(poses, std::string_view(json.dump()));
    const std::string message = refusal();
    write_file(poses, std::string_view(before));
    return message;
  };
  using Pose = nlohmann::json;
  EXPECT_NE(with_pose([](Pose& p) {
              p["camera_to_world"].erase(0);
            }).find("camera_path[0].camera_to_world: expected 16 numbers"),
            std::string::npos);
  EXPECT_NE(with_pose([](Pose& p) { p["camera_to_world"][6] = 2.0; }).find("expected a rotation"),
            std::string::npos);
  EXPECT_NE(with_pose([](Pose& p) { p["file_path"] = "frames/first.png"; }).find("file_path"),
            std::string::npos);
  EXPECT_NE(with_pose([](Pose& p) { p.erase("camera_to_world"); }).find("camera_to_world"),
            std::string::npos);
  EXPECT_EQ(refusal(), "no error");

  write_sound(scene / "source_syn_re.wav", Waveform(2, 22050, 22050), SampleFormat::pcm16);
  expect_refusal("source_syn_re.wav: has 2 channels, expected 1");
  write_sound(scene / "source_syn_re.wav", Waveform(1, 22050, 22050), SampleFormat::pcm16);
  expect_refusal("source_syn_re.wav: is silent throughout the training split");
  fs::remove(scene / "source_syn_re.wav");
  expect_refusal("source_syn_re.wav: ");
  write_file(scene / "binaural_syn_re.wav", std::string_view("RIFF"));
  expect_refusal("binaural_syn_re.wav: ");
  write_tiny_rwavs(root_);
  write_file(poses, std::string_view("{"));
  expect_refusal("transforms_scale_val.json: is not valid JSON");
  fs::remove(scene / "transforms_scale_train.json");
  expect_refusal("transforms_scale_train.json");
  write_file(root_ / "position.json", std::string_view("{\"1\": {}}"));
  expect_refusal("source_position");
}

}  // namespace
}  // namespace earpoint
