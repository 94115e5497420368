#include "denoise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <earpoint/core/vector_clones.h>

namespace earpoint {
namespace {

constexpr int kLevels = 5;
constexpr int kBorder = 1 << (kLevels - 1);  // the widest step: no neighbour is out of range
constexpr float kReach = 2.0F;               // footprints from the plane of a pixel
constexpr float kTolerance = 5.0F;           // standard deviations that count as noise
constexpr int kSamplesToKnowNoise = 16;

// One number per pixel, with a border of zeros.
class Plane {
 public:
  Plane(int width, int height)
      : stride_(width + 2 * kBorder),
        values_(static_cast<std::size_t>(stride_) * (height + 2 * kBorder)) {}

  /// Numbers from one row to the next.
  [[nodiscard]] std::ptrdiff_t stride() const { return stride_; }
  [[nodiscard]] float* row(int y) { return &values_[offset(y)]; }
  [[nodiscard]] const float* row(int y) const { return &values_[offset(y)]; }

 private:
  [[nodiscard]] std::size_t offset(int y) const {
    return static_cast<std::size_t>(y + kBorder) * stride_ + kBorder;
  }

  int stride_;
  std::vector<float> values_;
};

// Where the pixels lie: planes 0 to 2 position, 3 to 5 normal, 6 one over the reach, 7 the share of
// the samples on that surface.
using Place = std::array<Plane, 8>;

// One kind of light: planes 0 to 2 its colour, 3 luminance, 4 variance of the luminance, 5 one over
// the square of the difference that counts as noise.
using Light = std::array<Plane, 6>;

template <std::size_t kCount>
std::array<Plane, kCount> make_planes(int width, int height) {
  return [&]<std::size_t... kIndex>(std::index_sequence<kIndex...>) {
    return std::array<Plane, kCount>{((void)kIndex, Plane(width, height))...};
  }
  (std::make_index_sequence<kCount>{});
}

void fill_place(const PixelBuffers& buffers, int y, Place& place) {
  for (int x = 0; x < buffers.width; ++x) {
    const std::size_t i = static_cast<std::size_t>(y) * buffers.width + x;
    const Guide& guide = buffers.guides[i];
    const std::array<float, 6> values = {guide.position.x, guide.position.y, guide.position.z,
                                         guide.normal.x,   guide.normal.y,   guide.normal.z};
    const bool there = guide.lit && buffers.sums[i].samples > 0;
    for (std::size_t k = 0; k < 6; ++k) place[k].row(y)[x] = guide.lit ? values[k] : 0.0F;
    place[6].row(y)[x] = guide.lit ? 1.0F / (kReach * guide.footprint_m) : 0.0F;
    place[7].row(y)[x] =
        there ? static_cast<float>(buffers.sums[i].samples) / static_cast<float>(buffers.samples)
              : 0.0F;
  }
}

void fill_light(const PixelBuffers& buffers, int y, std::size_t part, Light& light) {
  for (int x = 0; x < buffers.width; ++x) {
    const PixelSum& sum = buffers.sums[static_cast<std::size_t>(y) * buffers.width + x];
    if (sum.samples == 0) continue;
    const auto n = static_cast<float>(sum.samples);
    const Rgb mean = sum.light.parts[part] * (1.0F / n);
    const float level = luminance(mean);
    light[0].row(y)[x] = mean.x;
    light[1].row(y)[x] = mean.y;
    light[2].row(y)[x] = mean.z;
    light[3].row(y)[x] = level;
    // Variance of the mean. One sample does not show its noise, which is taken to be as large.
    light[4].row(y)[x] = sum.samples > 1
                             ? std::max(0.0F, sum.squares[part] / n - level * level) / (n - 1.0F)
                             : level * level;
  }
}

// The noise of a pixel, estimated together with that of its neighbours.
EARPOINT_VECTOR_CLONES void estimate_noise(const Place& place, int width, int y, bool blind,
                                           Light& light) {
  float* inverse = light[5].row(y);
  if (blind) {
    std::fill(inverse, inverse + width, 0.0F);
    return;
  }
  for (int x = 0; x < width; ++x) {
    float weight = 1e-6F;
    float variance = 0.0F;
    for (int dy = -1; dy <= 1; ++dy) {
      const float* there = place[7].row(y + dy);
      const float* noise = light[4].row(y + dy);
      for (int dx = -1; dx <= 1; ++dx) {
        weight += there[x + dx];
        variance += there[x + dx] * noise[x + dx];
      }
    }
    inverse[x] = 1.0F / (kTolerance * kTolerance * variance / weight + 1e-12F);
  }
}

// The nine pixels that a level averages: the pixel itself and eight neighbours.
struct Taps {
  static constexpr std::size_t kCount = 9;
  static constexpr std::array<float, kCount> kKernel = {0.0625F, 0.125F,  0.0625F, 0.125F, 0.25F,
                                                        0.125F,  0.0625F, 0.125F,  0.0625F};

