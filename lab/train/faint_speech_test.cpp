#include "faint_speech.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <gtest/gtest.h>

#include <earpoint/audio/energy.h>

namespace earpoint {
namespace {

TEST(FaintSpeech, ATargetViewpointHearsTheNoiseAsLoud) {
  double ratio_db = 0.0;
  constexpr std::uint64_t kDraws = 40;
  for (std::uint64_t draw = 0; draw < kDraws; ++draw) {
    // Nobody speaks, so that noise is all there is.
    PairSample sample;
    sample.source = sample.target = Waveform(2, 8000, 16000);
    sample.dry = Waveform(1, 8000, 16000);
    RandomStream random(draw);
    make_faint(sample, PairTarget::viewpoint, -40.0, random);
    const auto source = sample.source.planar();
    const auto target = sample.target.planar();
    ratio_db += 10.0 * std::log10(energy(target) / energy(source)) / static_cast<double>(kDraws);
    double product = 0.0;
    for (std::size_t i = 0; i < source.size(); ++i) product += double{source[i]} * target[i];
    // Of the darkest noise half a second has some twenty independent values for each ear.
    EXPECT_LT(std::abs(product), 0.8 * std::sqrt(energy(source) * energy(target)));
  }
  // Single ones differ by 3 dB at most, those of a few bursts.
  EXPECT_NEAR(ratio_db, 0.0, 1.0);
}

TEST(FaintSpeech, ANearMicrophoneHearsNoNoise) {
  PairSample sample;
  sample.source = sample.target = Waveform(2, 8000, 16000);
  sample.dry = Waveform(1, 8000, 16000);
  RandomStream random(1);
  make_faint(sample, PairTarget::near_microphone, -40.0, random);
  EXPECT_GT(energy(sample.source.planar()), 0.0);
  EXPECT_EQ(energy(sample.target.planar()), 0.0);
}

}  // namespace
}  // namespace earpoint
