#include "denoise.h"

#include "vector_clones.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace earpoint {
namespace {

constexpr int kLevels = 5;
constexpr int kBorder = 1 << (kLevels - 1);  // the widest step: no neighbour is out of range
constexpr float kReach = 2.0F;               // footprints off the plane of a place
constexpr float kTolerance = 3.0F;           // standard deviations that noise explains
constexpr int kSamplesToKnowNoise = 16;

// One number per pixel, with a border of zeros.
class Plane {
 public:
  Plane(int width, int height)
      : stride_(width + 2 * kBorder),
        values_(static_cast<std::size_t>(stride_) * (height + 2 * kBorder)) {}

  [[nodiscard]] float* row(int y) { return &values_[offset(y)]; }
  [[nodiscard]] const float* row(int y) const { return &values_[offset(y)]; }

 private:
  [[nodiscard]] std::size_t offset(int y) const {
    return static_cast<std::size_t>(y + kBorder) * stride_ + kBorder;
  }

  int stride_;
  std::vector<float> values_;
};

// Where the pixels lie: planes 0 to 2 position, 3 to 5 normal, 6 one over the reach, 7 how much of
// the pixel there is.
using Place = std::array<Plane, 8>;

// One kind of light: planes 0 to 2 its colour, 3 luminance, 4 variance of the luminance, 5 one over
// the square of the difference that noise explains.
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
    // Of the mean; a single sample says nothing about its noise: as large as itself.
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

// Sums of one row.
struct RowSums {
  explicit RowSums(int width)
      : weight(static_cast<std::size_t>(width)), squares(weight), colour{weight, weight, weight} {}

  void clear() {
    for (std::vector<float>* values : {&weight, &squares, &colour[0], &colour[1], &colour[2]}) {
      std::fill(values->begin(), values->end(), 0.0F);
    }
  }

  std::vector<float> weight;
  std::vector<float> squares;
  std::array<std::vector<float>, 3> colour;
};

// How far the pixels of row y and their neighbours in row y + dy, dx aside, are on one surface.
EARPOINT_VECTOR_CLONES void compare_places(const Place& place, int width, int y, int dx, int dy,
                                           std::vector<float>& same) {
  const float* px = place[0].row(y);
  const float* py = place[1].row(y);
  const float* pz = place[2].row(y);
  const float* nx = place[3].row(y);
  const float* ny = place[4].row(y);
  const float* nz = place[5].row(y);
  const float* scale = place[6].row(y);
  const float* qx = place[0].row(y + dy) + dx;
  const float* qy = place[1].row(y + dy) + dx;
  const float* qz = place[2].row(y + dy) + dx;
  const float* mx = place[3].row(y + dy) + dx;
  const float* my = place[4].row(y + dy) + dx;
  const float* mz = place[5].row(y + dy) + dx;
  const float* there = place[7].row(y + dy) + dx;
  float* out = same.data();
  for (int x = 0; x < width; ++x) {
    const float turn = std::max(0.0F, nx[x] * mx[x] + ny[x] * my[x] + nz[x] * mz[x]);
    const float turn2 = turn * turn;
    const float turn4 = turn2 * turn2;
    const float turn8 = turn4 * turn4;
    const float apart =
        (nx[x] * (qx[x] - px[x]) + ny[x] * (qy[x] - py[x]) + nz[x] * (qz[x] - pz[x])) * scale[x];
    out[x] = turn8 * turn8 * std::max(0.0F, 1.0F - apart * apart) * there[x];
  }
}

EARPOINT_VECTOR_CLONES void add_neighbours(const Light& light, int width, int y, int dx, int dy,
                                           float kernel, const std::vector<float>& same_surface,
                                           RowSums& sums) {
  const float* same = same_surface.data();
  const float* inverse = light[5].row(y);
  const float* level = light[3].row(y);
  const float* red = light[0].row(y + dy) + dx;
  const float* green = light[1].row(y + dy) + dx;
  const float* blue = light[2].row(y + dy) + dx;
  const float* other = light[3].row(y + dy) + dx;
  const float* noise = light[4].row(y + dy) + dx;
  float* weight = sums.weight.data();
  float* squares = sums.squares.data();
  float* to_red = sums.colour[0].data();
  float* to_green = sums.colour[1].data();
  float* to_blue = sums.colour[2].data();
  for (int x = 0; x < width; ++x) {
    const float difference = other[x] - level[x];
    const float likely = 1.0F / (1.0F + difference * difference * inverse[x]);
    const float w = kernel * same[x] * likely * likely;
    weight[x] += w;
    squares[x] += w * w * noise[x];
    to_red[x] += w * red[x];
    to_green[x] += w * green[x];
    to_blue[x] += w * blue[x];
  }
}

void write_row(const RowSums& sums, const Light& from, int width, int y, Light& to) {
  for (int x = 0; x < width; ++x) {
    // Without a neighbour (nor itself) a pixel stays as it is.
    const float weight = sums.weight[x];
    const bool found = weight > 1e-8F;
    const float scale = found ? 1.0F / weight : 0.0F;
    Rgb colour{sums.colour[0][x] * scale, sums.colour[1][x] * scale, sums.colour[2][x] * scale};
    if (!found) colour = {from[0].row(y)[x], from[1].row(y)[x], from[2].row(y)[x]};
    to[0].row(y)[x] = colour.x;
    to[1].row(y)[x] = colour.y;
    to[2].row(y)[x] = colour.z;
    to[3].row(y)[x] = luminance(colour);
    to[4].row(y)[x] = found ? sums.squares[x] * scale * scale : from[4].row(y)[x];
  }
}

// What one thread works with.
struct Scratch {
  explicit Scratch(int width) : sums(width) {
    same.fill(std::vector<float>(static_cast<std::size_t>(width)));
  }

  std::array<std::vector<float>, 9> same;  // how far each neighbour is on the same surface
  RowSums sums;
};

// One row of one level, all kinds of light.
void smooth_row(const Place& place, const std::vector<Light>& from, int width, int y, int step,
                Scratch& scratch, std::vector<Light>& to) {
  std::array<std::vector<float>, 9>& same = scratch.same;
  for (int tap = 0; tap < 9; ++tap) {
    compare_places(place, width, y, step * (tap % 3 - 1), step * (tap / 3 - 1), same[tap]);
  }
  for (std::size_t part = 0; part < from.size(); ++part) {
    scratch.sums.clear();
    for (int tap = 0; tap < 9; ++tap) {
      const int column = tap % 3 - 1;
      const int row = tap / 3 - 1;
      const float kernel = (row == 0 ? 0.5F : 0.25F) * (column == 0 ? 0.5F : 0.25F);
      add_neighbours(from[part], width, y, step * column, step * row, kernel, same[tap],
                     scratch.sums);
    }
    write_row(scratch.sums, from[part], width, y, to[part]);
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
  std::vector<Scratch> scratch(static_cast<std::size_t>(pool.threads()), Scratch(width));
  for (int level = 0; level < kLevels; ++level) {
    // A few samples hardly know their own noise, and a rare bright one stands out from any
    // estimate: the first level takes all neighbours for alike.
    const bool blind = level == 0 && buffers.samples < kSamplesToKnowNoise;
    each_row([&](int y, int) {
      for (Light& part : light) estimate_noise(place, width, y, blind, part);
    });
    each_row([&](int y, int worker) {
      smooth_row(place, light, width, y, 1 << level, scratch[static_cast<std::size_t>(worker)],
                 next);
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
