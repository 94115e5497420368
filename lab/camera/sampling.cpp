#include "sampling.h"

#include <earpoint/core/vector_clones.h>

namespace earpoint {
namespace {

// Always inlined: the clones of sobol_pairs() need them in their own instruction set.
[[gnu::always_inline]] inline std::uint32_t reverse_bits(std::uint32_t x) {
  x = (x >> 16) | (x << 16);
  x = ((x >> 8) & 0x00FF00FFU) | ((x & 0x00FF00FFU) << 8);
  x = ((x >> 4) & 0x0F0F0F0FU) | ((x & 0x0F0F0F0FU) << 4);
  x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
  return ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
}

// A permutation in which a bit depends on lower bits only (Laine and Karras; constants by Vegdahl,
// 2021): on reversed bits it is Owen's nested scrambling.
[[gnu::always_inline]] inline std::uint32_t permute_upwards(std::uint32_t x, std::uint32_t seed) {
  x ^= x * 0x3D20ADEAU;
  x += seed;
  x *= (seed >> 16) | 1U;
  x ^= x * 0x05526C56U;
  x ^= x * 0x53A22864U;
  return x;
}

// The second Sobol dimension, bits reversed: its matrix is Pascal's triangle modulo 2, so bit b is
// the sum of all bits whose number contains b as a set of binary digits.
[[gnu::always_inline]] inline std::uint32_t pascal_sum(std::uint32_t x) {
  x ^= (x & 0xAAAAAAAAU) >> 1;
  x ^= (x & 0xCCCCCCCCU) >> 2;
  x ^= (x & 0xF0F0F0F0U) >> 4;
  x ^= (x & 0xFF00FF00U) >> 8;
  return x ^ (x >> 16);
}

[[gnu::always_inline]] inline UnitPair scrambled_pair(std::uint32_t index, std::uint32_t seed,
                                                      std::uint32_t seed_u, std::uint32_t seed_v) {
  const std::uint32_t shuffled = reverse_bits(permute_upwards(reverse_bits(index), seed));
  return {unit_from_bits(reverse_bits(permute_upwards(shuffled, seed_u))),
          unit_from_bits(reverse_bits(permute_upwards(pascal_sum(shuffled), seed_v)))};
}

std::uint32_t spread_bits(std::uint32_t x) {
  x = (x | (x << 8)) & 0x00FF00FFU;
  x = (x | (x << 4)) & 0x0F0F0F0FU;
  x = (x | (x << 2)) & 0x33333333U;
  return (x | (x << 1)) & 0x55555555U;
}

}  // namespace

std::uint32_t hash_words(std::uint32_t a, std::uint32_t b) {
  // Two rounds of a 32-bit finalizer (Wellons' lowbias32).
  std::uint32_t x = a ^ (b * 0x9E3779B9U + 0x7F4A7C15U);
  x = (x ^ (x >> 16)) * 0x7FEB352DU;
  x = (x ^ (x >> 15)) * 0x846CA68BU;
  x ^= x >> 16;
  x += b;
  x = (x ^ (x >> 16)) * 0x7FEB352DU;
  x = (x ^ (x >> 15)) * 0x846CA68BU;
  return x ^ (x >> 16);
}

UnitPair sobol_pair(std::uint32_t index, std::uint32_t seed) {
  return scrambled_pair(index, seed, hash_words(seed, 1), hash_words(seed, 2));
}

EARPOINT_VECTOR_CLONES void sobol_pairs(const std::array<std::uint32_t, 16>& indices,
                                        std::uint32_t seed, UnitPairs& pairs) {
  const std::uint32_t seed_u = hash_words(seed, 1);
  const std::uint32_t seed_v = hash_words(seed, 2);
  for (std::size_t lane = 0; lane < 16; ++lane) {
    const UnitPair pair = scrambled_pair(indices[lane], seed, seed_u, seed_v);
    pairs.u[lane] = pair.u;
    pairs.v[lane] = pair.v;
  }
}

std::uint32_t morton_index(std::uint32_t x, std::uint32_t y) {
  return spread_bits(x) | (spread_bits(y) << 1);
}

Float3 cone_direction(UnitPair sample, float height) {
  const float below = sample.u * height;
  const float z = 1.0F - below;
  const float radius = std::sqrt(std::max(0.0F, below * (1.0F + z)));
  const Turn turn = turn_of(sample.v);
  return {radius * turn.cosine, radius * turn.sine, z};
}

}  // namespace earpoint
