#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <earpoint/vector3.h>

namespace earpoint {

/// Triangles that lie on each other: the foot of a cupboard and the floor, a face that a model has
/// twice. Which of them a ray tracing library finds first hangs on the last bits of its
/// reciprocals, which differ from processor to processor; here the one with the highest number
/// counts, since what is put on something is added after it.
class CoincidentFaces {
 public:
  CoincidentFaces() = default;
  /// @param positions  [vertices], metres
  /// @param triangles  [triangles], indices into positions
  /// Cost: O(n log n) for n triangles, and O(k) for each of k that share a plane.
  CoincidentFaces(std::span<const std::array<float, 3>> positions,
                  std::span<const std::array<std::uint32_t, 3>> triangles);

  /// @return those that a triangle shares some of its area with, in ascending order
  [[nodiscard]] std::span<const std::uint32_t> partners(std::uint32_t triangle) const {
    if (first_.empty()) return {};
    return std::span(partners_).subspan(first_[triangle], first_[triangle + 1] - first_[triangle]);
  }

  /// The triangle that counts where a ray meets one.
  /// @param found    the triangle that the ray meets
  /// @param allowed  whether a ray can hit the triangle at all
  template <typename Allowed>
  [[nodiscard]] std::uint32_t on_top(std::uint32_t found, const std::array<float, 3>& origin,
                                     const std::array<float, 3>& direction,
                                     const Allowed& allowed) const {
    const std::span<const std::uint32_t> others = partners(found);
    if (others.empty()) return found;
    for (std::size_t i = others.size(); i > 0 && others[i - 1] > found; --i) {
      const std::uint32_t other = others[i - 1];
      if (allowed(other) && meet(other, origin, direction)) return other;
    }
    return found;
  }

 private:
  [[nodiscard]] bool meet(std::uint32_t triangle, const std::array<float, 3>& origin,
                          const std::array<float, 3>& direction) const;

  std::vector<std::uint32_t> first_;     // [triangles + 1], into partners_; empty if none has any
  std::vector<std::uint32_t> partners_;  // of all triangles
  std::vector<std::array<Vector3, 3>> corners_;  // [triangles], empty likewise
};

}  // namespace earpoint
