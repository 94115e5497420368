#include "passage_sound.h"

#include "line_source_wedge.h"

#include <array>
#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

double decibels(std::complex<double> a, std::complex<double> b) {
  return 20.0 * std::log10(std::abs(a) / std::abs(b));
}

TEST(LineSourceWedge, HankelFunctionIsThatOfBessel) {
  for (const double z : {0.3, 2.0, 4.9, 5.1, 20.0}) {
    const std::complex<double> wanted(j0(z), -y0(z));
    // The asymptotic series ends after eight terms: 1e-5 off where it begins, at 5.
    EXPECT_LT(std::abs(hankel(z) - wanted), 2e-4 * std::abs(wanted)) << z;
  }
  // On the imaginary axis it is 2 i / pi times the modified function K0: 0.113894 at 2 (Abramowitz
  // and Stegun, table 9.8), to six decimals.
  const std::complex<double> modified = hankel({0.0, -2.0}) * kPi / 2.0;
  EXPECT_NEAR(modified.imag(), 0.113894, 1e-5);
  EXPECT_NEAR(modified.real(), 0.0, 1e-5);
}

TEST(LineSourceWedge, FlatWallReflectsAndDiffractsNothing) {
  const EdgePoint source{1.0, 0.4 * kPi, 0.0};
  const EdgePoint receiver{2.0, 0.7 * kPi, 0.0};
  EXPECT_LT(std::abs(line_sound_past_wedge(kPi, source, receiver, {}, 5.0)), 1e-6);
}

TEST(LineSourceWedge, SoundHasNoJumpAtTheShadowBoundary) {
  const EdgePoint source{2.0, 0.25 * kPi, 0.0};
  constexpr double kNumber = 10.0;
  const auto total = [&](double angle, bool lit) {
    const EdgePoint receiver{3.0, angle, 0.0};
    const double straight = std::sqrt(4.0 + 9.0 - 12.0 * std::cos(angle - 0.25 * kPi));
    const std::complex<double> sound =
        line_sound_past_wedge(2.0 * kPi, source, receiver, {.straight = lit}, kNumber);
    return sound + (lit ? hankel(kNumber * straight) : 0.0);
  };
  const std::complex<double> above = total(1.25 * kPi - 1e-4, true);
  const std::complex<double> below = total(1.25 * kPi + 1e-4, false);
  // The two places are 0.6 mm apart, over which the sound changes by this much.
  EXPECT_LT(std::abs(above - below), 3e-3 * std::abs(above));
}

TEST(PassageSound, WidePassageIsTwoSidesAlone) {
  // Sound that is diffracted at both sides falls with their distance: at seven waves it is 0.1 dB
  // at most.
  const Passage passage{3.0, 0.1};
  for (const double y : {-0.5, 1.2, 2.6}) {
    const PassagePlace source{-2.0, 1.3};
    const PassagePlace receiver{2.0, y};
    EXPECT_NEAR(decibels(sound_through_passage(passage, source, receiver, 15.0),
                         sound_past_single_sides(passage, source, receiver, 15.0)),
                0.0, 0.15)
        << y;
  }
}

TEST(PassageSound, NarrowDeepPassageIsAPipe) {
  // A slit much narrower than a wave is loudest if its length, with both end corrections, is half a
  // wave. An open end adds about its width or less.
  const Passage passage{0.05, 0.5};
  double loudest = 0.0;
  double loudest_number = 0.0;
  for (double number = 3.0; number < 7.5; number += 0.02) {
    // Relative to the free field of a line source that is far away.
    const double level = std::abs(
        sound_through_passage(passage, {-3.0, 0.025}, {3.5, 0.025}, number) / hankel(number * 6.5));
    if (level > loudest) {
      loudest = level;
      loudest_number = number;
    }
  }
  const double longer_m = kPi / loudest_number - passage.depth_m;
  EXPECT_GT(longer_m, 0.8 * passage.width_m);
  EXPECT_LT(longer_m, 2.0 * passage.width_m);
}

TEST(PassageSound, IsReciprocal) {
  const Passage passage{0.9, 0.3};
  for (const double number : {1.0, 4.0, 13.0}) {
    const std::complex<double> there =
        sound_through_passage(passage, {-1.5, -0.3}, {2.1, 0.4}, number);
    const std::complex<double> back =
        sound_through_passage(passage, {-1.8, 0.4}, {1.8, -0.3}, number);
    EXPECT_LT(std::abs(there - back), 1e-6 * std::abs(there)) << number;
  }
}

}  // namespace
}  // namespace earpoint
