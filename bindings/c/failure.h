#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include <earpoint/earpoint.h>

namespace earpoint::c_api {

/// A bug of the caller's in C; becomes EARPOINT_USAGE_ERROR with this text.
class UsageError : public std::logic_error {
 public:
  UsageError(const std::string& where, const std::string& problem)
      : std::logic_error(where + ": " + problem) {}
};

/// Keeps the text for earpoint_last_error() without allocating.
/// @param text  a literal
earpoint_status fail_with_literal(earpoint_status status, const char* text) noexcept;

/// Called in a catch block: keeps the exception's text and tells which status it becomes.
earpoint_status fail_with_current_exception() noexcept;

/// Runs `call`; what it throws ends here.
template <typename Call>
earpoint_status guarded(Call&& call) noexcept {
  try {
    std::forward<Call>(call)();
    return EARPOINT_OK;
  } catch (...) {
    return fail_with_current_exception();
  }
}

/// @return the pointer
/// @throws UsageError if it is null
template <typename T>
T* not_null(T* pointer, const char* name) {
  if (pointer == nullptr) throw UsageError(name, "is a null pointer");
  return pointer;
}

}  // namespace earpoint::c_api
