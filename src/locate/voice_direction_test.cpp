#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/locate/voice_direction.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/binaural.h>

namespace earpoint {
namespace {

/// Bursts of noise, like syllables, from an azimuth.
Waveform bursts_from(const HrtfSet& head, double azimuth_deg, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> voice(16000);
  for (std::size_t i = 0; i < voice.size(); ++i) {
    const double envelope = std::pow(std::abs(std::sin(static_cast<double>(i) / 800.0)), 4.0);
    voice[i] = static_cast<float>(0.1 * envelope * random.normal());
  }
  return pan_binaural(voice, head,
                      {.azimuth_rad = radians_from_degrees(azimuth_deg), .distance_m = 1.5});
}

class VoiceDirectionTest : public ::testing::Test {
 protected:
  HrtfSet head_ = HrtfSet::load(VoiceDirection::kSampleRateHz);
};

TEST_F(VoiceDirectionTest, FindsADryVoiceWithinAStepOfItsGrid) {
  for (const double azimuth_deg : {-70.0, -25.0, 0.0, 10.0, 40.0}) {
    VoiceDirection direction(head_);
    const DirectionEvidence evidence = direction.listen(bursts_from(head_, azimuth_deg, 1));
    const double found_deg = degrees_from_radians(evidence.azimuth_rad());
    // The mirror image behind has nearly the same phase differences.
    const double mirrored_deg = found_deg >= 0.0 ? 180.0 - found_deg : -180.0 - found_deg;
    EXPECT_LE(std::min(std::abs(found_deg - azimuth_deg), std::abs(mirrored_deg - azimuth_deg)),
              5.0 + 1e-9)
        << azimuth_deg;
    const double here = evidence.likelihood_near(radians_from_degrees(azimuth_deg), 0.05);
    EXPECT_GT(here, 100.0 * evidence.likelihood_near(radians_from_degrees(azimuth_deg + 25), 0.05));
  }
}

TEST_F(VoiceDirectionTest, TellsTheSameOfALouderSound) {
  Waveform sound = bursts_from(head_, 30.0, 2);
  VoiceDirection quiet(head_), loud(head_);
  const DirectionEvidence expected = quiet.listen(sound);
  for (float& sample : sound.planar()) sample *= 8.0F;  // a power of two: no rounding
  const DirectionEvidence found = loud.listen(sound);
  for (std::size_t i = 0; i < expected.log_likelihood.size(); ++i) {
    EXPECT_NEAR(found.log_likelihood[i], expected.log_likelihood[i], 1e-6);
  }
  EXPECT_NEAR(found.power, 64.0 * expected.power, 1e-9 * found.power);
}

TEST_F(VoiceDirectionTest, EvidenceOfBlocksAddsUpToThatOfTheWhole) {
  const Waveform sound = bursts_from(head_, -40.0, 3);
  VoiceDirection whole(head_), parts(head_);
  const DirectionEvidence expected = whole.listen(sound);
  std::vector<double> sum(VoiceDirection::kDirections);
  for (std::ptrdiff_t start = 0; start < sound.samples(); start += 3200) {
    Waveform block(2, 3200, 16000);
    for (int ear = 0; ear < 2; ++ear) {
      std::copy_n(sound.channel(ear).begin() + start, 3200, block.channel(ear).begin());
    }
    const DirectionEvidence evidence = parts.listen(block);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += evidence.log_likelihood[i];
  }
  for (std::size_t i = 0; i < sum.size(); ++i) {
    EXPECT_NEAR(sum[i], expected.log_likelihood[i], 1e-9);  // the order of sums
  }
}

TEST_F(VoiceDirectionTest, SilenceTellsNothing) {
  VoiceDirection direction(head_);
  const DirectionEvidence evidence = direction.listen(Waveform(2, 8000, 16000));
  EXPECT_EQ(evidence.power, 0.0);
  for (const double value : evidence.log_likelihood) EXPECT_EQ(value, 0.0);
  EXPECT_DOUBLE_EQ(evidence.likelihood_near(0.0, 0.1), evidence.likelihood_outside(1.0));
}

}  // namespace
}  // namespace earpoint
