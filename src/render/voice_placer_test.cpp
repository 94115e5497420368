#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/audio/energy.h>
#include <earpoint/core/random.h>
#include <earpoint/render/voice_placer.h>
#include <earpoint/spatial/binaural.h>
#include <earpoint/spatial/dsp_renderer.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 16000;

Waveform noise_twice(std::ptrdiff_t samples, float right) {
  RandomStream random(9);
  Waveform sound(2, samples, kRate_hz);
  for (std::ptrdiff_t i = 0; i < samples; ++i) {
    sound.channel(0)[i] = static_cast<float>(0.1 * random.normal());
    sound.channel(1)[i] = right * sound.channel(0)[i];
  }
  return sound;
}

/// In blocks of uneven sizes.
Waveform place_all(const VoicePlacement& placement, const HrtfSet& head, const Waveform& sound) {
  VoicePlacer placer(placement, head);
  Waveform placed(2, sound.samples(), kRate_hz);
  std::ptrdiff_t at = 0;
  const auto append = [&](const Waveform& part) {
    for (int ear = 0; ear < 2; ++ear) {
      std::ranges::copy(part.channel(ear), placed.channel(ear).begin() + at);
    }
    at += part.samples();
  };
  for (std::ptrdiff_t start = 0; start < sound.samples(); start += 777) {
    const std::ptrdiff_t count = std::min<std::ptrdiff_t>(777, sound.samples() - start);
    Waveform block(2, count, kRate_hz);
    for (int ear = 0; ear < 2; ++ear) {
      std::copy_n(sound.channel(ear).begin() + start, count, block.channel(ear).begin());
    }
    append(placer.process(block));
  }
  append(placer.finish());
  EXPECT_EQ(at, sound.samples());
  return placed;
}

TEST(VoicePlacer, PutsAVoiceWhereTheHeadWouldHearIt) {
  const HrtfSet head = HrtfSet::load(kRate_hz);
  const Vector3 mouth{1.0, 1.0, 0.2};
  const Waveform mono = noise_twice(5000, 1.0F);
  const Waveform placed = place_all(placed_at(mouth, StereoKind::same), head, mono);
  const Spherical place = spherical_from_cartesian(mouth);
  const Waveform expected = pan_binaural(mono.channel(0), head, place);
  const double gain = distance_gain(place.distance_m);
  for (int ear = 0; ear < 2; ++ear) {
    for (std::ptrdiff_t i = 0; i < mono.samples(); ++i) {
      // Float transforms of blocks against one convolution.
      ASSERT_NEAR(placed.channel(ear)[i], expected.channel(ear)[i] / gain, 1e-4) << i;
    }
  }
}

TEST(VoicePlacer, TakesTheOneVoiceOutOfEveryKindOfStereo) {
  const HrtfSet head = HrtfSet::load(kRate_hz);
  const VoicePlacement same = placed_at({2.0, 0.0, 0.0}, StereoKind::same);
  const double expected = energy(place_all(same, head, noise_twice(3200, 1.0F)).planar());
  for (const auto& [kind, right] :
       {std::pair{StereoKind::one_channel, 0.0F}, std::pair{StereoKind::inverted, -1.0F}}) {
    const VoicePlacement placement{.rows = same.rows, .kind = kind};
    // Sums of the ears in another order: rounding of floats, 6e-8 a sample.
    EXPECT_NEAR(energy(place_all(placement, head, noise_twice(3200, right)).planar()), expected,
                1e-6 * expected);
  }
}

TEST(VoicePlacement, MovesLinearlyBetweenBoxesAndStaysWhereThereIsNone) {
  const auto box = [](double x) {
    return Box{.x_min = x - 0.1, .y_min = 0.3, .x_max = x + 0.1, .y_max = 0.9};
  };
  const SpeakerTrack track(std::vector<SpeakerTrack::Row>{
      {0.0, std::nullopt}, {1.0, box(0.25)}, {2.0, box(0.75)}, {3.0, std::nullopt}});
  const auto placement = placed_at(track, StereoKind::same, kPi / 2, std::nullopt);
  ASSERT_TRUE(placement);
  EXPECT_GT(placement->at(0.0).y, 0.3);
  EXPECT_NEAR(placement->at(1.5).y, 0.0, 1e-9);
  EXPECT_EQ(placement->at(9.0).y, placement->at(2.0).y);
  EXPECT_FALSE(placed_at(SpeakerTrack(std::vector<SpeakerTrack::Row>{{0.0, std::nullopt}}),
                         StereoKind::same, kPi / 2, std::nullopt));
}

}  // namespace
}  // namespace earpoint
