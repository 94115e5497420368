#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/random.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/synthesizer.h>
#include <earpoint/gtf/view.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/network_testing/random_weights.h>
#include <earpoint/render/make_synthesizer.h>
#include <earpoint/render_files/render.h>

namespace earpoint {
namespace {

constexpr double kFov_rad = 0.5 * kPi;

GtfWeights make_weights(int picture_px = 32) {
  GtfDescription description;
  description.channels = 8;
  description.layers = 2;
  description.bands = 10;
  description.picture_px = picture_px;
  description.window_samples = 4000;
  description.highpass_cutoff_hz = 80.0;
  return random_gtf_weights(description);
}

Observation make_observation(const Image& picture) {
  Observation observation;
  observation.sound = Waveform(2, 4000, 16000);
  RandomStream random(2);
  for (float& sample : observation.sound.planar()) {
    sample = static_cast<float>(0.1 * random.normal());
  }
  observation.picture = std::make_shared<const Image>(picture);
  observation.speaker_box = Box{0.1, 0.2, 0.3, 0.4};
  return observation;
}

std::vector<float> samples(const Waveform& sound) {
  return {sound.planar().begin(), sound.planar().end()};
}

/// Whether both ears have sound, for comparisons that silence would pass. The input has a root mean
/// square of 0.1 and the filters of random weights have gains near 1, so a tenth of it is far below
/// the output's level.
testing::AssertionResult is_audible(const Waveform& sound) {
  for (int ear = 0; ear < sound.channels(); ++ear) {
    const double level =
        std::sqrt(energy(sound.channel(ear)) / static_cast<double>(sound.samples()));
    if (!(level > 0.01)) {
      return testing::AssertionFailure() << "ear " << ear << " has a level of " << level;
    }
  }
  return testing::AssertionResult(sound.channels() == 2);
}

TEST(GtfSynthesizer, GivesWhatTheNetworkGivesForTheView) {
  const Image picture(96, 54, 3, 77);
  const Observation observation = make_observation(picture);
  const Pose pose{{1, -0.5, 0}, quaternion_from_euler({.yaw_rad = 0.4})};
  GtfSynthesizer synthesizer(make_weights(), kFov_rad);
  EXPECT_EQ(synthesizer.window_shape(48000).samples, 4000);
  EXPECT_EQ(synthesizer.ambient_cutoff_hz(), 80.0);
  EXPECT_EQ(synthesizer.picture_use(), PictureUse::if_there);
  synthesizer.observe(observation);
  const Waveform found = synthesizer.synthesize(pose);

  Gtf network(make_weights());
  const GtfView view = gtf_view(&picture, observation.speaker_box, kFov_rad, 32);
  network.set_picture(view.picture, view.speaker_box);
  network.set_pose(pose);
  std::vector<float> expected(2 * 4000);
  network.synthesize(observation.sound.planar(), expected);
  EXPECT_EQ(samples(found), expected);
  EXPECT_TRUE(is_audible(found));
}

TEST(GtfSynthesizer, LooksAgainWhereThePictureOrTheBoxIsAnother) {
  const Observation bright = make_observation(Image(64, 64, 3, 200));
  Observation dark = bright;
  dark.picture = std::make_shared<const Image>(64, 64, 3, std::uint8_t{10});
  Observation beside = dark;
  beside.speaker_box = Box{0.6, 0.2, 0.8, 0.4};
  const auto heard = [&](GtfSynthesizer& synthesizer, const Observation& observation) {
    synthesizer.observe(observation);
    const Waveform sound = synthesizer.synthesize({{1, 0, 0}, {}});
    EXPECT_TRUE(is_audible(sound));
    return samples(sound);
  };
  const auto at_first = [&](const Observation& observation) {
    GtfSynthesizer synthesizer(make_weights(), kFov_rad);
    return heard(synthesizer, observation);
  };
  EXPECT_NE(at_first(bright), at_first(dark));
  EXPECT_NE(at_first(beside), at_first(dark));
  GtfSynthesizer synthesizer(make_weights(), kFov_rad);
  for (const Observation& observation : {bright, bright, dark, beside, dark, bright}) {
    EXPECT_EQ(heard(synthesizer, observation), at_first(observation));
  }
}

TEST(GtfSynthesizer, HeedsTheSpeakersPlace) {
  const Image picture(64, 64, 3, 77);
  Observation observation = make_observation(picture);
  GtfSynthesizer synthesizer(make_weights(), kFov_rad);
  const auto heard = [&] {
    synthesizer.observe(observation);
    return samples(synthesizer.synthesize({{1, 0, 0}, {}}));
  };
  const std::vector<float> guessed = heard();
  observation.speaker_m = Vector3{0.5, 2, 0};
  const std::vector<float> at_left = heard();
  observation.speaker_m = Vector3{0.5, -2, 0};
  const std::vector<float> at_right = heard();
  EXPECT_NE(at_left, guessed);
  EXPECT_NE(at_left, at_right);
  EXPECT_NE(at_right, guessed);
}

TEST(GtfSynthesizer, WorksWithoutAPictureWhereTheNetworkDoesNotLook) {
  Observation observation = make_observation(Image(64, 64, 3, 77));
  observation.picture = nullptr;
  observation.speaker_box.reset();
  GtfSynthesizer synthesizer(make_weights(0), kFov_rad);
  EXPECT_EQ(synthesizer.picture_use(), PictureUse::never);
  synthesizer.observe(observation);
  const Waveform found = synthesizer.synthesize({});
  for (const float sample : found.planar()) ASSERT_TRUE(std::isfinite(sample));
  EXPECT_TRUE(is_audible(found));
}

/// Three seconds rendered along a path by a network without a picture.
class GtfPaths : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        std::filesystem::path(testing::TempDir()) / ("gtf_paths." + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    Waveform sound(2, 48000, 16000);
    RandomStream random(2);
    for (float& sample : sound.planar()) sample = static_cast<float>(0.1 * random.normal());
    write_sound(folder_ / "in.wav", sound, SampleFormat::float32);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] Waveform rendered(const EarpointPath& path, int threads = 1) const {
    GtfSynthesizer synthesizer(make_weights(0), kFov_rad);
    RenderInput source;
    source.sound.path = folder_ / "in.wav";
    const std::vector<RenderTarget> targets = {{path, folder_ / "out.wav"}};
    SilentProgress progress;
    ClipRenderOptions options;
    options.threads = threads;
    static_cast<void>(render(source, synthesizer, targets, options, progress));
    Waveform found = read_sound(folder_ / "out.wav");
    EXPECT_EQ(found.samples(), 48000);
    EXPECT_TRUE(is_audible(found));
    return found;
  }

