#include "live_renderer.h"

#include "bundled_clip.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/core/temporary_folder.h>
#include <earpoint/core_testing/allocation_count.h>
#include <earpoint/gtf/description.h>
#include <earpoint/network/weights.h>
#include <earpoint/network_testing/random_weights.h>
#include <earpoint/renderer.h>
#include <earpoint/waveform.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint::plugin {
namespace {

constexpr int kRate_hz = 16000;
constexpr std::ptrdiff_t kBlock = 300;
// What live_renderer.h promises: a second of warm-up. The fades are 50 and 10 ms.
constexpr std::ptrdiff_t kWarmUp = kRate_hz;
constexpr std::ptrdiff_t kModelFade = kRate_hz / 20;
constexpr std::ptrdiff_t kBypassFade = kRate_hz / 100;

GtfDescription small() {
  GtfDescription description;
  description.channels = 8;
  description.layers = 2;
  description.bands = 10;
  description.picture_px = 0;
  description.window_samples = 4000;
  description.delays = false;
  return description;
}

Waveform noise(std::ptrdiff_t samples, int rate_hz = kRate_hz) {
  Waveform sound(2, samples, rate_hz);
  RandomStream random(7);
  for (float& sample : sound.planar()) sample = static_cast<float>(0.05 * random.normal());
  return sound;
}

/// Three networks: one that passes sound on, one with random weights that is 20 ms later, one with
/// two textures.
class LiveRendererTest : public ::testing::Test {
 protected:
  LiveRendererTest() {
    GtfDescription later = small();
    later.phase_rounds = 1;
    GtfDescription textured = small();
    textured.texture = true;
    add("passing", pass_through_gtf_weights(small()));
    add("later", random_gtf_weights(later));
    add("textured", random_gtf_weights(textured));
  }

  void add(const std::string& name, const GtfWeights& weights) {
    models_.push_back({name, folder_.path() / (name + ".safetensors")});
    write_safetensors(models_.back().file, to_weight_file(weights));
  }

  [[nodiscard]] Stream stream(int model, std::optional<double> texture = {}) const {
    return Renderer::open(models_[static_cast<std::size_t>(model)].file.string(),
                          {.texture = texture})
        .stream({.sample_rate_hz = kRate_hz});
  }

