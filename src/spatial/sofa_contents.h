#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/spatial/sofa_file.h>

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

/// Reads what the child process sends: lengths as uint64, then bytes, in the order of the members
/// above. A child that a damaged file has confused may send anything.
/// @throws InputError unless the message is whole
SofaContents parse_sofa_message(std::span<const char> message, std::string_view where);

/// What read_sofa() makes of a file's contents.
/// @param path  the file, for messages
/// @throws InputError as read_sofa()
SofaFile sofa_file_from_contents(const std::filesystem::path& path, const SofaContents& contents);

}  // namespace earpoint
