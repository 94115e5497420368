#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <earpoint/weights/tensor.h>

namespace earpoint {
namespace {

Tensor raw(DType dtype, std::span<const std::uint16_t> bits) {
  Tensor tensor = make_tensor(bits, {static_cast<std::int64_t>(bits.size())});
  tensor.dtype = dtype;
  return tensor;
}

TEST(Tensor, HoldsWhatItWasMadeOf) {
  const std::array<float, 6> values{1, 2, 3, 4, 5, 6};
  const Tensor tensor = make_tensor<float>(values, {2, 3});
  EXPECT_EQ(tensor.elements(), 6);
  EXPECT_EQ(tensor.dtype, DType::f32);
  EXPECT_TRUE(std::equal(values.begin(), values.end(), tensor.as<float>().begin()));
  EXPECT_EQ(tensor, make_tensor<float>(values, {2, 3}));
  EXPECT_FALSE(tensor == make_tensor<float>(values, {3, 2}));
}

TEST(Tensor, RefusesAnotherTypeOrAnotherLength) {
  const std::array<float, 2> values{1, 2};
  Tensor tensor = make_tensor<float>(values, {2});
  EXPECT_THROW((void)tensor.as<std::int32_t>(), std::logic_error);
  EXPECT_THROW((void)make_tensor<float>(values, {3}), std::logic_error);
  tensor.data.pop_back();
  EXPECT_THROW((void)tensor.as<float>(), std::logic_error);
}

TEST(Tensor, CountsElementsWithoutOverflow) {
  using Shape = std::vector<std::int64_t>;
  const std::int64_t big = std::int64_t{1} << 32;
  EXPECT_EQ(element_count(Shape{}), 1);
  EXPECT_EQ(element_count(Shape{4, 0, 5}), 0);
  EXPECT_EQ(element_count(Shape{big, 1 << 30}), std::int64_t{1} << 62);
  EXPECT_EQ(element_count(Shape{big, big}), std::nullopt);
  EXPECT_EQ(element_count(Shape{big, big, 0}), 0);
  EXPECT_EQ(element_count(Shape{0, -1}), std::nullopt);
}

TEST(Tensor, NamesOfTypesRoundTrip) {
  for (const char* name : {"F64", "F32", "F16", "BF16", "I64", "I32", "I16", "I8", "U64", "U32",
                           "U16", "U8", "BOOL"}) {
    ASSERT_TRUE(dtype_from_name(name)) << name;
    EXPECT_EQ(name_of(*dtype_from_name(name)), name);
  }
  EXPECT_FALSE(dtype_from_name("F8_E4M3"));
}

TEST(Tensor, WidensHalvesExactly) {
  // Bit patterns and values from IEEE 754-2008, binary16.
  const std::array<std::uint16_t, 9> bits{0x3C00, 0xC000, 0x7BFF, 0x0400, 0x0001,
                                          0x8000, 0x7C00, 0x3555, 0x83FF};
  const Tensor widened = to_float32(raw(DType::f16, bits));
  const auto values = widened.as<float>();
  EXPECT_EQ(values[0], 1.0F);
  EXPECT_EQ(values[1], -2.0F);
  EXPECT_EQ(values[2], 65504.0F);
  EXPECT_EQ(values[3], 0x1p-14F);
  EXPECT_EQ(values[4], 0x1p-24F);
  EXPECT_TRUE(values[5] == 0 && std::signbit(values[5]));
  EXPECT_EQ(values[6], std::numeric_limits<float>::infinity());
  EXPECT_EQ(values[7], 1365.0F / 4096.0F);
  EXPECT_EQ(values[8], -1023 * 0x1p-24F);
  const std::array<std::uint16_t, 1> nan{0x7E00};
  EXPECT_TRUE(std::isnan(to_float32(raw(DType::f16, nan)).as<float>()[0]));
}

TEST(Tensor, WidensBrainFloatsAndNarrowsDoubles) {
  const std::array<std::uint16_t, 2> bits{0x3F80, 0xC049};
  const Tensor widened = to_float32(raw(DType::bf16, bits));
  EXPECT_EQ(widened.as<float>()[0], 1.0F);
  EXPECT_EQ(widened.as<float>()[1], -3.140625F);
  const std::array<double, 1> tenth{0.1};
  EXPECT_EQ(to_float32(make_tensor<double>(tenth, {1})).as<float>()[0], 0.1F);
  const std::array<std::int32_t, 1> integer{1};
  EXPECT_THROW((void)to_float32(make_tensor<std::int32_t>(integer, {1})), std::logic_error);
}

}  // namespace
}  // namespace earpoint
