#include "spoil_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
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

void widen_picture(PairSample& sample) {
  Image picture = *sample.picture;
  const double height = 9.0 / 16.0 * picture.width() / picture.height();
  if (height >= 1.0) return;
  const double top = 0.5 - 0.5 * height;
  const auto rows = static_cast<std::ptrdiff_t>(std::lround(top * picture.height()));
  const std::ptrdiff_t bar = rows * picture.width() * picture.channels();
  std::fill_n(picture.pixels().begin(), bar, kGrey);
  std::fill_n(picture.pixels().end() - bar, bar, kGrey);
  sample.picture = std::make_shared<const Image>(std::move(picture));
  if (!sample.speaker_box) return;
  Box& box = *sample.speaker_box;
  box.y_min = std::max(box.y_min, top);
  box.y_max = std::min(box.y_max, 1.0 - top);
  if (box.y_min >= box.y_max) sample.speaker_box.reset();
}

}  // namespace earpoint
