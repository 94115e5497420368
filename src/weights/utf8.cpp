#include "utf8.h"

#include <cstddef>

namespace earpoint {

bool is_utf8(std::string_view text) {
  const auto in = [&](std::size_t i, unsigned least, unsigned most) {
    const auto byte = static_cast<unsigned char>(i < text.size() ? text[i] : 0);
    return byte >= least && byte <= most;
  };
  for (std::size_t i = 0; i < text.size();) {
    std::size_t following = 0;
    if (in(i, 0x00, 0x7F)) {
      following = 0;
    } else if (in(i, 0xC2, 0xDF)) {
      following = 1;
    } else if (in(i, 0xE0, 0xEF)) {
      // The second byte is bounded so that three bytes are needed, and no surrogate is meant.
      following = 2;
      if (!in(i + 1, in(i, 0xE0, 0xE0) ? 0xA0 : 0x80, in(i, 0xED, 0xED) ? 0x9F : 0xBF))
        return false;
    } else if (in(i, 0xF0, 0xF4)) {
      following = 3;
      if (!in(i + 1, in(i, 0xF0, 0xF0) ? 0x90 : 0x80, in(i, 0xF4, 0xF4) ? 0x8F : 0xBF))
        return false;
    } else {
      return false;
    }
    for (std::size_t k = 1; k <= following; ++k) {
      if (!in(i + k, 0x80, 0xBF)) return false;
    }
    i += following + 1;
  }
  return true;
}

}  // namespace earpoint
