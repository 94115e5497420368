#pragma once

#include <cstdint>
#include <initializer_list>

namespace earpoint {

/// A seeded stream of random numbers: the same seed gives the same numbers on every machine.
/// xoshiro256++ (Blackman and Vigna, 2019), seeded by splitmix64.
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed) : RandomStream(seed, {}) {}

  /// A separate stream for every key path, e.g. {scene, conversation, purpose}: work can be
  /// split in any order over any number of threads and still draw the same numbers.
  RandomStream(std::uint64_t seed, std::initializer_list<std::uint64_t> keys);

  /// @return 64 uniform bits
  std::uint64_t next();
  /// @return uniform in [0, 1)
  double uniform();
  /// @return uniform in [low, high)
  double uniform(double low, double high);
  /// @return uniform in {0, ..., count - 1}, without bias; count > 0
  std::uint64_t index(std::uint64_t count);
  /// @return normal with mean 0 and variance 1
  double normal();

 private:
  std::uint64_t state_[4];
};

}  // namespace earpoint
