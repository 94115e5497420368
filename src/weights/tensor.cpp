#include <earpoint/weights/tensor.h>

#include <array>
#include <bit>
#include <limits>
#include <utility>

namespace earpoint {
namespace {

static_assert(std::endian::native == std::endian::little, "files are read without byte swaps");

struct DTypeFacts {
  DType dtype;
  std::string_view name;
  std::size_t size;
};

constexpr std::array<DTypeFacts, 13> kFacts{{{DType::f64, "F64", 8},
                                             {DType::f32, "F32", 4},
                                             {DType::f16, "F16", 2},
                                             {DType::bf16, "BF16", 2},
                                             {DType::i64, "I64", 8},
                                             {DType::i32, "I32", 4},
                                             {DType::i16, "I16", 2},
                                             {DType::i8, "I8", 1},
                                             {DType::u64, "U64", 8},
                                             {DType::u32, "U32", 4},
                                             {DType::u16, "U16", 2},
                                             {DType::u8, "U8", 1},
                                             {DType::boolean, "BOOL", 1}}};

const DTypeFacts& facts_of(DType dtype) {
  for (const DTypeFacts& facts : kFacts) {
    if (facts.dtype == dtype) return facts;
  }
  throw std::logic_error("not a DType");
}

float float_from_bf16(std::uint16_t bits) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(bits) << 16U);
}

/// IEEE 754 binary16: 1 sign, 5 exponent and 10 fraction bits.
float float_from_f16(std::uint16_t half) {
  const std::uint32_t sign = (half & 0x8000U) << 16U;
  const std::uint32_t exponent = (half >> 10U) & 0x1FU;
  const std::uint32_t fraction = half & 0x3FFU;
  if (exponent == 0) {  // zero and subnormals: fraction * 2^-24, exact in float32
    const float magnitude = static_cast<float>(fraction) * 0x1p-24F;
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(magnitude) | sign);
  }
  const std::uint32_t wide_exponent = exponent == 0x1F ? 0xFFU : exponent + (127U - 15U);
  return std::bit_cast<float>(sign | (wide_exponent << 23U) | (fraction << 13U));
}

template <typename From, typename Convert>
void convert_elements(const Tensor& from, Tensor& to, Convert convert) {
  for (std::size_t i = 0; i < from.data.size() / sizeof(From); ++i) {
    From value;
    std::memcpy(&value, from.data.data() + i * sizeof(From), sizeof(From));
    const float converted = convert(value);
    std::memcpy(to.data.data() + i * sizeof(float), &converted, sizeof(float));
  }
}

}  // namespace

std::size_t size_of(DType dtype) { return facts_of(dtype).size; }

std::string_view name_of(DType dtype) { return facts_of(dtype).name; }

std::optional<DType> dtype_from_name(std::string_view name) {
  for (const DTypeFacts& facts : kFacts) {
    if (facts.name == name) return facts.dtype;
  }
  return std::nullopt;
}

std::optional<std::int64_t> element_count(std::span<const std::int64_t> shape) {
  // A size of zero makes the product zero wherever it stands, but must not hide a negative one.
  std::int64_t count = 1;
  bool overflow = false;
  bool zero = false;
  for (const std::int64_t size : shape) {
    if (size < 0) return std::nullopt;
    zero = zero || size == 0;
    if (size != 0) overflow = __builtin_mul_overflow(count, size, &count) || overflow;
  }
  if (zero) return 0;
  if (overflow) return std::nullopt;
  return count;
}

std::string to_string(std::span<const std::int64_t> shape) {
  std::string text = "[";
  for (const std::int64_t size : shape) {
    if (text.size() > 1) text += ", ";
    text += std::to_string(size);
  }
  return text + "]";
}

std::int64_t Tensor::elements() const {
  const std::optional<std::int64_t> count = element_count(shape);
  EARPOINT_CHECK(count.has_value());
  return *count;
}

bool operator==(const Tensor& a, const Tensor& b) {
  return a.dtype == b.dtype && a.shape == b.shape && a.data == b.data;
}

Tensor to_float32(const Tensor& tensor) {
  EARPOINT_CHECK(tensor.data.size() ==
                 static_cast<std::size_t>(tensor.elements()) * size_of(tensor.dtype));
  if (tensor.dtype == DType::f32) return tensor;
  Tensor result{DType::f32, tensor.shape, {}};
  result.data.resize(static_cast<std::size_t>(tensor.elements()) * sizeof(float));
  switch (tensor.dtype) {
    case DType::f64:
      convert_elements<double>(tensor, result, [](double x) { return static_cast<float>(x); });
      break;
    case DType::f16:
      convert_elements<std::uint16_t>(tensor, result, float_from_f16);
      break;
    case DType::bf16:
      convert_elements<std::uint16_t>(tensor, result, float_from_bf16);
      break;
    default:
      throw std::logic_error("to_float32: not a floating-point tensor");
  }
  return result;
}

}  // namespace earpoint