  [[nodiscard]] static EarpointPath path(const std::string& rows) {
    return EarpointPath::parse_csv("time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n" + rows, "path");
  }

  std::filesystem::path folder_;
};

const Pose kFirst{{1, -0.5, 0}, quaternion_from_euler({.yaw_rad = radians_from_degrees(30)})};
const Pose kSecond{{-1, 2, 0}, quaternion_from_euler({.yaw_rad = radians_from_degrees(110)})};

TEST_F(GtfPaths, APathThatStandsStillEqualsStandingStill) {
  EXPECT_EQ(samples(rendered(path("0,1,-0.5,0,30,0,0\n3,1,-0.5,0,30,0,0\n"))),
            samples(rendered(EarpointPath(kFirst))));
}

TEST_F(GtfPaths, APathThatJumpsEqualsBothOfItsPlacesAwayFromTheJump) {
  const Waveform jumping = rendered(
      path("0,1,-0.5,0,30,0,0\n1.5,1,-0.5,0,30,0,0\n1.501,-1,2,0,110,0,0\n3,-1,2,0,110,0,0\n"));
  const Waveform at_first = rendered(EarpointPath(kFirst));
  const Waveform at_second = rendered(EarpointPath(kSecond));
  // Windows with the jump extend a quarter of a second to either side.
  for (int ear = 0; ear < 2; ++ear) {
    for (std::ptrdiff_t i = 0; i < 20000; ++i) {
      ASSERT_EQ(jumping.channel(ear)[i], at_first.channel(ear)[i]) << i;
    }
    for (std::ptrdiff_t i = 28100; i < 48000; ++i) {
      ASSERT_EQ(jumping.channel(ear)[i], at_second.channel(ear)[i]) << i;
    }
  }
  EXPECT_NE(samples(at_first), samples(at_second));
}

TEST_F(GtfPaths, AWalkIsFollowedFromHopToHop) {
  // A short step of the walk within a window, between poses at which a window would sample it.
  const Waveform walked = rendered(
      path("0,1,-0.5,0,30,0,0\n1.5,1,-0.5,0,30,0,0\n1.52,-1,2,0,110,0,0\n1.54,1,-0.5,0,30,0,0\n"
           "3,1,-0.5,0,30,0,0\n"));
  const Waveform still = rendered(EarpointPath(kFirst));
  double difference = 0.0;
  for (std::ptrdiff_t i = 24200; i < 24440; ++i) {
    difference += std::abs(walked.channel(0)[i] - still.channel(0)[i]);
  }
  EXPECT_GT(difference / 240, 1e-3);
}

TEST_F(GtfPaths, SeveralThreadsRenderTheSameSamples) {
  const EarpointPath walk = path("0,1,-0.5,0,30,0,0\n3,-1,2,0,110,0,0\n");
  const std::vector<float> alone = samples(rendered(walk));
  // Sixteen windows in groups of four and of six, the last of which is not full.
  for (const int threads : {2, 3}) EXPECT_EQ(samples(rendered(walk, threads)), alone) << threads;
}

TEST(GtfSynthesizer, IsMadeOfAWeightFile) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) /
                                     ("gtf." + std::to_string(::getpid()) + ".safetensors");
  write_safetensors(path, to_weight_file(make_weights()));
  const auto synthesizer = make_synthesizer(path.string(), {});
  EXPECT_EQ(synthesizer->window_shape(48000).samples, 4000);
  EXPECT_NE(dynamic_cast<GtfSynthesizer*>(synthesizer.get()), nullptr);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace earpoint
