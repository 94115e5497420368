#include <earpoint/kernels/matrix.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <oneapi/dnnl/dnnl.h>

#include <earpoint/error.h>
#include <earpoint/kernels/norms.h>

namespace earpoint::kernels {
namespace {

std::size_t area(int rows, int columns) { return static_cast<std::size_t>(rows) * columns; }

void product(char transpose_a, char transpose_b, std::span<const float> a, std::span<const float> b,
             std::span<float> out, int rows, int inner, int columns, float keep) {
  EARPOINT_CHECK(a.size() == area(rows, inner) && b.size() == area(inner, columns) &&
                 out.size() == area(rows, columns));
  const int a_stride = transpose_a == 'T' ? rows : inner;
  const int b_stride = transpose_b == 'T' ? inner : columns;
  const dnnl_status_t status =
      dnnl_sgemm(transpose_a, transpose_b, rows, columns, inner, 1.0F, a.data(), a_stride, b.data(),
                 b_stride, keep, out.data(), columns);
  EARPOINT_CHECK(status == dnnl_success);
}

}  // namespace

void multiply(std::span<const float> a, std::span<const float> b, std::span<float> out, int rows,
              int inner, int columns, bool add) {
  product('N', 'N', a, b, out, rows, inner, columns, add ? 1.0F : 0.0F);
}

void multiply_transposed(std::span<const float> a, std::span<const float> b, std::span<float> out,
                         int rows, int inner, int columns) {
  product('N', 'T', a, b, out, rows, inner, columns, 0.0F);
}

void transposed_multiply(std::span<const float> a, std::span<const float> b, std::span<float> out,
                         int rows, int inner, int columns) {
  product('T', 'N', a, b, out, rows, inner, columns, 0.0F);
}

void linear(std::span<const float> in, std::span<const float> weight, std::span<const float> bias,
            std::span<float> out, int rows) {
  const int outputs = static_cast<int>(bias.size());
  const int inputs = static_cast<int>(weight.size()) / outputs;
  multiply_transposed(in, weight, out, rows, inputs, outputs);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] += bias[i % bias.size()];
}

void layer_norm(std::span<const float> in, std::span<const float> weight,
                std::span<const float> bias, std::span<float> out) {
  const std::size_t width = weight.size();
  EARPOINT_CHECK(in.size() == out.size() && in.size() % width == 0);
  for (std::size_t at = 0; at < in.size(); at += width) {
    double mean = 0.0;
    double square = 0.0;
    for (std::size_t i = 0; i < width; ++i) mean += in[at + i];
    mean /= static_cast<double>(width);
    for (std::size_t i = 0; i < width; ++i) square += (in[at + i] - mean) * (in[at + i] - mean);
    const double scale = 1.0 / std::sqrt(square / static_cast<double>(width) + kLayerNormEpsilon);
    for (std::size_t i = 0; i < width; ++i) {
      out[at + i] = static_cast<float>((in[at + i] - mean) * scale) * weight[i] + bias[i];
    }
  }
}

void softmax_rows(std::span<float> values, int columns) {
  const auto width = static_cast<std::size_t>(columns);
  EARPOINT_CHECK(values.size() % width == 0);
  for (std::size_t at = 0; at < values.size(); at += width) {
    const std::span<float> row = values.subspan(at, width);
    const float largest = *std::ranges::max_element(row);
    float sum = 0.0F;
    for (float& x : row) sum += x = std::exp(x - largest);
    for (float& x : row) x /= sum;
  }
}

}  // namespace earpoint::kernels
