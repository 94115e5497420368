#include "develop.h"

#include "sampling.h"
#include "texture.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace earpoint {
namespace {

constexpr float kNeighbourReach = 2.5F;  // footprints

Rgb leaving(const Rgb& albedo, const Rgb& added, const PlaceLight& light) {
  return albedo * light.irradiance() * (1.0F / kPiF) + light.parts[PlaceLight::gloss] + added;
}

// Radiance of those samples of a pixel that lie on the surface at its middle.
Rgb middle_radiance(const PixelSum& sum, const PlaceLight& light) {
  const float scale = 1.0F / static_cast<float>(sum.samples);
  return leaving(sum.albedo * scale, sum.added * scale, light);
}

}  // namespace

namespace {

constexpr float kTileReach = 4.0F;  // footprints

/// The light for a stray sample, from the pixels around it whose middles show its surface.
/// @return false if there are none
bool borrow_from_middles(const std::vector<PlaceLight>& light, const PixelBuffers& buffers,
                         StraySample& stray) {
  const int x = static_cast<int>(stray.pixel) % buffers.width;
  const int y = static_cast<int>(stray.pixel) / buffers.width;
  PlaceLight sum;
  float weights = 0.0F;
  for (int row = std::max(0, y - 1); row <= std::min(buffers.height - 1, y + 1); ++row) {
    for (int column = std::max(0, x - 1); column <= std::min(buffers.width - 1, x + 1); ++column) {
      const std::size_t i = static_cast<std::size_t>(row) * buffers.width + column;
      if (buffers.sums[i].samples == 0) continue;
      const float weight = same_surface(buffers.guides[i], stray.place, kNeighbourReach);
      for (std::size_t part = 0; part < PlaceLight::kParts; ++part) {
        sum.parts[part] += light[i].parts[part] * weight;
      }
      weights += weight;
    }
  }
  if (weights <= 0.0F) return false;
  for (std::size_t part = 0; part < PlaceLight::kParts; ++part) {
    stray.light.parts[part] = sum.parts[part] * (1.0F / weights);
  }
  return true;
}

/// The mean light of those samples that lie on the surface of one of them.
PlaceLight shared_light(const std::vector<const StraySample*>& samples, const StraySample& of) {
  PlaceLight sum;
  float weights = 0.0F;
  for (const StraySample* sample : samples) {
    const float weight = sample == &of ? 1.0F : same_surface(of.place, sample->place, kTileReach);
    for (std::size_t part = 0; part < PlaceLight::kParts; ++part) {
      sum.parts[part] += sample->light.parts[part] * weight;
    }
    weights += weight;
  }
  for (Rgb& part : sum.parts) part = part * (1.0F / weights);
  return sum;
}

}  // namespace

void borrow_light(const std::vector<PlaceLight>& light, PixelBuffers& buffers, ThreadPool& pool) {
  const auto tiles = static_cast<std::ptrdiff_t>(buffers.strays.size());
  pool.run(tiles, [&](std::ptrdiff_t tile, int) {
    // Surfaces that are at the middle of no pixel, such as a pane in front of other things, share
    // their light within the tile.
    std::vector<const StraySample*> alone;
    std::vector<StraySample*> waiting;
    for (StraySample& stray : buffers.strays[static_cast<std::size_t>(tile)]) {
      if (borrow_from_middles(light, buffers, stray)) continue;
      alone.push_back(&stray);
      waiting.push_back(&stray);
    }
    std::vector<PlaceLight> shared;
    shared.reserve(alone.size());
    for (const StraySample* stray : alone) shared.push_back(shared_light(alone, *stray));
    for (std::size_t i = 0; i < waiting.size(); ++i) waiting[i]->light = shared[i];
  });
}

FloatImage put_together(const PixelBuffers& buffers, const std::vector<PlaceLight>& light) {
  std::vector<Rgb> sums(buffers.sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const PixelSum& sum = buffers.sums[i];
    if (sum.samples == 0) continue;
    sums[i] = middle_radiance(sum, light[i]) * static_cast<float>(sum.samples);
  }
  for (const std::vector<StraySample>& tile : buffers.strays) {
    for (const StraySample& stray : tile) {
      sums[stray.pixel] += leaving(stray.albedo, stray.added, stray.light);
    }
  }
  FloatImage radiance(buffers.width, buffers.height, 3);
  const float scale = 1.0F / static_cast<float>(buffers.samples);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    radiance.pixels()[3 * i] = sums[i].x * scale;
    radiance.pixels()[3 * i + 1] = sums[i].y * scale;
    radiance.pixels()[3 * i + 2] = sums[i].z * scale;
  }
  return radiance;
}

