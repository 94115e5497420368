#include "stack_kernels.h"

#include <type_traits>

// Compiled once per instruction set; the best one that the processor has is chosen at run time.
// The order of these matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vigas/stack_kernels.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>

#include <earpoint/kernels/elementary-inl.h>
#include "multiply-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace earpoint::training::HWY_NAMESPACE {
namespace {

using kernels::HWY_NAMESPACE::power_of_two;
using kernels::HWY_NAMESPACE::sine_within_one;

constexpr float kLog2OfE = 1.44269504F;

/// 1 / (1 + 2^x).
HWY_INLINE Vector logistic(Vector x) {
  const Lanes d;
  const Vector one = hn::Set(d, 1.0F);
  return hn::Div(one, hn::Add(one, power_of_two(d, x, 60.0F)));
}

/// cos(x) for x in [-1, 1]; error 6e-8. Least squares in its square.
HWY_INLINE Vector cosine_within_one(Vector x) {
  const Lanes d;
  const Vector square = hn::Mul(x, x);
  Vector sum = hn::Set(d, 2.42112492e-5F);
  sum = hn::MulAdd(sum, square, hn::Set(d, -1.38848457e-3F));
  sum = hn::MulAdd(sum, square, hn::Set(d, 4.16665802e-2F));
  sum = hn::MulAdd(sum, square, hn::Set(d, -0.5F));
  return hn::MulAdd(sum, square, hn::Set(d, 1.0F));
}

void products(std::span<const Product> terms, float* to, std::ptrdiff_t to_row, std::ptrdiff_t rows,
              std::ptrdiff_t columns) {
  for_column_blocks(columns, [=](std::ptrdiff_t column, auto vectors) HWY_ATTR {
    product_columns<decltype(vectors)::value>(terms, rows, column, to, to_row);
  });
}

void outer_products(const Outer& outer) {
  for_column_blocks(outer.columns, [&](std::ptrdiff_t column, auto vectors) HWY_ATTR {
    outer_columns<decltype(vectors)::value>(outer, column);
  });
}

void scaled_rows(const float* from, float factor, const float* bias, float* to, std::ptrdiff_t row,
                 std::ptrdiff_t rows, std::ptrdiff_t columns) {
  const Lanes d;
  for (std::ptrdiff_t i = 0; i < rows; ++i) {
    for (std::ptrdiff_t c = 0; c < columns; c += kLanes) {
      const Vector scaled = hn::Mul(hn::Set(d, factor), hn::LoadU(d, from + i * row + c));
      hn::StoreU(hn::Add(scaled, hn::LoadU(d, bias + c)), d, to + i * row + c);
    }
  }
}

void sum_of_rows(const float* from, std::ptrdiff_t row, std::ptrdiff_t rows, std::ptrdiff_t columns,
                 float* sums) {
  const Lanes d;
  for (std::ptrdiff_t c = 0; c < columns; c += kLanes) {
    Vector sum = hn::LoadU(d, sums + c);
    for (std::ptrdiff_t i = 0; i < rows; ++i) sum = hn::Add(sum, hn::LoadU(d, from + i * row + c));
    hn::StoreU(sum, d, sums + c);
  }
}

void gates_forward(float* gates, float* gated, std::ptrdiff_t samples, std::ptrdiff_t channels) {
  const Lanes d;
  for (std::ptrdiff_t i = 0; i < samples; ++i) {
    for (std::ptrdiff_t c = 0; c < channels; c += kLanes) {
      float* filter = gates + c;
      float* gate = filter + channels;
      // tanh(f) = 2 / (1 + exp(-2 f)) - 1
      const Vector half = logistic(hn::Mul(hn::Set(d, -2.0F * kLog2OfE), hn::LoadU(d, filter)));
      const Vector tanh = hn::MulSub(hn::Set(d, 2.0F), half, hn::Set(d, 1.0F));
      const Vector sigmoid = logistic(hn::Mul(hn::Set(d, -kLog2OfE), hn::LoadU(d, gate)));
      hn::StoreU(tanh, d, filter);
      hn::StoreU(sigmoid, d, gate);
      hn::StoreU(sine_within_one(d, hn::Mul(tanh, sigmoid)), d, gated + c);
    }
    gates += 2 * channels;
    gated += channels;
  }
}

void gates_backward(const float* gates, float* gradient, float* by_gates, float* sums,
                    std::ptrdiff_t samples, std::ptrdiff_t channels) {
  const Lanes d;
  for (std::ptrdiff_t c = 0; c < channels; c += kLanes) {
    Vector filter_sum = hn::LoadU(d, sums + c);
    Vector gate_sum = hn::LoadU(d, sums + channels + c);
    for (std::ptrdiff_t i = 0; i < samples; ++i) {
      const std::ptrdiff_t at = 2 * i * channels + c;
      const Vector tanh = hn::LoadU(d, gates + at);
      const Vector sigmoid = hn::LoadU(d, gates + at + channels);
      const Vector product = hn::Mul(tanh, sigmoid);
      float* by_gated = gradient + i * channels + c;
      const Vector by_product = hn::Mul(hn::LoadU(d, by_gated), cosine_within_one(product));
      // d tanh(f) = 1 - tanh^2 and d sigmoid(g) = sigmoid (1 - sigmoid)
      const Vector slope = hn::NegMulAdd(tanh, tanh, hn::Set(d, 1.0F));
      const Vector by_filter = hn::Mul(hn::Mul(by_product, sigmoid), slope);
      const Vector by_gate = hn::Mul(by_product, hn::NegMulAdd(product, sigmoid, product));
      hn::StoreU(by_filter, d, by_gates + at);
      hn::StoreU(by_gate, d, by_gates + at + channels);
      hn::StoreU(sine_within_one(d, product), d, by_gated);
      filter_sum = hn::Add(filter_sum, by_filter);
      gate_sum = hn::Add(gate_sum, by_gate);
    }
    hn::StoreU(filter_sum, d, sums + c);
    hn::StoreU(gate_sum, d, sums + channels + c);
  }
}

void sines_forward(float* x, std::ptrdiff_t count) {
  const Lanes d;
  for (std::ptrdiff_t i = 0; i < count; i += kLanes) {
    hn::StoreU(hn::Sin(d, hn::LoadU(d, x + i)), d, x + i);
  }
}

void sines_backward(float* x, float* gradient, std::ptrdiff_t count) {
  const Lanes d;
  for (std::ptrdiff_t i = 0; i < count; i += kLanes) {
    const Vector angle = hn::LoadU(d, x + i);
    hn::StoreU(hn::Mul(hn::LoadU(d, gradient + i), hn::Cos(d, angle)), d, gradient + i);
    hn::StoreU(hn::Sin(d, angle), d, x + i);
  }
}

}  // namespace
}  // namespace earpoint::training::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace earpoint::training {

