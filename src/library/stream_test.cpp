#include <earpoint/stream.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/core/random.h>
#include <earpoint/core_testing/allocation_count.h>
#include <earpoint/error.h>
#include <earpoint/gtf/description.h>
#include <earpoint/network/weights.h>
#include <earpoint/network_testing/random_weights.h>
#include <earpoint/renderer.h>
#include <earpoint/waveform.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class StreamTest : public ::testing::Test {
 protected:
  void SetUp() override {
    GtfDescription description;
    description.channels = 8;
    description.layers = 2;
    description.bands = 10;
    description.picture_px = 32;
    description.window_samples = 4000;
    description.highpass_cutoff_hz = {};  // as the crossover would change phases
    description.delays = false;
    write_safetensors(file_, to_weight_file(pass_through_gtf_weights(description)));
  }
  void TearDown() override { fs::remove(file_); }

  [[nodiscard]] Stream stream(int rate_hz) const {
    return Renderer::open(file_.string())
        .stream({.sample_rate_hz = rate_hz, .limit = false, .phase_rounds = 0});
  }

  fs::path file_ =
      fs::path(testing::TempDir()) / ("stream_test_" + std::to_string(::getpid()) + ".safetensors");
};

Waveform noise(std::ptrdiff_t samples, int rate_hz) {
  Waveform sound(2, samples, rate_hz);
  RandomStream random(3);
  for (float& sample : sound.planar()) sample = static_cast<float>(0.05 * random.normal());
  return sound;
}

void process(Stream& stream, const Waveform& sound, Waveform& result, std::ptrdiff_t block) {
  for (std::ptrdiff_t start = 0; start < sound.samples(); start += block) {
    const std::ptrdiff_t count = std::min(block, sound.samples() - start);
    const float* const in[] = {sound.channel(0).data() + start, sound.channel(1).data() + start};
    float* const out[] = {result.channel(0).data() + start, result.channel(1).data() + start};
    stream.process(in, out, count);
  }
}

TEST_F(StreamTest, IsAsLateAsItSaysAtAnyRateAndBlockSize) {
  for (const int rate_hz : {16000, 44100, 48000}) {
    const Waveform sound = noise(rate_hz, rate_hz);
    Waveform first;
    for (const std::ptrdiff_t block : {64, 441, 5000}) {
      Stream live = stream(rate_hz);
      Waveform result(2, sound.samples(), rate_hz);
      process(live, sound, result, block);
      const std::ptrdiff_t late = live.latency_samples();
      ASSERT_GT(late, 0);
      // The network passes its input on: over the second half, shifted by the latency, both are the
      // same sound.
      double product = 0.0, of_sound = 0.0, of_result = 0.0;
      for (std::ptrdiff_t i = sound.samples() / 2; i < sound.samples(); ++i) {
        const double x = sound.channel(0)[i - late], y = result.channel(0)[i];
        product += x * y;
        of_sound += x * x;
        of_result += y * y;
      }
      EXPECT_GT(product / std::sqrt(of_sound * of_result), 0.98) << rate_hz << " " << block;
      if (block == 64) first = result;
      EXPECT_TRUE(std::ranges::equal(result.planar(), first.planar())) << rate_hz << " " << block;
    }
  }
}

TEST_F(StreamTest, AllocatesNothingWhileItRuns) {
  Stream live = stream(48000);
  live.see(Image(40, 30, 3, 128), Box{0.4, 0.2, 0.6, 1.0});
  const Waveform sound = noise(24000, 48000);
  Waveform result(2, sound.samples(), 48000);
  const AllocationCount allocations;
  for (int i = 0; i < 3; ++i) {
    live.move_to({{0.1 * i, 0.5, 0}, quaternion_from_euler({0.3 * i, 0, 0})});
    live.place_speaker(Vector3{2, 0.1 * i, 0});
    process(live, sound, result, 256);
    (void)live.latency_samples();
    (void)live.speaker_m();
  }
  EXPECT_EQ(allocations.count(), 0);
}

