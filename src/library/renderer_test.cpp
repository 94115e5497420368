#include <earpoint/renderer.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/energy.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/gtf/description.h>
#include <earpoint/network.h>
#include <earpoint/network/weights.h>
#include <earpoint/network_testing/random_weights.h>
#include <earpoint/version.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// A folder of shipped models that holds one small network, `gtf`.
class RendererTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("renderer_test_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    GtfDescription description;
    description.channels = 8;
    description.layers = 2;
    description.bands = 10;
    description.picture_px = 32;
    description.window_samples = 4000;
    description.highpass_cutoff_hz = 80.0;
    write_safetensors(folder_ / "gtf.safetensors", to_weight_file(random_gtf_weights(description)));
    ::setenv("EARPOINT_MODELS_DIR", folder_.c_str(), 1);
  }
  void TearDown() override {
    ::unsetenv("EARPOINT_MODELS_DIR");
    fs::remove_all(folder_);
  }

  fs::path folder_;
};

Waveform noise(int channels, double duration_s, int rate_hz) {
  Waveform sound(channels, std::lround(duration_s * rate_hz), rate_hz);
  RandomStream random(5);
  for (float& sample : sound.planar()) sample = static_cast<float>(0.05 * random.normal());
  return sound;
}

Image picture(std::uint8_t grey) {
  Image image(32, 24, 3, grey);
  image.at(3, 4, 1) = 255;
  return image;
}

/// The result of a renderer that has rendered nothing before.
Waveform freshly(const Waveform& sound, const RenderRequest& request) {
  return Renderer::open("gtf").render(sound, request);
}

bool same(const Waveform& a, const Waveform& b) {
  return std::ranges::equal(a.planar(), b.planar());
}

double rms(std::span<const float> samples) {
  return std::sqrt(energy(samples) / static_cast<double>(samples.size()));
}

TEST_F(RendererTest, GivesBothEarsAtTheSoundsRateAndOfItsLength) {
  const Image seen = picture(90);
  Renderer renderer = Renderer::open("gtf");
  for (const int rate_hz : {16000, 22050, 44100, 48000}) {
    const Waveform there = renderer.render(
        noise(2, 0.7, rate_hz),
        {.picture = &seen, .speaker_m = Vector3{2, 0, 0}, .target = {{1, 0.5, 0}, {}}});
    EXPECT_EQ(there.channels(), 2);
    EXPECT_EQ(there.samples(), std::lround(0.7 * rate_hz));
    EXPECT_EQ(there.sample_rate_hz(), rate_hz);
    EXPECT_GT(rms(there.planar()), 1e-4);  // the input has 0.05
  }
}

TEST_F(RendererTest, WhatWasRenderedBeforeChangesNothing) {
  const Waveform sound = noise(2, 0.6, 16000);
  Image seen = picture(90);
  const RenderRequest first{.picture = &seen, .target = {{1, 0, 0}, {}}};
  Renderer renderer = Renderer::open("gtf");
  const Waveform dark = renderer.render(sound, first);
  EXPECT_TRUE(same(dark, freshly(sound, first)));
  // Another picture in the same memory is noticed.
  seen = picture(220);
  const Waveform bright = renderer.render(sound, first);
  EXPECT_TRUE(same(bright, freshly(sound, first)));
  EXPECT_FALSE(same(bright, dark));
  // And so is a missing picture.
  const RenderRequest blind{.target = {{1, 0, 0}, {}}};
  EXPECT_TRUE(same(renderer.render(sound, blind), freshly(sound, blind)));
}

TEST_F(RendererTest, AnyNumberOfThreadsGivesTheSameSamples) {
  const Waveform sound = noise(2, 1.3, 48000);
  const RenderRequest request{.target = {{0, 1, 0}, {}}};
  EXPECT_TRUE(
      same(Renderer::open("gtf", {.threads = 3}).render(sound, request), freshly(sound, request)));
}

TEST_F(RendererTest, APathThatStandsStillEqualsItsTarget) {
  const Waveform sound = noise(2, 0.8, 16000);
  const Pose pose{{0.5, 1, 0}, {}};
  const RenderRequest moving{.path = {{0.0, pose}, {0.8, pose}}};
  EXPECT_TRUE(same(freshly(sound, moving), freshly(sound, {.target = pose})));
}