  Taps(std::ptrdiff_t stride, std::ptrdiff_t step) {
    for (std::ptrdiff_t tap = 0; tap < 9; ++tap) {
      offset[tap] = step * (stride * (tap / 3 - 1) + tap % 3 - 1);
    }
  }

  std::array<std::ptrdiff_t, kCount> offset{};  // in a plane, from the pixel
};

// For one row: how much each neighbour is on the same surface, times the kernel.
struct RowWeights {
  explicit RowWeights(int width) { same.fill(std::vector<float>(static_cast<std::size_t>(width))); }

  std::array<std::vector<float>, Taps::kCount> same;
};

EARPOINT_VECTOR_CLONES void compare_places(const Place& place, int width, int y, const Taps& taps,
                                           RowWeights& weights) {
  const float* px = place[0].row(y);
  const float* py = place[1].row(y);
  const float* pz = place[2].row(y);
  const float* nx = place[3].row(y);
  const float* ny = place[4].row(y);
  const float* nz = place[5].row(y);
  const float* scale = place[6].row(y);
  const float* there = place[7].row(y);
  for (std::size_t tap = 0; tap < Taps::kCount; ++tap) {
    const std::ptrdiff_t to = taps.offset[tap];
    const float kernel = Taps::kKernel[tap];
    float* out = weights.same[tap].data();
    EARPOINT_INDEPENDENT_PASSES
    for (int x = 0; x < width; ++x) {
      const float turn =
          std::max(0.0F, nx[x] * nx[x + to] + ny[x] * ny[x + to] + nz[x] * nz[x + to]);
      const float turn2 = turn * turn;
      const float turn4 = turn2 * turn2;
      const float turn8 = turn4 * turn4;
      const float apart = (nx[x] * (px[x + to] - px[x]) + ny[x] * (py[x + to] - py[x]) +
                           nz[x] * (pz[x + to] - pz[x])) *
                          scale[x];
      out[x] = kernel * turn8 * turn8 * std::max(0.0F, 1.0F - apart * apart) * there[x + to];
    }
  }
}

// One row of one level, one kind of light.
EARPOINT_VECTOR_CLONES void smooth_row(const Light& from, int width, int y, const Taps& taps,
                                       const RowWeights& weights, Light& to) {
  const float* red = from[0].row(y);
  const float* green = from[1].row(y);
  const float* blue = from[2].row(y);
  const float* level = from[3].row(y);
  const float* noise = from[4].row(y);
  const float* inverse = from[5].row(y);
  std::array<const float*, Taps::kCount> same{};
  for (std::size_t tap = 0; tap < Taps::kCount; ++tap) same[tap] = weights.same[tap].data();
  float* to_red = to[0].row(y);
  float* to_green = to[1].row(y);
  float* to_blue = to[2].row(y);
  float* to_level = to[3].row(y);
  float* to_noise = to[4].row(y);
  EARPOINT_INDEPENDENT_PASSES
  for (int x = 0; x < width; ++x) {
    float weight = 0.0F;
    float squares = 0.0F;
    Rgb sum;
    const auto add = [&](std::size_t tap) {
      const std::ptrdiff_t at = x + taps.offset[tap];
      const float difference = level[at] - level[x];
      const float likely = std::max(0.0F, 1.0F - difference * difference * inverse[x]);
      const float w = same[tap][x] * likely * likely;
      weight += w;
      squares += w * w * noise[at];
      sum.x += w * red[at];
      sum.y += w * green[at];
      sum.z += w * blue[at];
    };
    // Unrolled by hand, so that the compiler vectorizes the loop over x.
    add(0), add(1), add(2), add(3), add(4), add(5), add(6), add(7), add(8);
    // Where all weights are zero, the pixel stays as it is.
    const float keep = weight > 1e-8F ? 0.0F : 1.0F;
    const float scale = (1.0F - keep) / (weight + 1e-20F);
    to_red[x] = sum.x * scale + keep * red[x];
    to_green[x] = sum.y * scale + keep * green[x];
    to_blue[x] = sum.z * scale + keep * blue[x];
    to_level[x] = 0.2126F * to_red[x] + 0.7152F * to_green[x] + 0.0722F * to_blue[x];
    to_noise[x] = squares * scale * scale + keep * noise[x];
  }
}

// Whether any pixel has light of that part.
bool has_part(const PixelBuffers& buffers, std::size_t part) {
  return std::any_of(buffers.sums.begin(), buffers.sums.end(),
                     [&](const PixelSum& sum) { return sum.squares[part] > 0.0F; });
}

}  // namespace

std::vector<PlaceLight> mean_light(const PixelBuffers& buffers) {
  std::vector<PlaceLight> light(buffers.sums.size());
  for (std::size_t i = 0; i < light.size(); ++i) {
    const PixelSum& sum = buffers.sums[i];
    if (sum.samples == 0) continue;
    for (std::size_t part = 0; part < PlaceLight::kParts; ++part) {
      light[i].parts[part] = sum.light.parts[part] * (1.0F / static_cast<float>(sum.samples));
    }
  }
  return light;
}

std::vector<PlaceLight> smooth_light(const PixelBuffers& buffers, ThreadPool& pool) {
  const int width = buffers.width;
  const int height = buffers.height;
  const auto each_row = [&](auto body) {
    pool.run(height, [&](std::ptrdiff_t y, int worker) { body(static_cast<int>(y), worker); });
  };
  std::vector<std::size_t> parts;
  for (std::size_t part = 0; part < PlaceLight::kParts; ++part) {
    if (has_part(buffers, part)) parts.push_back(part);
  }

  Place place = make_planes<8>(width, height);
  std::vector<Light> light(parts.size(), make_planes<6>(width, height));
  each_row([&](int y, int) {
    fill_place(buffers, y, place);
    for (std::size_t i = 0; i < parts.size(); ++i) fill_light(buffers, y, parts[i], light[i]);
  });
  std::vector<Light> next = light;
  std::vector<RowWeights> scratch(static_cast<std::size_t>(pool.threads()), RowWeights(width));
  for (int level = 0; level < kLevels; ++level) {
    // The noise of a few samples is not well known, and a rare bright sample exceeds any estimate:
    // the first level treats all differences as noise.
    const bool blind = level == 0 && buffers.samples < kSamplesToKnowNoise;
    each_row([&](int y, int) {
      for (Light& part : light) estimate_noise(place, width, y, blind, part);
    });
    const Taps taps(place[0].stride(), std::ptrdiff_t{1} << level);
    each_row([&](int y, int worker) {
      RowWeights& weights = scratch[static_cast<std::size_t>(worker)];
      compare_places(place, width, y, taps, weights);
      for (std::size_t i = 0; i < light.size(); ++i) {
        smooth_row(light[i], width, y, taps, weights, next[i]);
      }
    });
    std::swap(light, next);
  }

  std::vector<PlaceLight> result(buffers.sums.size());
  each_row([&](int y, int) {
    for (int x = 0; x < width; ++x) {
      PlaceLight& place_light = result[static_cast<std::size_t>(y) * width + x];
      for (std::size_t i = 0; i < parts.size(); ++i) {
        place_light.parts[parts[i]] = {light[i][0].row(y)[x], light[i][1].row(y)[x],
                                       light[i][2].row(y)[x]};
      }
    }
  });
  return result;
}

}  // namespace earpoint
