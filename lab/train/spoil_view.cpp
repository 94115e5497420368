#include "spoil_view.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace earpoint {
namespace {

/// What gtf_view() shows where there is no picture.
constexpr std::uint8_t kGrey = 128;
constexpr double kDarkest = 0.01;
constexpr double kDark = 0.2;

}  // namespace

std::shared_ptr<const Image> spoilt_picture(const Image& picture,
                                            std::shared_ptr<const Image> other,
                                            RandomStream& random) {
  const std::uint64_t kind = random.index(4);
  const double brightness = random.uniform(kDarkest, kDark);
  if (kind == 0) return other;
  if (kind < 3) {
    return std::make_shared<const Image>(picture.width(), picture.height(), picture.channels(),
                                         kind == 1 ? kGrey : std::uint8_t{0});
  }
  Image dark = picture;
  std::ranges::transform(picture.pixels(), dark.pixels().begin(), [&](std::uint8_t value) {
    return static_cast<std::uint8_t>(brightness * value);
  });
  return std::make_shared<const Image>(std::move(dark));
}

}  // namespace earpoint
