#include <earpoint/dataset/numpy_random.h>

#include <bit>
#include <numeric>
#include <utility>

#include <earpoint/error.h>

namespace earpoint {

std::uint32_t NumpyRandom::index(std::uint32_t count) {
  EARPOINT_CHECK(count > 0);
  const std::uint32_t greatest = count - 1;
  if (greatest == 0) return 0;  // draws nothing
  const std::uint32_t mask = (std::uint32_t{2} << (std::bit_width(greatest) - 1)) - 1;
  std::uint32_t draw = static_cast<std::uint32_t>(engine_()) & mask;
  while (draw > greatest) draw = static_cast<std::uint32_t>(engine_()) & mask;
  return draw;
}

std::vector<int> NumpyRandom::permutation(int count) {
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  for (int i = count - 1; i > 0; --i) {
    std::swap(order[i], order[index(static_cast<std::uint32_t>(i) + 1)]);
  }
  return order;
}

}  // namespace earpoint
