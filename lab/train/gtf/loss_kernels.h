#pragma once

#include <cstddef>

namespace earpoint::training {

/// Weights of the terms of the loss over one row of a spectrum, divided by what their means are
/// over.
struct RowWeights {
  float magnitude = 0.0F;
  float log_magnitude = 0.0F;
  float modulation = 0.0F;
  float phase_difference = 0.0F;
  float modulation_floor = 0.0F;  ///< magnitude that counts as silence
};

/// One bin of both ears: left real, imaginary; right. Rows of frames, zero beyond them.
struct BinPair {
  const float* found[4];
  const float* right[4];
};

/// One bin's part of the loss. @param slopes  receive the gradient by `found`
double loss_of_bin(const BinPair& bin, const RowWeights& weights, std::ptrdiff_t frames,
                   std::ptrdiff_t row, float* const* slopes);

/// Over the frames of one bin the square root of the length of the ears' cross-spectrum.
double loudness_of_bin(const float* const* planes, std::ptrdiff_t frames, std::ptrdiff_t row);

/// Sum of the magnitudes of both ears.
double magnitude_of_bin(const float* const* planes, std::ptrdiff_t frames, std::ptrdiff_t row);

}  // namespace earpoint::training
