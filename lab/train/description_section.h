#pragma once

#include <string>
#include <string_view>

namespace earpoint {

/// A description with keys of a configuration in place of the usual ones. Whether each is known is
/// for the description's own parser to say.
/// @param section  JSON object
/// @param usual    JSON of the whole description
/// @param where    the section, for messages
/// @throws InputError if the section is not an object, or sets the format or the network itself
[[nodiscard]] std::string description_with(std::string_view section, std::string_view usual,
                                           std::string_view where);

}  // namespace earpoint
