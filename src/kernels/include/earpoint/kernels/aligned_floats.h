#pragma once

#include <cstddef>
#include <memory>

namespace earpoint {

/// Floats on a 64-byte boundary, all zero at first. Large arrays ask for large pages: the planes of
/// all channels are visited together, which would need more page addresses than a core remembers.
class AlignedFloats {
 public:
  AlignedFloats() = default;
  /// @param size  >= 0
  explicit AlignedFloats(std::ptrdiff_t size);

  [[nodiscard]] float* data() { return data_.get(); }
  [[nodiscard]] const float* data() const { return data_.get(); }
  [[nodiscard]] std::ptrdiff_t size() const { return size_; }

 private:
  struct Free {
    void operator()(float* data) const;
  };
  std::unique_ptr<float[], Free> data_;
  std::ptrdiff_t size_ = 0;
};

}  // namespace earpoint
