#pragma once

#include "float3.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace earpoint {

/// A point of the unit square, each coordinate in [0, 1).
struct UnitPair {
  float u = 0.0F;
  float v = 0.0F;
};

/// Mixes two words into one in which every bit depends on all.
std::uint32_t hash_words(std::uint32_t a, std::uint32_t b);

/// Uniform in [0, 1) from the upper bits of a word.
constexpr float unit_from_bits(std::uint32_t bits) {
  return static_cast<float>(bits >> 8) * 0x1.0p-24F;
}

/// One point of a two-dimensional Sobol sequence, shuffled and scrambled after Owen. For one seed,
/// every aligned run of 2^n indices is spread evenly over the square: samples of one pixel and of a
/// block of neighbouring pixels (indices along a Morton curve) complete each other.
/// Source: Burley, Practical Hash-based Owen Scrambling, JCGT 9 (2020).
/// @param seed  another for every decision that must not be correlated
UnitPair sobol_pair(std::uint32_t index, std::uint32_t seed);

/// Sixteen points at once, as sobol_pair gives each.
struct UnitPairs {
  std::array<float, 16> u;
  std::array<float, 16> v;

  [[nodiscard]] UnitPair at(int lane) const { return {u[lane], v[lane]}; }
};
void sobol_pairs(const std::array<std::uint32_t, 16>& indices, std::uint32_t seed,
                 UnitPairs& pairs);

/// The place of a pixel on the Morton curve; both in [0, 65535].
std::uint32_t morton_index(std::uint32_t x, std::uint32_t y);

/// Cosine and sine of a turn: of 2 pi v. Polynomials, the same on every machine; the error is below
/// 1e-6.
struct Turn {
  float cosine = 1.0F;
  float sine = 0.0F;
};
inline Turn turn_of(float v) {
  // The nearest quarter and what is left of it, at most an eighth of a turn.
  const int quarter = static_cast<int>(8.0F * v + 1.0F) / 2;
  const float x = 2.0F * kPiF * (v - 0.25F * static_cast<float>(quarter));
  const float x2 = x * x;
  const float sine = x * (1.0F + x2 * (-1.0F / 6 + x2 * (1.0F / 120 - x2 / 5040)));
  const float cosine = 1.0F + x2 * (-0.5F + x2 * (1.0F / 24 + x2 * (-1.0F / 720 + x2 / 40320)));
  switch (quarter & 3) {
    case 0:
      return {cosine, sine};
    case 1:
      return {-sine, cosine};
    case 2:
      return {-cosine, -sine};
    default:
      return {sine, -cosine};
  }
}

/// A direction about +z with density cos / pi.
inline Float3 cosine_direction(UnitPair sample) {
  const float radius = std::sqrt(sample.u);
  const Turn turn = turn_of(sample.v);
  return {radius * turn.cosine, radius * turn.sine, std::sqrt(1.0F - sample.u)};
}

/// A direction in a cone about +z, uniform in solid angle.
/// @param height  one minus the cosine of the cone's half angle: keeps its digits in narrow cones
Float3 cone_direction(UnitPair sample, float height);

/// Splits one uniform number: the part of [low, high) that it fell into becomes a new one.
inline float rescale(float u, float low, float high) {
  return high > low ? std::clamp((u - low) / (high - low), 0.0F, 0x1.fffffep-1F) : 0.5F;
}

}  // namespace earpoint