TEST_F(RendererTest, OneChannelsVoiceIsPutAtTheSpeaker) {
  Renderer copy = Renderer::open("input");
  const Waveform mono = noise(1, 1.0, 16000);
  const Waveform nobody = copy.render(mono, {});
  EXPECT_TRUE(std::ranges::equal(nobody.channel(0), nobody.channel(1)));
  // The head shadows the ear away from the speaker.
  const Waveform left = copy.render(mono, {.speaker_m = Vector3{0, 1, 0}});
  EXPECT_GT(rms(left.channel(0)), 1.5 * rms(left.channel(1)));
  // The left of the picture is on the left.
  const Image seen = picture(90);
  const Waveform box =
      copy.render(mono, {.picture = &seen, .speaker_box = Box{0.0, 0.2, 0.1, 0.9}});
  EXPECT_GT(rms(box.channel(0)), 1.2 * rms(box.channel(1)));
}

TEST_F(RendererTest, BadInputGetsOneLine) {
  Renderer renderer = Renderer::open("gtf");
  Waveform sound = noise(2, 0.5, 16000);
  EXPECT_THROW((void)renderer.render(noise(2, 0.5, 8000), {}), InputError);
  EXPECT_THROW((void)renderer.render(noise(2, 0.01, 16000), {}), InputError);
  EXPECT_THROW((void)renderer.render(Waveform(2, 16000, 16000), {}), InputError);
  EXPECT_THROW((void)renderer.render(sound, {.speaker_box = Box{0.5, 0.5, 0.4, 1}}), InputError);
  EXPECT_THROW((void)renderer.render(sound, {.target = {{1e9, 0, 0}, {}}}), InputError);
  EXPECT_THROW((void)renderer.render(sound, {.path = {{0.0, {}}, {0.0, {}}}}), InputError);
  EXPECT_THROW((void)renderer.render(noise(3, 0.5, 16000), {}), std::logic_error);
  sound.channel(1)[77] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW((void)renderer.render(sound, {}), InputError);
  EXPECT_THROW((void)Renderer::open("nothing"), InputError);
  EXPECT_THROW((void)Renderer::open("gtf", {.horizontal_fov_rad = 90.0}), InputError);
  EXPECT_THROW((void)Renderer::open("gtf", {.texture = 0.0}), InputError);
  EXPECT_THROW((void)Renderer::open("gtf", {.texture = 5.0}), InputError);
  for (const int rounds : {-1, 1}) {
    EXPECT_THROW((void)Renderer::open("gtf").stream({.phase_rounds = rounds}), InputError)
        << rounds << ", but the network was trained without rounds";
  }
  EXPECT_THROW((void)Renderer::open("input").stream(), InputError);
}

TEST_F(RendererTest, NumbersThatAreNoneAreRefused) {
  const double nan = std::nan("");
  Renderer renderer = Renderer::open();
  const Waveform sound = noise(2, 0.5, 16000);
  for (const double gain_db : {nan, 1e9, -std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW((void)renderer.render(sound, {.gain_db = gain_db}), InputError);
  }
  const Pose no_turn{{1, 0, 0}, {0, 0, 0, 0}};
  const Pose nan_turn{{1, 0, 0}, {1, nan, 0, 0}};
  for (const Pose& pose : {no_turn, nan_turn}) {
    EXPECT_THROW((void)renderer.render(sound, {.target = pose}), InputError);
    EXPECT_THROW((void)renderer.render(sound, {.path = {{0, {}}, {0.5, pose}}}), InputError);
  }
}

TEST_F(RendererTest, WarnsOfWhatTheNetworkWasNotTrainedFor) {
  const Renderer renderer = Renderer::open("gtf");
  const Waveform sound = noise(2, 0.5, 16000);
  const auto near = renderer.warnings(sound, {.target = {{1, 0, 0}, {}}});
  const auto far = renderer.warnings(sound, {.target = {{30, 0, 0}, {}}});
  EXPECT_GT(far.size(), near.size());
}

TEST_F(RendererTest, TellsWhatAModelIs) {
  EXPECT_EQ(installed_networks(), std::vector<std::string>{"gtf"});
  const NetworkInfo info = describe_network("gtf");
  EXPECT_EQ(info.file, folder_ / "gtf.safetensors");
  EXPECT_EQ(info.kind, "gtf");
  EXPECT_GT(info.parameters, 1000);
  EXPECT_TRUE(info.renders && info.streams);
  EXPECT_EQ(Renderer::open().model(), info.file.string());
  EXPECT_THROW((void)describe_network("nothing"), InputError);
}

TEST(LibraryVersion, IsThatOfItsHeaders) { EXPECT_STREQ(library_version(), EARPOINT_VERSION_TEXT); }

}  // namespace
}  // namespace earpoint
