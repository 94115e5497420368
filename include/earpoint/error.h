#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace earpoint {

/// Bad data from outside: a file, a flag, a stream. The message is one line and reads
/// "where: problem; hint", so that a command can print it as it is and exit with 2.
class InputError : public std::runtime_error {
 public:
  /// @param where    the file, field or flag, e.g. "clip.mp4: audio stream 1"
  /// @param problem  what was expected and what was found
  /// @param hint     what the user can do about it; may be empty
  InputError(std::string_view where, std::string_view problem, std::string_view hint = {});
};

namespace detail {
[[noreturn]] void check_failed(const char* condition, const char* file, int line);
}  // namespace detail

}  // namespace earpoint

/// A caller's bug, always on: throws std::logic_error naming the condition and the place.
#define EARPOINT_CHECK(condition)                                                       \
  do {                                                                                  \
    if (!(condition)) ::earpoint::detail::check_failed(#condition, __FILE__, __LINE__); \
  } while (false)

/// The same for hot loops: on in the dev and sanitizer presets, gone in release.
#if defined(EARPOINT_DCHECK_ENABLED)
#define EARPOINT_DCHECK(condition) EARPOINT_CHECK(condition)
#else
#define EARPOINT_DCHECK(condition) \
  do {                             \
  } while (false)
#endif
