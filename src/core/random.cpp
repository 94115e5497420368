#include <earpoint/core/random.h>

#include <bit>
#include <cmath>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

std::uint64_t splitmix64(std::uint64_t& state) {
  state += 0x9E3779B97F4A7C15U;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31);
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::initializer_list<std::uint64_t> keys) {
  std::uint64_t mixed = seed;
  for (const std::uint64_t key : keys) {
    // Each key is mixed through the whole word, so that {1, 2} and {2, 1} are far apart.
    mixed = splitmix64(mixed) ^ key;
  }
  for (std::uint64_t& word : state_) word = splitmix64(mixed);
}

std::uint64_t RandomStream::next() {
  const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
  const std::uint64_t shifted = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= shifted;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double RandomStream::uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

double RandomStream::uniform(double low, double high) { return low + (high - low) * uniform(); }

std::uint64_t RandomStream::index(std::uint64_t count) {
  EARPOINT_CHECK(count > 0);
  // Draws above the largest multiple of `count` would favour the small indices: draw again.
  const std::uint64_t excess = (0 - count) % count;
  std::uint64_t draw = next();
  while (draw < excess) draw = next();
  return draw % count;
}

double RandomStream::normal() {
  // Box and Muller's transform; the second number is dropped, so that one call is one draw.
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(2.0 * kPi * uniform());
}

}  // namespace earpoint
