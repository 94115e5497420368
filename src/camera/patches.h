#pragma once

#include "sampling.h"
#include "surfaces.h"

#include <cstdint>
#include <span>
#include <vector>

namespace earpoint {

/// A point of a patch to trace from.
struct PatchSample {
  Float3 position;
  Float3 normal;  ///< unit length, on the patch's side
};

/// The surfaces of a scene cut into patches: what lies in one cube of a grid, faces roughly the
/// same way and is seen from the same side of its triangles. Big triangles fall into many patches,
/// many small ones into one. Found from a place on a triangle by a table, without search.
class Patches {
 public:
  static constexpr int kSamples = 8;  ///< per patch, drawn by area

  explicit Patches(const Surfaces& surfaces);

  [[nodiscard]] std::uint32_t size() const { return size_; }

  /// @param u, v  weights of the triangle's second and third vertex
  [[nodiscard]] std::uint32_t at(std::uint32_t triangle, float u, float v, bool front) const;

  /// The same a random bit aside, at most half a patch: borders between patches blur.
  [[nodiscard]] std::uint32_t near(std::uint32_t triangle, float u, float v, bool front,
                                   UnitPair aside) const;

  [[nodiscard]] std::span<const PatchSample> samples(std::uint32_t patch) const {
    return {&samples_[static_cast<std::size_t>(patch) * kSamples], kSamples};
  }

  /// Patches near each other share a region, about 1 m wide.
  [[nodiscard]] std::uint32_t region(std::uint32_t patch) const { return regions_[patch]; }
  [[nodiscard]] std::uint32_t regions() const { return region_count_; }

 private:
  void choose_width(const Surfaces& surfaces);
  void fill(const Surfaces& surfaces);
  void group_regions();

  float width_m_ = 0.25F;
  std::uint32_t size_ = 0;
  std::uint32_t region_count_ = 0;
  std::vector<std::uint32_t> first_bin_;  // [triangles]
  std::vector<std::uint16_t> divisions_;  // [triangles], of each edge
  std::vector<std::uint32_t> bin_patch_;  // [bins][front, back]
  std::vector<PatchSample> samples_;      // [patches][kSamples]
  std::vector<std::uint32_t> regions_;    // [patches]
};

}  // namespace earpoint
