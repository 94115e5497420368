#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <earpoint/image.h>

namespace earpoint {

/// Collects the colours of faces in one texture, a pixel for each.
class ColourPalette {
 public:
  /// @param colour  red, green, blue as on a screen, in [0, 1]
  /// @return the pixel's number
  std::uint32_t add(const std::array<float, 3>& colour) {
    colours_.push_back(colour);
    return static_cast<std::uint32_t>(colours_.size() - 1);
  }
  [[nodiscard]] bool empty() const { return colours_.empty(); }

  /// The pixel's middle in texture coordinates, once all colours are there.
  [[nodiscard]] std::array<float, 2> uv(std::uint32_t pixel) const;
  [[nodiscard]] Image texture() const;

 private:
  [[nodiscard]] std::uint32_t side() const;
  std::vector<std::array<float, 3>> colours_;
};

}  // namespace earpoint
