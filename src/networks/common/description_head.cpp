#include <earpoint/network/description_head.h>

#include <string>

#include <fmt/format.h>

#include <earpoint/core/quote.h>
#include <earpoint/error.h>
#include <earpoint/network/layer_shapes.h>

namespace earpoint {

void expect_head(JsonObjectReader& reader, std::string_view where, int format,
                 std::string_view network) {
  check_range(where, "format", reader.integer("format"), format, format);
  if (const std::string found = reader.string("network"); found != network) {
    throw InputError(where,
                     fmt::format("'network': expected '{}', found {}", network, in_quotes(found)));
  }
}

}  // namespace earpoint
