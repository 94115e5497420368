#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <earpoint/error.h>

namespace earpoint {

/// What one element of a tensor is. Named as safetensors names them (F32, BF16, ...).
enum class DType { f64, f32, f16, bf16, i64, i32, i16, i8, u64, u32, u16, u8, boolean };

/// Bytes of one element: 1, 2, 4 or 8.
[[nodiscard]] std::size_t size_of(DType dtype);

/// The name in a safetensors header: "F32", "BF16", "BOOL", ...
[[nodiscard]] std::string_view name_of(DType dtype);

/// The inverse of name_of; empty when there is no such type.
[[nodiscard]] std::optional<DType> dtype_from_name(std::string_view name);

/// The DType that stands for a C++ type. f16 and bf16 have none in C++20: see to_float32().
template <typename T>
[[nodiscard]] constexpr DType dtype_of() {
  if constexpr (std::is_same_v<T, double>) return DType::f64;
  if constexpr (std::is_same_v<T, float>) return DType::f32;
  if constexpr (std::is_same_v<T, std::int64_t>) return DType::i64;
  if constexpr (std::is_same_v<T, std::int32_t>) return DType::i32;
  if constexpr (std::is_same_v<T, std::int16_t>) return DType::i16;
  if constexpr (std::is_same_v<T, std::int8_t>) return DType::i8;
  if constexpr (std::is_same_v<T, std::uint64_t>) return DType::u64;
  if constexpr (std::is_same_v<T, std::uint32_t>) return DType::u32;
  if constexpr (std::is_same_v<T, std::uint16_t>) return DType::u16;
  if constexpr (std::is_same_v<T, std::uint8_t>) return DType::u8;
}

/// The product of the sizes (1 for a scalar, shape []); empty when a size is negative or the
/// product does not fit in an int64.
[[nodiscard]] std::optional<std::int64_t> element_count(std::span<const std::int64_t> shape);

/// "[64, 2, 1]", for messages.
[[nodiscard]] std::string to_string(std::span<const std::int64_t> shape);

/// A dense array: row-major (the last axis is contiguous), little-endian, without gaps.
struct Tensor {
  DType dtype = DType::f32;
  std::vector<std::int64_t> shape;  ///< [] is a scalar with one element
  std::vector<std::byte> data;      ///< elements() * size_of(dtype) bytes

  /// @throws std::logic_error if the shape has no element count
  [[nodiscard]] std::int64_t elements() const;

  /// The elements, read-only, as long as this tensor lives and its data are not touched.
  /// T is the C++ type of `dtype` exactly; uint8_t also views booleans (0 or 1).
  /// @throws std::logic_error if T is not the tensor's type or the data have another length.
  ///         Check files with expect_tensor() (safetensors.h) first.
  template <typename T>
  [[nodiscard]] std::span<const T> as() const {
    EARPOINT_CHECK(dtype == dtype_of<T>() ||
                   (dtype == DType::boolean && std::is_same_v<T, std::uint8_t>));
    EARPOINT_CHECK(data.size() == static_cast<std::size_t>(elements()) * sizeof(T));
    return {reinterpret_cast<const T*>(data.data()), data.size() / sizeof(T)};
  }
};

/// Equal type, shape and bytes (so a NaN equals the same NaN).
[[nodiscard]] bool operator==(const Tensor& a, const Tensor& b);

/// A tensor that holds a copy of `values`.
/// @param values  row-major, as many as `shape` has elements, else std::logic_error
template <typename T>
[[nodiscard]] Tensor make_tensor(std::span<const T> values, std::vector<std::int64_t> shape) {
  Tensor tensor{dtype_of<T>(), std::move(shape), {}};
  EARPOINT_CHECK(tensor.elements() == static_cast<std::int64_t>(values.size()));
  tensor.data.resize(values.size_bytes());
  if (!values.empty()) std::memcpy(tensor.data.data(), values.data(), values.size_bytes());
  return tensor;
}

/// The values of a floating-point tensor (f64, f32, f16, bf16), as float32. Exact, except that
/// f64 is rounded to the nearest.
/// @throws std::logic_error if it is of another type
[[nodiscard]] Tensor to_float32(const Tensor& tensor);

}  // namespace earpoint