float find_exposure(const FloatImage& radiance) {
  // The mean logarithm over the middle range of brightness, so that neither a window nor a dark
  // corner sets the exposure.
  constexpr float kDarkest = 1e-6F;
  constexpr double kLowShare = 0.1;
  constexpr double kHighShare = 0.9;
  constexpr double kGreyCard = 0.20;
  constexpr double kAdaptation = 0.85;  // 1 would show a cellar as bright as a terrace
  std::vector<float> levels;
  const auto pixels = radiance.pixels();
  for (std::size_t i = 0; i + 2 < pixels.size(); i += 3) {
    const float level = luminance({pixels[i], pixels[i + 1], pixels[i + 2]});
    if (level > kDarkest) levels.push_back(level);
  }
  if (levels.empty()) return 1.0F;
  const auto count = static_cast<double>(levels.size());
  const auto low = levels.begin() + static_cast<std::ptrdiff_t>(kLowShare * count);
  const auto high =
      std::max(low + 1, levels.begin() + static_cast<std::ptrdiff_t>(kHighShare * count));
  std::nth_element(levels.begin(), low, levels.end());
  std::nth_element(low, high, levels.end());
  const double sum = std::accumulate(
      low, high, 0.0, [](double so_far, float level) { return so_far + std::log(level); });
  const double middle = std::exp(sum / static_cast<double>(high - low));
  return static_cast<float>(kGreyCard / std::pow(middle, kAdaptation));
}

Rgb film_curve(const Rgb& radiance) {
  // Hable's curve (Filmic Tonemapping for Real-time Rendering, SIGGRAPH course 2010) with its
  // published constants.
  const auto curve = [](float x) {
    constexpr float kShoulder = 0.22F;
    constexpr float kLinear = 0.30F;
    constexpr float kAngle = 0.10F;
    constexpr float kToe = 0.20F;
    constexpr float kNumerator = 0.01F;
    constexpr float kDenominator = 0.30F;
    return (x * (kShoulder * x + kAngle * kLinear) + kToe * kNumerator) /
               (x * (kShoulder * x + kLinear) + kToe * kDenominator) -
           kNumerator / kDenominator;
  };
  constexpr float kWhite = 6.0F;
  constexpr float kBefore = 2.0F;
  const float scale = 1.0F / curve(kWhite);
  const auto channel = [&](float x) {
    return std::clamp(curve(kBefore * std::max(0.0F, x)) * scale, 0.0F, 1.0F);
  };
  return {channel(radiance.x), channel(radiance.y), channel(radiance.z)};
}

Image develop(const PixelBuffers& buffers, const std::vector<PlaceLight>& light, float exposure,
              ThreadPool& pool) {
  std::vector<Rgb> screen(buffers.sums.size());
  pool.run(buffers.height, [&](std::ptrdiff_t y, int) {
    const std::size_t first = static_cast<std::size_t>(y) * buffers.width;
    for (std::size_t i = first; i < first + buffers.width; ++i) {
      const PixelSum& sum = buffers.sums[i];
      if (sum.samples == 0) continue;
      screen[i] =
          film_curve(middle_radiance(sum, light[i]) * exposure) * static_cast<float>(sum.samples);
    }
  });
  for (const std::vector<StraySample>& tile : buffers.strays) {
    for (const StraySample& stray : tile) {
      screen[stray.pixel] += film_curve(leaving(stray.albedo, stray.added, stray.light) * exposure);
    }
  }
  Image picture(buffers.width, buffers.height, 3);
  const float scale = 1.0F / static_cast<float>(buffers.samples);
  for (std::size_t i = 0; i < screen.size(); ++i) {
    picture.pixels()[3 * i] = srgb_from_linear(screen[i].x * scale);
    picture.pixels()[3 * i + 1] = srgb_from_linear(screen[i].y * scale);
    picture.pixels()[3 * i + 2] = srgb_from_linear(screen[i].z * scale);
  }
  return picture;
}

}  // namespace earpoint
