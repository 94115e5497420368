#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/core_testing/allocation_count.h>
#include <earpoint/error.h>
#include <earpoint/pose.h>
#include <earpoint/render/dsp_stream.h>
#include <earpoint/render/render_in_memory.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/synthesis/dsp_synthesizer.h>
#include <earpoint/synthesis/earpoint_path.h>
#include <earpoint/waveform.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 48000;
constexpr Vector3 kMouth_m{2.0, 0.5, 0.1};
const Pose kBeside{{1.0, -1.0, 0.0}, quaternion_from_euler({.yaw_rad = 0.7})};

const HrtfSet& head() {
  static const HrtfSet set = HrtfSet::load(kRate_hz);
  return set;
}

DspStream placed_stream() {
  DspStream stream(head(), {});
  stream.place_speaker(kMouth_m);
  return stream;
}

Waveform noise(std::ptrdiff_t samples) {
  RandomStream random(1);
  Waveform sound(2, samples, kRate_hz);
  for (float& sample : sound.planar()) sample = 0.05F * static_cast<float>(random.normal());
  return sound;
}

void process(DspStream& stream, Waveform& sound, std::ptrdiff_t first, std::ptrdiff_t count) {
  const auto start = static_cast<std::size_t>(first);
  const auto size = static_cast<std::size_t>(count);
  const auto left = sound.channel(0).subspan(start, size);
  const auto right = sound.channel(1).subspan(start, size);
  stream.process({left, right}, {left, right});
}

TEST(DspStream, StandingStillItSoundsLikeTheRenderingOfTheWholeClip) {
  const Waveform source = noise(kRate_hz);
  SoundInMemory moment;
  moment.sound = source;
  moment.speaker_m = kMouth_m;
  DspSynthesizer synthesizer({}, radians_from_degrees(90.0));
  const Waveform expected = render_in_memory(moment, synthesizer, EarpointPath(kBeside), {});

  DspStream stream = placed_stream();
  stream.move_to(kBeside);
  Waveform heard = source;
  process(stream, heard, 0, heard.samples());
  const std::ptrdiff_t late = stream.latency_samples();
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
}

TEST(DspStream, BlocksOfAnyLengthGiveTheSameSound) {
  DspStream one = placed_stream();
  DspStream other = placed_stream();
  Waveform whole = noise(kRate_hz / 2);
  Waveform parts = whole;
  one.move_to(kBeside);
  other.move_to(kBeside);
  process(one, whole, 0, whole.samples());
  std::ptrdiff_t length = 1;
  for (std::ptrdiff_t at = 0; at < parts.samples(); at += length) {
    length = std::min((7 * length + 1) % 1999 + 1, parts.samples() - at);
    process(other, parts, at, length);
  }
  EXPECT_TRUE(std::ranges::equal(whole.planar(), parts.planar()));
  EXPECT_GT(std::ranges::max(whole.planar()), 0.05F);
}

TEST(DspStream, WithoutASpeakerTheSoundPassesUnchanged) {
  DspStream stream(head(), {});
  stream.move_to(kBeside);
  const Waveform source = noise(kRate_hz / 4);
  Waveform heard = source;
  process(stream, heard, 0, heard.samples());
  const std::ptrdiff_t late = stream.latency_samples();
  for (std::ptrdiff_t i = 0; i + late < heard.samples(); ++i) {
    // A transform there and back.
    ASSERT_NEAR(heard.channel(1)[i + late], source.channel(1)[i], 1e-6);
  }
  EXPECT_FALSE(stream.speaker_m().has_value());
}

/// The largest second difference: small for a low tone, large where there is a click.
double roughness(const Waveform& sound, std::ptrdiff_t from) {
  double largest = 0.0;
  const auto samples = sound.channel(0);
  for (std::ptrdiff_t i = from + 2; i < sound.samples(); ++i) {
    largest =
        std::max(largest, std::abs(double{samples[i]} - 2.0 * samples[i - 1] + samples[i - 2]));
  }
  return largest;
}

/// A low tone, the same at both ears.
Waveform tone() {
  Waveform sound(2, kRate_hz, kRate_hz);
  for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
    const double time_s = static_cast<double>(i) / kRate_hz;
    const auto sample = static_cast<float>(0.2 * std::sin(2.0 * kPi * 300.0 * time_s));
    sound.channel(0)[i] = sound.channel(1)[i] = sample;
  }
  return sound;
}

