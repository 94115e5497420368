#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace earpoint {

/// A variable of a SOFA file as stored.
struct SofaVariable {
  std::vector<float> values;
  std::string type;   // attribute Type: "cartesian", "spherical", or nothing
  std::string units;  // attribute Units
};

/// The unchecked contents of a SOFA file, by the names of the standard.
struct SofaContents {
  std::uint64_t measurements = 0;  // M
  std::uint64_t receivers = 0;     // R
  std::uint64_t taps = 0;          // N
  std::string convention;          // SOFAConventions
  std::string data_type;           // DataType
  std::map<std::string, SofaVariable, std::less<>> variables;
};

/// Reads a file's bytes through libmysofa.
///
/// libmysofa (1.3.1) follows damaged HDF5 structures into crashes and endless loops: with a few
/// random bytes changed, 3 to 4 files in 100 bring it down. So it runs in a child process of its
/// own, which hands back plain arrays; what becomes of the child is an error like any other.
/// @param where  the file, for messages
/// @throws InputError if libmysofa refuses the file, or dies or takes over 10 s on it
SofaContents load_sofa_contents(std::span<const std::byte> bytes, std::string_view where);

}  // namespace earpoint
