#include "failure.h"

#include <exception>
#include <new>

#include <earpoint/error.h>

namespace earpoint::c_api {
namespace {

/// A pointer, so that a failure in the audio thread only sets it.
thread_local const char* last_error = "";

earpoint_status fail_with_text(earpoint_status status, const char* text) noexcept {
  static thread_local std::string kept;
  try {
    kept = text;
  } catch (...) {
    return fail_with_literal(EARPOINT_OUT_OF_MEMORY, "out of memory");
  }
  for (char& c : kept) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  last_error = kept.c_str();
  return status;
}

}  // namespace

earpoint_status fail_with_literal(earpoint_status status, const char* text) noexcept {
  last_error = text;
  return status;
}

earpoint_status fail_with_current_exception() noexcept {
  try {
    throw;
  } catch (const InputError& error) {
    return fail_with_text(EARPOINT_INPUT_ERROR, error.what());
  } catch (const std::bad_alloc&) {
    return fail_with_literal(EARPOINT_OUT_OF_MEMORY, "out of memory");
  } catch (const std::logic_error& error) {
    return fail_with_text(EARPOINT_USAGE_ERROR, error.what());
  } catch (const std::exception& error) {
    return fail_with_text(EARPOINT_INTERNAL_ERROR, error.what());
  } catch (...) {
    return fail_with_literal(EARPOINT_INTERNAL_ERROR, "unknown failure");
  }
}

}  // namespace earpoint::c_api

const char* earpoint_last_error(void) { return earpoint::c_api::last_error; }
