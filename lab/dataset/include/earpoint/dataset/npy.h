#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

namespace earpoint {

/// A table of floating-point numbers.
struct NumberTable {
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::vector<double> values;  ///< [rows][columns]
};

/// Reads a NumPy .npy file that holds a 2-D array of 4- or 8-byte little-endian floats in C order.
/// @throws InputError naming what else it holds
/// Source: NumPy Enhancement Proposal 1, the .npy format, versions 1 to 3.
NumberTable read_npy(const std::filesystem::path& path);

/// Writes a table as 8-byte floats in C order. @throws InputError if it cannot be written
void write_npy(const std::filesystem::path& path, const NumberTable& table);

}  // namespace earpoint
