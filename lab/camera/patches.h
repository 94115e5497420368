#pragma once

#include "surfaces.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace earpoint {

/// A point of a patch to trace from.
struct PatchSample {
  Float3 position;
  Float3 normal;  ///< unit length, on the patch's side
};

/// How a triangle is cut into bins: parallelograms between parts of two of its edges, and triangles
/// at the third edge; each counts twice, for the two sides. Bins of all triangles share one count.
struct TriangleCut {
  std::uint32_t first = 0;     ///< bin, counting one side alone
  std::int32_t divisions = 1;  ///< of each edge
  float step = 1.0F;           ///< length of a part, of the edge's

  /// @param u, v  weights of the triangle's second and third vertex; clamped to the triangle
  [[nodiscard]] std::size_t bin(float u, float v, bool front) const {
    const auto scale = static_cast<float>(divisions);
    const int j = std::clamp(static_cast<int>(v * scale), 0, divisions - 1);
    const int i = std::clamp(static_cast<int>(u * scale), 0, divisions - 1 - j);
    const int number = j * divisions - j * (j - 1) / 2 + i;  // at most 40,000 divisions: fits
    return 2 * (first + static_cast<std::size_t>(number)) + (front ? 0 : 1);
  }
  [[nodiscard]] std::size_t first_bin() const { return 2 * static_cast<std::size_t>(first); }
  [[nodiscard]] std::size_t bins() const {
    return static_cast<std::size_t>(divisions) * (static_cast<std::size_t>(divisions) + 1);
  }
};

/// The surfaces of a scene cut into patches: what lies in one cube of a grid, faces roughly the
/// same way and is seen from the same side of its triangles. Big triangles fall into many patches,
/// many small ones into one. Found from a place on a triangle by a table, without search.
class Patches {
 public:
  static constexpr int kSamples = 8;  ///< per patch, drawn by area

  explicit Patches(const Surfaces& surfaces);

  /// Keeps the patches of `base` and adds those of the triangles that `surfaces` has beyond it, in
  /// regions of their own.
  Patches(const Patches& base, const Surfaces& surfaces);

  [[nodiscard]] std::uint32_t size() const { return size_; }

  /// @param u, v  weights of the triangle's second and third vertex
  [[nodiscard]] std::uint32_t at(std::uint32_t triangle, float u, float v, bool front) const {
    return bin_patch_[cuts_[triangle].bin(u, v, front)];
  }

  [[nodiscard]] const TriangleCut& cut(std::uint32_t triangle) const { return cuts_[triangle]; }
  [[nodiscard]] std::size_t bins() const { return bin_patch_.size(); }
  [[nodiscard]] std::uint32_t patch_of_bin(std::size_t bin) const { return bin_patch_[bin]; }

  [[nodiscard]] std::span<const PatchSample> samples(std::uint32_t patch) const {
    return {&samples_[static_cast<std::size_t>(patch) * kSamples], kSamples};
  }

  /// Patches near each other share a region, about 1 m wide.
  [[nodiscard]] std::uint32_t region(std::uint32_t patch) const { return regions_[patch]; }
  [[nodiscard]] std::uint32_t regions() const { return region_count_; }

 private:
  void choose_width(const Surfaces& surfaces);
  void cut_triangle(const Surfaces& surfaces, std::uint32_t triangle, std::size_t& bins);
  void fill(const Surfaces& surfaces, std::uint32_t first_triangle);
  void group_regions();

  float width_m_ = 0.25F;
  std::uint32_t size_ = 0;
  std::uint32_t region_count_ = 0;
  std::vector<TriangleCut> cuts_;         // [triangles]
  std::vector<std::uint32_t> bin_patch_;  // [bins][front, back]
  std::vector<PatchSample> samples_;      // [patches][kSamples]
  std::vector<std::uint32_t> regions_;    // [patches]
};

}  // namespace earpoint