HWY_EXPORT(products);
HWY_EXPORT(outer_products);
HWY_EXPORT(scaled_rows);
HWY_EXPORT(sum_of_rows);
HWY_EXPORT(gates_forward);
HWY_EXPORT(gates_backward);
HWY_EXPORT(sines_forward);
HWY_EXPORT(sines_backward);

void add_products(std::span<const Product> terms, float* to, std::ptrdiff_t to_row,
                  std::ptrdiff_t rows, std::ptrdiff_t columns) {
  HWY_DYNAMIC_DISPATCH(products)(terms, to, to_row, rows, columns);
}

void add_outer_products(const Outer& outer) { HWY_DYNAMIC_DISPATCH(outer_products)(outer); }

void scale_rows(const float* from, float factor, const float* bias, float* to, std::ptrdiff_t row,
                std::ptrdiff_t rows, std::ptrdiff_t columns) {
  HWY_DYNAMIC_DISPATCH(scaled_rows)(from, factor, bias, to, row, rows, columns);
}

void add_rows(const float* from, std::ptrdiff_t row, std::ptrdiff_t rows, std::ptrdiff_t columns,
              float* sums) {
  HWY_DYNAMIC_DISPATCH(sum_of_rows)(from, row, rows, columns, sums);
}

void open_gates(float* gates, float* gated, std::ptrdiff_t samples, std::ptrdiff_t channels) {
  HWY_DYNAMIC_DISPATCH(gates_forward)(gates, gated, samples, channels);
}

void open_gates_back(const float* gates, float* gradient, float* by_gates, float* sums,
                     std::ptrdiff_t samples, std::ptrdiff_t channels) {
  HWY_DYNAMIC_DISPATCH(gates_backward)(gates, gradient, by_gates, sums, samples, channels);
}

void sines(float* x, std::ptrdiff_t count) { HWY_DYNAMIC_DISPATCH(sines_forward)(x, count); }

void sines_back(float* x, float* gradient, std::ptrdiff_t count) {
  HWY_DYNAMIC_DISPATCH(sines_backward)(x, gradient, count);
}

}  // namespace earpoint::training
#endif  // HWY_ONCE
