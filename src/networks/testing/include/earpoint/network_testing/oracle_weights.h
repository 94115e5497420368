#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include <earpoint/vigas/weights.h>
#include <earpoint/weights/checkpoint.h>

namespace earpoint {

/// Weights for tests that are made by a formula, so that networks of any size need no large files.
///
/// Element i (row-major, from 0) of the tensor NAME with seed S:
///   key = FNV1a64(NAME) xor (S * 0x9E3779B97F4A7C15 mod 2^64)
///   z   = splitmix64 finaliser of key + (i + 1) * 0x9E3779B97F4A7C15
///   value = lo + (hi - lo) * (z >> 11) * 2^-53, computed in double, rounded to float32
class OracleRandom {
 public:
  OracleRandom(std::string_view tensor_name, std::uint64_t seed);

  /// The value of element `index`, at least `lo` and less than `hi` but for rounding.
  [[nodiscard]] float value(std::uint64_t index, double lo, double hi) const;

 private:
  std::uint64_t key_;
};

/// The whole checkpoint that a manifest describes: "seed", "hparams" (may be missing) and
/// "weights", a list of {name, shape, dtype, lo, hi} or {name, shape, dtype int64, value}.
/// @throws InputError if the file is not such a manifest
[[nodiscard]] Checkpoint make_oracle_checkpoint(const std::filesystem::path& manifest);

/// The same as checked weights, ready for inference.
[[nodiscard]] ViGasWeights make_oracle_vigas(const std::filesystem::path& manifest);

}  // namespace earpoint
