#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/resample.h>
#include <earpoint/core/random.h>
#include <earpoint/core_testing/allocation_count.h>
#include <earpoint/error.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/synthesizer.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/media/media.h>
#include <earpoint/network_testing/random_weights.h>
#include <earpoint/render/render_stream.h>
#include <earpoint/render_files/picture_stream.h>

namespace earpoint {
namespace {

const GtfWeights& shipped_weights() {
  static const GtfWeights weights = read_gtf_weights(EARPOINT_SOURCE_DIR "/models/gtf.safetensors");
  return weights;
}

GtfWeights small_weights() {
  GtfDescription description;
  description.channels = 8;
  description.layers = 2;
  description.bands = 10;
  description.picture_px = 16;
  description.window_samples = 4000;
  description.highpass_cutoff_hz = 80.0;
  return random_gtf_weights(description);
}

GtfWeights pass_through_weights(std::optional<double> highpass_cutoff_hz = {}) {
  GtfDescription description = small_weights().description;
  description.delays = false;
  description.highpass_cutoff_hz = highpass_cutoff_hz;
  return pass_through_gtf_weights(description);
}

/// Four seconds of speech at two ears.
Waveform speech(int rate_hz) {
  AudioReader reader(EARPOINT_SOURCE_DIR "/examples/clip.mp4");
  const Waveform sound = resample(reader.read(5 * reader.sample_rate_hz()), rate_hz);
  const std::ptrdiff_t samples = std::min<std::ptrdiff_t>(sound.samples(), 4 * rate_hz);
  Waveform part(2, samples, rate_hz);
  for (int ear = 0; ear < 2; ++ear) {
    std::copy_n(sound.channel(ear).begin(), samples, part.channel(ear).begin());
  }
  return part;
}

Waveform noise(std::ptrdiff_t samples, int rate_hz) {
  Waveform sound(2, samples, rate_hz);
  RandomStream random(3);
  for (float& sample : sound.planar()) sample = static_cast<float>(0.05 * random.normal());
  return sound;
}

Waveform processed(RenderStream& stream, const Waveform& sound, std::ptrdiff_t block) {
  Waveform result(2, sound.samples(), sound.sample_rate_hz());
  for (std::ptrdiff_t start = 0; start < sound.samples(); start += block) {
    const std::ptrdiff_t count = std::min(block, sound.samples() - start);
    const auto first = static_cast<std::size_t>(start);
    const auto size = static_cast<std::size_t>(count);
    stream.process(
        {sound.channel(0).subspan(first, size), sound.channel(1).subspan(first, size)},
        {result.channel(0).subspan(first, size), result.channel(1).subspan(first, size)});
  }
  return result;
}

double level_db(std::span<const float> samples) {
  return 10.0 * std::log10(energy(samples) / static_cast<double>(samples.size()) + 1e-30);
}

class RenderStreamRates : public testing::TestWithParam<int> {};

TEST_P(RenderStreamRates, BringBackThroughANetworkThatChangesNothingWhatWentInAsLateAsTheySay) {
  const Waveform sound = speech(GetParam());
  RenderStream stream(pass_through_weights(), {.sample_rate_hz = GetParam()});
  const Waveform found = processed(stream, sound, 512);
  const std::ptrdiff_t late = stream.latency_samples();
  double error = 0.0;
  double energy = 0.0;
  for (int ear = 0; ear < 2; ++ear) {
    for (std::ptrdiff_t i = late; i < sound.samples(); ++i) {
      const double before = sound.channel(ear)[i - late];
      error += (found.channel(ear)[i] - before) * (found.channel(ear)[i] - before);
      energy += before * before;
    }
  }
  // The floor of the magnitudes in the kernels alone gives -57 dB for a whole window; a delay that
  // is off by one sample would give -15 dB and worse.
  EXPECT_LT(10.0 * std::log10(error / energy), -50.0);
  // Block, network, both resamplings and the limiter.
  EXPECT_LT(static_cast<double>(late) / GetParam(), 0.1);
}

INSTANTIATE_TEST_SUITE_P(Rates, RenderStreamRates,
                         testing::Values(16000, 22050, 44100, 48000, 96000));

/// Compares the level of the third second in a stream with that of the same second as a window.
void expect_stream_as_loud_as_window(const Waveform& sound, const Pose& pose) {
  const Vector3 kMouth_m{2.0, 0.5, 0.0};  // given, since a stream's summary locates it elsewhere
  const auto picture =
      open_pictures(std::nullopt, EARPOINT_SOURCE_DIR "/examples/clip.mp4").nearest(2.5);
  RenderStream stream(shipped_weights(), {.sample_rate_hz = 16000});
  stream.see(picture.get(), {});
  stream.place_speaker(kMouth_m);
  stream.move_to(pose);
  const Waveform live = processed(stream, sound, 160);
  GtfSynthesizer windows(shipped_weights(), radians_from_degrees(90.0));
  Observation observation;
  observation.picture = picture;
  observation.speaker_m = kMouth_m;
  observation.sound = Waveform(2, 16000, 16000);
  for (int ear = 0; ear < 2; ++ear) {
    std::copy_n(sound.channel(ear).begin() + 32000, 16000, observation.sound.channel(ear).begin());
  }
  windows.observe(observation);
  const Waveform whole = windows.synthesize(pose);
  for (int ear = 0; ear < 2; ++ear) {
    const auto heard = live.channel(ear).subspan(32000 + stream.latency_samples(), 16000);
    // A stream has statistics of the last second instead of the window's own, and a causal ambient
    // split. How much that changes depends on the weights: 0.13 dB were measured with one training
    // and 0.45 dB with the next. At the first pose the source's sound is 2.2 and 3.4 dB off.
    EXPECT_NEAR(level_db(heard), level_db(whole.channel(ear)), 0.8);
  }
}

TEST(RenderStream, HearsTheEarpointAsWholeWindowsDo) {
  // The clip begins with silence, which no network has learned: speech after it once began so loud
  // that the limit of levels kept the next seconds 15 dB too quiet. A quiet room may be as bad.
  for (const double floor_db : {-200.0, -79.0, -65.0}) {
    SCOPED_TRACE(floor_db);
    Waveform sound = speech(16000);
    RandomStream random(5);
    for (float& sample : sound.planar()) {
      sample += static_cast<float>(std::pow(10.0, floor_db / 20.0) * random.normal());
    }
    expect_stream_as_loud_as_window(sound,
                                    {{1.0, 0.5, 0.0}, quaternion_from_euler({.yaw_rad = 1.2})});
    expect_stream_as_loud_as_window(sound,
                                    {{-1.5, 0.0, 0.0}, quaternion_from_euler({.yaw_rad = -0.7})});
  }
}

TEST(RenderStream, GivesTheSameForBlocksOfAnySize) {
  const Waveform sound = noise(20000, 48000);
  RenderStream once(small_weights(), {});
  const Waveform expected = processed(once, sound, sound.samples());
  EXPECT_GT(level_db(expected.channel(0)), -60.0);
  for (const std::ptrdiff_t block : {1, 37, 480, 1024}) {
    RenderStream stream(small_weights(), {});
    const Waveform found = processed(stream, sound, block);
    EXPECT_TRUE(std::ranges::equal(found.planar(), expected.planar())) << block;
  }
}

TEST(RenderStream, StartsOverAfterReset) {
  const Waveform sound = noise(9600, 48000);
  RenderStream stream(small_weights(), {});
  const Waveform first = processed(stream, sound, 480);
  stream.reset();
  const Waveform second = processed(stream, sound, 480);
  EXPECT_TRUE(std::ranges::equal(first.planar(), second.planar()));
}

TEST(RenderStream, AllocatesNothingWhileItRuns) {
  const Waveform sound = noise(4800, 44100);
  RenderStream stream(small_weights(), {.sample_rate_hz = 44100});
  Waveform out(2, sound.samples(), 44100);
  AllocationCount counted;
  for (int i = 0; i < 20; ++i) {
    stream.move_to({{0.1 * i, 0.0, 0.0}, {}});
    stream.process({sound.channel(0), sound.channel(1)}, {out.channel(0), out.channel(1)});
  }
  EXPECT_EQ(counted.count(), 0);
}

TEST(RenderStream, AddsAmbientSoundAndTheBandAboveTheModelAtTheirLevel) {
  constexpr int kRate_hz = 48000;
  const std::vector<double> tones_hz = {20.0, 80.0, 160.0, 1000.0, 5000.0, 7800.0, 8000.0, 12000.0};
  Waveform sound(2, 3 * kRate_hz, kRate_hz);
  for (int ear = 0; ear < 2; ++ear) {
    for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
      for (const double frequency_hz : tones_hz) {
        sound.channel(ear)[i] += static_cast<float>(
            0.02 * std::sin(2.0 * kPi * frequency_hz * static_cast<double>(i) / kRate_hz));
      }
    }
  }
  RenderStream stream(pass_through_weights(80.0), {});
  const Waveform found = processed(stream, sound, 480);
  // The amplitude of a tone in the last second, which has whole periods of all.
  const auto amplitude = [&](double frequency_hz) {
    double sine = 0.0;
    double cosine = 0.0;
    for (std::ptrdiff_t i = 2 * kRate_hz; i < 3 * kRate_hz; ++i) {
      const double angle = 2.0 * kPi * frequency_hz * static_cast<double>(i) / kRate_hz;
      sine += found.channel(0)[i] * std::sin(angle);
      cosine += found.channel(0)[i] * std::cos(angle);
    }
    return 2.0 * std::hypot(sine, cosine) / kRate_hz;
  };
  for (const double frequency_hz : tones_hz) {
    // 0.1 dB: the floor of magnitudes in the kernels.
    EXPECT_NEAR(20.0 * std::log10(amplitude(frequency_hz) / 0.02), 0.0, 0.1) << frequency_hz;
  }
}

TEST(RenderStream, SurvivesWhatIsNoNumber) {
  Waveform sound = noise(9600, 48000);
  RenderStream stream(small_weights(), {});
  sound.channel(0)[100] = std::numeric_limits<float>::quiet_NaN();
  sound.channel(1)[200] = std::numeric_limits<float>::infinity();
  const Waveform found = processed(stream, sound, 480);
  EXPECT_TRUE(std::ranges::all_of(found.planar(), [](float x) { return std::isfinite(x); }));
  EXPECT_GT(level_db(found.channel(0)), -60.0);
}

TEST(RenderStream, RefusesWhatItCannotDo) {
  EXPECT_THROW(RenderStream(small_weights(), {.sample_rate_hz = 8000}), InputError);
  EXPECT_THROW(RenderStream(small_weights(), {.sample_rate_hz = 44056}), InputError);
  RenderStream stream(small_weights(), {});
  EXPECT_THROW(stream.move_to({{1e9, 0.0, 0.0}, {}}), InputError);
  EXPECT_THROW(stream.place_speaker(Vector3{std::nan(""), 0.0, 0.0}), InputError);
}

}  // namespace
}  // namespace earpoint
