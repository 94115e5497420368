#include "patches.h"

#include "sampling.h"

#include <cmath>
#include <unordered_map>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr std::size_t kMostBins = 3'000'000;
constexpr double kMostPatches = 100'000.0;  // of flat surface; clutter adds some
constexpr float kRegionWidthM = 1.0F;
// Not a round number, so that walls and floors do not lie on the border between two cubes.
constexpr float kGridShiftM = 0.0737F;

std::uint64_t cube_key(const Float3& position, float width_m) {
  const auto cell = [&](float coordinate) {
    const auto index = static_cast<std::int64_t>(std::floor((coordinate + kGridShiftM) / width_m));
    return static_cast<std::uint64_t>(index) & 0xFFFFFU;
  };
  return (cell(position.x) << 40) | (cell(position.y) << 20) | cell(position.z);
}

// Which of the six axis directions a normal is nearest to.
std::uint64_t facing(const Float3& normal) {
  const Float3 size{std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)};
  if (size.x >= size.y && size.x >= size.z) return normal.x > 0.0F ? 0 : 1;
  if (size.y >= size.z) return normal.y > 0.0F ? 2 : 3;
  return normal.z > 0.0F ? 4 : 5;
}

// Division of an edge of length `longest` into parts of at most `width`.
int divisions_of(float longest_m, float width_m) {
  return static_cast<int>(std::clamp(std::ceil(longest_m / width_m), 1.0F, 40'000.0F));
}

std::size_t bins_of(std::size_t divisions) { return divisions * (divisions + 1) / 2; }

float longest_edge(const Surfaces& surfaces, std::uint32_t triangle) {
  const Float3 a = surfaces.corner(triangle, 0);
  const Float3 b = surfaces.corner(triangle, 1);
  const Float3 c = surfaces.corner(triangle, 2);
  return std::max(norm(b - a), std::max(norm(c - b), norm(a - c)));
}

}  // namespace

Patches::Patches(const Surfaces& surfaces) {
  choose_width(surfaces);
  fill(surfaces, 0);
  group_regions();
}

Patches::Patches(const Patches& base, const Surfaces& surfaces) : Patches(base) {
  const auto first = static_cast<std::uint32_t>(cuts_.size());
  std::size_t bins = bin_patch_.size() / 2;
  for (std::uint32_t i = first; i < surfaces.triangles(); ++i) cut_triangle(surfaces, i, bins);
  bin_patch_.resize(2 * bins);
  fill(surfaces, first);
  group_regions();
}

void Patches::cut_triangle(const Surfaces& surfaces, std::uint32_t triangle, std::size_t& bins) {
  const int divisions = divisions_of(longest_edge(surfaces, triangle), width_m_);
  cuts_.push_back({.first = static_cast<std::uint32_t>(bins),
                   .divisions = divisions,
                   .step = 1.0F / static_cast<float>(divisions)});
  bins += bins_of(static_cast<std::size_t>(divisions));
}

void Patches::choose_width(const Surfaces& surfaces) {
  double area_m2 = 0.0;
  for (std::uint32_t i = 0; i < surfaces.triangles(); ++i) area_m2 += surfaces.area_m2(i);
  // Both sides of everything.
  width_m_ = std::max(width_m_, static_cast<float>(std::sqrt(2.0 * area_m2 / kMostPatches)));
  while (true) {
    cuts_.clear();
    std::size_t bins = 0;
    for (std::uint32_t i = 0; i < surfaces.triangles(); ++i) cut_triangle(surfaces, i, bins);
    if (bins <= kMostBins + surfaces.triangles()) {
      bin_patch_.resize(2 * bins);
      return;
    }
    width_m_ *= 1.4F;
  }
}

void Patches::fill(const Surfaces& surfaces, std::uint32_t first_triangle) {
  std::unordered_map<std::uint64_t, std::uint32_t> patch_of_key;
  std::vector<float> weights(size_);  // [patches], area of all bins so far
  for (std::uint32_t triangle = first_triangle; triangle < surfaces.triangles(); ++triangle) {
    const int n = cuts_[triangle].divisions;
    const float bin_area = surfaces.area_m2(triangle) / static_cast<float>(n * n);
    std::uint32_t number = cuts_[triangle].first;
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i + j < n; ++i, ++number) {
        // A bin is a parallelogram, at the slanted edge a triangle: half as large.
        const bool whole = i + j + 1 < n;
        const float area = std::max(1e-12F, whole ? 2.0F * bin_area : bin_area);
        const float middle = whole ? 0.5F : 1.0F / 3.0F;
        const float scale = 1.0F / static_cast<float>(n);
        const Float3 centre = surfaces.position(triangle, (static_cast<float>(i) + middle) * scale,
                                                (static_cast<float>(j) + middle) * scale);
        UnitPair inside{unit_from_bits(hash_words(number, 11)),
                        unit_from_bits(hash_words(number, 12))};
        if (!whole && inside.u + inside.v > 1.0F) inside = {1.0F - inside.u, 1.0F - inside.v};
        const Float3 sample =
            surfaces.position(triangle, (static_cast<float>(i) + inside.u) * scale,
                              (static_cast<float>(j) + inside.v) * scale);
        for (int side = 0; side < 2; ++side) {
          const Float3 normal =
              side == 0 ? surfaces.face_normal(triangle) : -surfaces.face_normal(triangle);
          const std::uint64_t key =
              cube_key(centre, width_m_) << 4 | facing(normal) << 1 | static_cast<unsigned>(side);
          const auto [entry, is_new] = patch_of_key.try_emplace(key, size_);
          const std::uint32_t patch = entry->second;
          if (is_new) {
            ++size_;
            weights.push_back(0.0F);
            samples_.resize(samples_.size() + kSamples);
          }
          weights[patch] += area;
          // Every slot keeps one of the bins so far, drawn by area.
          for (int slot = 0; slot < kSamples; ++slot) {
            const float draw =
                unit_from_bits(hash_words(number, static_cast<std::uint32_t>(20 + slot)));
            if (draw * weights[patch] > area) continue;
            samples_[static_cast<std::size_t>(patch) * kSamples + slot] = {sample, normal};
          }
          bin_patch_[2 * static_cast<std::size_t>(number) + side] = patch;
        }
      }
    }
  }
}

void Patches::group_regions() {
  // Regions grow with the width of patches, which grows with the scene.
  const float width_m = kRegionWidthM * width_m_ / 0.25F;
  std::unordered_map<std::uint64_t, std::uint32_t> region_of_key;
  for (auto patch = static_cast<std::uint32_t>(regions_.size()); patch < size_; ++patch) {
    const std::uint64_t key = cube_key(samples(patch)[0].position, width_m);
    const auto [entry, is_new] = region_of_key.try_emplace(key, region_count_);
    if (is_new) ++region_count_;
    regions_.push_back(entry->second);
  }
}

}  // namespace earpoint