TEST_F(StreamTest, WritesWhereItReadsAlsoWithTheEarsSwapped) {
  const Waveform sound = noise(16000, 16000);
  Stream live = stream(16000);
  Waveform expected(2, sound.samples(), 16000);
  process(live, sound, expected, 500);
  Waveform memory = sound;
  live.reset();
  for (std::ptrdiff_t start = 0; start < sound.samples(); start += 500) {
    float* const left = memory.channel(0).data() + start;
    float* const right = memory.channel(1).data() + start;
    const float* const in[] = {left, right};
    float* const out[] = {right, left};
    live.process(in, out, 500);
  }
  EXPECT_TRUE(std::ranges::equal(memory.channel(1), expected.channel(0)));
  EXPECT_TRUE(std::ranges::equal(memory.channel(0), expected.channel(1)));
}

TEST(DspLiveStream, StandingStillItSoundsLikeTheRenderingOfTheClip) {
  const Waveform sound = noise(44100, 44100);
  RenderRequest request;
  request.speaker_m = Vector3{2.0, 0.5, 0.1};
  request.target = {{1.0, -1.0, 0.0}, quaternion_from_euler({.yaw_rad = 0.7})};
  Renderer renderer = Renderer::open("dsp");
  const Waveform expected = renderer.render(sound, request);

  Stream live = renderer.stream({.sample_rate_hz = 44100});
  live.place_speaker(request.speaker_m);
  live.move_to(request.target);
  Waveform heard(2, sound.samples(), 44100);
  process(live, sound, heard, 256);
  const std::ptrdiff_t late = live.latency_samples();
  float peak = 0.0F;
  for (int ear = 0; ear < 2; ++ear) {
    for (std::ptrdiff_t i = 0; i + late < heard.samples(); ++i) {
      const float sample = expected.channel(ear)[i];
      // Both convolve in float, by transforms of other lengths.
      ASSERT_NEAR(heard.channel(ear)[i + late], sample, 1e-5) << "ear " << ear << ", sample " << i;
      peak = std::max(peak, std::abs(sample));
    }
  }
  EXPECT_GT(peak, 0.05F);
  EXPECT_EQ(live.speaker_m(), request.speaker_m);
}

TEST(DspLiveStream, TakesTheSpeakerFromABoxInAPicture) {
  Stream live = Renderer::open("dsp").stream();
  EXPECT_FALSE(live.speaker_m().has_value());
  live.see(Image(40, 30, 3, 128), Box{0.0, 0.2, 0.2, 1.0});
  ASSERT_TRUE(live.speaker_m().has_value());
  EXPECT_GT(live.speaker_m()->y, 0.3);  // a box on the left
  live.see_nothing();
  EXPECT_FALSE(live.speaker_m().has_value());
}

TEST(DspLiveStream, AllocatesNothingWhileItRuns) {
  Stream live = Renderer::open("dsp").stream();
  live.place_speaker(Vector3{2, 0, 0});
  const Waveform sound = noise(24000, 48000);
  Waveform result(2, sound.samples(), 48000);
  const AllocationCount allocations;
  for (int i = 0; i < 3; ++i) {
    live.move_to({{0.1 * i, 0.5, 0}, quaternion_from_euler({0.3 * i, 0, 0})});
    process(live, sound, result, 256);
  }
  EXPECT_EQ(allocations.count(), 0);
}

TEST(DspLiveStream, BadInputGetsOneLine) {
  Renderer renderer = Renderer::open("dsp");
  EXPECT_THROW((void)renderer.stream({.sample_rate_hz = 11025}), InputError);
  EXPECT_THROW((void)renderer.stream({.phase_rounds = 1}), InputError);
  EXPECT_THROW((void)Renderer::open("input").stream(), InputError);
  Stream live = renderer.stream({.phase_rounds = 0});
  EXPECT_THROW(live.see_nothing(Box{0.4, 0.2, 0.6, 1.0}), InputError);
  EXPECT_THROW(live.move_to({{1e9, 0, 0}, {}}), InputError);
}

TEST_F(StreamTest, BadInputGetsOneLine) {
  EXPECT_THROW((void)stream(11025), InputError);
  Stream live = stream(48000);
  EXPECT_THROW(live.move_to({{1e9, 0, 0}, {}}), InputError);
  EXPECT_THROW(live.move_to({{0, 0, 0}, {std::nan(""), 0, 0, 0}}), InputError);
  EXPECT_THROW(live.place_speaker(Vector3{0, 0, std::nan("")}), InputError);
  EXPECT_THROW(live.see_nothing(Box{0.4, 0.2, 0.3, 1.0}), InputError);
  EXPECT_THROW(live.see(Image(), {}), std::logic_error);
}

}  // namespace
}  // namespace earpoint
