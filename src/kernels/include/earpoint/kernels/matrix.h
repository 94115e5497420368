#pragma once

#include <span>

namespace earpoint::kernels {

/// Matrix products and what a transformer makes of them, on row-major floats. oneDNN multiplies, on
/// as many threads as OpenMpThreads says. None of these allocates for its result.

/// out [rows][columns] = a [rows][inner] * b, b being [inner][columns]; adds to `out` if `add`.
void multiply(std::span<const float> a, std::span<const float> b, std::span<float> out, int rows,
              int inner, int columns, bool add = false);

/// The same with b given as [columns][inner].
void multiply_transposed(std::span<const float> a, std::span<const float> b, std::span<float> out,
                         int rows, int inner, int columns);

/// The same with a given as [inner][rows].
void transposed_multiply(std::span<const float> a, std::span<const float> b, std::span<float> out,
                         int rows, int inner, int columns);

/// A linear layer on every row: out [rows][outputs] = in [rows][inputs] * weight^T + bias.
void linear(std::span<const float> in, std::span<const float> weight, std::span<const float> bias,
            std::span<float> out, int rows);

/// Every row to mean 0 and variance 1 (eps 1e-5), then scaled and shifted.
void layer_norm(std::span<const float> in, std::span<const float> weight,
                std::span<const float> bias, std::span<float> out);

/// Every row becomes exp(x) / sum of exp(x).
void softmax_rows(std::span<float> values, int columns);

}  // namespace earpoint::kernels