/// What is heard of the tone where the head turns by `turn_rad` in the first half second and then
/// stands still.
Waveform heard_turning(double from_rad, double turn_rad) {
  DspStream stream = placed_stream();
  Waveform heard = tone();
  constexpr std::ptrdiff_t kStep = 480;
  const double half = static_cast<double>(heard.samples()) / 2.0;
  for (std::ptrdiff_t at = 0; at < heard.samples(); at += kStep) {
    const double turned_rad = turn_rad * std::min(1.0, static_cast<double>(at) / half);
    stream.move_to({{0.0, 0.0, 0.0}, quaternion_from_euler({.yaw_rad = from_rad + turned_rad})});
    process(stream, heard, at, kStep);
  }
  return heard;
}

/// The largest difference over the last quarter, either ear.
float difference_at_the_end(const Waveform& a, const Waveform& b) {
  float largest = 0.0F;
  for (int ear = 0; ear < 2; ++ear) {
    for (std::ptrdiff_t i = 3 * a.samples() / 4; i < a.samples(); ++i) {
      largest = std::max(largest, std::abs(a.channel(ear)[i] - b.channel(ear)[i]));
    }
  }
  return largest;
}

TEST(DspStream, MovesWithoutAClick) {
  constexpr double kTurn_rad = 1.5;
  const Waveform moves = heard_turning(0.0, kTurn_rad);
  const Waveform starts = heard_turning(0.0, 0.0);
  const Waveform arrived = heard_turning(kTurn_rad, 0.0);
  // The last move is followed, all the way: what is left of the fades is far in the past.
  EXPECT_LT(difference_at_the_end(moves, arrived), 1e-6F);
  EXPECT_GT(difference_at_the_end(moves, starts), 0.02F);
  // A cross-fade of 40 ms bends the tone's waveform a little; a switch would be as large as the
  // tone itself, hundreds of times its second difference.
  const double still = std::max(roughness(starts, kRate_hz / 4), roughness(arrived, kRate_hz / 4));
  EXPECT_LT(roughness(moves, kRate_hz / 8), 2.0 * still);
}

TEST(DspStream, AllocatesNothingWhileTheEarpointAndTheSpeakerMove) {
  DspStream stream = placed_stream();
  Waveform sound = noise(kRate_hz / 2);
  const Waveform source = sound;
  constexpr std::ptrdiff_t kStep = 256;
  const AllocationCount allocations;
  for (std::ptrdiff_t at = 0; at + kStep <= sound.samples(); at += kStep) {
    const double way = static_cast<double>(at) / kRate_hz;
    // Past the mouth at 0.2 m, where the responses of near sources are computed, and the speaker
    // is unknown for a while.
    const double left_m = kMouth_m.y - 0.2;
    stream.move_to({{8.0 * way, left_m, 0.0}, quaternion_from_euler({.yaw_rad = way})});
    if (way > 0.3) stream.place_speaker({});
    if (way > 0.4) stream.place_speaker(Vector3{2.0, way, 0.0});
    process(stream, sound, at, kStep);
  }
  EXPECT_EQ(allocations.count(), 0);
  EXPECT_FALSE(std::ranges::equal(sound.planar(), source.planar()));
}

TEST(DspStream, SeesTheSpeakerInThePicture) {
  DspStream stream(head(), {});
  const Image picture(640, 480, 3);
  stream.see(&picture, Box{0.0, 0.25, 0.25, 1.0});
  ASSERT_TRUE(stream.speaker_m().has_value());
  EXPECT_GT(stream.speaker_m()->y, 0.2);  // on the left
  stream.place_speaker(kMouth_m);
  EXPECT_EQ(stream.speaker_m(), kMouth_m);
  EXPECT_THROW(stream.see(nullptr, Box{0.0, 0.25, 0.25, 1.0}), InputError);
}

TEST(DspStream, PlacesThatAreNoNumbersAreRefused) {
  DspStream stream = placed_stream();
  const double nan = std::nan("");
  EXPECT_THROW(stream.move_to({{0.0, nan, 0.0}, {}}), InputError);
  EXPECT_THROW(stream.move_to({{0.0, 0.0, 0.0}, {1.0, nan, 0.0, 0.0}}), InputError);
  EXPECT_THROW(stream.place_speaker(Vector3{nan, 0.0, 0.0}), InputError);
}

TEST(DspStream, ResetReturnsToSilence) {
  DspStream stream = placed_stream();
  Waveform sound = noise(kRate_hz / 4);
  Waveform again = sound;
  stream.move_to(kBeside);
  process(stream, sound, 0, sound.samples());
  stream.reset();
  process(stream, again, 0, again.samples());
  EXPECT_TRUE(std::ranges::equal(sound.planar(), again.planar()));
  EXPECT_GT(std::ranges::max(sound.planar()), 0.05F);
}

}  // namespace
}  // namespace earpoint