  TemporaryFolder folder_;
  std::vector<StreamingModel> models_;
};

Waveform process(LiveRenderer& live, const Settings& settings, const Waveform& sound,
                 std::ptrdiff_t block = kBlock) {
  Waveform result(2, sound.samples(), sound.sample_rate_hz());
  for (std::ptrdiff_t at = 0; at < sound.samples(); at += block) {
    const float* const in[] = {sound.channel(0).data() + at, sound.channel(1).data() + at};
    float* const out[] = {result.channel(0).data() + at, result.channel(1).data() + at};
    live.process(settings, in, out, std::min(block, sound.samples() - at));
  }
  return result;
}

Waveform process(Stream stream, const Settings& settings, const Waveform& sound) {
  stream.move_to(settings.earpoint);
  stream.place_speaker(settings.speaker_m);
  Waveform result(2, sound.samples(), sound.sample_rate_hz());
  const float* const in[] = {sound.channel(0).data(), sound.channel(1).data()};
  float* const out[] = {result.channel(0).data(), result.channel(1).data()};
  stream.process(in, out, sound.samples());
  return result;
}

/// What has played is reset by a thread before it can play again.
void wait_until_ready(const LiveRenderer& live, const Settings& settings) {
  for (int tries = 0; tries < 6000 && !live.is_ready_for(settings); ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_TRUE(live.is_ready_for(settings));
}

TEST_F(LiveRendererTest, EqualsTheStreamOfItsModelWhateverTheBlocks) {
  const Waveform sound = noise(kRate_hz);
  for (const std::ptrdiff_t block : {1, 64, 300, 5000}) {
    for (const int model : {0, 1}) {
      LiveRenderer live(models_, kRate_hz);
      ASSERT_EQ(live.problem(), "");
      const Settings settings{.earpoint = {{0.5, -0.25, 0}, quaternion_from_euler({.yaw_rad = 1})},
                              .speaker_m = Vector3{2, 0.5, 0},
                              .model = model};
      const std::ptrdiff_t pad = live.latency_samples() - stream(model).latency_samples();
      const Waveform expected = delayed(process(stream(model), settings, sound), pad);
      EXPECT_TRUE(same(process(live, settings, sound, block), expected)) << model << " " << block;
    }
  }
}

TEST_F(LiveRendererTest, IsAsLateAsTheSlowestModelWhicheverPlays) {
  const LiveRenderer live(models_, kRate_hz);
  EXPECT_EQ(live.latency_samples(), stream(1).latency_samples());
  EXPECT_GT(stream(1).latency_samples(), stream(0).latency_samples());
}

TEST_F(LiveRendererTest, CrossFadesToTheOtherModelAfterASecond) {
  const std::ptrdiff_t before = 7 * kBlock;
  const std::ptrdiff_t after = kWarmUp + kModelFade + kRate_hz / 2;
  const Waveform sound = noise(before + after);
  const Settings first{.model = 0};
  const Settings second{.model = 1};
  LiveRenderer live(models_, kRate_hz);
  (void)process(live, first, part_of(sound, 0, before));
  const Waveform result = process(live, second, part_of(sound, before, after));

  const std::ptrdiff_t pad = live.latency_samples() - stream(0).latency_samples();
  const Waveform old = part_of(delayed(process(stream(0), first, sound), pad), before, after);
  const Waveform next = process(stream(1), second, part_of(sound, before, after));
  for (int c = 0; c < 2; ++c) {
    for (std::ptrdiff_t i = 0; i < after; ++i) {
      const auto place = std::clamp<std::ptrdiff_t>(i + 1 - kWarmUp, 0, kModelFade);
      const float part = static_cast<float>(place) / static_cast<float>(kModelFade);
      ASSERT_EQ(result.channel(c)[i], std::lerp(old.channel(c)[i], next.channel(c)[i], part)) << i;
    }
  }
  EXPECT_FALSE(same(old, next));
}

TEST_F(LiveRendererTest, ComesBackToAModelThatHasPlayed) {
  const std::ptrdiff_t length = kWarmUp + kModelFade + kRate_hz / 2;
  const Waveform sound = noise(length);
  LiveRenderer live(models_, kRate_hz);
  const Settings first{.model = 0};
  const Settings second{.model = 2};
  (void)process(live, first, sound);
  (void)process(live, second, sound);
  wait_until_ready(live, first);
  const Waveform back = process(live, first, sound);
  // As a stream that is new at the switch.
  const std::ptrdiff_t pad = live.latency_samples() - stream(0).latency_samples();
  const Waveform fresh = delayed(process(stream(0), first, sound), pad);
  const std::ptrdiff_t start = kWarmUp + kModelFade;
  EXPECT_TRUE(same(part_of(back, start, length - start), part_of(fresh, start, length - start)));
}

TEST_F(LiveRendererTest, PlaysTheTextureThatIsAskedFor) {
  const Waveform sound = noise(kRate_hz);
  const auto with = [&](bool natural) {
    LiveRenderer live(models_, kRate_hz);
    return process(live, {.model = 2, .natural_texture = natural}, sound);
  };
  const Waveform natural = with(true);
  const Waveform mean = with(false);
  LiveRenderer live(models_, kRate_hz);
  const std::ptrdiff_t pad = live.latency_samples() - stream(2).latency_samples();
  EXPECT_TRUE(same(natural, delayed(process(stream(2, 1.0), {}, sound), pad)));
  EXPECT_TRUE(same(mean, delayed(process(stream(2, 0.0), {}, sound), pad)));
  EXPECT_FALSE(same(natural, mean));
  // One without that choice has one sound for both.
  EXPECT_TRUE(same(process(live, {.model = 0, .natural_texture = false}, sound),
                   delayed(process(stream(0), {}, sound),
                           live.latency_samples() - stream(0).latency_samples())));
}

TEST_F(LiveRendererTest, BypassIsTheInputAsLateAndFades) {
  const Waveform sound = noise(6 * kRate_hz / 10);
  LiveRenderer live(models_, kRate_hz);
  const Waveform late = delayed(sound, live.latency_samples());
  EXPECT_TRUE(same(process(live, {.bypass = true}, sound), late));

  live.reset();
  const std::ptrdiff_t before = 20 * kBlock;
  const Waveform rendered = process(live, {}, sound);
  live.reset();
  (void)process(live, {}, part_of(sound, 0, before));
  const Waveform rest =
      process(live, {.bypass = true}, part_of(sound, before, sound.samples() - before));
  for (std::ptrdiff_t i = 0; i < rest.samples(); ++i) {
    const float part = static_cast<float>(std::min(i + 1, kBypassFade)) / float{kBypassFade};
    const float wet = rendered.channel(0)[before + i];
    const float dry = late.channel(0)[before + i];
    ASSERT_EQ(rest.channel(0)[i], part == 1.0F ? dry : std::lerp(wet, dry, part)) << i;
  }
}

TEST_F(LiveRendererTest, ResetRestartsFromSilenceInTheMiddleOfASwitch) {
  const Waveform sound = noise(kRate_hz);
  LiveRenderer live(models_, kRate_hz);
  const Waveform first = process(live, {.model = 1}, sound);
  (void)process(live, {.model = 2, .bypass = true}, sound);
  live.reset();
  EXPECT_TRUE(same(process(live, {.model = 1}, sound), first));
}

TEST_F(LiveRendererTest, AllocatesNothingWhileItRunsAndSwitches) {
  const Waveform sound = noise(kWarmUp + kModelFade + kRate_hz / 2);
  LiveRenderer live(models_, kRate_hz);
  Waveform result(2, kBlock, kRate_hz);
  const auto run = [&](const Settings& settings) {
    float* const out[] = {result.channel(0).data(), result.channel(1).data()};
    for (std::ptrdiff_t at = 0; at + kBlock <= sound.samples(); at += kBlock) {
      const float* const in[] = {sound.channel(0).data() + at, sound.channel(1).data() + at};
      live.process(settings, in, out, kBlock);
    }
  };
  const AllocationCount allocations;
  run({.speaker_m = Vector3{2, 1, 0}});
  run({.earpoint = {{1, 0, 0}, {}}, .model = 1});
  run({.model = 2, .natural_texture = false, .bypass = true});
  (void)live.speaker_m();
  EXPECT_EQ(allocations.count(), 0);
}

TEST_F(LiveRendererTest, PassesTheInputAndSaysWhyIfItCannotRender) {
  const Waveform sound = noise(1000);
  for (const double rate_hz : {8000.0, 11025.0, 44056.5, 48010.0, 384000.0}) {
    LiveRenderer live(models_, rate_hz);
    EXPECT_NE(live.problem().find("sample rate"), std::string::npos) << live.problem();
    EXPECT_EQ(live.latency_samples(), 0);
    EXPECT_TRUE(same(process(live, {}, sound), sound));
  }
  LiveRenderer nothing({}, 48000);
  EXPECT_NE(nothing.problem().find("models"), std::string::npos) << nothing.problem();
  EXPECT_TRUE(same(process(nothing, {.bypass = true}, sound), sound));
}

TEST_F(LiveRendererTest, SaysWhyAndSwapsNoEarsInTheHostsMemory) {
  const Waveform sound = noise(300);
  for (const double rate_hz :
       {0.0, -48000.0, 1e300, std::nan(""), std::numeric_limits<double>::infinity()}) {
    LiveRenderer live(models_, rate_hz);
    EXPECT_EQ(live.status(), Status::rate_not_supported) << rate_hz;
    Waveform memory = sound;
    float* const left = memory.channel(0).data();
    float* const right = memory.channel(1).data();
    const float* const in[] = {left, right};
    float* const out[] = {right, left};
    live.process({}, in, out, 300);
    EXPECT_TRUE(std::ranges::equal(memory.channel(1), sound.channel(0)));
    EXPECT_TRUE(std::ranges::equal(memory.channel(0), sound.channel(1)));
  }
  EXPECT_EQ(LiveRenderer({}, 48000).status(), Status::no_model);
}

TEST_F(LiveRendererTest, ModelsThatAreGoneLeaveTheOthersAndTheirNumbers) {
  const Waveform sound = noise(kRate_hz / 2);
  std::filesystem::remove(models_[0].file);
  std::ofstream(models_[2].file) << "no weights";
  LiveRenderer live(models_, kRate_hz);
  EXPECT_EQ(live.status(), Status::renders) << live.problem();
  ASSERT_EQ(live.left_out().size(), 2u);
  EXPECT_NE(live.left_out()[0].find("passing"), std::string::npos) << live.left_out()[0];
  EXPECT_EQ(live.latency_samples(), stream(1).latency_samples());
  const Waveform expected = process(stream(1), {}, sound);
  for (const int model : {0, 1, 2}) {
    live.reset();
    EXPECT_TRUE(same(process(live, {.model = model}, sound), expected)) << model;
  }
  std::filesystem::remove(models_[1].file);
  LiveRenderer none(models_, kRate_hz);
  EXPECT_EQ(none.status(), Status::no_model);
  EXPECT_NE(none.problem().find("passing"), std::string::npos) << none.problem();
  EXPECT_TRUE(same(process(none, {}, sound), sound));
}

TEST_F(LiveRendererTest, ANumberWithoutAModelMeansTheFirst) {
  const Waveform sound = noise(kRate_hz / 2);
  LiveRenderer live(models_, kRate_hz);
  const Waveform first = process(live, {.model = 0}, sound);
  for (const int model : {-1, 3, 15}) {
    live.reset();
    EXPECT_TRUE(same(process(live, {.model = model}, sound), first)) << model;
  }
}

TEST_F(LiveRendererTest, SurvivesSamplesThatAreNoNumbers) {
  Waveform sound = noise(kRate_hz);
  sound.channel(0)[3000] = std::numeric_limits<float>::quiet_NaN();
  sound.channel(1)[3001] = std::numeric_limits<float>::infinity();
  LiveRenderer live(models_, kRate_hz);
  const Waveform result = process(live, {}, sound);
  EXPECT_TRUE(std::ranges::all_of(result.planar(), [](float x) { return std::isfinite(x); }));
}

}  // namespace
}  // namespace earpoint::plugin
