#pragma once

#include <cstdint>
#include <random>
#include <vector>

namespace earpoint {

/// NumPy's legacy generator, as far as the released loaders draw from it, so that their pairs,
/// speakers and windows can be drawn again. Not for anything new: use RandomStream.
/// Source: NumPy's documentation of RandomState; MT19937, Matsumoto and Nishimura (1998).
class NumpyRandom {
 public:
  /// As np.random.seed(seed).
  explicit NumpyRandom(std::uint32_t seed) : engine_(seed) {}

  /// As np.random.randint(0, count) and the index that np.random.choice takes of `count` things.
  /// @param count  > 0
  std::uint32_t index(std::uint32_t count);

  /// As np.random.permutation(count).
  std::vector<int> permutation(int count);

 private:
  std::mt19937 engine_;
};

}  // namespace earpoint
