#pragma once

#include <functional>
#include <string>

#include <earpoint/error.h>

namespace earpoint {

/// What an action is refused with; "accepted" if it is not.
inline std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace earpoint
